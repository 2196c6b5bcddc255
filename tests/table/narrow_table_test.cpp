// Tables of some directions alone: lookups of every kind, against tables of all of them.
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "indices.h"
#include "refusal.h"
#include "row_name.h"
#include "small_table.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace stratus {
namespace {

struct Directions {
    const char* name;
    Axis mu_in, mu_out, azimuth;
};

Axis cosines(double lowest, double highest, int count) {
    return make_axis(AxisScale::arcsine_of_fourth_root, lowest, highest, count);
}
Axis azimuths(double lowest, double highest, int count, AxisScale scale = AxisScale::linear) {
    return make_axis(scale, lowest, highest, count);
}

Table table_of(const Directions& directions, bool to_infinity = true) {
    Table table = empty_table({9, 12, 2, 2, 1}, {0.05, 8, to_infinity});
    table.phase_function = PhaseFunction::rayleigh();
    table.tolerance = small_table_tolerance;
    table.mu_in = directions.mu_in;
    table.mu_out = directions.mu_out;
    table.azimuth = directions.azimuth;
    fill(table, smooth_shape);
    return table;
}

const Table& full() {
    static const Table table =
        table_of({"Full", cosines(0.01, 1, 28), cosines(0.01, 1, 28), azimuths(0, pi, 17)});
    return table;
}

std::vector<Directions> narrow() {
    const Axis any_cosine = cosines(0.01, 1, 28), any_azimuth = azimuths(0, pi, 17);
    return {
        {"OneSun", cosines(0.35, 0.35, 1), any_cosine, any_azimuth},
        {"OneView", any_cosine, cosines(0.35, 0.35, 1), any_azimuth},
        {"SomeViews", any_cosine, cosines(0.2, 0.5, 7), any_azimuth},
        {"SomeOfBoth", cosines(0.2, 0.5, 7), cosines(0.2, 0.5, 7), any_azimuth},
        {"SomeOfEach", cosines(0.6, 0.7, 4), cosines(0.2, 0.5, 7), any_azimuth},
        {"SomeAzimuths", any_cosine, any_cosine, azimuths(1.2, 1.5, 4)},
        {"AzimuthsFromForward", any_cosine, any_cosine, azimuths(0, 0.7, 5)},
        {"AzimuthsToBackward", any_cosine, any_cosine, azimuths(2.3, pi, 5)},
        {"AzimuthsByRoots", any_cosine, any_cosine, azimuths(0.3, 1, 6, AxisScale::square_root)},
        {"OneAzimuth", any_cosine, any_cosine, azimuths(2, 2, 1)},
        {"LittleOfAll", cosines(0.35, 0.35, 1), cosines(0.2, 0.3, 4), azimuths(2.6, 2.8, 4)},
        {"OneDirection", cosines(0.35, 0.35, 1), cosines(0.6, 0.6, 1), azimuths(2, 2, 1)},
    };
}

class NarrowTable : public testing::TestWithParam<Directions> {
  protected:
    Table table_ = table_of(GetParam());

