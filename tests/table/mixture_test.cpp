// Tables that mix two kinds of scattering, seen at one mixture: TableView::at.
#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>

#include "refusal.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

/// A table whose interpolated part is `level` everywhere.
Table level_table(double level, double g) {
    Table table = empty_table({4, 4, 4, 4, 4}, {0.25, 8, true});
    table.phase_function = PhaseFunction::henyey_greenstein(g);
    fill(table, [level](const SamplePoint&) { return level; });
    return table;
}

const Table& first() {
    static const Table table = level_table(0.5, 0.3);
    return table;
}

const Table& second() {
    static const Table table = level_table(2, -0.6);
    return table;
}

const Table& both() {
    static const Table table = mixed(first(), second());
    return table;
}

constexpr double depths[] = {0.05, 0.9, 8, 20, 1e5, infinity};

// Samples are floats.
constexpr double mixture_rounding = 1e-6;

TEST(Mixture, GoesStraightFromOneKindToTheOther) {
    for (const double f : {0.0, 0.3, 0.75, 1.0})
        for (const double depth : depths)
            for (const Geometry& at : three_geometries)
                for (const auto look_up : {reflection, transmission}) {
                    const Scattered a = look_up(first().view(), 0.9, depth, at);
                    const Scattered b = look_up(second().view(), 0.9, depth, at);
                    const Scattered found = look_up(both().view().at({f}), 0.9, depth, at);
                    const double expected = f * a.multiple + (1 - f) * b.multiple;
                    EXPECT_NEAR(found.single, f * a.single + (1 - f) * b.single,
                                1e-14 * found.single);
                    EXPECT_NEAR(found.multiple, expected, mixture_rounding * expected);
                }
}

TEST(Mixture, OfEachEndIsTheTableOfOneKindToTheBit) {
    for (const double depth : depths)
        for (const Geometry& at : three_geometries)
            for (const auto look_up : {reflection, transmission}) {
                EXPECT_EQ(look_up(both().view().at({0}), 0.9, depth, at).total(),
                          look_up(second().view(), 0.9, depth, at).total());
                EXPECT_EQ(look_up(both().view().at({1}), 0.9, depth, at).multiple,
                          look_up(first().view(), 0.9, depth, at).multiple);
            }
}

TEST(Mixture, IsThatOfTheSlicesBoundAtIt) {
    const TableView view = both().view().at({0.25});
    const Slice slice = bind(view, 0.9, 0.9);
    const RgbSlice rgb = bind_rgb(view, {0.9, 0.9, 8}, {0.9, 0.5, 0.9});
    for (const Geometry& at : three_geometries) {
        const double R = reflection(view, 0.9, 0.9, at).total();
        const double T = transmission(view, 0.9, 8, at).total();
        constexpr double straight_lines = 1e-3;  // between the samples of a slice
        EXPECT_NEAR(value_of(slice, Side::reflection, at), R, straight_lines * R);
        EXPECT_NEAR(rgb.transmission(static_cast<float>(at.mu_in), static_cast<float>(at.mu_out),
                                     static_cast<float>(at.azimuth))
                        .b,
                    T, straight_lines * T);
    }
    const double forward =
        0.25 * (*view.phase_function)(1) + 0.75 * (*view.second_phase_function)(1);
    EXPECT_NEAR(slice.source_behind(1), source_seen_through(forward, 0.9, 0.9, 1), 1e-6);
}

/// At depth 8 and k = 0.5 R is at its limit, but transmitted light may be an eighth off the shape of a deep layer's.
TEST(Mixture, KnowsDeepTransmissionOnlyOnceItsShapeIsThatOfDeepLayers) {
    const auto half = [](const SamplePoint&) { return 0.5; };
    for (const double deepest : {8.0, 32.0}) {
        Table table = filled({2, 4, 3, 3, 3}, {0.25, deepest, false}, half, half);
        table.diffusion_exponent = {0.5, 0.5};
        table.tolerance = 1e-2;
        EXPECT_NO_THROW(bind(table.view(), infinity, 0.9));
        EXPECT_NO_THROW(bind(table.view(), 50, 0.9));  // below depth 32 T is 1e-8 or less
        if (deepest == 8)
            expect_refusal([&] { bind(table.view(), 12, 0.9); },
                           "optical_depth must be in [0, 8] of the table, or deep enough for the "
                           "law of diffusion, got 12");
        table.transmission_multiple.clear();
        EXPECT_NO_THROW(bind(table.view(), 50, 0.9));
    }
}

TEST(Mixture, KnowsNoDeepLayerWhereOnePartIsFarFromItsLimit) {
    const auto half = [](const SamplePoint&) { return 0.5; };
    Table steep = filled({2, 4, 3, 3, 3}, {0.25, 32, false}, half, half), flat = steep;
    steep.diffusion_exponent = {0.5, 0.5};
    flat.diffusion_exponent = {0, 0};
    const Table table = mixed(flat, steep);
    EXPECT_NO_THROW(bind(table.view().at({0}), 50, 0.9));
    for (const double share : {0.5, 1.0})
        expect_refusal(
            [&] { bind(table.view().at({share}), 50, 0.9); },
            "optical_depth must be in [0, 32] of the table, or deep enough for the law of "
            "diffusion, got 50");
}

TEST(Mixture, NotChosenGivesNotANumberAndCannotBeBound) {
    EXPECT_TRUE(std::isnan(reflection(both().view(), 0.9, 1, three_geometries[0]).total()));
    EXPECT_TRUE(std::isnan(transmission(both().view(), 0.9, 1, three_geometries[0]).total()));
    expect_refusal([] { bind(both().view(), 1, 0.9); },
                   "at: mixture must be chosen for this table, got nan");
    expect_refusal([] { bind(both().view().at({1.1}), 1, 0.9); },
                   "at: mixture must be in [0, 1], got 1.1");
}

}  // namespace
}  // namespace stratus
