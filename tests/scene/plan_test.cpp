#include <stratus/scene/plan.h>

#include <stratus/runtime/angle.h>

#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace stratus {
namespace {

Scene with_effects(Scene scene, const SceneEffects& effects) {
    scene.effects = effects;
    return scene;
}

const EffectShare* share_of(const Plan& plan, const std::string& name) {
    const auto found = std::find_if(plan.shares.begin(), plan.shares.end(),
                                    [&](const EffectShare& share) { return share.name == name; });
    return found == plan.shares.end() ? nullptr : &*found;
}

Plan plan_of(const Scene& scene) { return plan_scenes({scene})[0]; }

/// A slab under a wide camera: all cosines of view, one of the sun.
Scene wide_slab(double optical_depth, double albedo) {
    Scene scene = small_slab(optical_depth, albedo);
    scene.width = scene.height = 48;
    scene.tolerance = 0.01;
    return scene;
}

TEST(Plan, NeedsNoTableForDarkDust) {
    Scene scene = wide_slab(0.5, 0.02);
    scene.tolerance = 0.05;
    const Plan plan = plan_of(scene);
    EXPECT_FALSE(plan.effects.multiple);
    EXPECT_FALSE(needed_recipe(with_effects(scene, plan.effects)));
    const EffectShare* const multiple = share_of(plan, "multiple");
    ASSERT_NE(multiple, nullptr);
    // Every order is about w/2 of the one before or less, and there is some.
    EXPECT_GT(multiple->max, 0);
    EXPECT_LT(multiple->max, 0.02);
}

TEST(Plan, NeedsATableForBrightDust) {
    const Scene scene = wide_slab(0.5, 0.9);
    const Plan plan = plan_of(scene);
    EXPECT_TRUE(plan.effects.multiple);
    EXPECT_GT(share_of(plan, "multiple")->max, 0.1);
}

TEST(Plan, NeedsNoReflectionOnTheUnlitSide) {
    Scene scene = wide_slab(1, 0.9);
    scene.to_sun = direction_at(radians(-50), 1);
    const Plan plan = plan_of(scene);
    EXPECT_FALSE(plan.effects.reflection);
    EXPECT_EQ(share_of(plan, "reflection")->max, 0);
    const std::optional<Recipe> recipe = needed_recipe(with_effects(scene, plan.effects));
    ASSERT_TRUE(recipe);
    EXPECT_FALSE(recipe->reflection);
    EXPECT_TRUE(recipe->transmission);
}

TEST(Plan, NeedsNoTransmissionOnTheLitSideBeforeABlackBackground) {
    Scene scene = wide_slab(1, 0.9);
    scene.background.colour = {0, 0, 0};
    const std::optional<Recipe> recipe = needed_recipe(with_effects(scene, plan_of(scene).effects));
    ASSERT_TRUE(recipe);
    EXPECT_TRUE(recipe->reflection);
    EXPECT_FALSE(recipe->transmission);
}

TEST(Plan, NeedsTransmissionBeforeABackgroundThatShinesThrough) {
    const Scene scene = wide_slab(1, 0.9);
    const std::optional<Recipe> recipe = needed_recipe(with_effects(scene, plan_of(scene).effects));
    ASSERT_TRUE(recipe);
    EXPECT_TRUE(recipe->transmission);
}

TEST(Plan, NeedsNoAzimuthForIsotropicScattering) {
    Scene scene = wide_slab(1, 0.9);
    scene.layer.components = {PhaseFunction::isotropic()};
    EXPECT_FALSE(plan_of(scene).effects.azimuth);
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.5)};
    EXPECT_TRUE(plan_of(scene).effects.azimuth);
}

TEST(Plan, KeepsEffectsOffThatTheSceneSwitchesOff) {
    Scene scene = wide_slab(1, 0.9);
    scene.effects.single = false;
    const Plan plan = plan_of(scene);
    EXPECT_FALSE(plan.effects.single);
    EXPECT_EQ(share_of(plan, "single"), nullptr);
}

