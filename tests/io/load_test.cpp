// A renderer's day: many threads look up one table while another loads and drops others. 3 s, or as
// many as STRATUS_LOAD_SECONDS says.
#include <stratus/io/table_file.h>
#include <stratus/runtime/lookup.h>

#include "sample_table.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <malloc.h>
#include <string>
#include <thread>
#include <vector>

namespace stratus {
namespace {

constexpr int thread_count = 64;

struct Question {
    double albedo, optical_depth;
    Geometry geometry;
};

std::vector<Question> questions() {
    std::mt19937 random(64);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<Question> all(512);
    for (Question& at : all)
        at = {share(random),
              0.01 * std::pow(1000, share(random)),
              {0.03 + 0.97 * share(random), 0.03 + 0.97 * share(random), 2 * pi * share(random)}};
    return all;
}

using Answer = std::array<double, 2>;  // R, T

Answer answer(const TableView& table, const Question& at) {
    return {reflection(table, at.albedo, at.optical_depth, at.geometry).total(),
            transmission(table, at.albedo, at.optical_depth, at.geometry).total()};
}

std::vector<Answer> answers(const TableView& table, const std::vector<Question>& all) {
    std::vector<Answer> found;
    for (const Question& at : all) found.push_back(answer(table, at));
    return found;
}

/// Without touching the heap, which is watched.
bool answers_are(const std::vector<Answer>& expected, const TableView& table,
                 const std::vector<Question>& all) {
    for (std::size_t k = 0; k < all.size(); ++k)
        if (answer(table, all[k]) != expected[k]) return false;
    return true;
}

/// Bytes in use, of all arenas and of what is mapped by itself.
double heap() {
    const struct mallinfo2 info = ::mallinfo2();
    return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

double seconds_to_run() {
    const char* const asked = std::getenv("STRATUS_LOAD_SECONDS");
    return asked ? std::strtod(asked, nullptr) : 3;
}

TEST(Load, OfSixtyFourThreadsLeavesAnswersAndHeapAsTheyWere) {
    const test::TemporaryFolder folder;
    const Table table = test::sample_table({5, 8, true, 16, 16, 9});
    const std::vector<std::filesystem::path> paths{folder / "other.h5", folder / "other.exr"};
    for (const auto& path : paths) write_table(test::sample_table({4, 6, true, 12, 12, 7}), path);
    const std::vector<Question> asked = questions();
    const std::vector<Answer> expected = answers(table.view(), asked);

    std::atomic<bool> stop = false;
    std::atomic<long> wrong = 0, rounds = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < thread_count; ++t)
        threads.emplace_back([&] {
            while (!stop) {
                if (!answers_are(expected, table.view(), asked)) ++wrong;
                ++rounds;
            }
        });

    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(seconds_to_run());
    constexpr int warm_up = 5;  // loads after which libraries hold what they keep
    std::vector<Answer> of_other;
    std::vector<double> in_use;
    int loads = 0;
    for (; loads <= 2 * warm_up || Clock::now() < end; ++loads) {
        for (const auto& path : paths) {
            const Table other = read_table(path);
            if (of_other.empty()) of_other = answers(other.view(), asked);
            if (!answers_are(of_other, other.view(), asked)) ++wrong;
        }
        in_use.push_back(heap());
    }
    stop = true;
    for (std::thread& thread : threads) thread.join();

    EXPECT_EQ(wrong, 0);
    EXPECT_GE(rounds, thread_count);
    const auto middle = in_use.begin() + warm_up + (loads - warm_up) / 2;
    const double before = *std::min_element(in_use.begin() + warm_up, middle);
    const double after = *std::min_element(middle, in_use.end());
    EXPECT_LE(after, 1.01 * before) << loads << " loads";
    std::cout << rounds << " rounds of " << 2 * asked.size() << " lookups, " << 2 * loads
              << " loads; heap " << before << ", then " << after << " bytes\n";
}

}  // namespace
}  // namespace stratus
