#include <stratus/bake/parallel.h>

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace stratus {
namespace {

TEST(ThreadCount, IsTheRequestedNumber) {
    EXPECT_EQ(thread_count(1), 1);
    EXPECT_EQ(thread_count(7), 7);
}

TEST(ThreadCount, IsPositiveByDefault) { EXPECT_GE(thread_count(0), 1); }

TEST(ParallelFor, CallsEachIndexOnce) {
    for (const int threads : {0, 1, 2, 7, 100})
        for (const int count : {0, 1, 5, 1000}) {
            std::vector<std::atomic<int>> calls(static_cast<std::size_t>(count));
            parallel_for(count, threads, [&](int i) { ++calls[static_cast<std::size_t>(i)]; });
            for (int i = 0; i < count; ++i)
                EXPECT_EQ(calls[static_cast<std::size_t>(i)], 1) << i << " of " << count;
        }
}

TEST(ParallelFor, ReportsEveryFinishedCall) {
    std::vector<int> told;  // calls come one at a time: no lock
    parallel_for(
        200, 4, [](int) {}, [&](int done) { told.push_back(done); });
    ASSERT_EQ(told.size(), 200u);
    for (int n = 0; n < 200; ++n) EXPECT_EQ(told[static_cast<std::size_t>(n)], n + 1);
}

TEST(ParallelFor, RethrowsFromTheBody) {
    for (const int threads : {1, 3}) try {
            parallel_for(50, threads, [](int i) {
                if (i == 17) throw std::runtime_error("cell 17");
            });
            ADD_FAILURE() << "nothing was thrown";
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "cell 17");
        }
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

}  // namespace
}  // namespace stratus
