#include <stratus/table/packed_table.h>

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/kernels/packed.h>

#include "indices.h"
#include "instruction_sets.h"
#include "row_name.h"
#include "small_table.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace stratus {
namespace {

Table packable(const Counts& counts, const Depths& depths, const char* phase = "rayleigh",
               const FunctionOfPoint& function = smooth_shape) {
    Table table = empty_table(counts, depths);
    table.phase_function = parse_phase_function(phase);
    table.tolerance = small_table_tolerance;
    fill(table, function);
    return table;
}

constexpr Counts usual{9, 12, 16, 16, 9};
constexpr Depths to_eight{0.05, 8, false}, to_infinity{0.05, 8, true};

/// Random lookups, cosines evenly spread over their roots, azimuths over ten turns.
std::vector<SamplePoint> random_lookups(const Table& table, int count, double shallowest,
                                        double deepest) {
    const TableView view = table.view();
    Uniform uniform(1);
    std::vector<SamplePoint> all;
    for (int n = 0; n < count; ++n) {
        const auto cosine = [&] { return std::pow(0.1 + 0.9 * uniform(), 2); };
        SamplePoint p{};
        p.albedo = view.albedo.lowest + (1 - view.albedo.lowest) * uniform();
        p.optical_depth = shallowest * std::pow(deepest / shallowest, uniform());
        p.mu_in = cosine();
        p.mu_out = cosine();
        p.azimuth = 20 * pi * (uniform() - 0.5);
        all.push_back(p);
    }
    return all;
}

/// That the lookups of a packed table are those of lookup.h, to the tolerance relative to R or T
/// but not to less than 1 % of 1.
void expect_lookups(const PackedTable& packed, const TableView& view,
                    const std::vector<SamplePoint>& at) {
    for (const SamplePoint& p : at)
        for (const Side side : both_sides) {
            const Scattered found = scattering_at(packed, side, p),
                            expected =
                                scattering(view, side, p.albedo, p.optical_depth, geometry(p));
            const double scale = std::max(expected.total(), 0.01);
            EXPECT_NEAR(found.multiple, expected.multiple, small_table_tolerance * scale)
                << (side == Side::reflection ? "R" : "T") << " at w " << p.albedo << " tau "
                << p.optical_depth << " mu " << p.mu_in << " " << p.mu_out << " azimuth "
                << p.azimuth;
            // Single precision, and exp of paths up to 80.
            EXPECT_NEAR(found.single, expected.single, 1e-5 * std::max(expected.single, 1e-4));
        }
}

struct Shape {
    const char* name;
    Counts counts;
    Depths depths;
    const char* phase;
    FunctionOfPoint function = smooth_shape;
};

class PackedTableShapes : public testing::TestWithParam<Shape> {};

TEST_P(PackedTableShapes, AgreeWithLookups) {
    const Shape& of = GetParam();
    const Table table = packable(of.counts, of.depths, of.phase, of.function);
    expect_lookups(PackedTable(pack(table)), table.view(), random_lookups(table, 400, 0.01, 20));
}

INSTANTIATE_TEST_SUITE_P(
    All, PackedTableShapes,
    testing::ValuesIn<Shape>(
        {{"usual", usual, to_eight, "henyey_greenstein:g=0.5"},
         {"to_infinity", usual, to_infinity, "rayleigh"},
         {"two_lobes", usual, to_eight,
          "0.6*henyey_greenstein:g=-0.5 + 0.4*henyey_greenstein:g=0.5"},
         {"sampled", usual, to_eight, "lambert_sphere"},
         {"without_azimuth", {9, 12, 16, 16, 1}, to_eight, "isotropic"},
         {"two_azimuths", {9, 12, 16, 16, 2}, to_eight, "isotropic"},
         {"one_albedo", {1, 12, 16, 16, 9}, to_infinity, "rayleigh"},
         {"two_albedos", {2, 12, 16, 16, 9}, to_eight, "rayleigh"},
         {"three_depths", {9, 3, 16, 16, 9}, to_infinity, "rayleigh"},
         {"one_depth", {9, 1, 16, 16, 9}, to_eight, "rayleigh"},
         {"infinite_depth_alone", {9, 0, 16, 16, 9}, to_infinity, "rayleigh"},
         {"cosines_that_differ", {9, 12, 16, 15, 9}, to_eight, "rayleigh"},
         {"two_cosines", {9, 12, 2, 2, 9}, to_eight, "rayleigh"},
         {"many_depths", {9, 40, 16, 16, 9}, {0.01, 100, true}, "rayleigh"},
         {"ridges", samples_of_ridges, to_infinity, "rayleigh", ridge},
         {"ridges_without_azimuth", {13, 20, 16, 16, 1}, to_infinity, "isotropic", ridge}}),
    row_name);

/// A table whose azimuths lie evenly in their square root, and albedos in the fourth of 1 - w.
Table forward_filled() {
    Table table = empty_table(usual, to_eight);
    table.azimuth = make_axis(AxisScale::square_root, 0, pi, usual.azimuth);
    table.albedo = make_axis(AxisScale::fourth_root_of_complement, table.albedo.values.front(),
                             table.albedo.values.back(), usual.albedo);
    for (const auto a : indices(table.albedo.values))
        table.diffusion_exponent[a] = small_table_exponent(table.albedo.values[a]);
    table.phase_function = parse_phase_function("henyey_greenstein:g=0.5");
    table.tolerance = small_table_tolerance;
    fill(table, smooth_shape);
    return table;
}

class PackedTableInstructionSets : public testing::TestWithParam<InstructionSet> {
  protected:
    void SetUp() override {
        if (!is_available(GetParam())) GTEST_SKIP() << "this processor has none";
        limit_.emplace(GetParam());
    }

