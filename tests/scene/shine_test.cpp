// Light between a planet and its rings, against sums over many rays, and by energy.
#include <stratus/scene/render.h>

#include <stratus/runtime/constants.h>

#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

/// Rings of several depths, a gap among them, around a flattened planet under a sun at 25 degrees.
Scene shining(bool once_only = true) {
    Scene scene = small_rings(1);
    scene.effects.multiple = !once_only;
    scene.effects.ringshine = scene.effects.planetshine = true;
    scene.to_sun = direction_at(radians(25), radians(40));
    scene.sun_colour = {1, 0.5, 0.25};
    Rings& rings = std::get<Rings>(scene.subject);
    rings.profile = {{1.25, 1.5, 1.52, 1.9, 1.95, 2.0, 2.05, 2.3},
                     {0.1, 0.2, 1.5, 2.0, 0.0, 0.0, 0.5, 0.6},
                     {0.2, 0.2, 0.5, 0.5, 0.5, 0.5, 0.4, 0.4},
                     {0.1, 0.1, 0.1, 0.2, 0.1, 0.1, 0.1, 0.1}};
    rings.flattening = 0.1;
    return scene;
}

Scene without_shine(Scene scene) {
    scene.effects.ringshine = scene.effects.planetshine = false;
    return scene;
}

/// Mean of of(direction) over directions distributed as the cosine about `normal`.
template <class Function>
Rgb3 cosine_mean(const Vector3& normal, int count, const Function& of) {
    const Vector3 across = normalised(cross(normal, {0.3, 0.5, 0.8})), along = cross(normal, across);
    Rgb3 sum{};
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < count; ++k) {
            const double squared = (i + 0.5) / count, angle = 2 * pi * (k + 0.5) / count;
            const double sine = std::sqrt(squared);
            sum = sum + of(std::sqrt(1 - squared) * normal + sine * std::cos(angle) * across +
                           sine * std::sin(angle) * along);
        }
    return 1.0 / (count * count) * sum;
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

TEST(Ringshine, IsTheMeanOfRaysToTheRings) {
    const Scene scene = shining(), dark = without_shine(scene);
    const LayerLight shine(scene, nullptr), light(dark, nullptr);
    double largest = 0, worst = 0;
    for (const double latitude : {-55.0, -30.0, -12.0, -4.0, 4.0, 12.0, 30.0, 55.0})
        for (const double longitude : {40.0, 85.0, 137.0, 195.0, 220.0, 300.0}) {
            const Vector3 point = on_globe(latitude, longitude, 0.1), normal = normal_of(point, 0.1);
            const Rgb3 expected = cosine_mean(normal, 1500, [&](const Vector3& direction) {
                return radiance_along(dark, light, {point + 1e-9 * normal, direction}, dark.to_sun);
            });
            const Rgb3 got = shine.ringshine(point);
            largest = std::max(largest, got[0]);
            worst = std::max(worst, std::abs(got[0] - expected[0]) / expected[0]);
            printf("%g %g  %.5f %.5f  %.2e\n", latitude, longitude, got[0], expected[0], got[0]/expected[0]-1);
        }
    EXPECT_LT(worst, 5e-3);
    EXPECT_GT(largest, 0.02);
}

TEST(Planetshine, IsTheMeanOfRaysToThePlanet) {
    Scene scene = shining();
    const Scene dark = without_shine(scene);
    scene.effects.ringshine = false;
    const LayerLight shine(scene, nullptr), light(dark, nullptr);
    const Rings& rings = std::get<Rings>(scene.subject);
    for (const double elevation : {40.0, -15.0})
      for (const bool grid : {true, false})
      for (const double radius : {1.3, 1.6, 2.2})
        for (const double longitude : {40.0, 95.0, 160.0, 222.0, 311.0}) {
            Scene seen=scene; seen.camera.position = 10.0 * direction_at(radians(elevation), 0);
            const LayerLight seen_light(seen, nullptr);
            const Vector3 point = radius * direction_at(0, radians(longitude));
            const Vector3 to_eye = grid ? -seen.camera.forward() : normalised(seen.camera.position-point);
            const Matter matter = rings.profile.at(radius, {1, 1, 1});
            Rgb3 expected{};
            for (const double side : {1.0, -1.0})
                expected = expected + cosine_mean({0, 0, side}, 400, [&](const Vector3& direction) -> Rgb3 {
                    const Rgb3 globe = radiance_along(dark, light, {point, direction}, dark.to_sun);
                    if (globe == Rgb3{}) return {};
                    const Geometry geometry = scattering_geometry({0, 0, 1}, direction, to_eye);
                    return globe * ((side > 0) == (to_eye.z > 0)
                                        ? light.reflection(matter, geometry)
                                        : light.transmission(matter, geometry));
                });
            const Ray ray{point + 3.0 * to_eye, -to_eye};
            const double direct = radiance_along(dark, light, ray, dark.to_sun)[0];
            const double got = radiance_along(seen, seen_light, ray, dark.to_sun)[0]-direct;
            printf("%g %g %g %d  %.6f %.6f %.2e; of direct %.4f\n", elevation, radius, longitude, grid,
                   got, expected[0], got / expected[0] - 1, direct);
        }
}

}  // namespace
}  // namespace stratus
