// One table, many threads: what `./run test --sanitize` runs under ThreadSanitizer, which sees
// every unguarded access to what one thread writes.
#include <stratus/bsdf/bsdf.h>
#include <stratus/table/lookup.h>

#include "row_name.h"
#include "small_table.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

namespace stratus {
namespace {

constexpr int thread_count = 8;

/// All that threads share.
struct Shared {
    Table table;
    Table over_ground;
    Bsdf bsdf;
};

/// A table with a phase function of every kind, from 0.5 to 8 and at infinity.
Table every_kind() {
    Table table = plain_table({5, 5, 5, 5, 5}, {0.5, 8, true});
    table.phase_function = parse_phase_function(
        "0.1*isotropic + 0.1*rayleigh + 0.1*anisotropic:x=0.5 + 0.2*lambert_sphere + "
        "0.2*henyey_greenstein:g=0.1 + 0.1*tabulated:points=0 1/90 0/180 0.25 + "
        "0.2*moments:chi=1 0.1");
    return table;
}

Table every_kind_over_ground() {
    Table table = every_kind();
    table.transmission_multiple.clear();
    table.lower_boundary = LowerBoundary::layer(table.phase_function, 0.9);
    prepare(table);
    return table;
}

/// A function of a shared table at one point. New lookups are rows of `functions` below.
struct Function {
    const char* name;
    double (*value)(const Shared& shared, const SamplePoint& p);
};

const Function functions[] = {
    {"Reflection",
     [](const Shared& shared, const SamplePoint& p) {
         return scattering_at(shared.table, Side::reflection, p).total();
     }},
    {"Transmission",
     [](const Shared& shared, const SamplePoint& p) {
         return scattering_at(shared.table, Side::transmission, p).total();
     }},
    {"ReflectionOverGround",
     [](const Shared& shared, const SamplePoint& p) {
         return scattering_at(shared.over_ground, Side::reflection, p).total();
     }},
    {"Bsdf",
     [](const Shared& shared, const SamplePoint& p) {
         const float mu = static_cast<float>(p.mu_in);
         const Bsdf::SampleOfAngles drawn = shared.bsdf.sample(mu, static_cast<float>(p.mu_out),
                                                               static_cast<float>(p.albedo), 0.5f);
         return double{drawn.value} +
                double{shared.bsdf.pdf(drawn.side, mu, drawn.mu_out, drawn.azimuth)} +
                double{shared.bsdf.albedo(mu).reflected};
     }},
};

/// Below, within and above the finite depths.
std::vector<SamplePoint> random_points(int count) {
    Uniform share(7);
    std::vector<SamplePoint> points;
    for (int i = 0; i < count; ++i)
        points.push_back(
            {share(), 0.1 * std::pow(1000, share()), 1 - share(), 1 - share(), 2 * pi * share()});
    return points;
}

class SharedTable : public testing::TestWithParam<Function> {};

TEST_P(SharedTable, IsBitIdenticalFromManyThreads) {
    const Table table = every_kind();
    const Shared shared{table, every_kind_over_ground(), Bsdf(bind(table.view(), 2, 0.7))};
    const std::vector<SamplePoint> points = random_points(200);
    const auto values_at_all_points = [&] {
        std::vector<double> values;
        for (const SamplePoint& p : points) values.push_back(GetParam().value(shared, p));
        return values;
    };

    // The threads come first, so that they would also meet on what is computed at first use.
    std::vector<std::vector<double>> of_thread(thread_count);
    std::atomic<int> waiting{thread_count};
    std::vector<std::thread> threads;
    for (std::vector<double>& values : of_thread)
        threads.emplace_back([&] {
            --waiting;
            while (waiting > 0) std::this_thread::yield();  // all begin at once
            values = values_at_all_points();
        });
    for (std::thread& thread : threads) thread.join();

    const std::vector<double> alone = values_at_all_points();
    for (const std::vector<double>& values : of_thread) {
        ASSERT_EQ(values.size(), alone.size());
        EXPECT_EQ(std::memcmp(values.data(), alone.data(), alone.size() * sizeof(double)), 0);
    }
}

INSTANTIATE_TEST_SUITE_P(EveryFunction, SharedTable, testing::ValuesIn(functions), row_name);

#if defined(__SANITIZE_THREAD__)
TEST(ThreadSanitizerDeathTest, SeesTwoThreadsWriteTheSame) {
    constexpr int exit_code_of_a_race = 66;
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    EXPECT_EXIT(
        {
            int shared = 0;
            std::thread other([&] { ++shared; });
            ++shared;
            other.join();
            std::exit(0);
        },
        testing::ExitedWithCode(exit_code_of_a_race), "data race");
}
#endif

}  // namespace
}  // namespace stratus
