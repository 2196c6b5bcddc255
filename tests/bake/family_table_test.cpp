// Tables of families of phase functions, against tables of single ones and the solver.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/packed_table.h>

#include "table_equality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

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

void expect_tables_of_members(const Recipe& recipe) {
    const Table table = solve_table(recipe);
    ASSERT_GE(table.member_count(), 2u);
    for (const std::size_t m : {std::size_t{0}, table.member_count() - 2}) {
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

Recipe droplets() {
    return family_recipe(
        "mie:radius=0.3um,variance=0.1",
        "radius = ['0.2um', '0.4um']\nwavelength = { values = ['450nm', '0.65um'] }\n",
        "radius_samples = 5\n");
}

TEST(FamilyTable, HoldsTheTablesOfItsMembers) {
    expect_tables_of_members(lobes(3));
    expect_tables_of_members(droplets());
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

TEST(FamilyTable, MeetsItsToleranceBetweenItsMembers) {
    const Recipe recipe = parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.5'\n"
        "tolerance = 2e-2\n"
        "optical_depth = { min = 1.0, max = 1.0 }\n"
        "albedo = { min = 0.9, max = 0.9 }\n"
        "[family]\n"
        "g = [0.0, 0.6]\n");
    const Table table = bake(recipe);
    EXPECT_GE(table.member_count(), 3u);
    VerifyOptions options{.samples = 200, .seed = 77};
    const Verification verification = verify(table, options);
    EXPECT_TRUE(verification.meets(recipe.tolerance)) << verification.samples.back().error;
    std::set<double> members;
    for (const auto& sample : verification.samples) members.insert(sample.member[0]);
    EXPECT_GE(members.size(), 4u);
    options.samples = 16;
    options.bound = true;
    EXPECT_TRUE(verify(table, options).meets(recipe.tolerance));
}

}  // namespace
}  // namespace stratus
