#include <stratus/scene/contents.h>

#include <stratus/base/constants.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "small_scene.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(SeenLight, IsOfBothSidesWhereTheSunLiesOnTheHorizon) {
    Scene slab = small_slab(1, 0.9);
    slab.to_sun = direction_at(radians(0.1), 1);
    EXPECT_FALSE(seen_light(slab).transmission);
    slab.sun_diameter = radians(0.5);
    EXPECT_TRUE(seen_light(slab).transmission);
    EXPECT_TRUE(seen_light(slab).reflection);
}

TEST(SeenLight, OfRingsIsOfBothSidesWhereTheyAndTheirPlanetLightOneAnother) {
    Scene rings = small_rings(1);
    shine_on_one_another(rings, true);
    EXPECT_TRUE(seen_light(rings).shine);
    EXPECT_TRUE(seen_light(rings).transmission);
    shine_on_one_another(rings, false);
    EXPECT_FALSE(seen_light(rings).shine);
    EXPECT_FALSE(seen_light(rings).transmission);
}

TEST(SeenLight, OfADeckFromBeneathIsTransmittedAndReflectedDown) {
    Scene slab = small_slab(1, 0.9);
    the_slab(slab).surface.emplace();
    the_slab(slab).surface->colour = {0.5f, 0.5f, 0.5f};
    the_slab(slab).height = 1;
    EXPECT_FALSE(seen_light(slab).underside);
    slab.camera.orthographic = false;
    slab.camera.position = {0, 0, -0.5};
    EXPECT_TRUE(seen_light(slab).underside);
    EXPECT_TRUE(seen_light(slab).transmission);
    EXPECT_FALSE(seen_light(slab).reflection);
    EXPECT_EQ(estimate_orders(slab, 0.01).multiple.change, 1);
}

TEST(SeenLight, OfPlanetsIsReflected) {
    Scene planet = small_planet(30, 2, 0.4);
    EXPECT_TRUE(seen_light(planet).reflection);
    EXPECT_FALSE(seen_light(planet).fluxes);
    the_planet(planet).surface.colour = {0.5f, 0.5f, 0.5f};
    EXPECT_TRUE(seen_light(planet).fluxes);
    EXPECT_EQ(brightest_ground(planet), 0.5);
    the_planet(planet).surface.pattern = Texture::Pattern::continents;
    the_planet(planet).surface.other = {0.7f, 0.7f, 0.7f};
    EXPECT_NEAR(brightest_ground(planet), 0.7, 1e-6);
}

TEST(MatterSpans, LieBetweenKnots) {
    Scene scene = small_rings(2);
    the_rings(scene).profile.optical_depth[1] = 0.5;
    const std::vector<MatterSpan> spans = matter_spans(scene);
    ASSERT_EQ(spans.size(), 1u);
    EXPECT_EQ(spans[0].optical_depth.min, 0.5);
    EXPECT_EQ(spans[0].optical_depth.max, 2);
    EXPECT_DOUBLE_EQ(spans[0].albedo.max, 0.6);
    EXPECT_NEAR(spans[0].mixture.min, 0.5, 1e-12);
}

/// One range within another, up to rounding.
void expect_within(const Range& range, const Range& found, double rounding, const char* what) {
    EXPECT_GE(found.min, range.min - rounding) << what;
    EXPECT_LE(found.max, range.max + rounding) << what;
}

/// All rays of a picture look up what its ranges tell, within the table that its recipe makes.
TEST(SeenDirections, HoldThoseOfEveryRay) {
    Uniform unit(3);
    int looked_up = 0, narrow = 0;
    for (int n = 0; n < 240; ++n) {
        Scene scene = n % 3 == 0   ? small_slab(1, 0.5)
                      : n % 3 == 1 ? small_rings(1)
                                   : small_planet(0, 1, 0.5);
        scene.width = 24;
        scene.height = 16;
        scene.effects.multiple = false;
        shine_on_one_another(scene, false);
        scene.camera.position =
            (1.5 + 8 * unit()) * direction_at(std::asin(2 * unit() - 1), 2 * pi * unit());
        scene.camera.look_at =
            n % 3 == 2 ? Vector3{0, 0, 0} : Vector3{3 * unit(), 3 * unit(), unit() - 0.5};
        scene.camera.orthographic = n % 2 == 0;
        scene.camera.width = n % 2 == 0 ? 4 : radians(4 + 116 * std::pow(unit(), 2));
        if (n % 5 > 0) scene.background.colour = {0, 0, 0};
        scene.to_sun = direction_at(std::asin(2 * unit() - 1), 2 * pi * unit());
        if (n % 4 == 0) scene.sun_diameter = radians(4 * unit());
        const SeenDirections seen = seen_directions(scene);
        const SeenLight light = seen_light(scene);
        LayerLight lookups(scene, nullptr);
        LookupRange range;
        lookups.record(&range);
        RenderOptions one_thread;
        one_thread.threads = 1;
        render(scene, lookups, one_thread);
        if (!range.reflection && !range.transmission) continue;
        ++looked_up;
        EXPECT_TRUE(light.reflection || !range.reflection) << n;
        EXPECT_TRUE(light.transmission || !range.transmission) << n;
        expect_within(seen.mu_in, range.mu_in, 1e-9, "mu_in");
        expect_within(seen.mu_out, range.mu_out, 1e-9, "mu_out");
        expect_within(seen.azimuth, range.azimuth, 1e-6, "azimuth");
        scene.effects.multiple = true;
        const Recipe recipe = *needed_recipe(scene);
        expect_within(recipe.mu_in, range.mu_in, 1e-12, "mu_in of the table");
        expect_within(recipe.mu_out, range.mu_out, 0, "mu_out of the table");
        expect_within(recipe.azimuth, range.azimuth, 0, "azimuth of the table");
        narrow += recipe.mu_out.max - recipe.mu_out.min < 1 &&
                  recipe.azimuth.max - recipe.azimuth.min < 180;
    }
    EXPECT_GT(looked_up, 120);
    EXPECT_GT(narrow, 40);
    EXPECT_LT(narrow, looked_up);
}

TEST(SeenScatteringAngles, AreThoseBetweenSunAndEye) {
    Scene slab = small_slab(1, 0.5);
    const auto angle_of = [&](const Vector3& ray) {
        return 180 - degrees(std::acos(dot(slab.to_sun, -ray)));
    };
    Range seen = seen_scattering_angles(slab, Side::reflection);
    EXPECT_NEAR(seen.min, angle_of(slab.camera.forward()), 1e-9);
    EXPECT_NEAR(seen.max, angle_of(slab.camera.forward()), 1e-9);
    slab.camera.orthographic = false;
    slab.camera.width = radians(30);
    seen = seen_scattering_angles(slab, Side::reflection);
    const PictureRays rays(slab.camera, slab.width, slab.height);
    for (const double x : {0, slab.width})
        for (const double y : {0, slab.height}) {
            const double angle = angle_of(rays.through(x, y).direction);
            expect_within(seen, {angle, angle}, 0, "of a corner");
        }
    EXPECT_LT(seen.max - seen.min, 60);
    for (const Side side : both_sides) {
        seen = seen_scattering_angles(small_planet(30, 1, 0.5), side);
        EXPECT_NEAR(seen.min, 150, 1e-9);
        EXPECT_NEAR(seen.max, 150, 1e-9);
    }
}

}  // namespace
}  // namespace stratus
