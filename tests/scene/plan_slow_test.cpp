// Pictures by the plan against pictures with everything, on random scenes and on two that a sample
// of pixels would misjudge.
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

namespace stratus {
namespace {

float brightest_channel(const float* pixel) { return std::max({pixel[0], pixel[1], pixel[2]}); }

/// Maximum change of a pixel relative to its own light, or to 1 % of the brightest.
double max_change(const Image& all, const Image& some) {
    float most = 0;
    for (std::size_t i = 0; i < all.rgb.size(); i += 3)
        most = std::max(most, brightest_channel(&all.rgb[i]));
    double max = 0;
    for (std::size_t i = 0; i < all.rgb.size() && most > 0; ++i)
        max = std::max(max,
                       double{std::abs(all.rgb[i] - some.rgb[i])} /
                           double{std::max(brightest_channel(&all.rgb[i - i % 3]), 0.01f * most)});
    return max;
}

Image picture(const Scene& scene) {
    const auto tables = bake_for({scene});
    const LayerLight light(scene, tables[0].get());
    return render(scene, light);
}

Scene planned(const Scene& scene, const Plan& plan) {
    Scene less = scene;
    less.effects = plan.effects;
    return less;
}

class RandomScenes {
  public:
    Scene next() {
        Scene scene;
        switch (static_cast<int>(between(0, 3))) {
            case 0: scene = rings(); break;
            case 1: scene = planet(); break;
            default: scene = slab();
        }
        scene.width = 28;
        scene.height = 20;
        scene.samples = 1;
        scene.tolerance = 0.01;
        scene.to_sun = direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        if (happens(0.2)) scene.sun_diameter = radians(between(0.1, 2));
        if (happens(0.2)) scene.layer.density = between(0.01, 0.3);
        if (happens(0.3)) scene.layer.opposition = Opposition::hapke(1, power(-3, -1));
        return scene;
    }

  private:
    double between(double min, double max) {
        return std::uniform_real_distribution<double>(min, max)(random_);
    }
    double power(double min, double max) { return std::pow(10, between(min, max)); }
    bool happens(double chance) { return between(0, 1) < chance; }
    Rgb colour() {
        return {static_cast<float>(between(0, 1)), static_cast<float>(between(0, 1)),
                static_cast<float>(between(0, 1))};
    }
    PhaseFunction phase_function() {
        switch (static_cast<int>(between(0, 4))) {
            case 0: return PhaseFunction::isotropic();
            case 1: return PhaseFunction::rayleigh();
            case 2: return PhaseFunction::lambert_sphere();
            default: return PhaseFunction::henyey_greenstein(between(-0.4, 0.7));
        }
    }
    std::array<double, 3> tint(double most) {
        return {most * between(0.01, 1), most * between(0.01, 1), most * between(0.01, 1)};
    }

    Scene rings() {
        Scene scene = small_rings(1);
        scene.layer.components = {phase_function(), phase_function()};
        scene.layer.albedo = tint(1);
        auto& subject = std::get<Rings>(scene.subject);
        subject.surface.colour = happens(0.2) ? colour() : Rgb{0, 0, 0};
        RingProfile profile;
        const int knots = 2 + static_cast<int>(between(0, 6));
        double radius = between(1.1, 1.5);
        const double deepest = power(-4, 0.5), brightest = power(-2.5, 0);
        for (int k = 0; k < knots; ++k) {
            profile.radius.push_back(radius);
            profile.optical_depth.push_back(deepest * between(0.1, 1));
            const double w = brightest * between(0.2, 1), share = between(0, 1);
            profile.w1.push_back(w * share);
            profile.w2.push_back(w * (1 - share));
            radius += happens(0.3) ? 1e-4 : between(0.1, 0.3);  // thin ringlets among them
        }
        subject.profile = profile;
        scene.camera.position =
            between(6, 12) * direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? between(1, 6) : radians(between(5, 40));
        if (happens(0.5)) scene.background.colour = colour();
        return scene;
    }
    Scene planet() {
        Scene scene = small_planet(0, happens(0.2) ? infinity : power(-3, 1), 1);
        scene.layer.components = {phase_function()};
        scene.layer.albedo = tint(power(-2.5, 0));
        if (happens(0.5)) std::get<Planet>(scene.subject).surface.colour = colour();
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? 2.1 : radians(25);
        return scene;
    }
    Scene slab() {
        Scene scene = small_slab(power(-3, 1), 1);
        scene.layer.components = {phase_function()};
        scene.layer.albedo = tint(power(-2.5, 0));
        scene.background.colour = happens(0.5) ? colour() : Rgb{0, 0, 0};
        scene.camera.position =
            10.0 * direction_at(std::asin(between(0.05, 1)), between(0, 2 * pi));
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? 2 : radians(between(10, 90));
        auto& subject = std::get<Slab>(scene.subject);
        if (happens(0.3)) {
            subject.surface.emplace();
            subject.surface->colour = colour();
        }
        if (happens(0.3)) {
            scene.layer.optical_depth.pattern = DepthMap::Pattern::clouds;
            scene.layer.optical_depth.scale = 0.5;
        }
        return scene;
    }

    std::mt19937 random_{15};
};

TEST(PlannedPicture, DiffersFromThatWithEverythingByLessThanTheTolerance) {
    RandomScenes scenes;
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
    std::get<Rings>(scene.subject).surface.colour = {0, 0, 0};
    const double half_width = 2.5 / 60268;  // 5 km, in Saturn's radii
    auto& profile = std::get<Rings>(scene.subject).profile;
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
}  // namespace stratus
