#include <stratus/bake/ranks.h>

#include <stratus/bake/parallel.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include "rank_messages.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <numeric>
#include <semaphore>
#include <set>
#include <signal.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace stratus {
namespace {

// A sleep takes 20 us of processor time where timers are slow.
constexpr std::chrono::microseconds longest_of_waiting{200}, longest_of_serving{2000};
constexpr std::chrono::microseconds sleep_between_stages{10000};

bool is_alive(pid_t process) { return ::kill(process, 0) == 0 || errno != ESRCH; }

/// Holds a count of a semaphore while it lives.
class SemaphoreGuard {
  public:
    explicit SemaphoreGuard(std::counting_semaphore<>& semaphore) : semaphore_(semaphore) {
        semaphore_.acquire();
    }
    ~SemaphoreGuard() { semaphore_.release(); }
    SemaphoreGuard(const SemaphoreGuard&) = delete;
    SemaphoreGuard& operator=(const SemaphoreGuard&) = delete;

  private:
    std::counting_semaphore<>& semaphore_;
};

}  // namespace

struct Ranks::State {
    /// Where a rank runs.
    struct Place {
        char machine[256];
        pid_t process;
    };

    static Place this_place() {
        Place place{};
        ::gethostname(place.machine, sizeof place.machine - 1);
        place.process = ::getpid();
        return place;
    }

    State(std::unique_ptr<RankTransport> transport_, RanksOptions options_)
        : transport(std::move(transport_)), options(std::move(options_)), rank(transport->rank()) {}

    // ---- all ranks -----------------------------------------------------------------------------

    RankMessage await(int from, int tag) {
        for (Backoff backoff(longest_of_waiting);; backoff.sleep())
            if (auto message = transport->receive(from, tag)) return std::move(*message);
    }

    void send_to_first(Head head, std::span<const char> bytes = {}) {
        transport->send(0, to_first, joined(head, bytes));
    }

    std::vector<char> share(std::vector<char> bytes) {
        if (transport->count() == 1) return bytes;
        std::size_t size = bytes.size();
        transport->broadcast({reinterpret_cast<char*>(&size), sizeof size});
        bytes.resize(size);
        transport->broadcast(bytes);
        return bytes;
    }

