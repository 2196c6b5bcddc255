#include <stratus/scene/plan.h>

#include <stratus/base/angle.h>
#include <stratus/base/constants.h>

#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace stratus {
namespace {

Scene with_effects(Scene scene, const SceneEffects& effects) {
    scene.effects = effects;
    return scene;
}

bool leaves_out(const Plan& plan, const std::string& name) {
    return std::ranges::find(plan.left_out, name, &LeftOut::name) != plan.left_out.end();
}

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
    const Plan plan = plan_scene(scene);
    EXPECT_FALSE(plan.effects.multiple);
    EXPECT_TRUE(needed_paths(with_effects(scene, plan.effects)).empty());
    ASSERT_TRUE(leaves_out(plan, "multiple"));
    // Every order is about w/2 of the one before or less, and there is some.
    EXPECT_GT(plan.left_out[0].change.bound, 0);
    EXPECT_LT(plan.left_out[0].change.bound, 0.02);
    EXPECT_LE(plan.left_out[0].change.found, plan.left_out[0].change.bound);
}

TEST(Plan, NeedsATableForBrightDust) {
    const Plan plan = plan_scene(wide_slab(0.5, 0.9));
    EXPECT_TRUE(plan.effects.multiple);
    EXPECT_FALSE(leaves_out(plan, "multiple"));
}

TEST(Plan, KeepsWhatTheSceneNames) {
    Scene scene = wide_slab(0.5, 0.02);
    scene.tolerance = 0.05;
    scene.named = {&SceneEffects::multiple};
    EXPECT_TRUE(plan_scene(scene).effects.multiple);
}

TEST(Plan, NeedsNoAzimuthForIsotropicScattering) {
    Scene scene = wide_slab(1, 0.9);
    scene.layer.components = {PhaseFunction::isotropic()};
    EXPECT_FALSE(plan_scene(scene).effects.azimuth);
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.5)};
    EXPECT_TRUE(plan_scene(scene).effects.azimuth);
}

TEST(Plan, KeepsEffectsOffThatTheSceneSwitchesOff) {
    Scene scene = wide_slab(1, 0.9);
    scene.effects.single = false;
    const Plan plan = plan_scene(scene);
    EXPECT_FALSE(plan.effects.single);
    EXPECT_TRUE(plan.effects.multiple) << "all the light that there is";
}

TEST(Plan, NeedsATableForTheGroundUnderAThinLayer) {
    Scene scene = small_planet(30, 0.05, 0.999);
    scene.tolerance = 0.02;
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.7)};
    scene.layer.albedo = {0.02, 0.02, 0.02};
    EXPECT_FALSE(plan_scene(scene).effects.multiple);
    scene.layer.albedo = {0.999, 0.999, 0.999};
    std::get<Planet>(scene.subject).surface.colour = {0.9f, 0.9f, 0.9f};
    EXPECT_TRUE(plan_scene(scene).effects.multiple);
}

/// What a plan changes: the largest relative change of a ray's light, found at random places of the
/// scene by the solver.
TEST(OrderBounds, AreNotExceededByAnyRay) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    int bounded = 0;
    for (int n = 0; n < 30; ++n) {
        Scene scene = small_planet(180 * unit(random), std::pow(10, 2 * unit(random) - 2),
                                   0.3 * unit(random));
        const double g = 0.8 * unit(random) - 0.2;
        scene.layer.components = {PhaseFunction::henyey_greenstein(g)};
        const OrderBounds bounds = bound_orders(scene, infinity);
        ASSERT_LE(bounds.multiple.found, bounds.multiple.bound);
        bounded += bounds.multiple.bound < 1;
        const double phase = std::acos(std::clamp(dot({1, 0, 0}, scene.to_sun), -1.0, 1.0));
        for (int k = 0; k < 20; ++k) {
            const Vector3 normal =
                direction_at(std::asin(2 * unit(random) - 1), 2 * pi * unit(random));
            const Vector3 to_eye{1, 0, 0};
            if (dot(normal, scene.to_sun) < 0.01 || dot(normal, to_eye) < 0.01) continue;
            const Geometry at = scattering_geometry(normal, scene.to_sun, to_eye);
            ASSERT_NEAR(cos_scattering_angle_reflected(at), -std::cos(phase), 1e-9);
            const LayerSolution layer =
                solve_layer(scene.layer.components[0], scene.layer.albedo[0],
                            scene.layer.optical_depth.max, {at.mu_in, at.mu_out});
            const SolvedValue value = layer.reflection(0, 1, at.azimuth);
            EXPECT_LE(value.multiple / value.total, bounds.multiple.bound * 1.001)
                << "g " << g << ", " << bounds.multiple.where;
            const double mean = layer.reflection_modes[0](0, 1);
            EXPECT_LE(std::abs(value.multiple - mean) / value.total,
                      bounds.azimuth.bound * 1.001 + 1e-6);
        }
    }
    EXPECT_GT(bounded, 20);
}

