// Tables of some directions alone, against those of all and against the solver.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/forecast.h>
#include <stratus/base/constants.h>
#include <stratus/table/lookup.h>
#include <stratus/transfer/solve.h>

#include "all_near.h"
#include "refusal.h"
#include "row_name.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stratus::test {
namespace {

/// What a recipe is narrowed to.
struct Narrowing {
    const char* name;
    Range mu_in = Recipe().mu_in, mu_out = Recipe().mu_out, azimuth = Recipe().azimuth;
};

const Narrowing narrowings[] = {{"OneSun", {0.4, 0.4}},
                                {.name = "OneView", .mu_out = {0.4, 0.4}},
                                {.name = "GrazingViews", .mu_out = {0, 0.1}},
                                {"SomeOfBoth", {0.2, 0.5}, {0.2, 0.5}},
                                {.name = "ForwardAzimuths", .azimuth = {0, 25}},
                                {.name = "BackwardAzimuths", .azimuth = {160, 180}},
                                {.name = "OneAzimuth", .azimuth = {120, 120}},
                                {"All", {0.4, 0.4}, {0.6, 0.7}, {100, 109}}};

class NarrowBake : public testing::TestWithParam<Narrowing> {
  protected:
    Recipe narrowed(Recipe recipe) const {
        recipe.mu_in = GetParam().mu_in;
        recipe.mu_out = GetParam().mu_out;
        recipe.azimuth = GetParam().azimuth;
        return recipe;
    }
};

void expect_within(const AxisView& axis, double value) {
    EXPECT_GE(value, axis.lowest);
    EXPECT_LE(value, axis.highest);
}

TEST_P(NarrowBake, KeepsItsToleranceAgainstTheSolver) {
    const Recipe recipe = narrowed(rayleigh_recipe());
    const Table table = bake(recipe);
    const Verification found = verify(table, {.samples = 400});
    EXPECT_TRUE(found.meets(recipe.tolerance)) << found.samples.back().error;
    ASSERT_EQ(found.samples.size(), 800U);  // of both sides
    for (const ErrorSample& sample : found.samples) {
        expect_within(table.mu_in.view(), sample.geometry.mu_in);
        expect_within(table.mu_out.view(), sample.geometry.mu_out);
        expect_within(table.azimuth.view(), sample.geometry.azimuth);
    }
    // The check itself, without its random points.
    const double in = table.mu_in.values.front(), out = table.mu_out.values.back();
    const double around = table.azimuth.values.back();
    const LayerSolution layer = solve_layer(recipe.phase_function, 0.93, 0.7, {in, out});
    const Scattered looked_up = reflection(table.view(), 0.93, 0.7, {in, out, around});
    const double solved = layer.reflection(0, 1, around).total;
    EXPECT_NEAR(looked_up.total(), solved, recipe.tolerance * solved);
}

TEST_P(NarrowBake, EndsWhereTheRecipeDoes) {
    const Recipe recipe = narrowed(explicit_recipe());
    const Table table = solve_table(recipe);
    const auto expect_ends = [](const Axis& axis, double first, double last) {
        EXPECT_EQ(axis.values.front(), first);
        EXPECT_EQ(axis.values.back(), last);
        EXPECT_GE(axis.values.size(), first == last ? 1U : 4U);
    };
    expect_ends(table.mu_in, std::max(recipe.mu_in.min, 1e-4), recipe.mu_in.max);
    expect_ends(table.mu_out, std::max(recipe.mu_out.min, 1e-4), recipe.mu_out.max);
    expect_ends(table.azimuth, radians(recipe.azimuth.min),
                recipe.azimuth.max == 180 ? pi : radians(recipe.azimuth.max));
    EXPECT_LT(table.sample_count(), solve_table(explicit_recipe()).sample_count());
    EXPECT_FALSE(table.view().has_all_directions());
}

TEST_P(NarrowBake, IsBakedAgainFromItsResolvedRecipe) {
    const Recipe recipe = narrowed(explicit_recipe());
    expect_same_bits(solve_table(parse_recipe(resolved_text(recipe))), solve_table(recipe));
}

TEST_P(NarrowBake, IsForecast) {
    const Recipe recipe = narrowed(explicit_recipe());
    EXPECT_EQ(forecast(recipe).samples_a_side,
              static_cast<double>(solve_table(recipe).sample_count()));
}

INSTANTIATE_TEST_SUITE_P(Of, NarrowBake, testing::ValuesIn(narrowings), row_name);

/// A single cosine that is a sample of the full table, too: the samples are the same.
TEST(NarrowTable, HoldsWhatTheFullOneHolds) {
    const Table full = solve_table(explicit_recipe());
    const std::size_t i = 5, outs = full.mu_out.values.size(),
                      azimuths = full.azimuth.values.size(), row = outs * azimuths;
    Recipe recipe = explicit_recipe();
    recipe.mu_in.min = recipe.mu_in.max = full.mu_in.values[i];
    const Table narrow = solve_table(recipe);
    ASSERT_EQ(narrow.mu_out.values, full.mu_out.values);
    ASSERT_EQ(narrow.azimuth.values, full.azimuth.values);
    ASSERT_EQ(narrow.reflection_multiple.size() * outs, full.reflection_multiple.size());
    const double rounding = 2 * recipe.tolerance / 500;  // samples are rounded to a share of it
    for (const auto samples : {&Table::reflection_multiple, &Table::transmission_multiple})
        for (const auto n : indices((narrow.*samples))) {
            const float expected = (full.*samples)[n / row * row * outs + i * row + n % row];
            EXPECT_NEAR((narrow.*samples)[n], expected, rounding * std::abs(expected));
        }
}

TEST(NarrowTable, HasFluxesWhereAllIncidentDirectionsAreKnown) {
    const Table full = solve_table(explicit_recipe());
    Recipe recipe = explicit_recipe();
    recipe.mu_out = {0.3, 0.3};
    recipe.azimuth = {20, 40};
    const Table of_views = solve_table(recipe);
    ASSERT_EQ(of_views.mu_in.values, full.mu_in.values);
    for (const auto flux :
         {&Table::plane_albedo, &Table::diffuse_transmittance, &Table::spherical_albedo})
        expect_all_near(of_views.*flux, full.*flux, 0, 1e-6);
    recipe.mu_in = {0.3, 0.3};
    const Table of_one = solve_table(recipe);
    EXPECT_TRUE(of_one.plane_albedo.empty());
    EXPECT_TRUE(of_one.diffuse_transmittance.empty());
    EXPECT_EQ(of_one.spherical_albedo.size(), full.spherical_albedo.size());
}

TEST(NarrowTable, HasOneAzimuthWhereNothingDependsOnIt) {
    Recipe recipe = deep_recipe();
    recipe.azimuth = {30, 60};
    const Table table = bake(recipe);
    EXPECT_EQ(table.azimuth.values, std::vector<double>{0});
    EXPECT_TRUE(table.view().has_all_directions());
}

TEST(NarrowTable, IsCheckedNearForwardWithinItsAzimuths) {
    Recipe recipe = peaked_recipe();
    recipe.azimuth = {0, 20};
    recipe.mu_out = {0.3, 0.9};
    const Table table = bake(recipe);
    const Verification found = verify(table, {.samples = 400});
    EXPECT_TRUE(found.meets(recipe.tolerance));
    EXPECT_GE(found.forward.size(), 50U);
    for (const ErrorSample& sample : found.forward) {
        expect_within(table.mu_out.view(), sample.geometry.mu_out);
        EXPECT_LE(sample.geometry.azimuth, radians(20));
    }
}

TEST(NarrowTable, RefusesDirectionsOutOfRange) {
    Recipe recipe = explicit_recipe();
    recipe.mu_in = {0.5, 0.25};
    expect_refusal([&] { solve_table(recipe); }, "mu_in.min must be in [0, mu_in.max], got 0.5");
    recipe.mu_in = {0, 0};
    expect_refusal([&] { resolve(recipe); }, "mu_in.max must be in [0.0001, 1], got 0");
    recipe.mu_in = {0, 1};
    recipe.azimuth = {0, 200};
    expect_refusal([&] { solve_table(recipe); },
                   "azimuth_deg.max must be in [0.001, 180], got 200");
}

}  // namespace
}  // namespace stratus::test
