#include <stratus/base/constants.h>
#include <stratus/scene/plan.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "plan_scenes.h"
#include "temporary_folder.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

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
    EXPECT_GT(plan.left_out[0].change.change, 0);
    EXPECT_LT(plan.left_out[0].change.change, 0.02);
    EXPECT_LE(plan.left_out[0].change.found, plan.left_out[0].change.change);
}

TEST(Plan, MeasuresAzimuthsByTheOrdersThatAreThere) {
    Scene scene = wide_slab(0.05, 1);
    scene.camera.position = 10.0 * direction_at(radians(20), 0);
    scene.to_sun = direction_at(radians(20), pi);
    EXPECT_FALSE(plan_scene(scene).effects.azimuth);
    scene.effects.single = false;
    EXPECT_TRUE(plan_scene(scene).effects.azimuth);
}

TEST(Plan, LeavesOutOfFilmsWhatAllFramesDo) {
    Scene dark = wide_slab(0.5, 0.02), darker = wide_slab(0.5, 0.01);
    dark.tolerance = darker.tolerance = 0.05;
    const Scene bright = wide_slab(0.5, 0.9);
    const auto planned = [](const std::vector<Scene>& frames) {
        std::vector<SceneFile> film(frames.size());
        for (const auto k : indices(frames)) film[k].panels = {frames[k]};
        const Plan plan = follow_plans(film).at(0);
        for (const SceneFile& frame : film)
            EXPECT_EQ(frame.panels[0].effects.multiple, !leaves_out(plan, "multiple"));
        return plan;
    };
    EXPECT_FALSE(leaves_out(planned({dark, bright}), "multiple"));
    EXPECT_FALSE(leaves_out(planned({bright, dark}), "multiple"));
    const Plan both = planned({darker, dark});
    ASSERT_TRUE(leaves_out(both, "multiple"));
    EXPECT_EQ(both.left_out[0].change.change, plan_scene(dark).left_out[0].change.change);
    EXPECT_GT(both.left_out[0].change.change, plan_scene(darker).left_out[0].change.change);
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
    the_planet(scene).surface.colour = {0.9f, 0.9f, 0.9f};
    EXPECT_TRUE(plan_scene(scene).effects.multiple);
}

/// What a plan changes: the largest relative change of a ray's light, found at random places of the
/// scene by the solver.
TEST(OrderEstimates, AreNotExceededByRays) {
    Uniform unit(7);
    int estimated = 0;
    for (int n = 0; n < 30; ++n) {
        Scene scene = small_planet(180 * unit(), std::pow(10, 2 * unit() - 2), 0.3 * unit());
        const double g = 0.8 * unit() - 0.2;
        scene.layer.components = {PhaseFunction::henyey_greenstein(g)};
        const OrderEstimates estimates = estimate_orders(scene, infinity);
        ASSERT_LE(estimates.multiple.found, estimates.multiple.change);
        estimated += estimates.multiple.change < 1;
        const double phase = std::acos(std::clamp(dot({1, 0, 0}, scene.to_sun), -1.0, 1.0));
        for (int k = 0; k < 20; ++k) {
            const Vector3 normal = direction_at(std::asin(2 * unit() - 1), 2 * pi * unit());
            const Vector3 to_eye{1, 0, 0};
            if (dot(normal, scene.to_sun) < 0.01 || dot(normal, to_eye) < 0.01) continue;
            const Geometry at = scattering_geometry(normal, scene.to_sun, to_eye);
            ASSERT_NEAR(cos_scattering_angle_reflected(at), -std::cos(phase), 1e-9);
            const LayerSolution layer =
                solve_layer(scene.layer.components[0], scene.layer.albedo[0],
                            scene.layer.optical_depth.max, {at.mu_in, at.mu_out});
            const SolvedValue value = layer.reflection(0, 1, at.azimuth);
            EXPECT_LE(value.multiple / value.total, estimates.multiple.change)
                << "g " << g << ", " << estimates.multiple.where;
            const double mean = layer.modes.reflection[0](0, 1);
            EXPECT_LE(std::abs(value.multiple - mean) / value.total,
                      estimates.azimuth.change + 1e-6);
        }
    }
    EXPECT_GT(estimated, 20);
}