TEST(Plan, IsIndependentOfOtherScenes) {
    const Scene one = wide_slab(1, 0.9), other = wide_slab(0.5, 0.02);
    const std::vector<Plan> both = plan_scenes({one, other});
    ASSERT_EQ(both.size(), 2u);
    // Shared tables span both, so that the last digits may differ.
    EXPECT_NEAR(share_of(both[0], "multiple")->mean, share_of(plan_of(one), "multiple")->mean,
                0.01);
    EXPECT_NEAR(share_of(both[1], "multiple")->mean, share_of(plan_of(other), "multiple")->mean,
                0.001);
}

TEST(Plan, CostsAreThoseOfTheNeededTables) {
    Scene scene = wide_slab(1, 0.9);
    scene.background.colour = {0, 0, 0};
    PlanOptions options;
    options.costs = true;
    const Plan plan = plan_scenes({scene}, options)[0];
    ASSERT_TRUE(plan.costs);
    const PlanCosts& costs = *plan.costs;
    ASSERT_EQ(costs.without.size(), plan.shares.size());
    EXPECT_GT(costs.all.bake_seconds, 0);
    EXPECT_GT(costs.all.ray_ns, 0);
    for (std::size_t e = 0; e < plan.shares.size(); ++e) {
        const std::string& name = plan.shares[e].name;
        const bool side = name == "transmission" || name == "reflection";
        const double expected = name == "multiple" ? 0
                                : side             ? costs.all.bytes / 2
                                                   : costs.all.bytes;
        if (name != "azimuth") {
            EXPECT_EQ(costs.without[e].bytes, expected) << name;
        }
    }
    // one side, with azimuths or without
    std::size_t azimuth = 0;
    while (plan.shares[azimuth].name != "azimuth") ++azimuth;
    const SceneCost& both = plan.effects.azimuth ? costs.all : costs.without[azimuth];
    EXPECT_EQ(costs.planned.bytes, both.bytes / 2);

    // and what is counted is what a bake fills
    const auto tables = bake_layer_tables(scene, *needed_recipe(scene));
    const double samples = static_cast<double>(tables->tables[0].sample_count());
    EXPECT_NEAR(costs.all.bytes / (2 * sizeof(float) * samples), 1, 0.5);
}

TEST(Plan, MeasuresTheBakeOfASharedRecipeOnce) {
    Scene one = wide_slab(1, 0.9), other = one;
    other.title = "The same table, the sun elsewhere";
    other.to_sun = direction_at(radians(50), 1);
    const std::vector<Plan> plans = plan_scenes({one, other}, {.bake = {}, .costs = true});
    // Two measurements would not agree to the last bit.
    EXPECT_EQ(plans[0].costs->all.bake_seconds, plans[1].costs->all.bake_seconds);
}

TEST(Plan, CountsATableForEachChannelWithItsOwnPhaseFunction) {
    const Scene grey = wide_slab(1, 0.9);
    Scene coloured = grey;
    coloured.layer.channels = {3, PhaseFunction::rayleigh()};
    const Plan one = plan_scenes({grey}, {.bake = {}, .costs = true})[0],
               three = plan_scenes({coloured}, {.bake = {}, .costs = true})[0];
    EXPECT_EQ(three.costs->all.bytes, 3 * one.costs->all.bytes);
    EXPECT_EQ(three.effects.azimuth, one.effects.azimuth);
    for (std::size_t e = 0; e < one.shares.size(); ++e) {
        EXPECT_EQ(three.shares[e].mean, one.shares[e].mean) << one.shares[e].name;
        EXPECT_EQ(three.shares[e].max, one.shares[e].max) << one.shares[e].name;
    }
}

TEST(LookupRange, IsThatOfThePixels) {
    Scene scene = wide_slab(1, 0.9);
    const LookupRange range = measure_range(scene);
    EXPECT_TRUE(range.reflection);
    EXPECT_FALSE(range.transmission);
    EXPECT_NEAR(range.mu_in.min, std::cos(radians(30)), 1e-12);  // one sun
    EXPECT_EQ(range.mu_in.min, range.mu_in.max);
    EXPECT_NEAR(range.mu_out.max, std::cos(radians(60)), 1e-12);  // orthographic
    EXPECT_EQ(range.optical_depth.max, 1);
    EXPECT_EQ(range.albedo.min, 0.9);
}

}  // namespace
}  // namespace stratus
