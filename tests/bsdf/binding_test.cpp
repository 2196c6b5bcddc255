#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>

#include "directions.h"
#include "refusal.h"
#include "row_name.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

struct AzimuthCase {
    const char* name;
    bool with_azimuth;
    AxisScale scale;
};

class BindingTolerance : public testing::TestWithParam<AzimuthCase> {};

TEST_P(BindingTolerance, IsMet) {
    const Table table = smooth_table(GetParam().with_azimuth, GetParam().scale);
    for (const double tau : {0.02, 0.3, 5.0, 100.0, infinity})
        for (const double w : {0.2, 0.9, 1.0}) {
            const Slice slice = bind(table.view(), tau, w);
            for (const Direction& at : random_directions(500, 0.02f)) {
                const double R = reflection(table.view(), w, tau, at.geometry()).total();
                const double T = transmission(table.view(), w, tau, at.geometry()).total();
                EXPECT_NEAR(reflected(slice, at), R, table.tolerance * R);
                EXPECT_NEAR(transmitted(slice, at), T, table.tolerance * std::max(T, 1e-6));
            }
        }
}

INSTANTIATE_TEST_SUITE_P(
    All, BindingTolerance,
    testing::Values(AzimuthCase{"an_isotropic_table", false, AxisScale::linear},
                    AzimuthCase{"an_anisotropic_table", true, AxisScale::linear},
                    AzimuthCase{"azimuth_in_its_square_root", true, AxisScale::square_root}),
    row_name);

TEST(Binding, TakesFewerBytesAtALooserTolerance) {
    Table table = smooth_table(true);
    const std::size_t usual = bind(table.view(), 1, 0.9).bytes();
    table.tolerance = 1e-2;
    EXPECT_LT(bind(table.view(), 1, 0.9).bytes(), usual / 2);
}

TEST(Binding, GivesASliceThatOutlivesItsTable) {
    Slice slice = [] {
        const Table table = smooth_table(true);
        return bind(table.view(), 1, 0.9);
    }();
    const float before = slice.reflection(0.4f, 0.6f, 1);
    const Slice moved = std::move(slice);
    EXPECT_EQ(moved.reflection(0.4f, 0.6f, 1), before);
    EXPECT_GT(before, 0);
}

TEST(Binding, KeepsSingleScatteringWhereSamplesAreNegative) {
    Table table = empty_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    table.phase_function = PhaseFunction::henyey_greenstein(0.5);
    fill(table, [](const SamplePoint&) { return -1; });
    Effects effects;
    effects.multiple = false;
    const float single = bind(table.view(), 1, 0.9, effects).transmission(0.4f, 0.6f, 1);
    EXPECT_GT(single, 0);
    EXPECT_NEAR(bind(table.view(), 1, 0.9).transmission(0.4f, 0.6f, 1), single, 1e-6 * single);
    const Scattered light = transmission(table.view(), 0.9, 1, {0.4, 0.6, 1});
    EXPECT_NEAR(light.single, single, 1e-6 * single);
    EXPECT_EQ(light.multiple, 0);
}

TEST(Binding, RefusesLayersOutsideTheTable) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    const TableView view = table.view();
    expect_refusal([&] { bind(view, 1, 0.1); },
                   "bind: albedo must be 0 or in [0.19, 1] of the table, got 0.1");
    expect_refusal([&] { bind(view, 9, 1); },
                   "bind: optical_depth must be in [0, 8] of the table, or deep enough for the law "
                   "of diffusion, got 9");
    expect_refusal([&] { bind(view, infinity, 1); },
                   "optical_depth must be in [0, 8] of the table, or deep enough for the law of "
                   "diffusion, got inf");
    expect_refusal(
        [&] {
            bind_rgb(view, {1, 1, 9}, {1, 1, 1});
        },
        "optical_depth must be in [0, 8] of the table, or deep enough for the law of diffusion, "
        "got 9");
    Effects effects;
    effects.density = 0.5;
    expect_refusal([&] { bind(view, 5, 1, effects); },
                   "optical_depth must be in [0, 8] of the table, or deep enough for the law of "
                   "diffusion, got 10");
    effects.multiple = false;
    EXPECT_NO_THROW(bind(view, 5, 1, effects));
    const Table both = mixed(table, table);
    Table part = both;
    set_mixture(part, make_axis(AxisScale::linear, 0.25, 0.75, 2));
    prepare(part);
    expect_refusal([&] { bind(part.view().at({0.1}), 1, 1); },
                   "bind: mixture must be in [0.25, 0.75] of the table, got 0.1");
    Table semi_infinite = table;
    semi_infinite.optical_depth.values = {infinity};
    semi_infinite.reflection_multiple.resize(semi_infinite.sample_count());
    semi_infinite.transmission_multiple.clear();
    prepare(semi_infinite);
    expect_refusal([&] { bind(semi_infinite.view(), 1, 1); },
                   "optical_depth must be inf, all that the table holds, got 1");
}

