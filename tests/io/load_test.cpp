// Many threads look up one table while another loads and drops others, as in a renderer: for 3 s,
// or STRATUS_LOAD_SECONDS.
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>

#include "indices.h"
#include "sample_table.h"
#include "temporary_folder.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <malloc.h>
#include <thread>
#include <vector>

namespace stratus::test {
namespace {

constexpr int thread_count = 64;

struct Query {
    double albedo, optical_depth;
    Geometry geometry;
};

std::vector<Query> random_queries() {
    Uniform share(64);
    std::vector<Query> all(512);
    for (Query& at : all)
        at = {share(),
              0.01 * std::pow(1000, share()),
              {0.03 + 0.97 * share(), 0.03 + 0.97 * share(), 2 * pi * share()}};
    return all;
}

using Answer = std::array<double, 2>;  // R, T

Answer answer(const TableView& table, const Query& at) {
    return {reflection(table, at.albedo, at.optical_depth, at.geometry).total(),
            transmission(table, at.albedo, at.optical_depth, at.geometry).total()};
}

std::vector<Answer> answers(const TableView& table, const std::vector<Query>& all) {
    std::vector<Answer> found;
    for (const Query& at : all) found.push_back(answer(table, at));
    return found;
}

/// Does not allocate, since heap use is measured.
bool answers_are(const std::vector<Answer>& expected, const TableView& table,
                 const std::vector<Query>& all) {
    for (const auto k : indices(all))
        if (answer(table, all[k]) != expected[k]) return false;
    return true;
}

/// Bytes allocated, in all arenas and mapped separately.
double heap_in_use() {
    const struct mallinfo2 info = ::mallinfo2();
    return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

double seconds_to_run() {
    const char* const text = std::getenv("STRATUS_LOAD_SECONDS");
    return text ? std::strtod(text, nullptr) : 3;
}

TEST(Load, OnManyThreadsChangesNeitherResultsNorHeapUse) {
    const TemporaryFolder folder;
    const Table table = sample_table({5, 8, true, 16, 16, 9});
    const std::vector<std::filesystem::path> paths{folder / "other.h5", folder / "other.exr"};
    for (const auto& path : paths) write_table(sample_table({4, 6, true, 12, 12, 7}), path);
    const std::vector<Query> queries = random_queries();
    const std::vector<Answer> expected = answers(table.view(), queries);

    std::atomic<bool> stop = false;
    std::atomic<long> wrong = 0, rounds = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < thread_count; ++t)
        threads.emplace_back([&] {
            while (!stop) {
                if (!answers_are(expected, table.view(), queries)) ++wrong;
                ++rounds;
            }
        });

    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(seconds_to_run());
    constexpr int warm_up = 5;  // loads after which libraries have filled their caches
    std::vector<Answer> other_expected;
    std::vector<double> in_use;
    int loads = 0;
    for (; loads <= 2 * warm_up || Clock::now() < end; ++loads) {
        for (const auto& path : paths) {
            const Table other = read_table(path);
            if (other_expected.empty()) other_expected = answers(other.view(), queries);
            if (!answers_are(other_expected, other.view(), queries)) ++wrong;
        }
        in_use.push_back(heap_in_use());
    }
    stop = true;
    for (std::thread& thread : threads) thread.join();

    EXPECT_EQ(wrong, 0);
    EXPECT_GE(rounds, thread_count);
    const auto middle = in_use.begin() + warm_up + (loads - warm_up) / 2;
    const double before = *std::min_element(in_use.begin() + warm_up, middle);
    const double after = *std::min_element(middle, in_use.end());
    EXPECT_LE(after, 1.01 * before) << loads << " loads";
}

}  // namespace
}  // namespace stratus::test
