#include "ring_footprint.h"
#include "subjects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

/// Distance at which a ray enters the unit sphere; negative: nowhere.
double distance_to_sphere(const Ray& ray) noexcept {
    const double along = dot(ray.origin, ray.direction);
    // By the ray's nearest point, as below.
    const Vector3 nearest = ray.origin - along * ray.direction;
    const double under = 1 - dot(nearest, nearest);
    return under > 0 ? -along - std::sqrt(under) : -1;
}

}  // namespace

double distance_to_globe(const Ray& ray, double flattening) noexcept {
    const double stretch = 1 / (1 - flattening);
    const Vector3 o{ray.origin.x, ray.origin.y, ray.origin.z * stretch};
    const Vector3 d{ray.direction.x, ray.direction.y, ray.direction.z * stretch};
    const double a = dot(d, d), b = dot(o, d);
    // By the ray's nearest point: b^2 - a c would cancel far from the globe.
    const double inverse = 1 / a, along = b * inverse;
    const Vector3 nearest = o - along * d;
    const double under = (1 - dot(nearest, nearest)) * inverse;
    return under > 0 ? -along - std::sqrt(under) : -1;
}

Vector3 globe_normal(const Vector3& point, double flattening) noexcept {
    const double stretch = 1 / (1 - flattening);
    return normalised({point.x, point.y, point.z * stretch * stretch});
}

double waves_within(const Planet& planet, const SceneLayer& layer, const Cell& cell) noexcept {
    const double waves =
        std::max(layer.optical_depth.waves(sphere_extent), planet.surface.waves(sphere_extent));
    if (waves == 0) return 0;
    // Rays beside the planet count at the point of its limb that they pass.
    std::array<Vector3, 4> points{};
    const std::array<Ray, 4> sides = cell.sides();
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Ray& ray = sides[k];
        const double distance = distance_to_sphere(ray);
        points[k] = normalised(ray.at(distance < 0 ? -dot(ray.origin, ray.direction) : distance));
    }
    return waves * std::max(length(points[1] - points[0]), length(points[3] - points[2]));
}

PlanetPlace planet_place(const Planet& planet, const SceneLayer& layer,
                         const Vector3& normal) noexcept {
    const bool placed = layer.optical_depth.uses_image_place() || planet.surface.uses_image_place();
    const SurfacePoint point = placed ? sphere_point(normal) : SurfacePoint{normal, 0, 0};
    return {point, {layer.optical_depth.at(point), layer.albedo, 1}};
}

Rgb3 planet_light(const Planet& planet, const View& view, const Vector3& normal) noexcept {
    const Geometry geometry = scattering_geometry(normal, view.to_sun, -view.ray.direction);
    const auto [point, matter] = planet_place(planet, view.scene.layer, normal);
    const Rgb3 light = layer_light(view, matter, geometry, Side::reflection);
    if (planet.surface.is_black()) return light;
    return light + mirrored_sun(view, planet.surface, matter, matter, geometry) +
           irradiance(view, geometry.mu_in) *
               (view.light.total_transmittance(matter, geometry.mu_out) *
                view.light.ground(matter, geometry.mu_in, planet.surface.at(point)));
}

Rgb3 ray_radiance(const Planet& planet, const View& view) noexcept {
    if (seen_shell(view.scene) > 0) return shell_radiance(planet, view);
    const double distance = distance_to_sphere(view.ray);
    if (distance < 0)
        return background_along(view.scene, view.ray.direction) +
               sun_along(view.scene, view.ray.direction);
    const Vector3 normal = normalised(view.ray.at(distance));
    return dot(normal, view.to_sun) > 0 ? planet_light(planet, view, normal) : Rgb3{};
}

}  // namespace stratus