    std::vector<std::vector<char>> gather(std::span<const char> bytes, int from_ranks) {
        const auto count = size(from_ranks);
        std::vector<std::vector<char>> of_rank(count);
        std::vector<std::size_t> sizes(count);
        std::vector<char> all;
        if (rank == 0) {
            of_rank[0].assign(bytes.begin(), bytes.end());
            for (std::size_t r = 1; r < count; ++r)
                of_rank[r] = await(static_cast<int>(r), gathering).bytes;
            for (std::size_t r = 0; r < count; ++r) {
                sizes[r] = of_rank[r].size();
                all.insert(all.end(), of_rank[r].begin(), of_rank[r].end());
            }
        } else if (rank < from_ranks) {
            transport->send(0, gathering, bytes);
        }
        transport->broadcast({reinterpret_cast<char*>(sizes.data()), count * sizeof(std::size_t)});
        all.resize(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
        transport->broadcast(all);
        auto from = all.begin();
        for (std::size_t r = 0; r < count; ++r) {
            const auto to = from + static_cast<std::ptrdiff_t>(sizes[r]);
            of_rank[r].assign(from, to);
            from = to;
        }
        return of_rank;
    }

    std::vector<char> solve(const RankedStage& of_all, int piece, std::span<const char> given) {
        ++pieces;
        return of_all.solve(piece, given);
    }

    RankTally tally() const { return {pieces, processor_seconds()}; }

    // ---- rank 0 --------------------------------------------------------------------------------

    struct Claim {
        int from, stage, slot;
    };

    std::string rank_name(int number) const {
        const Place& place = places[size(number)];
        return "rank " + std::to_string(number) + " (" + place.machine + ", process " +
               std::to_string(place.process) + ")";
    }

    /// The stage's next open piece, no_piece or not_yet. The caller holds the mutex.
    int next_piece() {
        if (open.empty()) return no_piece;
        const int piece = open.front();
        if (stage->most_ahead > 0 && !running.empty() &&
            piece - *running.begin() >= stage->most_ahead)
            return not_yet;
        open.pop_front();
        running.insert(piece);
        return piece;
    }

    /// The next one for a thread of rank 0, which waits for it.
    int await_piece() {
        std::unique_lock lock(mutex);
        int piece = not_yet;
        changed.wait(lock, [&] { return (piece = next_piece()) != not_yet; });
        return piece;
    }

    std::vector<char> given(int piece) const {
        return stage->give ? stage->give(piece) : std::vector<char>{};
    }

    /// A claim waits until rank 0 is at its stage and the next piece may begin.
    void serve(const Claim& claim) {
        int piece = no_piece;
        {
            const std::lock_guard lock(mutex);
            if (claim.stage == stage_number) piece = next_piece();
            if (claim.stage > stage_number || piece == not_yet) {
                waiting.push_back(claim);
                return;
            }
        }
        std::vector<char> answer;
        if (piece != no_piece) answer = given(piece);
        const std::span<const char> first = raw_bytes(piece);
        answer.insert(answer.begin(), first.begin(), first.end());
        transport->send(claim.from, first_slot + claim.slot, answer);
    }

    void finish_piece(int piece, std::span<const char> result) {
        stage->take(piece, result);
        std::deque<Claim> held;
        {
            const std::lock_guard lock(mutex);
            running.erase(piece);
            ++finished;
            stage->progress(finished);
            held.swap(waiting);
            changed.notify_all();
        }
        for (const Claim& claim : held) serve(claim);
    }

    void handle(const RankMessage& message) {
        const auto head = from_raw_bytes<Head>(message.bytes);
        const auto from = size(message.from);
        note_life(from, head.kind == Kind::leaving);
        const std::span<const char> bytes = std::span(message.bytes).subspan(sizeof head);
        switch (head.kind) {
            case Kind::alive:
                transport->send(message.from, life_sign, joined(Head{Kind::alive, 0, 0}, kept()));
                return;
            case Kind::failed:
                end_losing(
                    1, rank_name(message.from) + ": " + std::string(bytes.begin(), bytes.end()));
            case Kind::leaving:
                tallies[from] = {head.pieces, head.seconds};
                transport->send(message.from, life_sign, raw_bytes(Head{Kind::leaving, 0, 0}));
                return;
            case Kind::claim:
                // The other rank waits for its next piece, not for what becomes of the last one.
                serve({message.from, head.stage, head.slot});
                if (head.piece != no_piece) finish_piece(head.piece, bytes);
        }
    }

    void note_life(std::size_t from, bool leaves) {
        const std::lock_guard lock(mutex);
        seen[from] = Clock::now();
        if (leaves) has_left[from] = true;
    }

    bool all_have_left() {
        const std::lock_guard lock(mutex);
        return std::ranges::all_of(has_left, [](bool left) { return left; });
    }

    /// Why a rank counts as lost; empty: none does.
    std::string loss() {
        const std::lock_guard lock(mutex);
        for (std::size_t r = 1; r < places.size(); ++r) {
            if (has_left[r]) continue;
            const std::string name = rank_name(static_cast<int>(r));
            if (is_watched[r] && !is_alive(places[r].process))
                return name + " was killed or has crashed";
            if (seconds_since(seen[r]) > options.time_limit)
                return name + " has given no sign of life for " +
                       short_number(options.time_limit, 6) + " s";
        }
        return "";
    }

    void check_lives() {
        const std::string lost = loss();
        if (!lost.empty()) end_losing(1, lost);
    }

    /// Serves the other ranks, until all have left.
    void serve_all() {
        for (Backoff backoff(longest_of_serving); !all_have_left();) {
            while (auto message = transport->receive(-1, to_first)) {
                handle(*message);
                backoff.reset();
            }
            std::unique_lock lock(mutex);
            const bool is_asked = is_leaving || !open.empty() || !running.empty();
            changed.wait_for(lock, is_asked ? backoff.next() : sleep_between_stages);
        }
    }

    /// Ends all where one is lost, or a signal comes, whatever the thread that serves waits for.
    void watch() {
        for (int n = 0; !all_have_left(); ++n) {
            if (const int signal = options.stop ? options.stop() : 0) end_stopped(signal);
            if (n % 5 == 0) check_lives();
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    /// mpirun stops all ranks when one has ended: which one shows soon.
    [[noreturn]] void end_stopped(int signal) {
        for (int n = 0; n < 10; ++n) {
            check_lives();
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        end_losing(128 + signal, "interrupted");
    }

    void run_first(const RankedStage& of_all, int threads) {
        std::deque<Claim> early;
        {
            const std::lock_guard lock(mutex);
            stage = &of_all;
            finished = 0;
            for (int piece = 0; piece < of_all.count; ++piece)
                if (of_all.is_done(piece))
                    ++finished;
                else
                    open.push_back(piece);
            ++stage_number;
            early.swap(waiting);
            changed.notify_all();
        }
        for (const Claim& claim : early) serve(claim);
        parallel_for(threads, threads, [&](int) {
            try {
                for (int piece; (piece = await_piece()) != no_piece;)
                    finish_piece(piece, solve(of_all, piece, given(piece)));
            } catch (...) {
                const std::lock_guard lock(mutex);
                open.clear();
                changed.notify_all();
                throw;
            }
        });
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return finished == of_all.count; });
    }

    // ---- the others ----------------------------------------------------------------------------

    void run_other(const RankedStage& of_all, int threads) {
        ++stage_number;
        std::counting_semaphore<> solving(threads);
        const int slots = threads + of_all.claimed_ahead;
        parallel_for(slots, slots, [&](int slot) {
            Head claim{Kind::claim, stage_number, slot};
            std::vector<char> result;
            for (;;) {
                send_to_first(claim, result);
                const std::vector<char> answer = await(0, first_slot + slot).bytes;
                claim.piece = from_raw_bytes<int>(answer);
                if (claim.piece == no_piece) return;
                const SemaphoreGuard guard(solving);
                result = solve(of_all, claim.piece, std::span(answer).subspan(sizeof(int)));
            }
        });
    }

    /// The lowest of the other ranks on rank 0's machine watches its process, and tells its loss.
    bool watches_first() const {
        for (int r = 1; r < rank; ++r)
            if (is_watched[size(r)]) return false;
        return is_watched[0];
    }

    /// Rank 0 can say nothing any more.
    [[noreturn]] void end_without_first(const std::string& reason, const std::string& kept) {
        std::fprintf(stderr, "stratus: %s%s\n", reason.c_str(),
                     kept.empty() ? "" : ("; " + kept).c_str());
        transport->abort(1);
        std::_Exit(1);  // which compilers cannot tell
    }

    /// Gives signs of life, and expects them of rank 0, until rank 0 says good-bye.
    void keep_alive() {
        std::string kept;  // as rank 0 last said
        const double interval = std::min(1.0, options.time_limit / 4);
        auto told = Clock::now() - std::chrono::hours(1);
        for (auto heard = Clock::now();;) {
            if (seconds_since(told) > interval && !is_leaving) {
                send_to_first({Kind::alive, 0, 0});
                told = Clock::now();
            }
            while (const auto answer = transport->receive(0, life_sign)) {
                heard = Clock::now();
                if (from_raw_bytes<Head>(answer->bytes).kind == Kind::leaving) return;
                const auto said = std::span(answer->bytes).subspan(sizeof(Head));
                kept = std::string(said.begin(), said.end());
            }
            if (watches_first() && !is_alive(places[0].process))
                end_without_first(rank_name(0) + " was killed or has crashed", kept);
            if (seconds_since(heard) > options.time_limit)
                end_without_first(rank_name(0) + " has given no sign of life for " +
                                      short_number(options.time_limit, 6) + " s",
                                  kept);
            std::this_thread::sleep_for(std::chrono::milliseconds(is_leaving ? 1 : 20));
        }
    }

    std::string kept() const { return options.kept ? options.kept() : ""; }

    /// For what the other ranks are to blame.
    [[noreturn]] void end_losing(int exit_code, const std::string& reason) {
        const std::string work = kept();
        end_all(exit_code, work.empty() ? reason : reason + "; " + work);
    }

    [[noreturn]] void end_all(int exit_code, const std::string& reason) {
        static std::mutex once;  // the first reason is the one that is told
        once.lock();
        if (rank != 0) {
            // Most such reasons are rank 0's, too, who tells them better.
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            send_to_first({Kind::failed, 0, 0}, reason);
            std::this_thread::sleep_for(std::chrono::duration<double>(options.time_limit));
            transport->abort(exit_code);
        }
        std::fprintf(stderr, "stratus: %s\n", reason.c_str());
        transport->abort(exit_code);
        std::_Exit(exit_code);  // which compilers cannot tell
    }

    const std::unique_ptr<RankTransport> transport;
    const RanksOptions options;
    const int rank;
    std::mutex mutex;
    int stage_number = 0;
    std::atomic<int> pieces = 0;  // that this rank solved
    std::atomic<bool> is_leaving = false;
    std::thread thread;   // serves, or gives signs of life
    std::thread watcher;  // rank 0's

    std::vector<Place> places;
    std::vector<bool> is_watched;  // on this machine, where it can be seen whether it lives

    // Rank 0's alone.
    std::vector<bool> has_left;
    std::vector<Clock::time_point> seen;
    std::vector<RankTally> tallies;
    const RankedStage* stage = nullptr;
    std::deque<int> open;   // pieces
    std::set<int> running;  // pieces
    std::deque<Claim> waiting;
    int finished = 0;  // pieces
    std::condition_variable changed;
};

Ranks::Ranks(std::unique_ptr<RankTransport> transport, RanksOptions options)
    : state_(std::make_unique<State>(std::move(transport), std::move(options))) {
    State& state = *state_;
    const State::Place here = State::this_place();
    for (const std::vector<char>& bytes : state.gather(raw_bytes(here), count())) {
        const auto place = from_raw_bytes<State::Place>(bytes);
        state.places.push_back(place);
        state.is_watched.push_back(std::strcmp(place.machine, here.machine) == 0 &&
                                   is_alive(place.process));
    }
    state.seen.resize(state.places.size(), Clock::now());
    state.tallies.resize(state.places.size());
    state.has_left.resize(state.places.size(), false);
    state.has_left[0] = true;
    if (state.rank == 0) state.watcher = std::thread([&state] { state.watch(); });
    state.thread = std::thread([&state] {
        try {
            state.rank == 0 ? state.serve_all() : state.keep_alive();
        } catch (const std::exception& error) {
            state.end_all(1, error.what());
        }
    });
}

Ranks::~Ranks() {
    if (state_->thread.joinable()) state_->transport->abort(1);
}

int Ranks::rank() const { return state_->rank; }
int Ranks::count() const { return state_->transport->count(); }

std::vector<char> Ranks::share(std::vector<char> bytes) { return state_->share(std::move(bytes)); }

std::vector<std::vector<char>> Ranks::gather(std::span<const char> bytes, int from_ranks) {
    return state_->gather(bytes, from_ranks);
}

void Ranks::run(const RankedStage& stage, int threads) {
    if (is_first())
        state_->run_first(stage, threads);
    else
        state_->run_other(stage, threads);
}

bool Ranks::is_finished() const { return !state_->thread.joinable(); }

std::vector<RankTally> Ranks::finish() {
    State& state = *state_;
    state.share({});  // rank 0 has all it needs
    state.is_leaving = true;
    state.changed.notify_all();
    if (!is_first()) {
        const RankTally tally = state.tally();
        state.send_to_first({Kind::leaving, 0, 0, no_piece, tally.pieces, tally.seconds});
    }
    state.thread.join();
    if (state.watcher.joinable()) state.watcher.join();
    state.tallies[0] = state.tally();
    return state.tallies;
}

void Ranks::end_all(int exit_code, const std::string& reason) {
    state_->end_all(exit_code, reason);
}

}  // namespace stratus
