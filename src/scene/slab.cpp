#include "subjects.h"

#include <algorithm>
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

/// Radiance of the ground, which is lit and seen through the layer; the ray comes from above.
Rgb3 ground_light(const Slab& slab, const View& view, const Matter& seen,
                  const Vector3& crossing) noexcept {
    const double mu_in = view.to_sun.z, mu_out = -view.ray.direction.z;
    const Vector3 point = crossing + (slab.height / mu_out) * view.ray.direction;
    const Matter lit =
        matter_at(slab, view.scene.layer, point + (slab.height / mu_in) * view.to_sun);
    const Rgb albedo = slab.surface->at(plane_point(point.x, point.y, slab.image_size));
    return mu_in * view.light.ground(lit, mu_in, seen, mu_out, albedo);
}

}  // namespace

Rgb3 radiance_of(const Slab& slab, const View& view) noexcept {
    const double distance = -view.ray.origin.z / view.ray.direction.z;
    auto background = [&] { return background_along(view.scene, view.ray.direction); };
    if (!(distance > 0) || distance > max_distance) return background();
    const Vector3 crossing = view.ray.at(distance);
    const bool from_above = view.ray.direction.z < 0;
    if (!slab.surface && !is_on(slab, crossing)) return background();
    const Matter matter = matter_at(slab, view.scene.layer, crossing);
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction);
    Rgb3 light{};
    if (!slab.surface || view.to_sun.z > 0) {
        const bool lit = (view.to_sun.z > 0) == from_above;
        light = geometry.mu_in * (lit ? view.light.reflection(matter, geometry)
                                      : view.light.transmission(matter, geometry));
    }
    if (!slab.surface)
        return view.scene.effects.background
                   ? light + view.light.background(matter, geometry.mu_out) * background()
                   : light;
    return view.to_sun.z > 1e-6 ? light + ground_light(slab, view, matter, crossing) : light;
}

}  // namespace stratus