/// A few of those that bench/plan_bench.cpp keeps the record of.
TEST(OrderEstimates, AreNotExceededByPicturesOfRandomScenes) {
    int judged = 0;
    for (unsigned seed = 1; seed <= 18; ++seed) {
        RandomScenes scenes(seed);
        Scene scene = seed % 3 == 0   ? scenes.next()
                      : seed % 3 == 1 ? scenes.adversarial()
                                      : scenes.stack();
        scene.tolerance = 0.03;
        shine_on_one_another(scene, false);
        for (const auto& [effect, estimate, found, where] : changes_of(scene)) {
            EXPECT_LE(found, estimate + scene.tolerance)
                << "without " << effect << ", " << where << ", " << seed;
            ++judged;
        }
    }
    EXPECT_GT(judged, 6);
}

TEST(OrderEstimates, GrowWithDepthAndAlbedo) {
    const auto change = [](double depth, double albedo) {
        return estimate_orders(wide_slab(depth, albedo), infinity).multiple.change;
    };
    EXPECT_LT(change(0.01, 0.5), change(0.1, 0.5));
    EXPECT_LT(change(0.1, 0.5), change(1, 0.5));
    EXPECT_LT(change(1, 0.4), change(1, 0.5));
}

TEST(OrderEstimates, EndWhereBothEffectsAreNeeded) {
    Scene scene = wide_slab(1, 0.9);
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.5)};
    const OrderEstimates first = estimate_orders(scene, 1e-3), all = estimate_orders(scene, 1);
    EXPECT_GT(first.multiple.found, 1e-3);
    EXPECT_LE(first.multiple.found, all.multiple.found);
    EXPECT_LE(first.azimuth.found, all.azimuth.found);
}

// Two halves of a layer, hardly unlike, are a stack of the same light.
TEST(OrderEstimates, AreTheLayersOwnOfItsHalvesAsAStack) {
    for (const float background : {0.0f, 1.0f}) {
        Scene scene = wide_slab(1, 0.01);
        scene.background.colour = {background, background, background};
        scene.layer.components = {PhaseFunction::rayleigh()};
        const OrderEstimates layer = estimate_orders(scene, infinity);
        scene.layer = layer_of_stacks(
            {{{PhaseFunction::rayleigh(), 0.01, 0.5}, {PhaseFunction::rayleigh(), 0.010001, 0.5}}});
        const OrderEstimates stack = estimate_orders(scene, infinity);
        EXPECT_GT(layer.multiple.found, 1e-3);
        EXPECT_NEAR(stack.azimuth.found, layer.azimuth.found, 1e-5);
        // A stack counts all that is diffuse in the light of the background.
        if (background == 0)
            EXPECT_NEAR(stack.multiple.found, layer.multiple.found, 1e-5);
        else
            EXPECT_GE(stack.multiple.found, layer.multiple.found);
    }
}

/// A planet under thin air that is a shell, of which the camera sees so much, beside the limb or not.
Scene aired_planet(double height, double width) {
    Scene scene = small_planet(20, 0.3, 0.9);
    scene.tolerance = 0.01;
    scene.camera.width = width;
    scene.subject = Planet{.shell = height};
    return scene;
}

TEST(Plan, LeavesOutShellsThatChangeNoPixel) {
    const Scene thin = aired_planet(1e-4, 0.5);
    const Plan plan = plan_scene(thin);
    EXPECT_FALSE(plan.effects.shell);
    ASSERT_TRUE(leaves_out(plan, "shell"));
    EXPECT_LE(max_change(picture(thin), picture(with_effects(thin, plan.effects))), thin.tolerance);
    EXPECT_TRUE(plan_scene(aired_planet(0.05, 1)).effects.shell);
    EXPECT_TRUE(plan_scene(aired_planet(1e-4, 2)).effects.shell) << "at the limb";
    Scene low_sun = thin;
    low_sun.to_sun = direction_at(0, radians(90));
    EXPECT_TRUE(plan_scene(low_sun).effects.shell) << "along the terminator";
    Scene named = thin;
    named.named = {&SceneEffects::shell};
    EXPECT_TRUE(plan_scene(named).effects.shell);
}

