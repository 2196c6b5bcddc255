#include <stratus/runtime/half_table.h>

#include <stratus/runtime/constants.h>
#include <stratus/runtime/lookup.h>

#include "small_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stratus {
namespace {

constexpr double half_rounding = 1.0 / 2048;

/// The cubic through four samples has weights whose magnitudes sum to no more than 1.25 an axis.
const double weights_of_five_axes = std::pow(1.25, 5);

/// Between 1 and 3, what is left of samples once they are divided by all that lookups divide by.
double uneven(const Point& p) {
    const double depth = p.optical_depth < infinity ? std::log2(p.optical_depth) : 9;
    return 2 + std::sin(4 * p.albedo + depth + 3 * p.mu_in + 5 * p.mu_out + 3 * p.azimuth);
}

double reflected(const Point& p) { return small_table_reflection_scale(p) * uneven(p); }

/// Negative, for the sign's sake.
double transmitted(const Point& p) { return -small_table_transmission_scale(p) * uneven(p); }

struct Lookups {
    Scattered reflected, transmitted;
};

Lookups look_up(const TableView& view, const Point& p) {
    const Geometry geometry{p.mu_in, p.mu_out, p.azimuth};
    return {reflection(view, p.albedo, p.optical_depth, geometry),
            transmission(view, p.albedo, p.optical_depth, geometry)};
}

struct Shape {
    const char* name;
    Counts counts;
    Depths depths;
};

class Halved : public testing::TestWithParam<Shape> {};

TEST_P(Halved, AnswersAsItsFloatsDoToTheRoundingOfHalves) {
    const Shape& shape = GetParam();
    const Table table = filled(shape.counts, shape.depths, reflected, transmitted);
    const HalfTable half = halved(table);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0, 1);
    const double reach = shape.depths.highest / shape.depths.lowest;
    // Samples are up to 3 times their scale.
    const double bound = half_rounding * weights_of_five_axes * 3;
    int differing = 0;
    for (int i = 0; i < 2000; ++i) {
        const Point p{0.19 + 0.81 * share(random),
                      shape.depths.lowest * std::pow(reach, share(random)),
                      0.01 + 0.99 * share(random), 0.01 + 0.99 * share(random), pi * share(random)};
        const Lookups floats = look_up(table.view(), p), halves = look_up(half.view(), p);
        EXPECT_EQ(halves.reflected.single, floats.reflected.single);
        EXPECT_EQ(halves.transmitted.single, floats.transmitted.single);
        EXPECT_NEAR(halves.reflected.multiple, floats.reflected.multiple,
                    bound * small_table_reflection_scale(p));
        EXPECT_NEAR(halves.transmitted.multiple, floats.transmitted.multiple,
                    bound * small_table_transmission_scale(p));
        differing += halves.reflected.multiple != floats.reflected.multiple ? 1 : 0;
    }
    EXPECT_GT(differing, 1900);  // rarely do errors cancel to the last bit
}

INSTANTIATE_TEST_SUITE_P(EveryWidthOfAzimuths, Halved,
                         testing::Values(Shape{"OneAzimuth", {5, 6, 5, 5, 1}, {0.5, 8, true}},
                                         Shape{"TwoAzimuths", {5, 6, 5, 5, 2}, {0.5, 8, true}},
                                         Shape{"ThreeAzimuths", {5, 6, 5, 5, 3}, {0.5, 8, true}},
                                         Shape{"FiveAzimuths", {5, 6, 5, 5, 5}, {0.5, 8, true}},
                                         Shape{"ShortAxes", {2, 3, 3, 2, 3}, {0.5, 8, false}},
                                         Shape{"ThinLayers", {5, 6, 5, 5, 5}, {1e-6, 1e-4, false}}),
                         [](const auto& row) { return row.param.name; });

TEST(Halved, HoldsWhatIsFarBeyondTheRangeOfHalves) {
    // T falls from 1e-1 to 1e-30 and less; cosines of 0.01 scatter 1e8 times what those of 1 do in
    // layers of 1e-6 (small_table.h), and 1e30 is added on top.
    for (const Depths& depths : {Depths{1, 64, false}, Depths{1e-6, 1e-4, false}}) {
        const auto large = [](const Point& p) { return 1e30 * reflected(p); };
        const Table table = filled({3, 5, 5, 5, 1}, depths, large, transmitted);
        const HalfTable half = halved(table);
        for (const double w : table.albedo.values)
            for (const double tau : table.optical_depth.values)
                for (const double mu_in : table.mu_in.values)
                    for (const double mu_out : table.mu_out.values) {
                        const Point p{w, tau, mu_in, mu_out, 0};
                        const Lookups found = look_up(half.view(), p);
                        EXPECT_NEAR(found.reflected.multiple / large(p), 1, 1.01 * half_rounding);
                        EXPECT_NEAR(found.transmitted.multiple / transmitted(p), 1,
                                    1.01 * half_rounding);
                    }
    }
}

