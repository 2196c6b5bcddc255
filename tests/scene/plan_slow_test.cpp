// Pictures by the plan against pictures with everything, on random scenes and on two that a sample
// of pixels would misjudge.
#include <stratus/scene/plan.h>

#include "plan_scenes.h"
#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stratus::test {
namespace {

Scene planned(const Scene& scene, const Plan& plan) {
    Scene less = scene;
    less.effects = plan.effects;
    return less;
}

TEST(PlannedPicture, DiffersFromThatWithEverythingByLessThanTheTolerance) {
    RandomScenes scenes(15);
    int less = 0, without_table = 0;
    for (int n = 0; n < 200; ++n) {
        const Scene scene = scenes.next();
        const Plan plan = plan_scene(scene);
        if (plan.left_out.empty()) continue;  // the same picture
        ++less;
        const Scene lean = planned(scene, plan);
        without_table += needed_paths(lean).empty();
        EXPECT_LE(max_change(picture(scene), picture(lean)), scene.tolerance)
            << "scene " << n << " without " << plan.left_out[0].name << ", "
            << plan.left_out[0].change.where;
    }
    EXPECT_GT(less, 30) << "effects left out";
    EXPECT_LT(less, 190);
    EXPECT_GT(without_table, 15);
}

TEST(PlannedPicture, KeepsTheOrdersThatABrightRingletInAFaintRingNeeds) {
    Scene scene = small_rings(1e-3);
    the_rings(scene).surface.colour = {0, 0, 0};
    const double half_width = 2.5 / 60268;  // 5 km, in Saturn's radii
    auto& profile = the_rings(scene).profile;
    profile.radius = {1.5, 2 - 2 * half_width, 2 - half_width, 2 + half_width, 2 + 2 * half_width,
                      2.5};
    profile.optical_depth = {1e-3, 1e-3, 2, 2, 1e-3, 1e-3};
    profile.w1 = {0.01, 0.01, 0.6, 0.6, 0.01, 0.01};
    profile.w2 = {0.01, 0.01, 0.35, 0.35, 0.01, 0.01};
    scene.tolerance = 0.01;
    EXPECT_TRUE(plan_scene(scene).left_out.empty());
    // It matters: looked at closely, the ringlet loses a good part of its light.
    scene.camera.orthographic = true;
    scene.camera.position = {2, 0, 10};
    scene.camera.look_at = {2, 0, 0};
    scene.camera.width = 6 * half_width;
    scene.width = 32;
    scene.height = 4;
    EXPECT_GT(max_change(picture(scene), picture(once(scene))), 0.2);
    // Without the ringlet, the ring needs no table.
    for (std::vector<double>* const values : {&profile.optical_depth, &profile.w1, &profile.w2})
        std::ranges::fill(*values, values->front());
    EXPECT_FALSE(plan_scene(scene).effects.multiple);
}

TEST(PlannedPicture, KeepsAnOppositionSpotThatWasAskedFor) {
    SceneFile file = parse_scene(R"(
        tolerance = 0.02
        [picture]
        width = 400
        height = 400
        samples = 1
        [camera]
        distance = 10.0
        orthographic_width = 2.1
        [sun]
        phase_angle_deg = 0.3
        [layer]
        phase_function = "lambert_sphere"
        albedo = 0.005
        optical_depth = inf
        opposition = { law = "hapke", amplitude = 1.0, width = 0.002 }
        [planet]
    )");
    const Scene& scene = file.panels[0];
    const Plan plan = plan_scene(scene);
    EXPECT_TRUE(plan.effects.opposition);
    EXPECT_FALSE(plan.effects.multiple);
    const Image all = picture(scene);
    EXPECT_LE(max_change(all, picture(planned(scene, plan))), scene.tolerance);
    Scene without = scene;
    without.effects.opposition = false;
    EXPECT_GT(max_change(all, picture(without)), 0.2);
}

}  // namespace
}  // namespace stratus::test
