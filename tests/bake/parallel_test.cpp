#include <stratus/bake/parallel.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <pthread.h>

#include <atomic>
#include <barrier>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

namespace stratus {
namespace {

/// The threads that call it.
class Callers {
  public:
    void add() {
        const std::lock_guard lock(mutex_);
        ids_.insert(std::this_thread::get_id());
        ++calls_;
    }
    std::size_t count() const { return ids_.size(); }
    int calls() const { return calls_; }

  private:
    std::mutex mutex_;
    std::set<std::thread::id> ids_;
    int calls_ = 0;
};

TEST(ThreadCount, IsTheRequestedNumberOrAtLeastOne) {
    for (const int threads : {1, 7}) EXPECT_EQ(thread_count(threads), threads);
    EXPECT_GE(thread_count(0), 1);
}

TEST(ParallelFor, CallsEachIndexOnce) {
    for (const int threads : {0, 1, 2, 7, 100})
        for (const int count : {0, 1, 5, 1000}) {
            std::vector<std::atomic<int>> calls(static_cast<std::size_t>(count));
            parallel_for(count, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
            for (int i = 0; i < count; ++i)
                EXPECT_EQ(calls[static_cast<std::size_t>(i)], 1) << i << " of " << count;
        }
}

#ifdef __GLIBC__
TEST(ParallelFor, MakesDoWithTheThreadsThatTheSystemGrants) {
    pthread_attr_t before, stacks_beyond_all_memory;
    pthread_getattr_default_np(&before);
    pthread_attr_init(&stacks_beyond_all_memory);
    pthread_attr_setstacksize(&stacks_beyond_all_memory, std::size_t{1} << 47);
    ASSERT_EQ(pthread_setattr_default_np(&stacks_beyond_all_memory), 0);
    EXPECT_THROW(std::thread([] {}).join(), std::system_error);
    std::set<int> called;
    const auto body = [&](int i) { called.insert(i); };  // calls share a thread: no lock
    parallel_for(100, 8, body);
    nested_parallel_for(3, 8,
                        [&](int i) { parallel_for(100, 8, [&](int j) { body(100 * i + j); }); });
    EXPECT_EQ(called.size(), 300u);
    pthread_setattr_default_np(&before);
    pthread_attr_destroy(&stacks_beyond_all_memory);
}
#endif

TEST(ParallelFor, ReportsEveryFinishedCall) {
    std::vector<int> told;  // calls come one at a time: no lock
    parallel_for(
        200, 4, [](int) {}, [&](int done) { told.push_back(done); });
    ASSERT_EQ(told.size(), 200u);
    for (int n = 0; n < 200; ++n) EXPECT_EQ(told[static_cast<std::size_t>(n)], n + 1);
}

TEST(ParallelFor, RethrowsFromTheBody) {
    for (const int threads : {1, 3})
        EXPECT_EQ(refusal<std::runtime_error>([&] {
                      parallel_for(50, threads, [](int i) {
                          if (i == 17) throw std::runtime_error("cell 17");
                      });
                  }),
                  "cell 17");
}

TEST(ParallelFor, StopsAfterAFailure) {
    std::atomic<int> calls = 0;
    const auto body = [&](int) {
        ++calls;
        throw std::runtime_error("at once");
    };
    EXPECT_THROW(parallel_for(100000, 2, body), std::runtime_error);
    EXPECT_LE(calls, 2);  // one for each thread
}

TEST(ParallelFor, RethrowsFromTheListener) {
    const auto listener = [](int done) {
        if (done == 3) throw std::runtime_error("interrupted");
    };
    EXPECT_THROW(parallel_for(
                     50, 2, [](int) {}, listener),
                 std::runtime_error);
}

TEST(ParallelFor, SharesItsThreadsWithTheLoopsWithin) {
    Callers threads;
    parallel_for(4, 2, [&](int) { parallel_for(50, 8, [&](int) { threads.add(); }); });
    EXPECT_LE(threads.count(), 2u);
}

TEST(NestedParallelFor, CallsEachIndexOfEachLoopOnce) {
    for (const int threads : {1, 2, 5}) {
        std::vector<std::vector<int>> calls(7, std::vector<int>(50));
        nested_parallel_for(7, threads, [&](int row) {
            for (const int within : {0, 1}) {
                int told = 0;
                parallel_for(
                    50, within,
                    [&](int i) {
                        ++calls[static_cast<std::size_t>(row)][static_cast<std::size_t>(i)];
                    },
                    [&](int done) { EXPECT_EQ(done, ++told); });
                EXPECT_EQ(told, 50);
            }
        });
        for (const std::vector<int>& of_row : calls)
            for (const int count : of_row) EXPECT_EQ(count, 2);
    }
}

TEST(NestedParallelFor, SharesItsThreadsWithTheLoopsWithin) {
    Callers threads;
    std::barrier all_three(3);  // reached only where three threads work on the one row
    nested_parallel_for(1, 3, [&](int) {
        parallel_for(3, 0, [&](int) {
            all_three.arrive_and_wait();
            threads.add();
        });
        parallel_for(100, 8, [&](int) { threads.add(); });
    });
    EXPECT_EQ(threads.count(), 3u) << "and on no others";
}

TEST(NestedParallelFor, KeepsASingleCallOnTheCallingThread) {
    for (int n = 0; n < 50; ++n)
        nested_parallel_for(1, 4, [caller = std::this_thread::get_id()](int) {
            EXPECT_EQ(std::this_thread::get_id(), caller);
        });
}

TEST(NestedParallelFor, IsALoopOfTheOneAroundIt) {
    Callers threads;
    nested_parallel_for(3, 2, [&](int) {
        nested_parallel_for(20, 2, [&](int) { parallel_for(3, 2, [&](int) { threads.add(); }); });
    });
    EXPECT_LE(threads.count(), 2u);
    EXPECT_EQ(threads.calls(), 3 * 20 * 3);
}

TEST(NestedParallelFor, RethrowsFromALoopWithin) {
    EXPECT_THROW(nested_parallel_for(4, 2,
                                     [](int row) {
                                         parallel_for(10, 2, [&](int i) {
                                             if (row == 2 && i == 7) throw std::runtime_error("7");
                                         });
                                     }),
                 std::runtime_error);
}

}  // namespace
}  // namespace stratus