  private:
    std::optional<InstructionSetLimit> limit_;
};

Table table_of_ridges() {
    return packable(samples_of_ridges, to_infinity, "henyey_greenstein:g=0.5", ridge);
}

TEST_P(PackedTableInstructionSets, AgreeWithLookups) {
    for (const Table& table : {packable(usual, to_eight), table_of_ridges(), forward_filled()}) {
        std::vector<SamplePoint> at = random_lookups(table, 300, 0.05, 8);
        for (std::size_t n = 0; n < 100; ++n) at[n].azimuth /= 100;  // forward
        expect_lookups(PackedTable(pack(table)), table.view(), at);
    }
    const PackedTable ridges(pack(table_of_ridges()));
    for (const Side side : both_sides) EXPECT_EQ(ridges.side(side).functions, most_functions);
}

void expect_alike_one_many_and_three(const Table& table) {
    const PackedTable packed(pack(table));
    std::vector<SamplePoint> at =
        random_lookups(table, 1003, 0.01, 40);  // no multiple of any width
    for (SamplePoint& p : at) p.azimuth /= 10;  // floats tell few of more turns apart
    const PointArrays arrays(at);
    const PackedPoints points = arrays.view();
    std::vector<float> total(at.size());
    for (const Side side : both_sides) {
        packed.scattering(side, points, total.data());
        for (const auto n : indices(at)) {
            const Geometry here{points.mu_in[n], points.mu_out[n], points.azimuth[n]};
            const double w = points.albedo[n], depth = points.optical_depth[n],
                         one = packed.scattering(side, w, depth, here).total();
            EXPECT_NEAR(total[n], one, 1e-6 * std::max(1.0, one));
            // The second as the first, the third mostly in another block.
            const PackedLayers layers{{w, w, 1 - w}, {depth, depth, 9 * depth}};
            double value[3];
            packed.multiple(side, layers, here, 1, value);
            for (int k = 0; k < 3; ++k) {
                const double multiple =
                    packed.scattering(side, layers.albedo[k], layers.optical_depth[k], here)
                        .multiple;
                EXPECT_NEAR(value[k], multiple, 1e-6 * std::max(1.0, multiple));
            }
        }
    }
}

TEST_P(PackedTableInstructionSets, AgreeBetweenOneManyAndThree) {
    expect_alike_one_many_and_three(packable(usual, to_infinity, "henyey_greenstein:g=0.5"));
    expect_alike_one_many_and_three(table_of_ridges());
}

/// What slices are bound from, times the shares intercepted.
void expect_layers(const Table& table, double albedo, const std::vector<double>& optical_depths) {
    const PackedTable packed(pack(table));
    for (const double optical_depth : optical_depths) {
        const std::vector<float> layer = packed.layer(Side::reflection, albedo, optical_depth, {});
        std::size_t n = 0;
        for (const double in : table.mu_in.values)
            for (const double out : table.mu_out.values)
                for (const double azimuth : table.azimuth.values) {
                    const double shares = intercepted_share(optical_depth, in) *
                                          intercepted_share(optical_depth, out);
                    const double expected =
                        packed.reflection(albedo, optical_depth, {in, out, azimuth}).multiple;
                    EXPECT_NEAR(double{layer[n++]} * shares, expected, 3e-6 * expected);
                }
        EXPECT_EQ(n, layer.size());
    }
}

TEST_P(PackedTableInstructionSets, GiveALayerAtTheSamplesAsLookupsDo) {
    for (const Table& table : {packable(usual, to_infinity), table_of_ridges()})
        expect_layers(table, 0.8, {0.03, 1.7, 20.0, infinity});
    expect_layers(packable({9, 12, 3, 3, 3}, to_eight), 0.8, {1.7});  // axes that are sampled again
    expect_layers(packable({9, 12, 1, 16, 1}, to_eight), 0.8, {1.7});
}

TEST_P(PackedTableInstructionSets, AgreeWithTheGenericOne) {
    const Table table = packable(usual, to_infinity, "henyey_greenstein:g=0.5");
    const std::vector<SamplePoint> at = random_lookups(table, 200, 0.01, 40);
    const auto totals = [&] {  // kernels are chosen when a table is opened
        const PackedTable packed(pack(table));
        std::vector<double> all;
        for (const SamplePoint& p : at)
            for (const Side side : both_sides)
                all.push_back(scattering_at(packed, side, p).total());
        return all;
    };
    const std::vector<double> found = totals();
    const InstructionSetLimit generic(InstructionSet::generic);
    const std::vector<double> expected = totals();
    for (const auto n : indices(found))  // roundings of sums of products alone
        EXPECT_NEAR(found[n], expected[n], 1e-6 * std::max(1.0, expected[n]));
}

INSTANTIATE_TEST_SUITE_P(All, PackedTableInstructionSets, testing::ValuesIn(instruction_sets),
                         instruction_set_row);

TEST(PackedTable, IsSymmetricInTheCosinesBitForBit) {
    const Table table = packable(usual, to_infinity);
    const PackedTable packed(pack(table));
    for (const SamplePoint& p : random_lookups(table, 200, 0.01, 40)) {
        const SamplePoint back{p.albedo, p.optical_depth, p.mu_out, p.mu_in, p.azimuth};
        for (const Side side : both_sides)
            EXPECT_EQ(scattering_at(packed, side, p).multiple,
                      scattering_at(packed, side, back).multiple);
    }
}

TEST(PackedTable, ScattersNothingAtZeroDepthOrAlbedo) {
    Table table = packable(usual, to_infinity);
    const PackedTable packed(pack(table));
    EXPECT_EQ(packed.reflection(0.9, 0, {0.4, 0.7, 1}).total(), 0);
    EXPECT_EQ(packed.transmission(0.9, 0, {0.4, 0.7, 1}).total(), 0);
    EXPECT_EQ(packed.transmission(0.9, infinity, {0.4, 0.7, 1}).total(), 0);
    EXPECT_EQ(packed.reflection(0, 1, {0.4, 0.7, 1}).single, 0);
}

TEST(PackedTable, ApproachesInfiniteDepthAsDiffusionDoes) {
    const Table table = packable(usual, to_infinity);
    const PackedTable packed(pack(table));
    std::vector<SamplePoint> at = random_lookups(table, 100, 8, 1e5);
    for (int n = 0; n < 20; ++n) at[static_cast<std::size_t>(n)].optical_depth = infinity;
    at[0].albedo = at[30].albedo = 1;
    expect_lookups(packed, table.view(), at);
}

TEST(PackedTable, UsesNeighboursOfUnderflowingSamples) {
    // T of the lower albedos is below 1e-35 at the deepest samples.
    const Table table = packable({9, 24, 12, 12, 1}, {0.1, 400, false}, "isotropic");
    const PackedTable packed(pack(table));
    for (const SamplePoint& p : random_lookups(table, 200, 20, 400)) {
        const double found = scattering_at(packed, Side::transmission, p).multiple;
        const double expected = scattering_at(table, Side::transmission, p).multiple;
        EXPECT_NEAR(found, expected, small_table_tolerance * std::max(expected, 0.01));
    }
}

TEST(PackedTable, GivesSingleScatteringAloneOfAMissingSide) {
    Table table = packable(usual, to_eight);
    table.transmission_multiple.clear();
    const PackedTable packed(pack(table));
    const Scattered found = packed.transmission(0.9, 1, {0.4, 0.7, 1});
    const Scattered expected = transmission(table.view(), 0.9, 1, {0.4, 0.7, 1});
    EXPECT_EQ(found.multiple, 0);
    EXPECT_NEAR(found.single, expected.single, 1e-6 * expected.single);
}

class PackedTableOverBoundary : public testing::TestWithParam<LowerBoundary> {};

TEST_P(PackedTableOverBoundary, AgreeWithLookups) {
    Table table = empty_table(usual, to_infinity);
    table.phase_function = PhaseFunction::henyey_greenstein(0.5);
    table.tolerance = small_table_tolerance;
    table.lower_boundary = GetParam();
    table.reflection_multiple = tabulate(table, shape_over_boundary);
    prepare(table);
    expect_lookups(PackedTable(pack(table)), table.view(), random_lookups(table, 400, 0.005, 40));
}

INSTANTIATE_TEST_SUITE_P(All, PackedTableOverBoundary,
                         testing::Values(LowerBoundary::surface(0.3),
                                         LowerBoundary::layer(PhaseFunction::rayleigh(), 0.6)),
                         [](const auto& row) {
                             return row.param.kind == LowerBoundary::Kind::surface ? "surface"
                                                                                   : "layer";
                         });

TEST(PackedTable, OutlivesItsTable) {
    Table table = packable(usual, to_eight);
    const double expected = reflection(table.view(), 0.9, 1, {0.4, 0.7, 1}).total();
    PackedTable packed(pack(table));
    table = Table();
    const PackedTable moved = std::move(packed);
    EXPECT_NEAR(moved.reflection(0.9, 1, {0.4, 0.7, 1}).total(), expected,
                small_table_tolerance * expected);
    EXPECT_FALSE(moved.file().empty());
}

TEST(PackedTable, JoinsMixturesAsLookupsDo) {
    const Table one = packable(usual, to_eight);
    const Table other = packable(usual, to_eight, "henyey_greenstein:g=0.5");
    Table table = mixed(one, other);
    for (const auto a : indices(one.albedo.values))  // those of the first member
        table.diffusion_exponent[a] *= 1.3;
    prepare(table);
    const PackedTable packed(pack(table));
    for (const double mixture : {0.0, 0.3, 1.0})
        for (const SamplePoint& p : random_lookups(table, 50, 0.05, 8)) {
            const Geometry at = geometry(p);
            const TableView view = table.view().at({mixture});
            const PackedLayers three{{p.albedo, p.albedo, p.albedo},
                                     {p.optical_depth, p.optical_depth, p.optical_depth}};
            for (const Side side : both_sides) {
                const Scattered found =
                                    packed.scattering(side, p.albedo, p.optical_depth, at, mixture),
                                expected = scattering(view, side, p.albedo, p.optical_depth, at);
                const double allowed = small_table_tolerance * expected.total();
                EXPECT_NEAR(found.multiple, expected.multiple, allowed);
                EXPECT_NEAR(found.single, expected.single, 1e-5 * expected.single);
                double values[3];
                packed.multiple(side, three, at, mixture, values);
                for (const double value : values) EXPECT_NEAR(value, found.multiple, 1e-6);
                EXPECT_NEAR(packed.multiple(side, p.albedo, p.optical_depth, at, view.members),
                            found.multiple, 1e-6);
            }
        }
}

}  // namespace
}  // namespace stratus
