#include <stratus/base/constants.h>

#include "ring_light.h"
#include "subjects.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stratus {
namespace {

/// Beyond it, an integer no longer counts the cells of patterns: the horizon.
constexpr double max_distance = 1e13;

bool is_on(const Slab& slab, const Vector3& point) noexcept {
    return std::abs(point.x) <= slab.half_size && std::abs(point.y) <= slab.half_size;
}

/// Empty beyond the slab's edges.
Matter matter_at(const Slab& slab, const SceneLayer& layer, const Vector3& point) noexcept {
    if (!is_on(slab, point)) return {0, layer.albedo, 1};
    return {layer.optical_depth.at(plane_point(point.x, point.y, slab.image_size)), layer.albedo,
            1};
}

/// The layer through which the sun lights a point of the ground.
Matter lit_through(const Slab& slab, const View& view, const Vector3& point) noexcept {
    return matter_at(slab, view.scene.layer, point + (slab.height / view.to_sun.z) * view.to_sun);
}

/// Radiance of the ground at one of its points, by Lambert's law.
Rgb3 ground_light(const Slab& slab, const View& view, const Vector3& point) noexcept {
    const double mu_in = view.to_sun.z;
    if (!slab.surface || mu_in <= least_cosine) return {};
    const Matter lit = lit_through(slab, view, point);
    const Rgb albedo = slab.surface->at(plane_point(point.x, point.y, slab.image_size));
    return irradiance(view, mu_in) * view.light.ground(lit, mu_in, albedo);
}

/// The sun that an ocean mirrors at one of its points.
Rgb3 sun_in_water(const Slab& slab, const View& view, const Vector3& point,
                  const Matter& seen) noexcept {
    if (!slab.surface || !slab.surface->mirror || view.to_sun.z <= least_cosine) return {};
    return mirrored_sun(view, *slab.surface, lit_through(slab, view, point), seen,
                        scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction));
}

/// The ray crosses the layer and goes on to the background. Over ground it comes from below, and the
/// layer reflects down what the ground sends up: A t(mu_in) / (1 - A s) times the plane albedo, the
/// sum over all orders of light between the two. Of ground and layers that vary, the ground straight
/// below stands for all.
Rgb3 sky_light(const Slab& slab, const View& view, const Vector3& crossing) noexcept {
    const Vector3& direction = view.ray.direction;
    const Matter matter = matter_at(slab, view.scene.layer, crossing);
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -direction);
    Rgb3 light{};
    if (!slab.surface || view.to_sun.z > 0)
        light = layer_light(
            view, matter, geometry,
            (view.to_sun.z > 0) == (direction.z < 0) ? Side::reflection : Side::transmission);
    if (!view.scene.effects.background) return light;
    if (slab.surface && matter.optical_depth > 0)
        light = light + view.light.plane_albedo(matter, geometry.mu_out) *
                            ground_light(slab, view, crossing - Vector3{0, 0, slab.height});
    if (!view.scene.background.is_black())
        light = light + view.light.background(matter, geometry.mu_out) *
                            background_along(view.scene, direction);
    if (is_sun_along(view.scene, direction))
        light = light + view.light.beam(matter, geometry.mu_out) * sun_along(view.scene, direction);
    return light;
}

/// The ray crosses the layer from above and ends on the ground.
Rgb3 light_over_ground(const Slab& slab, const View& view, const Vector3& crossing) noexcept {
    const Vector3& direction = view.ray.direction;
    if (view.to_sun.z <= 0) return {};
    const Matter matter = matter_at(slab, view.scene.layer, crossing);
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -direction);
    const Vector3 point = crossing + (slab.height / geometry.mu_out) * direction;
    return layer_light(view, matter, geometry, Side::reflection) +
           view.light.total_transmittance(matter, geometry.mu_out) *
               ground_light(slab, view, point) +
           sun_in_water(slab, view, point, matter);
}

/// Distance along a ray to a level plane; infinity beyond the horizon.
double distance_to_plane(const Ray& ray, double z) noexcept {
    const double distance = (z - ray.origin.z) / ray.direction.z;
    return distance > 0 && distance <= max_distance ? distance : infinity;
}

}  // namespace

double waves_within(const Slab& slab, const SceneLayer& layer, const Cell& cell) noexcept {
    double waves = layer.optical_depth.waves(slab.image_size);
    if (slab.surface) waves = std::max(waves, slab.surface->waves(slab.image_size));
    if (waves == 0) return 0;
    const std::array<Ray, 4> sides = cell.sides();
    const auto distance = [&](const Ray& ray) {
        const double to_layer = distance_to_plane(ray, 0);
        return std::isinf(to_layer) && slab.surface ? distance_to_plane(ray, -slab.height)
                                                    : to_layer;
    };
    const auto apart = [&](const Ray& one, const Ray& other) {
        const double a = distance(one), b = distance(other);
        if (std::isinf(a) && std::isinf(b)) return 0.0;
        return std::isinf(a) || std::isinf(b) ? infinity : length(one.at(a) - other.at(b));
    };
    return waves * std::max(apart(sides[0], sides[1]), apart(sides[2], sides[3]));
}

Rgb3 ray_radiance(const Slab& slab, const View& view) noexcept {
    const double to_layer = distance_to_plane(view.ray, 0),
                 to_ground = distance_to_plane(view.ray, -slab.height);
    if (!std::isinf(to_layer)) {
        const Vector3 crossing = view.ray.at(to_layer);
        if (slab.surface && view.ray.direction.z < 0)
            return light_over_ground(slab, view, crossing);
        if (slab.surface || is_on(slab, crossing)) return sky_light(slab, view, crossing);
    } else if (slab.surface && !std::isinf(to_ground)) {
        const Vector3 point = view.ray.at(to_ground);
        return ground_light(slab, view, point) + sun_in_water(slab, view, point, {});
    }
    return background_along(view.scene, view.ray.direction) +
           sun_along(view.scene, view.ray.direction);
}

}  // namespace stratus
