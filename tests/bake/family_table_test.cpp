// Tables of families and mixtures of phase functions, against tables of single ones and the solver.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/packed_table.h>

#include "table_equality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

/// Every choice spelled out but those of the family.
Recipe family_recipe(const std::string& phase_function, const std::string& family,
                     const std::string& samples) {
    return parse_recipe("phase_function = '" + phase_function +
                        "'\n"
                        "tolerance = 1e-2\n"
                        "optical_depth = { min = 0.5, max = 2.0 }\n"
                        "albedo = { min = 0.9, max = 1.0 }\n"
                        "[discretisation]\n"
                        "nodes = 9\n"
                        "modes = 12\n"
                        "mu_samples = 12\n"
                        "azimuth_samples = 12\n"
                        "optical_depth_samples_per_octave = 2\n"
                        "albedo_samples = 4\n" +
                        samples + "[family]\n" + family);
}

/// The first of them, as many as this.
void expect_tables_of_members(const Recipe& recipe, std::size_t members) {
    const Table table = solve_table(recipe);
    ASSERT_GE(table.member_count(), members);
    for (std::size_t m = 0; m < members; ++m) {
        SCOPED_TRACE(m);
        const Table alone = solve_table(at_member(recipe, member_at(table.family, m)));
        test::expect_same_bits(table_at(table, member_at(table.family, m)), alone);
    }
}

/// Lookups of a family, and of the table that it makes of one member, against a table of one phase
/// function, which is solved on its own.
double worst_beside_single(const Recipe& recipe, const FamilyPoint& point) {
    const Table table = solve_table(recipe), alone = solve_table(at_member(recipe, point));
    const Table member = table_at(table, point);
    double worst = 0;
    for (const auto look_up : {reflection, transmission})
        for (const double depth : {0.5, 0.8, 2.0})
            for (const Geometry& at : {Geometry{0.3, 0.8, 0.4}, {1, 0.2, 2}, {0.6, 0.6, 3.1}}) {
                const double expected = look_up(alone.view(), 0.97, depth, at).total();
                for (const TableView& view : {table.view().at(point), member.view()}) {
                    const double found = look_up(view, 0.97, depth, at).total();
                    worst = std::max(worst, std::abs(found / expected - 1));
                }
            }
    return worst;
}

Recipe lobes(int samples) {
    return family_recipe("henyey_greenstein:g=0.5", "g = [0.1, 0.7]\n",
                         "g_samples = " + std::to_string(samples) + "\n");
}

/// Two kinds of scattering in any mixture.
Recipe mixtures() {
    return parse_recipe(
        "phase_function = 'henyey_greenstein:g=-0.4'\n"
        "second_phase_function = 'henyey_greenstein:g=0.3'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 0.5, max = inf }\n"
        "albedo = { min = 0.5, max = 1.0 }\n"
        "[discretisation]\n"
        "nodes = 9\n"
        "modes = 7\n"
        "mu_samples = 9\n"
        "azimuth_samples = 6\n"
        "optical_depth_samples_per_octave = 2\n"
        "deepest_optical_depth = 8\n"
        "albedo_samples = 5\n"
        "mixture_samples = 3\n");
}

Recipe droplets() {
    return family_recipe(
        "mie:radius=0.3um,variance=0.1",
        "radius = ['0.2um', '0.4um']\nwavelength = { values = ['450nm', '0.65um'] }\n",
        "radius_samples = 5\n");
}

TEST(FamilyTable, HoldsTheTablesOfItsMembers) {
    expect_tables_of_members(lobes(3), 2);  // the last g is rounded
    expect_tables_of_members(droplets(), 10);
    expect_tables_of_members(mixtures(), 3);
    Recipe over_ground = mixtures();
    over_ground.lower_boundary = LowerBoundary::surface(0.3);
    over_ground.transmission = false;
    expect_tables_of_members(over_ground, 3);
}

TEST(FamilyTable, JoinsSingleTablesBetweenItsMembers) {
    const double two = worst_beside_single(lobes(2), {0.43}),
                 five = worst_beside_single(lobes(5), {0.43}),
                 nine = worst_beside_single(lobes(9), {0.43});
    EXPECT_LT(five, 2e-3);
    EXPECT_LT(nine, five / 10);  // half the steps: a cubic's error falls to a sixteenth
    EXPECT_GT(two, 10 * five);   // or nothing would depend on the axis
}

