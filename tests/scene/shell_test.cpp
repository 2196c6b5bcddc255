// Planets whose layer is a spherical shell, against photons and limits.
#include <stratus/base/constants.h>
#include <stratus/scene/render.h>

#include "indices.h"
#include "shell_photons.h"
#include "small_scene.h"
#include "subjects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

Scene shell(double height, double optical_depth, double albedo, double phase_angle) {
    Scene scene = small_planet(phase_angle, optical_depth, albedo);
    the_planet(scene).shell = height;
    scene.layer.components = {PhaseFunction::henyey_greenstein(0.5)};
    return scene;
}

/// Light along a ray in the plane of eye and sun, at a distance from the planet's centre.
double seen_at(const Scene& scene, const LayerLight& light, double impact) {
    return radiance_along(scene, light, {{5, impact, 0}, {-1, 0, 0}}, scene.to_sun)[0];
}

/// In the photons' frame the eye is along z and the ray meets the x axis.
ShellLight photons_at(const Scene& scene, double impact) {
    const double side = impact < 0 ? -1 : 1;
    return shell_photons(scene.layer.components[0], scene.layer.albedo[0],
                         scene.layer.optical_depth.max, the_planet(scene).shell,
                         {std::abs(impact), {side * scene.to_sun.y, 0, scene.to_sun.x}}, 10000);
}

struct ShellCase {
    double height, optical_depth;
    double error;  // of all light on the sunlit part, relative
};

class ShellAndPhotons : public testing::TestWithParam<ShellCase> {};