TEST(OrderBounds, GrowWithDepthAndAlbedo) {
    const auto bound = [](double depth, double albedo) {
        return bound_orders(wide_slab(depth, albedo), infinity).multiple.bound;
    };
    EXPECT_LT(bound(0.01, 0.5), bound(0.1, 0.5));
    EXPECT_LT(bound(0.1, 0.5), bound(1, 0.5));
    EXPECT_LT(bound(1, 0.4), bound(1, 0.5));
}

TEST(OrderShares, SumToAllOrders) {
    const ScatteringPlace place{
        PhaseFunction::henyey_greenstein(0.4), 0.8, 1, 0, Side::transmission, {0.6, 0.3, 1}};
    const std::vector<double> shares = order_shares(place, 100);
    double sum = 0;
    for (const double share : shares) sum += share;
    EXPECT_NEAR(sum, 1, 1e-3);  // modes are cut at 1e-4
    const std::optional<int> enough = orders_for(shares, 0.01);
    ASSERT_TRUE(enough);
    EXPECT_GT(*enough, 2);
    EXPECT_LT(*enough, 40);
    EXPECT_FALSE(orders_for({0.5, 0.3}, 0.01));
}

TEST(PlanReport, TellsWhatEffectsChangeAndCost) {
    Scene scene = wide_slab(1, 0.9);
    scene.background.colour = {0, 0, 0};
    scene.layer.opposition = Opposition::hapke(1, 0.05);
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.5)};
    const FileReport file = report_plans({scene});
    const PlanReport& report = file.scenes[0];
    const auto share_of = [&](const std::string& name) {
        return std::ranges::find(report.shares, name, &EffectShare::name);
    };
    ASSERT_NE(share_of("multiple"), report.shares.end());
    EXPECT_TRUE(share_of("multiple")->bounded);
    EXPECT_GT(share_of("multiple")->max, share_of("multiple")->mean);
    EXPECT_FALSE(share_of("transmission")->seen);
    // Seen from 60 degrees, the sun at 30 on the other side: one geometry.
    const double phase_angle = radians(90);
    const double bump = opposition_factor(scene.layer.opposition, -std::cos(phase_angle), 1,
                                          std::cos(radians(30)), std::cos(radians(60))) -
                        1;
    EXPECT_NEAR(share_of("opposition")->max, bump / (1 + bump), 1e-9);
    ASSERT_TRUE(report.orders);
    EXPECT_TRUE(report.orders->enough);
    const PlanCosts& costs = report.costs;
    ASSERT_EQ(costs.without.size(), report.shares.size());
    EXPECT_GT(costs.all.table_seconds(), 0);
    EXPECT_GT(costs.all.ray_ns.median, 0);
    EXPECT_GE(costs.all.ray_ns.spread, 0);
    EXPECT_EQ(costs.planned.bytes, costs.all.bytes);
    EXPECT_EQ(file.cost.tables.bytes, costs.all.bytes);
    EXPECT_GT(file.cost.seconds(), file.cost.ray_seconds);
    const auto multiple = static_cast<std::size_t>(share_of("multiple") - report.shares.begin());
    EXPECT_EQ(costs.without[multiple].bytes, 0);
    // What is counted is what a bake fills: samples and some fluxes.
    const auto tables = bake_for({scene});
    double samples = 0;
    for (const auto& table : tables[0]->paths)
        if (table) samples += static_cast<double>(table->headers[0].sample_count());
    EXPECT_NEAR(costs.all.bytes / (sizeof(float) * samples), 1, 0.1);
}

TEST(PlanReport, CountsTheLightThatRingsAndPlanetExchange) {
    Scene rings = once(small_rings(1));
    const RenderCost apart = report_plans({rings}).cost;
    rings.effects.ringshine = rings.effects.planetshine = true;
    const RenderCost shining = report_plans({rings}).cost;
    EXPECT_GT(shining.light_seconds, 10 * apart.light_seconds);
    EXPECT_EQ(shining.seconds(), shining.light_seconds + shining.ray_seconds);
}

TEST(PlanReport, CountsTheTablesThatChannelsShareOnce) {
    const Scene grey = wide_slab(1, 0.9);
    Scene alike = grey, unlike = grey;
    alike.layer.channels = {3, PhaseFunction::rayleigh()};
    unlike.layer.channels = {PhaseFunction::rayleigh(), PhaseFunction::isotropic(),
                             PhaseFunction::henyey_greenstein(0.3)};
    const std::vector<PlanReport> reports = report_plans({grey, alike, unlike}).scenes;
    EXPECT_EQ(reports[1].costs.all.bytes, reports[0].costs.all.bytes);
    EXPECT_GT(reports[2].costs.all.bytes, 2 * reports[0].costs.all.bytes);
    for (std::size_t e = 0; e < reports[0].shares.size(); ++e)
        EXPECT_EQ(reports[1].shares[e].max, reports[0].shares[e].max) << reports[0].shares[e].name;
}

}  // namespace
}  // namespace stratus