    /// Random layers, and directions within the table's.
    std::vector<SamplePoint> points(int count) const {
        Uniform uniform(3);
        const TableView view = table_.view();
        const auto within = [&](const AxisView& axis) {
            return axis.lowest + uniform() * (axis.highest - axis.lowest);
        };
        std::vector<SamplePoint> all;
        for (int n = 0; n < count; ++n) {
            SamplePoint p{};
            p.albedo = within(view.albedo);
            p.optical_depth = 0.05 * std::pow(200, uniform());
            p.mu_in = within(view.mu_in);
            p.mu_out = within(view.mu_out);
            p.azimuth = within(view.azimuth);
            all.push_back(p);
        }
        return all;
    }
};

TEST_P(NarrowTable, IsLookedUpLikeTheFullOne) {
    for (const SamplePoint& p : points(300))
        for (const Side side : both_sides) {
            const double expected = scattering_at(full(), side, p).total();
            const double found = scattering_at(table_, side, p).total();
            // Both interpolate; the coarser has 28 cosines and 17 azimuths.
            EXPECT_NEAR(found, expected, 0.5 * small_table_tolerance * expected)
                << p.mu_in << ' ' << p.mu_out << ' ' << p.azimuth;
        }
}

TEST_P(NarrowTable, IsSymmetricInAzimuth) {
    for (const SamplePoint& p : points(20)) {
        const double once = scattering_at(table_, Side::reflection, p).multiple;
        for (const double other : {-p.azimuth, 2 * pi - p.azimuth, 2 * pi + p.azimuth})
            EXPECT_NEAR(
                reflection(table_.view(), p.albedo, p.optical_depth, {p.mu_in, p.mu_out, other})
                    .multiple,
                once, 1e-6);
    }
}

TEST_P(NarrowTable, IsBoundLikeItIsLookedUp) {
    for (const SamplePoint& layer : points(4)) {
        const Slice slice = bind(table_.view(), layer.optical_depth, layer.albedo);
        const std::vector<SamplePoint> at = points(300);
        const PointArrays arrays(at);
        const PackedPoints all = arrays.view();
        std::vector<float> many(at.size());
        for (const Side side : both_sides) {
            slice.scattering(side, at.size(), all.mu_in, all.mu_out, all.azimuth, many.data());
            for (const auto n : indices(at)) {
                const double expected = scattering(table_.view(), side, layer.albedo,
                                                   layer.optical_depth, geometry(at[n]))
                                            .total();
                const double found = value_of(slice, side, geometry(at[n]));
                EXPECT_NEAR(found, expected, small_table_tolerance * std::max(expected, 0.01));
                EXPECT_NEAR(many[n], found, 2e-6 * std::max(found, 0.01));
            }
        }
    }
}

TEST_P(NarrowTable, IsPackedLikeItIsLookedUp) {
    const PackedTable packed(pack(table_));
    const std::vector<SamplePoint> at = points(200);
    const PointArrays arrays(at);
    std::vector<float> total(at.size());
    for (const Side side : both_sides) {
        packed.scattering(side, arrays.view(), total.data());
        for (const auto n : indices(at)) {
            const SamplePoint& p = at[n];
            const double expected = scattering_at(table_, side, p).total();
            const double found = scattering_at(packed, side, p).total();
            EXPECT_NEAR(found, expected, small_table_tolerance * std::max(expected, 0.01))
                << p.mu_in << ' ' << p.mu_out << ' ' << p.azimuth;
            EXPECT_NEAR(total[n], found, 2e-5 * std::max(found, 0.01));
        }
    }
}

TEST_P(NarrowTable, MakesNoBsdf) {
    EXPECT_FALSE(table_.view().has_all_directions());
    Slice slice = bind(table_.view(), 1, 0.9);
    EXPECT_FALSE(slice.has_all_directions());
    expect_refusal([&] { Bsdf(std::move(slice)); }, {"Bsdf", "all directions", "narrowed"});
    EXPECT_NO_THROW(Bsdf(bind(table_.view(), 1, 0.9, {.multiple = false})));
}

INSTANTIATE_TEST_SUITE_P(Of, NarrowTable, testing::ValuesIn(narrow()), row_name);

TEST(FullTable, MakesABsdf) {
    EXPECT_TRUE(full().view().has_all_directions());
    EXPECT_NO_THROW(Bsdf(bind(full().view(), 1, 0.9)));
}

TEST(NarrowTables, AreClampedToTheirDirections) {
    const Table table =
        table_of({"", cosines(0.35, 0.35, 1), cosines(0.2, 0.5, 7), azimuths(1.2, 1.5, 4)});
    const auto multiple = [&](double in, double out, double azimuth) {
        return reflection(table.view(), 0.9, 1, {in, out, azimuth}).multiple;
    };
    EXPECT_NEAR(multiple(0.8, 0.3, 1.3), multiple(0.35, 0.3, 1.3), 1e-6);
    EXPECT_NEAR(multiple(0.35, 0.9, 1.3), multiple(0.35, 0.5, 1.3), 1e-6);
    EXPECT_NEAR(multiple(0.35, 0.3, 0.1), multiple(0.35, 0.3, 1.2), 1e-6);
    EXPECT_NEAR(multiple(0.35, 0.3, 3.1), multiple(0.35, 0.3, 1.5), 1e-6);
}

}  // namespace
}  // namespace stratus