// Light scattered once is exact. Of the rest, what comes sideways is lost in the twilight.
TEST_P(ShellAndPhotons, AgreeAsStated) {
    const auto& [height, optical_depth, error] = GetParam();
    constexpr double sigmas = 4, faint = 0.01;
    for (const double phase_angle : {30.0, 90.0, 150.0}) {
        const Scene scene = shell(height, optical_depth, 0.99, phase_angle), first = once(scene);
        const BakedLight light(scene);
        const LayerLight single(first, nullptr);
        for (const double impact :
             {-0.5, 0.0, 0.5, 0.9, 0.99, 1 + 0.3 * height, 1 + 0.8 * height}) {
            const ShellLight photons = photons_at(scene, impact);
            const double expected = photons.single.value + photons.multiple.value,
                         got = seen_at(scene, light, impact),
                         noise = sigmas * photons.multiple.standard_error;
            EXPECT_NEAR(seen_at(first, single, impact), photons.single.value,
                        sigmas * photons.single.standard_error + 1e-6)
                << phase_angle << ' ' << impact;
            const double sunlit = std::cos(radians(phase_angle) - std::asin(std::min(1.0, impact)));
            if (sunlit > 0.1 && expected > faint)
                EXPECT_NEAR(got, expected, error * expected + noise)
                    << phase_angle << ' ' << impact;
            else
                EXPECT_LT(got, 1.3 * expected + faint) << phase_angle << ' ' << impact;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Heights, ShellAndPhotons,
                         testing::ValuesIn<ShellCase>({{0.001, 10, 0.05},
                                                       {0.01, 0.1, 0.03},
                                                       {0.01, 1, 0.05},
                                                       {0.01, 5, 0.13},
                                                       {0.05, 0.1, 0.06},
                                                       {0.05, 1, 0.09}}),
                         [](const auto& each) { return std::to_string(each.index); });

TEST(Shell, OfNoHeightIsPlane) {
    Scene thin = shell(1e-6, 2, 0.9, 60), plane = thin;
    plane.effects.shell = false;
    the_planet(thin).surface.colour = {0.5f, 0.25f, 0.125f};
    plane.subject = thin.subject;
    const auto tables = bake_for({thin, plane});
    const LayerLight light(thin, tables[0].get()), flat(plane, tables[1].get());
    for (const double impact : {-0.3, 0.0, 0.4, 0.8}) {
        const Ray ray{{5, impact, 0.2}, {-1, 0, 0}};
        const Rgb3 got = radiance_along(thin, light, ray, thin.to_sun),
                   expected = radiance_along(plane, flat, ray, plane.to_sun);
        for (const auto c : three_channels) EXPECT_NEAR(got[c] / expected[c], 1, 1e-3);
    }
}

TEST(Shell, ThatHardlyScattersLeavesTheGroundToLambertsLaw) {
    Scene scene = once(shell(0.05, 1e-9, 1, 60));
    the_planet(scene).surface.colour = {0.5f, 0.5f, 0.5f};
    const LayerLight light(scene, nullptr);
    for (const double impact : {-0.3, 0.0, 0.8, 0.99}) {
        const double normal = std::asin(impact), mu = std::cos(radians(60) - normal);
        EXPECT_NEAR(seen_at(scene, light, impact), 0.5 * mu, 1e-6) << impact;
    }
    EXPECT_LT(seen_at(scene, light, 1.01), 1e-6);
}

// Over bright ground and beyond the limb, from the lit side into the twilight.
TEST(Shell, InColoursIsTheShellOfEachDepth) {
    for (const Rgb3& depths : {Rgb3{0.1, 0.3, 1}, Rgb3{1, 0, 0}, Rgb3{2e-4, 1e-4, 0.5}}) {
        Scene coloured = shell(0.02, std::ranges::max(depths), 0.99, 90);
        the_planet(coloured).surface.colour = {0.5f, 0.5f, 0.5f};
        for (const auto c : three_channels)
            coloured.layer.extinction[c] = depths[c] / std::ranges::max(depths);
        const auto tables =
            bake_layer_tables(of_all_directions(*needed_recipe(coloured, LightPath::sunlight)));
        const LayerLight light(coloured, tables.get());
        for (const auto c : three_channels) {
            Scene grey = coloured;
            grey.layer.extinction = {1, 1, 1};
            grey.layer.optical_depth.max = depths[c];
            const LayerLight alone(grey, tables.get());
            for (const double impact : {-0.1, 0.0, 0.5, 0.95, 1.005}) {
                const Ray ray{{5, impact, 0}, {-1, 0, 0}};
                const double expected = radiance_along(grey, alone, ray, grey.to_sun)[c];
                EXPECT_NEAR(radiance_along(coloured, light, ray, grey.to_sun)[c], expected,
                            1e-5 * expected + 1e-6)
                    << c << ' ' << impact << ' ' << depths[c];
            }
        }
    }
}

// Light leaves a steep column of thin air along the ray, not along the layer.
TEST(Shell, OfThinAirIsPlaneBeforeTheSun) {
    for (const double optical_depth : {1e-5, 3e-4}) {
        Scene thin = shell(1e-6, optical_depth, 0.99, 30), plane = thin;
        plane.effects.shell = false;
        thin.effects.single = plane.effects.single = false;
        const auto tables = bake_layer_tables(of_all_directions(*needed_recipe(thin)));
        const double expected = seen_at(plane, LayerLight(plane, tables.get()), 0.2);
        EXPECT_NEAR(seen_at(thin, LayerLight(thin, tables.get()), 0.2), expected, 1e-3 * expected);
    }
}

TEST(Shell, WithoutBackgroundHidesTheSky) {
    Scene scene = once(shell(0.05, 0.5, 0, 60));
    scene.background.colour = {1, 1, 1};
    const double seen = seen_at(scene, LayerLight(scene, nullptr), 1.03);
    EXPECT_TRUE(seen > 0.01 && seen < 0.5) << seen;
    scene.effects.background = false;
    EXPECT_EQ(seen_at(scene, LayerLight(scene, nullptr), 1.03), 0);
    EXPECT_EQ(seen_at(scene, LayerLight(scene, nullptr), 1.06), 1) << "beside it";
}

// A sun so low that no beam gets through leaves numbers finite, and the ocean's glint is the plane layer's.
TEST(Shell, OverGroundIsFiniteAndMirrors) {
    Scene scene = once(shell(1e-4, 400, 0.9, 89));
    auto& surface = the_planet(scene).surface;
    surface.colour = {0.5f, 0.5f, 0.5f};
    for (const double impact : {-0.5, 0.0, 0.02, 0.1, 0.9}) {
        const double light = seen_at(scene, LayerLight(scene, nullptr), impact);
        EXPECT_TRUE(light >= 0 && light < 1) << impact << ' ' << light;
    }
    scene = once(shell(1e-6, 0.1, 0.9, 40));
    auto& sea = the_planet(scene).surface;
    sea.mirror = read_ground_law("ocean:wind=5");
    sea.colour = {0.1f, 0.1f, 0.1f};
    Scene plane = scene;
    plane.effects.shell = false;
    const double glint = seen_at(plane, LayerLight(plane, nullptr), std::sin(radians(20)));
    EXPECT_GT(glint, 0.2);
    EXPECT_NEAR(seen_at(scene, LayerLight(scene, nullptr), std::sin(radians(20))) / glint, 1, 1e-3);
}

TEST(ShellCosine, IsTheCosineOfThinShellsAndOfSteepBeams) {
    for (const double depth : {1e-3, 1.0, 10.0}) {
        EXPECT_NEAR(shell_cosine(depth, 1e-9, 0.3), 0.3, 1e-4);
        EXPECT_NEAR(shell_cosine(depth, 0.05, 1), 1, 1e-9);
        EXPECT_LT(shell_cosine(depth, 0.01, -0.05), shell_cosine(depth, 0.01, 0));
        EXPECT_EQ(shell_cosine(depth, 0.01, -0.5), 0) << "in the planet's shadow";
    }
    // A level beam has the slant depth sqrt(2 k t) at the depth t of a deep shell of extinction k, and leaves
    // 1 / k in its column; in a thin one 1 - x / 2 of it passes, x = 2 sqrt(2 / height) / 3 depths.
    EXPECT_NEAR(shell_cosine(10, 0.01, 0), 0.001, 2e-5);
    EXPECT_NEAR(shell_cosine(1e-6, 1e-3, 0), std::sqrt(1e-3 / 2) * 3 / 4, 1e-4);
}

}  // namespace
}  // namespace stratus
