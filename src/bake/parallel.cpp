#include <stratus/bake/parallel.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace stratus {

namespace {

/// One loop, on which any number of threads may work.
class Loop {
  public:
    /// Both functions outlive it.
    Loop(int count, const std::function<void(int)>& body, const std::function<void(int)>* finished)
        : count_(count), body_(body), finished_(finished) {}

    int count() const { return count_; }
    bool is_work_left() const { return next_ < count_; }

    /// Until all is done or taken by other threads.
    void work() {
        for (int i; (i = next_.fetch_add(1)) < count_;) {
            try {
                body_(i);
                const std::lock_guard lock(mutex_);
                ++done_;
                if (finished_ != nullptr && *finished_) (*finished_)(done_);
            } catch (...) {
                const std::lock_guard lock(mutex_);
                if (!failure_) failure_ = std::current_exception();
                next_ = count_;
            }
        }
    }

    /// Once no thread works on it.
    void rethrow() const {
        if (failure_) std::rethrow_exception(failure_);
    }

  private:
    const int count_;
    const std::function<void(int)>& body_;
    const std::function<void(int)>* const finished_;  // null: none
    std::atomic<int> next_{0};
    std::mutex mutex_;
    int done_ = 0;
    std::exception_ptr failure_;
};

/// The threads of a loop, which the loops within share.
class Team {
  public:
    static thread_local Team* of_this_thread;

    Team(Loop& outermost, int threads) : outermost_(outermost), working_(threads) {}

    /// Body of each thread: works on the outermost loop, then on whatever others have open. A single
    /// call stays on the thread that began the loop.
    void work(bool began_it) {
        of_this_thread = this;
        if (began_it || outermost_.count() > 1) outermost_.work();
        std::unique_lock lock(mutex_);
        --working_;
        changed_.notify_all();
        for (;;) {
            Shared* open = nullptr;
            changed_.wait(lock, [&] { return working_ == 0 || (open = find_open()) != nullptr; });
            if (open == nullptr) break;
            ++open->helpers;
            lock.unlock();
            open->loop.work();
            lock.lock();
            --open->helpers;
            changed_.notify_all();
        }
        of_this_thread = nullptr;
    }

    /// Goes on without threads that the system does not grant.
    void forgo(int threads) {
        const std::lock_guard lock(mutex_);
        working_ -= threads;
        changed_.notify_all();
    }

    /// A loop within: begun by its thread, open to all others.
    void share(Loop& loop) {
        Shared shared{loop};
        std::unique_lock lock(mutex_);
        open_.push_back(&shared);
        changed_.notify_all();
        lock.unlock();
        loop.work();
        lock.lock();
        std::erase(open_, &shared);
        changed_.wait(lock, [&] { return shared.helpers == 0; });
    }

  private:
    struct Shared {
        Loop& loop;
        int helpers = 0;
    };

    Shared* find_open() const {
        const auto found = std::ranges::find_if(
            open_, [](const Shared* shared) { return shared->loop.is_work_left(); });
        return found == open_.end() ? nullptr : *found;
    }

    Loop& outermost_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Shared*> open_;
    int working_;  // threads that still work on the outermost loop
};

thread_local Team* Team::of_this_thread = nullptr;

void run(Loop& loop, int threads) {
    if (threads < 2) {
        loop.work();
    } else if (Team::of_this_thread != nullptr) {
        Team::of_this_thread->share(loop);
    } else {
        Team team(loop, threads);
        std::vector<std::thread> others;
        others.reserve(static_cast<std::size_t>(threads));
        try {
            for (int t = 1; t < threads; ++t) others.emplace_back([&] { team.work(false); });
        } catch (const std::system_error&) {
            team.forgo(threads - 1 - static_cast<int>(others.size()));
        }
        team.work(true);
        for (std::thread& other : others) other.join();
    }
    loop.rethrow();
}

}  // namespace

int thread_count(int requested) {
    return requested > 0 ? requested
                         : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(int count, int threads, const std::function<void(int)>& body,
                  const std::function<void(int)>& finished) {
    Loop loop(count, body, &finished);
    run(loop, std::min(thread_count(threads), count));
}

void nested_parallel_for(int count, int threads, const std::function<void(int)>& body) {
    Loop loop(count, body, nullptr);
    const bool is_within = Team::of_this_thread != nullptr;
    run(loop, is_within ? std::min(thread_count(threads), count) : thread_count(threads));
}

}  // namespace stratus