TEST(Plan, LeavesOutOrdersOfAPlaneLayerInPlaceOfAShell) {
    Scene scene = aired_planet(1e-5, 0.5);
    scene.layer.albedo = {0.01, 0.01, 0.01};
    EXPECT_FALSE(plan_scene(scene).effects.multiple);
    scene.named = {&SceneEffects::shell};
    EXPECT_TRUE(plan_scene(scene).effects.multiple) << "of shells orders are not estimated";
}

/// A few of those that bench/plan_bench.cpp keeps the record of; in the last four dark pixels along the
/// terminator outnumber those at the limb, which change more.
TEST(ShellEstimate, IsNotExceededByPicturesOfRandomShells) {
    int judged = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Scene scene =
            RandomScenes(seed <= 16 ? seed : (std::array{225u, 264u, 305u, 407u}[seed - 17]))
                .shell();
        for (const auto& [effect, estimate, found, where] : changes_of(scene)) {
            EXPECT_LE(found, estimate + 0.1 * scene.tolerance) << where << ", " << seed;
            judged += found > 0;
        }
    }
    EXPECT_GT(judged, 8);
}

TEST(OrderShares, SumToAllOrders) {
    const std::vector<double> shares =
        order_shares(PhaseFunction::henyey_greenstein(0.4), 0.8, 1, Side::transmission,
                     {{{0.6, 0.3, 1}, 1}, {{0.6, 0.9, 2}, 2}}, 100);
    double sum = 0;
    for (const double share : shares) sum += share;
    EXPECT_NEAR(sum, 1, 1e-3);  // modes are cut at 1e-4
    const int enough = orders_for(shares, 0.01);
    EXPECT_GT(enough, 2);
    EXPECT_LT(enough, 40);
    // A few orders and the geometric series beyond tell nearly as much.
    const std::vector<double> first(shares.begin(), shares.begin() + 5);
    EXPECT_NEAR(orders_for(first, 0.01), enough, 1);
    EXPECT_EQ(orders_for({0.5, 0.3}, 0.01), 6);  // 0.2, and 0.4 of it with each order
}

TEST(PlanReport, TellsHowManyOrdersSuffice) {
    Scene scene = wide_slab(4, 0.95);
    scene.tolerance = 2e-3;
    scene.background.colour = {0, 0, 0};
    scene.layer.components = {PhaseFunction::henyey_greenstein(-0.5)};
    const PlanReport report = report_plans({scene}).scenes[0];
    ASSERT_EQ(report.orders.size(), 1u);
    EXPECT_EQ(report.orders[0].share.size(), 5u);
    const Geometry at{std::cos(radians(30)), std::cos(radians(60)), 0};
    const std::vector<double> all =
        order_shares(scene.layer.components[0], 0.95, 4, Side::reflection, {{at, 1}}, 60);
    EXPECT_NEAR(report.orders[0].enough, orders_for(all, scene.tolerance), 2);
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
    EXPECT_FALSE(share_of("multiple")->estimated) << "it is kept";
    EXPECT_GE(share_of("multiple")->max, share_of("multiple")->mean);
    EXPECT_FALSE(share_of("transmission")->seen);
    // Seen from 60 degrees, the sun at 30 on the other side: one geometry.
    const double phase_angle = radians(90);
    const double bump = opposition_factor(scene.layer.opposition, -std::cos(phase_angle), 1,
                                          std::cos(radians(30)), std::cos(radians(60))) -
                        1;
    EXPECT_NEAR(share_of("opposition")->max, bump / (1 + bump), 1e-9);
    const LayerSolution layer = solve_layer(scene.layer.components[0], 0.9, 1,
                                            {std::cos(radians(30)), std::cos(radians(60))});
    const SolvedValue seen = layer.reflection(0, 1, 0);
    EXPECT_NEAR(share_of("multiple")->mean, seen.multiple / (seen.total + bump * seen.single),
                0.03);
    ASSERT_EQ(report.orders.size(), 1u) << "of the lit side, which alone is seen";
    EXPECT_EQ(report.orders[0].side, Side::reflection);
    EXPECT_NEAR(report.orders[0].share[0], seen.single / seen.total, 0.03);
    EXPECT_GT(file.cost.tables.solve_seconds, 0);
    EXPECT_GT(file.cost.ray_seconds, 0);
    EXPECT_GT(file.cost.seconds(), file.cost.ray_seconds);
    EXPECT_EQ(file.kept_seconds, 0) << "without a cache choices are made again";
    EXPECT_NEAR(share_of("multiple")->table_bytes, file.cost.tables.bytes, 1);
    EXPECT_NEAR(share_of("multiple")->table_seconds, file.cost.tables.seconds(), 1e-9);
    EXPECT_EQ(share_of("opposition")->table_seconds, 0);
    EXPECT_GT(share_of("azimuth")->table_seconds, 0);
    // What is counted is what a bake fills: samples and some fluxes.
    const auto tables = bake_for({scene});
    double samples = 0;
    for (const auto& table : tables[0]->paths)
        if (table) samples += static_cast<double>(table->headers[0].sample_count());
    EXPECT_NEAR(file.cost.tables.bytes / (sizeof(float) * samples), 1, 0.1);
}

