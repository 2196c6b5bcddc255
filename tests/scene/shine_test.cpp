// Light between a planet and its rings, against sums over many rays, and by energy.
#include <stratus/scene/render.h>

#include <stratus/base/constants.h>

#include "all_near.h"
#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace stratus {
namespace {

/// Rings of several depths, a gap among them, around a flattened planet under a sun at 25 degrees.
/// One mixture of the components, so that tables are small.
Scene shining() {
    Scene scene = small_rings(1);
    shine_on_one_another(scene, true);
    scene.to_sun = direction_at(radians(25), radians(40));
    scene.sun_colour = {1, 0.5, 0.25};
    scene.layer.albedo = {1, 0.8, 0.6};
    scene.tolerance = 5e-3;
    Rings& rings = the_rings(scene);
    rings.profile = {{1.25, 1.5, 1.52, 1.9, 1.95, 2.0, 2.05, 2.3},
                     {0.1, 0.2, 1.5, 2.0, 0.0, 0.0, 0.5, 0.6},
                     {0.2, 0.2, 0.6, 0.6, 0.6, 0.6, 0.4, 0.4},
                     {0.1, 0.1, 0.3, 0.3, 0.3, 0.3, 0.2, 0.2}};
    rings.flattening = 0.1;
    return scene;
}

Scene without_shine(Scene scene) {
    shine_on_one_another(scene, false);
    return scene;
}

/// Mean of of(direction) over count^2 directions on a spiral, distributed as the cosine about
/// `normal`.
template <class Function>
Rgb3 cosine_mean(const Vector3& normal, int count, const Function& of) {
    const Vector3 across = normalised(cross(normal, {0.3, 0.5, 0.8})),
                  along = cross(normal, across);
    const int directions = count * count;
    Rgb3 sum{};
    for (int n = 0; n < directions; ++n) {
        const double squared = (n + 0.5) / directions,
                     angle = 2 * pi * std::fmod(n * std::numbers::phi, 1.0);
        const double sine = std::sqrt(squared);
        sum = sum + of(std::sqrt(1 - squared) * normal + sine * std::cos(angle) * across +
                       sine * std::sin(angle) * along);
    }
    return 1.0 / directions * sum;
}

Vector3 on_globe(double latitude_deg, double longitude_deg, double flattening) {
    Vector3 point = direction_at(radians(latitude_deg), radians(longitude_deg));
    point.z *= 1 - flattening;
    return point;
}

Vector3 normal_of(const Vector3& point, double flattening) {
    const double pole = 1 - flattening;
    return normalised({point.x, point.y, point.z / (pole * pole)});
}

/// Radiance below which errors need not be a share of it: 1 % of bright rings.
constexpr double faint = 5e-3;

void expect_ringshine(const Scene& scene) {
    const Scene dark = without_shine(scene);
    const LayerLight shine(scene, nullptr), light(dark, nullptr);
    for (const double latitude : {-55.0, -30.0, -12.0, -4.0, 4.0, 12.0, 30.0, 55.0})
        for (const double longitude : {40.0, 137.0, 195.0, 220.0}) {
            const Vector3 point = on_globe(latitude, longitude, 0.1),
                          normal = normal_of(point, 0.1);
            const int rays = std::abs(latitude) < 10 ? 1200 : 600;  // the rings are seen edge on
            const Rgb3 expected = cosine_mean(normal, rays, [&](const Vector3& direction) {
                return radiance_along(dark, light, {point + 1e-9 * normal, direction}, dark.to_sun);
            });
            const Rgb3 got = shine.ringshine(point);
            constexpr double accuracy = 5e-3;
            for (const auto c : three_channels)
                EXPECT_NEAR(scene.sun_colour[c] * got[c], expected[c],
                            accuracy * std::max(expected[c], 1e-3))
                    << latitude << ' ' << longitude << ' ' << c;
        }
}

TEST(Ringshine, IsTheMeanOfRaysToTheRings) { expect_ringshine(once(shining())); }

TEST(Ringshine, OfNarrowlyForwardScatteringRingsIsTheMeanOfRaysToThem) {
    Scene scene = once(shining());
    scene.layer.components[1] = PhaseFunction::henyey_greenstein(0.9);
    expect_ringshine(scene);
}

/// Rings of one depth from `inner` to `outer` in a profile whose other rows hold `beside`.
Scene ring_within(double inner, double outer, double beside, double first, double last) {
    Scene scene = once(shining());
    scene.effects.planetshine = false;
    constexpr double edge = 1e-7;
    the_rings(scene).profile = {{first, inner - edge, inner, outer, outer + edge, last},
                                {beside, beside, 2, 2, beside, beside},
                                {0.6, 0.6, 0.6, 0.6, 0.6, 0.6},
                                {0.3, 0.3, 0.3, 0.3, 0.3, 0.3}};
    return scene;
}

TEST(Ringshine, DoesNotDependOnEmptyRowsBesideRings) {
    const auto expect_alike = [](double inner, double outer, double beside, double last) {
        Scene alone = once(shining());
        alone.effects.planetshine = false;
        the_rings(alone).profile = {{inner, outer}, {2, 2}, {0.6, 0.6}, {0.3, 0.3}};
        const Scene within = ring_within(inner, outer, beside, 1.01, last);
        const LayerLight expected_light(alone, nullptr), light(within, nullptr);
        for (const double latitude : {-20.0, -8.0, 4.0, 12.0, 22.0, 40.0})
            for (const double longitude : {40.0, 137.0, 195.0, 220.0}) {
                const Vector3 point = on_globe(latitude, longitude, 0.1);
                const double expected = expected_light.ringshine(point)[0];
                EXPECT_NEAR(light.ringshine(point)[0], expected, 5e-3 * std::max(expected, 1e-3))
                    << inner << ' ' << beside << ' ' << latitude << ' ' << longitude;
            }
    };
    expect_alike(1.1, 1.11, 0, 8);
    expect_alike(1.1, 1.11, 1e-9, 8);  // which return next to nothing
    expect_alike(1.3, 2.3, 0, 200);
}

TEST(Ringshine, LightsTheNightSide) {
    Scene scene = once(shining());
    scene.sun_colour = {1, 0.5, 0.25};
    const Vector3 point = on_globe(20, 160, 0), eye = 3.0 * point;
    the_rings(scene).flattening = 0;
    ASSERT_LT(dot(point, scene.to_sun), -0.1);
    const LayerLight light(scene, nullptr);
    const Rgb3 seen = radiance_along(scene, light, {eye, -point}, scene.to_sun);
    const double albedo[] = {0.5, 0.25, 0.75};
    for (const auto c : three_channels) {
        EXPECT_GT(seen[c], 1e-4);
        EXPECT_NEAR(seen[c], albedo[c] * scene.sun_colour[c] * light.ringshine(point)[c], 1e-9);
    }
    scene.effects.ringshine = false;
    const LayerLight without(scene, nullptr);
    EXPECT_EQ(radiance_along(scene, without, {eye, -point}, scene.to_sun)[0], 0);
}

TEST(Ringshine, IsNeverNegative) {
    const Scene scene = once(shining());
    const LayerLight light(scene, nullptr);
    for (int latitude = -80; latitude <= 80; latitude += 2)
        for (int longitude = 0; longitude < 360; longitude += 3)
            for (const double channel : light.ringshine(on_globe(latitude, longitude, 0.1)))
                EXPECT_GE(channel, 0) << latitude << ' ' << longitude;
}

/// What planetshine adds to a point of the rings, by a sum over rays to the globe.
Rgb3 expected_planetshine(const Scene& dark, const LayerLight& light, const Vector3& point,
                          const Vector3& to_eye) {
    const Matter matter = the_rings(dark).profile.at(length(point), dark.layer.albedo);
    Rgb3 sum{};
    for (const double side : {1.0, -1.0})
        sum = sum + cosine_mean({0, 0, side}, 300, [&](const Vector3& direction) -> Rgb3 {
                  const Rgb3 globe = radiance_along(dark, light, {point, direction}, dark.to_sun);
                  if (globe == Rgb3{}) return {};
                  const Geometry geometry = scattering_geometry({0, 0, 1}, direction, to_eye);
                  return globe * ((side > 0) == (to_eye.z > 0)
                                      ? light.reflection(matter, geometry)
                                      : light.transmission(matter, geometry));
              });
    return sum;
}

/// `all_tables`: of its layer along all directions, if it needs any.
void expect_planetshine(Scene scene, const LayerTables* all_tables) {
    scene.effects.ringshine = false;
    for (const double elevation : {40.0, -15.0})
        for (const bool to_camera : {true, false}) {
            scene.camera.position = 10.0 * direction_at(radians(elevation), 0);
            const Scene dark = without_shine(scene);
            // Planetshine towards the camera by its own table, in place of the exact one.
            LayerTables tables = all_tables ? *all_tables : LayerTables();
            if (all_tables && to_camera) tables.paths.back() = bake_for({scene})[0]->paths.back();
            const LayerLight shine(scene, all_tables ? &tables : nullptr), light(dark, all_tables);
            for (const double radius : {1.3, 1.6, 2.2})
                for (const double longitude : {40.0, 95.0, 311.0}) {
                    const Vector3 point = radius * direction_at(0, radians(longitude));
                    const Vector3 to_eye = to_camera ? -scene.camera.forward()
                                                     : normalised(scene.camera.position - point);
                    const Ray ray{point + 0.1 * to_eye, -to_eye};
                    const Rgb3 expected = expected_planetshine(dark, light, point, to_eye),
                               direct = radiance_along(dark, light, ray, scene.to_sun),
                               all = radiance_along(scene, shine, ray, scene.to_sun);
                    for (const auto c : three_channels)
                        EXPECT_NEAR(all[c], direct[c] + expected[c],
                                    scene.tolerance * std::max(all[c], faint))
                            << elevation << ' ' << radius << ' ' << longitude << ' ' << to_camera;
                }
        }
}

TEST(Planetshine, IsTheMeanOfRaysToThePlanet) {
    Scene scene = once(shining());
    scene.tolerance = 2e-3;
    expect_planetshine(scene, nullptr);
}

TEST(Planetshine, OfAllOrdersIsTheMeanOfRaysToThePlanet) {
    const Scene scene = shining();
    const auto all = bake_layer_tables(of_all_directions(*needed_recipe(scene)));
    expect_planetshine(scene, all.get());
}

/// Compares planetshine below a close camera with that along the same rays, but of another camera, for
/// which it is not tabulated.
void expect_planetshine_below(Scene scene, double height, double turn_deg) {
    scene.camera.orthographic = false;
    scene.to_sun = direction_at(radians(25), radians(40 + turn_deg));
    const Vector3 below = 1.8 * direction_at(0, radians(turn_deg));
    Scene other = scene;
    scene.camera.position = below + Vector3{0, 0, height};
    const LayerLight tabulated(scene, nullptr), integrated(other, nullptr);
    for (int k = 0; k < 60; ++k) {
        const Vector3 aside = direction_at(0, 2 * pi * k * std::numbers::phi),
                      point = below + height * std::sqrt(0.2 * k) * aside;
        const Ray ray{scene.camera.position, normalised(point - scene.camera.position)};
        const Rgb3 expected = radiance_along(other, integrated, ray, scene.to_sun),
                   got = radiance_along(scene, tabulated, ray, scene.to_sun);
        for (const auto c : three_channels)
            EXPECT_NEAR(got[c], expected[c], 2e-3 * std::max(expected[c], faint))
                << height << ' ' << turn_deg << ' ' << k << ' ' << c;
    }
}

TEST(Planetshine, IsNeverNegative) {
    Scene scene = once(shining());
    scene.effects.ringshine = false;
    scene.to_sun = direction_at(0, radians(40));  // no light falls on the rings but the globe's
    scene.camera.position = {0, 0, 10};
    const LayerLight light(scene, nullptr);
    for (const double radius : {1.3, 1.6, 2.2})
        for (int longitude = 0; longitude < 360; ++longitude) {
            const Vector3 point = radius * direction_at(0, radians(longitude));
            const Ray ray{point + Vector3{0, 0, 1}, {0, 0, -1}};
            for (const double channel : radiance_along(scene, light, ray, scene.to_sun))
                EXPECT_GE(channel, 0) << radius << ' ' << longitude;
        }
}

TEST(Planetshine, BelowACloseCameraIsThatOfSingleRays) {
    Scene scene = once(shining());
    scene.effects.ringshine = false;
    the_rings(scene).profile = {{1.25, 2.3}, {0.7, 0.9}, {0.6, 0.4}, {0.3, 0.5}};
    expect_planetshine_below(scene, 0.03, 172);
    expect_planetshine_below(scene, -0.1, 7);
}

TEST(Planetshine, DoesNotDependOnRowsFarBeyondRings) {
    Scene alone = once(shining());
    the_rings(alone).profile = {{1.3, 2.3}, {2, 2}, {0.6, 0.6}, {0.3, 0.3}};
    alone.effects.ringshine = false;
    const LayerLight expected_light(alone, nullptr);
    for (const auto& [beside, last] : {std::pair(0.0, 200.0), std::pair(1e-9, 20.0)}) {
        Scene within = ring_within(1.3, 2.3, beside, 1.01, last);
        within.effects.planetshine = true;
        within.effects.ringshine = false;
        const LayerLight light(within, nullptr);
        for (const double radius : {1.35, 1.7, 2.25})
            for (const double longitude : {40.0, 137.0, 220.0, 311.0}) {
                const Vector3 point = radius * direction_at(0, radians(longitude)),
                              ahead = alone.camera.forward();
                const Ray ray{point - 0.1 * ahead, ahead};
                const double expected = radiance_along(alone, expected_light, ray, alone.to_sun)[0];
                EXPECT_NEAR(radiance_along(within, light, ray, within.to_sun)[0], expected,
                            2e-3 * std::max(expected, faint))
                    << beside << ' ' << radius << ' ' << longitude;
            }
    }
}

/// The planet under clouds over its surface.
Scene cloudy(Scene scene, double optical_depth) {
    SceneLayer clouds;
    clouds.components = {PhaseFunction::henyey_greenstein(0.6)};
    clouds.albedo = {1, 0.99, 0.9};
    clouds.optical_depth.max = optical_depth;
    the_rings(scene).planet_layer = clouds;
    return scene;
}

/// Tables of the rings along all directions, and those of the planet.
LayerTables all_tables_of(const Scene& scene) {
    LayerTables tables;
    tables.paths[0] = bake_layer_table(of_all_directions(*needed_recipe(scene)));
    tables.planet = bake_for({scene})[0]->planet;
    return tables;
}

/// Light of the rings that the clouds send to the eye, by a sum over rays to the rings.
Rgb3 expected_on_clouds(const Scene& dark, const LayerLight& light, const Vector3& point,
                        const Vector3& to_eye) {
    const Rings& rings = the_rings(dark);
    const Vector3 normal = normal_of(point, rings.flattening);
    const LayerLight& clouds = *light.planet();
    const Matter matter = *uniform_matter(clouds.scene());
    return cosine_mean(normal, 150, [&](const Vector3& direction) -> Rgb3 {
        const Rgb3 sent =
            radiance_along(dark, light, {point + 1e-9 * normal, direction}, dark.to_sun);
        if (sent == Rgb3{}) return {};
        const Geometry geometry = scattering_geometry(normal, direction, to_eye);
        return sent * (clouds.reflection(matter, geometry) +
                       clouds.total_transmittance(matter, geometry.mu_out) *
                           clouds.ground(matter, geometry.mu_in, rings.surface.colour));
    });
}

// Two beams stand for the light of a wide arc, of which clouds reflect nearly as much; what they scatter
// once depends more on the angle.
TEST(Ringshine, OnCloudsIsNearlyTheMeanOfRaysToTheRings) {
    for (const bool multiple : {false, true}) {
        Scene scene = cloudy(shining(), 3);
        scene.effects.planetshine = false;
        scene.effects.multiple = multiple;
        const LayerTables tables = multiple ? all_tables_of(scene) : LayerTables();
        const Scene dark = without_shine(scene);
        const LayerLight shine(scene, &tables), light(dark, &tables);
        double sum = 0;
        int places = 0;
        for (const double latitude : {-55.0, -30.0, -12.0, 12.0, 30.0, 55.0})
            for (const double longitude : {137.0, 195.0, 220.0})
                for (const double aside : {-40.0, 0.0, 40.0}) {
                    const Vector3 point = on_globe(latitude, longitude, 0.1),
                                  normal = normal_of(point, 0.1),
                                  to_eye = direction_at(radians(20), radians(longitude + aside));
                    if (dot(to_eye, normal) < 0.1 || dot(normal, scene.to_sun) > 0) continue;
                    const Rgb3 expected = expected_on_clouds(dark, light, point, to_eye);
                    const Rgb3 got = radiance_along(scene, shine, {point + 0.02 * to_eye, -to_eye},
                                                    scene.to_sun);
                    const double error = got[1] / expected[1] - 1;
                    EXPECT_LT(std::abs(error), multiple ? 0.08 : 0.25)
                        << latitude << ' ' << longitude << ' ' << aside;
                    sum += error * error;
                    ++places;
                }
        EXPECT_GT(places, 30);
        EXPECT_LT(std::sqrt(sum / places), multiple ? 0.03 : 0.15);
    }
}

// White clouds of any depth over a white surface send back all that falls on them.
TEST(Ringshine, LeavesWhiteCloudsAsItFellOnThem) {
    Scene scene = cloudy(shining(), 3);
    Rings& rings = the_rings(scene);
    rings.surface.colour = {1, 1, 1};
    rings.planet_layer->albedo = {1, 1, 1};
    scene.effects.planetshine = false;
    const BakedLight light(scene);
    for (const double latitude : {-20.0, 35.0}) {
        const Vector3 point = on_globe(latitude, 215, 0.1), normal = normal_of(point, 0.1);
        ASSERT_LT(dot(normal, scene.to_sun), 0);
        const Rgb3 sent = cosine_mean(normal, 60, [&](const Vector3& direction) {
            return radiance_along(scene, light, {point + 0.02 * direction, -direction},
                                  scene.to_sun);
        });
        const Rgb3 fallen = light.ringshine(point);
        for (const auto c : three_channels)
            EXPECT_NEAR(sent[c] / (scene.sun_colour[c] * fallen[c]), 1, 2 * scene.tolerance);
    }
}

TEST(Planetshine, OfCloudsIsTheMeanOfRaysToThem) {
    Scene scene = cloudy(once(shining()), 3);
    scene.tolerance = 2e-3;
    expect_planetshine(scene, nullptr);
}

TEST(Planetshine, OfCloudsAndAllOrdersIsTheMeanOfRaysToThem) {
    const Scene scene = cloudy(shining(), 3);
    const LayerTables tables = all_tables_of(scene);
    expect_planetshine(scene, &tables);
}

TEST(CloudsWithinRings, AreThoseOfThePlanetAloneBesideTransparentRings) {
    Scene within = cloudy(small_rings(0), 3);
    within.camera.width = 2;
    Scene alone = within;
    alone.layer = *the_rings(within).planet_layer;
    alone.subject = Planet{the_rings(within).surface};
    const auto tables = bake_for({within, alone});
    EXPECT_EQ(tables[0]->planet->paths, tables[1]->paths);
    const Image expected = render(alone, LayerLight(alone, tables[1].get())),
                got = render(within, LayerLight(within, tables[0].get()));
    expect_all_near(got.rgb, expected.rgb, 0, 1e-6);
    EXPECT_GT(expected.rgb[3 * 136], 0.1f);
}

TEST(CloudsWithinRings, AreInTheShadowOfRings) {
    Scene scene = once(cloudy(small_rings(0.5), 3));
    const Vector3 point = on_globe(-20, 20, 0), to_eye = direction_at(radians(-30), radians(40));
    const Ray ray{point + to_eye, -to_eye};
    const Rgb3 shadowed = radiance_along(scene, LayerLight(scene, nullptr), ray, scene.to_sun);
    scene.effects.shadows = false;
    const Rgb3 lit = radiance_along(scene, LayerLight(scene, nullptr), ray, scene.to_sun);
    EXPECT_GT(lit[0], 0.01);
    EXPECT_NEAR(shadowed[0] / lit[0], std::exp(-0.5 / scene.to_sun.z), 1e-12);
}

TEST(CloudsWithinRings, WithoutDepthLeaveLambertsLaw) {
    const Scene bare = once(shining()), clear = cloudy(bare, 0);
    const Image expected = render(bare, LayerLight(bare, nullptr)),
                got = render(clear, LayerLight(clear, nullptr));
    expect_all_near(got.rgb, expected.rgb, 0, 1e-6);
}

// From afar and from close by, off the lit side and through the rings.
TEST(RingOrders, OfPicturesAreThoseOfSingleRays) {
    Scene scene = without_shine(shining());
    scene.camera.orthographic = false;
    scene.camera.width = radians(90);
    const auto tables = bake_layer_tables(of_all_directions(*needed_recipe(scene)));
    for (const double distance : {20.0, 3.5})
        for (const double elevation : {35.0, -20.0}) {
            scene.camera.position = distance * direction_at(radians(elevation), radians(10));
            Scene large = scene;
            large.width = large.height = 512;
            const LayerLight tabulated(large, tables.get()), looked_up(scene, tables.get());
            ASSERT_NE(tabulated.ring_orders(), nullptr);
            ASSERT_EQ(looked_up.ring_orders(), nullptr);
            for (int k = 0; k < 400; ++k) {
                const double radius = 1.26 + 1.03 * k / 400;
                const Vector3 point = radius * direction_at(0, k * std::numbers::phi);
                const Ray ray{scene.camera.position, normalised(point - scene.camera.position)};
                const Rgb3 expected = radiance_along(scene, looked_up, ray, scene.to_sun),
                           got = radiance_along(large, tabulated, ray, scene.to_sun);
                for (const auto c : three_channels)
                    EXPECT_NEAR(got[c], expected[c],
                                0.1 * scene.tolerance * std::max(expected[c], faint))
                        << distance << ' ' << elevation << ' ' << radius << ' ' << c;
            }
        }
}

/// Compares orders of rings below a close camera, whose directions change fast with the place.
void expect_orders_below(const LayerTables& tables, Scene scene, double height, double turn_deg) {
    scene.to_sun = direction_at(radians(30), radians(20 + turn_deg));
    const Vector3 below = 2.0 * direction_at(0, radians(turn_deg));
    scene.camera.position = below + Vector3{0, 0, height};
    Scene large = scene;
    large.width = large.height = 512;
    const LayerLight tabulated(large, &tables), looked_up(scene, &tables);
    for (int k = 0; k < 200; ++k) {
        const Vector3 aside = direction_at(0, 2 * pi * k * std::numbers::phi),
                      point = below + height * std::sqrt(0.05 * k) * aside;
        const Ray ray{scene.camera.position, normalised(point - scene.camera.position)};
        const double expected = radiance_along(scene, looked_up, ray, scene.to_sun)[0],
                     got = radiance_along(large, tabulated, ray, scene.to_sun)[0];
        EXPECT_NEAR(got, expected, 0.1 * scene.tolerance * expected)
            << height << ' ' << turn_deg << ' ' << k;
    }
}

TEST(RingOrders, BelowACloseCameraAreThoseOfSingleRays) {
    Scene scene = small_rings(1);
    scene.camera.orthographic = false;
    const RingProfile even{{1.5, 2.9}, {1, 1}, {0.3, 0.3}, {0.6, 0.6}};
    RingProfile with_empty_rows = even;
    with_empty_rows.radius.insert(with_empty_rows.radius.begin(), {1.4, 1.4999999});
    with_empty_rows.optical_depth = {0, 0, 1, 1};
    with_empty_rows.w1.resize(4, 0.3);
    with_empty_rows.w2.resize(4, 0.6);
    for (const RingProfile& profile : {even, with_empty_rows}) {
        the_rings(scene).profile = profile;
        const auto tables = bake_layer_tables(of_all_directions(*needed_recipe(scene)));
        for (const double height : {0.02, 0.05, 0.3})
            for (const double turn : {0.0, 57.3, 172.0, 285.0})
                expect_orders_below(*tables, scene, height, turn);
    }
}

}  // namespace
}  // namespace stratus