TEST(Binding, ClampsToTheNearestLayerOnRequest) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    Effects multiple;
    multiple.single = false;
    const Slice edge = bind(table.view(), 8, 1, multiple);
    EXPECT_FALSE(edge.clamped());
    for (const double tau : {100.0, infinity}) {
        const Slice slice = bind(table.view(), tau, 1, multiple, OutsideTable::clamp);
        EXPECT_TRUE(slice.clamped());
        constexpr double refinement = 1e-4;  // is relative to totals, which differ
        EXPECT_NEAR(slice.reflection(0.5f, 0.7f, 1), edge.reflection(0.5f, 0.7f, 1), refinement);
        // A semi-infinite layer transmits nothing.
        EXPECT_NEAR(slice.transmission(0.5f, 0.7f, 1),
                    tau == infinity ? 0 : edge.transmission(0.5f, 0.7f, 1), refinement);
    }
    EXPECT_TRUE(bind(table.view(), 1, 0.1, {}, OutsideTable::clamp).clamped());
    EXPECT_FALSE(bind(table.view(), 1, 0.2, {}, OutsideTable::clamp).clamped());
}

TEST(Binding, ExtrapolatesByTheLimitingLaws) {
    const Table table = plain_table({4, 6, 6, 6, 5}, {0.5, 32, false});
    const TableView view = table.view();
    for (const Direction& at : random_directions(100, 0.02f)) {
        const Geometry g = at.geometry();
        // No scattering.
        const Slice black = bind(view, 1, 0);
        EXPECT_EQ(reflected(black, at), 0);
        EXPECT_EQ(transmitted(black, at), 0);
        EXPECT_FALSE(black.clamped());
        // Thinner than the table.
        const double thin = reflection(view, 0.9, 0.01, g).total();
        EXPECT_NEAR(reflected(bind(view, 0.01, 0.9), at), thin, 1e-3 * thin);
        // Deeper than the table, where the diffusion law has saturated.
        const Slice semi_infinite = bind(view, infinity, 0.5);
        EXPECT_FALSE(semi_infinite.clamped());
        EXPECT_EQ(transmitted(semi_infinite, at), 0);
        const double deep = reflection(view, 0.5, 32, g).total();
        EXPECT_NEAR(reflected(semi_infinite, at), deep, 1e-3 * deep);
        const double T =
            small_table_scale(Side::transmission, {0.5, 40, g.mu_in, g.mu_out, g.azimuth});
        EXPECT_NEAR(transmitted(bind(view, 40, 0.5), at), T, 1e-2 * T + 1e-12);
    }
    EXPECT_EQ(bind(view, infinity, 1, {.reflection = false}).transmission(1, 1, 0), 0);
}

TEST(Binding, RefusesArgumentsOutOfRange) {
    Table table = smooth_table(true);
    const TableView view = table.view();
    expect_refusal([&] { bind(view, -1, 0.5); }, "bind: optical_depth must be in [0, inf], got -1");
    expect_refusal([&] { bind(view, NAN, 0.5); }, "optical_depth must be in [0, inf], got nan");
    expect_refusal([&] { bind(view, 1, 1.1); }, "bind: albedo must be in [0, 1], got 1.1");
    expect_refusal(
        [&] {
            bind_rgb(view, {1, 1, 1}, {0.5, -0.1, 0.5});
        },
        "albedo must be in [0, 1], got -0.1");
    expect_refusal([&] { bind(view, 1, 0.5, {.density = 1}); }, "density must be in [0, 1)");
}

}  // namespace
}  // namespace stratus