TEST(PlanReport, CountsOrdersOnBothSidesThatAreSeen) {
    Scene scene = small_rings(1);
    scene.camera.position = 10.0 * direction_at(radians(-40), 0);
    const std::vector<OrderReport> unlit = report_plans({scene}).scenes[0].orders;
    ASSERT_EQ(unlit.size(), 1u);
    EXPECT_EQ(unlit[0].side, Side::transmission);
    EXPECT_GT(unlit[0].share[0], unlit[0].share[1]);
    EXPECT_GT(unlit[0].enough, 2);
}

TEST(PlanReport, KeepsItsChoicesForTheRender) {
    const TemporaryFolder folder;
    TableCache cache(folder.path(), 1 << 30);
    const Scene scene = wide_slab(1, 0.9);
    const FileReport first = report_plans({scene}, {}, &cache);
    EXPECT_GT(first.kept_seconds, 0);
    EXPECT_EQ(first.cost.tables.choose_seconds, 0);
    const std::unique_ptr<Checkpoint> choices = cache.open_choices(*needed_recipe(scene));
    ASSERT_TRUE(choices);
    EXPECT_GT(choices->pieces(), 5u);
    EXPECT_TRUE(choices->find("attempt 0, check, ladder 0")) << "a piece of the check was timed";
    // What was timed is what the bake itself solves.
    BakeOptions options;
    options.checked_points = 1000;
    std::vector<char> solved, packed;
    options.packed = &packed;
    options.log.keep = [&](const std::string& piece, std::span<const char> result) {
        if (piece == "attempt 0, check, ladder 0") solved.assign(result.begin(), result.end());
    };
    bake(*needed_recipe(scene), options);
    EXPECT_EQ(solved, choices->find("attempt 0, check, ladder 0"));
}

TEST(PlanReport, CountsNothingForTablesThatAreKept) {
    const TemporaryFolder folder;
    TableCache cache(folder.path(), 1 << 30);
    const Scene scene = wide_slab(1, 0.9);
    const auto alone = bake_for({scene});
    report_plans({scene}, {}, &cache);
    const auto planned = bake_for({scene}, {}, &cache);
    const Geometry at{0.5, 0.7, 1};
    EXPECT_EQ(planned[0]->at(LightPath::sunlight)->packed.reflection(0.9, 1, at).total(),
              alone[0]->at(LightPath::sunlight)->packed.reflection(0.9, 1, at).total())
        << "choices that are found make the same table";
    EXPECT_EQ(report_plans({scene}, {}, &cache).cost.tables.seconds(), 0);
}

TEST(PlanReport, CountsTheLightThatRingsAndPlanetExchange) {
    Scene rings = once(small_rings(1));
    const RenderCost apart = report_plans({rings}).cost;
    shine_on_one_another(rings, true);
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
    const FileReport of_grey = report_plans({grey}), of_two = report_plans({grey, alike}),
                     of_all = report_plans({grey, alike, unlike});
    EXPECT_EQ(of_two.cost.tables.bytes, of_grey.cost.tables.bytes);
    EXPECT_GT(of_all.cost.tables.bytes, 2 * of_grey.cost.tables.bytes);
    const std::vector<EffectShare>&one = of_two.scenes[0].shares, &other = of_two.scenes[1].shares;
    for (const auto e : indices(one)) EXPECT_NEAR(one[e].max, other[e].max, 1e-5) << one[e].name;
}

}  // namespace
}  // namespace stratus::test