TEST(FamilyTable, OfDropletsJoinsSingleTables) {
    EXPECT_LT(worst_beside_single(droplets(), {0.27, 0.45}), 5e-3);
    EXPECT_LT(worst_beside_single(droplets(), {0.36, 0.65}), 5e-3);
}

TEST(FamilyTable, LeavesThePathLawToLookups) {
    Recipe narrow =
        family_recipe("henyey_greenstein:g=0.9", "g = [0.86, 0.9]\n", "g_samples = 4\n");
    narrow.discretisation.nodes = 20;
    narrow.discretisation.modes = 40;
    narrow.discretisation.azimuth_samples = 24;
    narrow.discretisation.mu_samples = 20;
    EXPECT_LT(worst_beside_single(narrow, {0.875}), 1e-3);
    const Table table = solve_table(narrow);
    ASSERT_TRUE(table.path_law);
    const PackedTable packed(pack(table));
    const Geometry straight_on{0.7, 0.7, 0.05};
    const double expected = transmission(table.view().at({0.88}), 0.95, 1, straight_on).total();
    EXPECT_NEAR(transmission(packed.view().at({0.88}), 0.95, 1, straight_on).total(), expected,
                4e-3 * expected);
}

/// Nothing chosen, rings in small.
Recipe rings_recipe(double tolerance, const std::string& depths) {
    return parse_recipe(
        "phase_function = 'henyey_greenstein:g=-0.5'\n"
        "second_phase_function = 'henyey_greenstein:g=0.5'\n"
        "tolerance = " +
        std::to_string(tolerance) + "\noptical_depth = " + depths +
        "\nalbedo = { min = 0.8, max = 1.0 }\n");
}

TEST(FamilyTable, MeetsItsToleranceBetweenItsMembers) {
    for (const Recipe& recipe : {rings_recipe(2e-2, "{ min = 0.5, max = 1 }"),
                                 rings_recipe(2e-2, "{ min = 4, max = inf }"),
                                 parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                                              "tolerance = 2e-2\n"
                                              "optical_depth = { min = 1.0, max = 1.0 }\n"
                                              "albedo = { min = 0.9, max = 0.9 }\n"
                                              "[family]\n"
                                              "g = [0.0, 0.6]\n")}) {
        SCOPED_TRACE(recipe.text);
        const Table table = bake(recipe);
        VerifyOptions options{.samples = 400, .seed = 77};
        const Verification verification = verify(table, options);
        EXPECT_TRUE(verification.meets(recipe.tolerance)) << verification.samples.back().error;
        EXPECT_LE(verification.energy_defect, 1e-6);
        EXPECT_LE(verification.furnace_defect, recipe.tolerance);
        const auto [first, last] = std::ranges::minmax(
            verification.samples, {}, [](const ErrorSample& sample) { return sample.member[0]; });
        const std::vector<double>& members = table.family.at(0).axis.values;
        EXPECT_LT(first.member[0], members.front() + 0.1);  // the whole range was sampled
        EXPECT_GT(last.member[0], members.back() - 0.1);
        options.samples = 32;
        options.bound = true;
        EXPECT_TRUE(verify(table, options).meets(recipe.tolerance));
    }
}

TEST(FamilyTable, FailsVerificationWhereCoarse) {
    Recipe recipe = resolve(rings_recipe(2e-2, "{ min = 1, max = 1 }"));
    const auto is_met = [&](int mixture_samples) {
        recipe.discretisation.family_samples[0] = mixture_samples;
        Table table = solve_table(recipe);
        table.attributes["nodes"] = std::to_string(recipe.discretisation.nodes);
        return verify(table, {.samples = 500}).meets(recipe.tolerance);
    };
    EXPECT_TRUE(is_met(recipe.discretisation.family_samples[0]));
    EXPECT_FALSE(is_met(2));
}

TEST(Resolve, RefinesTheMixtureWithTolerance) {
    const auto samples = [](double tolerance) {
        return resolve(rings_recipe(tolerance, "{ min = 1, max = 1 }"))
            .discretisation.family_samples[0];
    };
    const int few = samples(5e-2), many = samples(2e-3);
    EXPECT_GE(few, 2);
    EXPECT_LT(few, many);
}

}  // namespace
}  // namespace stratus