TEST(Halved, AnswersAsItsFloatsDoOutsideTheFiniteDepths) {
    const Table table = filled({5, 6, 5, 5, 5}, {0.5, 8, true}, reflected, transmitted);
    const HalfTable half = halved(table);
    for (const double w : table.albedo.values)
        for (const double tau : {0.0, 1e-3, 0.4, 8.1, 20.0, 1e3, infinity}) {
            const Point p{w, tau, 0.4, 0.6, 1};
            const Lookups floats = look_up(table.view(), p), halves = look_up(half.view(), p);
            // Three axes are interpolated, and what lies between two depths is between their
            // values.
            const double bound = half_rounding * std::pow(1.25, 3) * 3;
            EXPECT_NEAR(halves.reflected.multiple, floats.reflected.multiple,
                        bound * small_table_reflection_scale(p));
            EXPECT_NEAR(halves.transmitted.multiple, floats.transmitted.multiple,
                        bound * small_table_transmission_scale(p));
        }
}

TEST(Halved, LeavesSamplesThatFloatCannotHoldToTheirNeighbours) {
    const Table table = filled({5, 8, 3, 3, 1}, {1, 1024, false}, reflected, transmitted);
    const HalfTable half = halved(table);
    ASSERT_EQ(table.transmission_weight[7], 0);  // exp(-0.99 * 1024)
    EXPECT_EQ(half.table.transmission_weight[7], 0);
    for (const double tau : {300.0, 1000.0})
        for (const double w : {0.19, 0.5, 0.999, 1.0}) {
            const Point p{w, tau, 0.4, 0.6, 0};
            const double floats = look_up(table.view(), p).transmitted.multiple;
            const double halves = look_up(half.view(), p).transmitted.multiple;
            EXPECT_NEAR(
                halves, floats,
                half_rounding * weights_of_five_axes * 3 * small_table_transmission_scale(p));
        }
}

TEST(Halved, KeepsLayersThatScatterNothing) {
    Table table = empty_table({2, 3, 3, 3, 1}, {1, 8, true});
    table.reflection_multiple.assign(table.sample_count(), 0);
    prepare(table);
    const HalfTable half = halved(table);
    EXPECT_NE(half.table.reflection_weight[0], 0);
    const Lookups found = look_up(half.view(), {0.5, 2, 0.4, 0.6, 0});
    EXPECT_EQ(found.reflected.multiple, 0);
    EXPECT_EQ(found.transmitted.multiple, 0);  // has no such side
    EXPECT_FALSE(half.view().has_transmission());
}

TEST(Halved, KeepsSignsAndDropsWhatIsLost) {
    Table table = empty_table({1, 1, 1, 2, 2}, {1, 1, false});
    table.lower_boundary = LowerBoundary::surface(0.5);  // weights of 1
    table.reflection_multiple = {3, -2, 1e-9f, 0.25f};
    prepare(table);
    const HalfTable half = halved(table);
    const Samples samples = half.view().reflection_multiple;
    const float weight = half.table.reflection_weight[0];
    EXPECT_EQ(samples[0] * weight, 3);
    EXPECT_EQ(samples[1] * weight, -2);
    EXPECT_EQ(half.reflection_multiple[2].bits, 0);  // no subnormal number
    EXPECT_EQ(samples[3] * weight, 0.25f);
}

TEST(Samples, AreCopiedAsFloatsFromEitherKind) {
    const Table table = filled({3, 4, 3, 3, 5}, {0.5, 8, true}, reflected, transmitted);
    const HalfTable half = halved(table);
    for (const Samples& samples :
         {table.view().reflection_multiple, half.view().transmission_multiple}) {
        std::vector<float> some(20);
        samples.copy(7, 20, some.data());
        for (std::ptrdiff_t i = 0; i < 20; ++i)
            EXPECT_EQ(some[static_cast<std::size_t>(i)], samples[7 + i]);
    }
}

TEST(HalfTable, HoldsHalfTheBytesOfSamples) {
    const Table table = filled({3, 4, 3, 3, 5}, {0.5, 8, true}, reflected, transmitted);
    const HalfTable half = halved(table);
    EXPECT_EQ(sizeof(Half), 2u);
    EXPECT_EQ(half.reflection_multiple.size(), table.sample_count());
    EXPECT_EQ(half.transmission_multiple.size(), table.sample_count());
    EXPECT_EQ(half.table.reflection_multiple.capacity(), 0u);
    EXPECT_EQ(half.table.transmission_multiple.capacity(), 0u);
}

}  // namespace
}  // namespace stratus
