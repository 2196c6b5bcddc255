// Tables of two kinds of scattering in any mixture, against those of one mixture and the solver.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>

#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace stratus {
namespace {

/// Every choice spelled out.
Recipe small_recipe() {
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

/// All that was solved, at each sample of the mixture, is what the table of that one holds.
void expect_tables_of_mixtures(const Recipe& recipe) {
    const Table table = solve_table(recipe);
    ASSERT_EQ(table.family.at(0).axis.values, (std::vector<double>{0, 0.5, 1}));
    for (std::size_t m = 0; m < 3; ++m) {
        const double share = table.family[0].axis.values[m];
        SCOPED_TRACE(share);
        const Table alone = solve_table(at_member(recipe, {share}));
        test::expect_same_bits(table_at(table, {share}), alone);
        // between the samples of all other axes and beyond the last depth, too
        const TableView view = table.view().at({share});
        for (const double albedo : {0.5, 0.83, 1.0})
            for (const double depth : {0.1, 1.3, 7.0, 30.0})
                for (const Geometry& at : {Geometry{0.3, 0.8, 0.4}, Geometry{0.05, 0.9, 3}})
                    for (const auto look_up : {reflection, transmission}) {
                        const double expected = look_up(alone.view(), albedo, depth, at).total();
                        constexpr double rounding = 1e-6;  // floats
                        EXPECT_NEAR(look_up(view, albedo, depth, at).total(), expected,
                                    rounding * expected);
                    }
    }
}

TEST(MixtureTable, HoldsTheTablesOfItsMixtures) { expect_tables_of_mixtures(small_recipe()); }

TEST(MixtureTable, HoldsTheTablesOfItsMixturesOverGround) {
    Recipe recipe = small_recipe();
    recipe.lower_boundary = LowerBoundary::surface(0.3);
    recipe.transmission = false;
    expect_tables_of_mixtures(recipe);
}

TEST(MixtureTable, AtShareOneIsThePlainTable) {
    const Table table = solve_table(small_recipe());
    Recipe plain = small_recipe();
    plain.family.clear();
    plain.discretisation.family_samples = {};
    const Table alone = solve_table(plain);
    EXPECT_FALSE(alone.has_family());
    const Slice found = bind(table.view().at({1}), 2, 0.9);
    const Slice expected = bind(alone.view(), 2, 0.9);
    for (const float azimuth : {0.0f, 1.0f, 3.0f})
        EXPECT_NEAR(found.reflection(0.4f, 0.7f, azimuth), expected.reflection(0.4f, 0.7f, azimuth),
                    1e-6);
}

/// Nothing chosen, rings in small.
Recipe open_recipe(double tolerance, const std::string& depths) {
    return parse_recipe(
        "phase_function = 'henyey_greenstein:g=-0.5'\n"
        "second_phase_function = 'henyey_greenstein:g=0.5'\n"
        "tolerance = " +
        std::to_string(tolerance) + "\noptical_depth = " + depths +
        "\nalbedo = { min = 0.8, max = 1.0 }\n");
}

TEST(MixtureTable, MeetsItsToleranceBetweenItsMixtures) {
    for (const char* depths : {"{ min = 0.5, max = 1 }", "{ min = 4, max = inf }"}) {
        SCOPED_TRACE(depths);
        const Recipe recipe = open_recipe(2e-2, depths);
        const Table table = bake(recipe);
        VerifyOptions options{.samples = 400, .seed = 77};
        const Verification verification = verify(table, options);
        EXPECT_TRUE(verification.meets(recipe.tolerance)) << verification.samples.back().error;
        EXPECT_LE(verification.energy_defect, 1e-6);
        EXPECT_LE(verification.furnace_defect, recipe.tolerance);
        const auto [first, last] = std::ranges::minmax(
            verification.samples, {}, [](const ErrorSample& sample) { return sample.member[0]; });
        EXPECT_LT(first.member[0], 0.1);  // the whole range was sampled
        EXPECT_GT(last.member[0], 0.9);
        options.samples = 32;
        options.bound = true;
        EXPECT_TRUE(verify(table, options).meets(recipe.tolerance));
    }
}

TEST(MixtureTable, FailsVerificationWhereCoarse) {
    Recipe recipe = resolve(open_recipe(2e-2, "{ min = 1, max = 1 }"));
    const auto is_met = [&](int mixture_samples) {
        recipe.discretisation.family_samples[0] = mixture_samples;
        Table table = solve_table(recipe);
        table.attributes["nodes"] = std::to_string(recipe.discretisation.nodes);
        return verify(table, VerifyOptions{.samples = 500}).meets(recipe.tolerance);
    };
    EXPECT_TRUE(is_met(recipe.discretisation.family_samples[0]));
    EXPECT_FALSE(is_met(2));
}

TEST(Resolve, RefinesTheMixtureWithTolerance) {
    const auto samples = [](double tolerance) {
        return resolve(open_recipe(tolerance, "{ min = 1, max = 1 }"))
            .discretisation.family_samples[0];
    };
    const int few = samples(5e-2), many = samples(2e-3);
    EXPECT_GE(few, 2);
    EXPECT_LT(few, many);
}

}  // namespace
}  // namespace stratus
