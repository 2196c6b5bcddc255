#include <stratus/runtime/constants.h>

#include "planet_shine.h"
#include "subjects.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

/// Where a ray meets the plane of the rings; infinity: nowhere.
struct Crossing {
    double distance = infinity, radius = infinity;
};

Crossing ring_crossing(const Ray& ray) noexcept {
    const double distance = -ray.origin.z / ray.direction.z;
    if (!(distance > 0) || std::isinf(distance)) return {};
    const Vector3 point = ray.at(distance);
    return {distance, std::hypot(point.x, point.y)};
}

bool is_ring(const Rings& rings, double radius) noexcept {
    return radius >= rings.profile.inner() && radius <= rings.profile.outer();
}

Rgb3 ring_light(const Rings& rings, const Matter& matter, const View& view,
                double distance) noexcept {
    const Vector3 point = view.ray.at(distance);
    const PlanetShine* const shine = view.light.planetshine();
    const Rgb3 from_planet = shine ? shine->light(rings, view, point, matter) : Rgb3{};
    if (view.scene.effects.shadows && distance_to_globe({point, view.to_sun}, rings.flattening) > 0)
        return from_planet;
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction);
    const bool lit = (view.to_sun.z > 0) == (view.ray.direction.z < 0);
    return from_planet +
           irradiance(view, geometry.mu_in) * (lit ? view.light.reflection(matter, geometry)
                                                   : view.light.transmission(matter, geometry));
}

}  // namespace

Matter RingProfile::at(double at_radius, const std::array<double, 3>& tint) const noexcept {
    if (!(at_radius >= inner() && at_radius <= outer())) return {};
    const auto above = std::lower_bound(radius.begin() + 1, radius.end() - 1, at_radius);
    const auto k = static_cast<std::size_t>(above - radius.begin());
    const double share = (at_radius - radius[k - 1]) / (radius[k] - radius[k - 1]);
    auto linear = [&](const std::vector<double>& rows) {
        return rows[k - 1] + share * (rows[k] - rows[k - 1]);
    };
    const double first = linear(w1), both = first + linear(w2);
    return {linear(optical_depth),
            {both * tint[0], both * tint[1], both * tint[2]},
            both > 0 ? first / both : 1};
}

Rgb3 globe_light(const Rings& rings, const View& view, const Vector3& point) noexcept {
    const Vector3 normal = globe_normal(point, rings.flattening);
    const double mu_in = dot(normal, view.to_sun);
    Rgb3 share = view.light.ringshine(point);
    if (mu_in > 0) {
        Rgb3 direct{mu_in, mu_in, mu_in};
        const Crossing crossing = ring_crossing({point, view.to_sun});
        if (view.scene.effects.shadows && is_ring(rings, crossing.radius))
            direct =
                mu_in * view.light.beam(rings.profile.at(crossing.radius, view.scene.layer.albedo),
                                        std::max(std::abs(view.to_sun.z), 1e-6));
        share = share + direct;
    }
    const Rgb albedo = rings.surface.at(sphere_point(normal));
    return irradiance(view, 1) * share * Rgb3{double{albedo.r}, double{albedo.g}, double{albedo.b}};
}

Rgb3 radiance_of(const Rings& rings, const View& view) noexcept {
    const double to_planet = distance_to_globe(view.ray, rings.flattening);
    const Crossing crossing = ring_crossing(view.ray);
    const bool before_planet = to_planet > 0 && to_planet < crossing.distance;
    auto planet = [&] { return globe_light(rings, view, view.ray.at(to_planet)); };
    auto background = [&] { return background_along(view.scene, view.ray.direction); };
    auto sun = [&] { return sun_along(view.scene, view.ray.direction); };
    if (!is_ring(rings, crossing.radius) || before_planet)
        return to_planet > 0 ? planet() : background() + sun();
    const Matter matter = rings.profile.at(crossing.radius, view.scene.layer.albedo);
    const Rgb3 light = ring_light(rings, matter, view, crossing.distance);
    if (!view.scene.effects.background) return light;
    const double mu = std::max(std::abs(view.ray.direction.z), 1e-6);
    const Rgb3 beam = view.light.beam(matter, mu);
    return to_planet > 0 ? light + beam * planet()
                         : light + view.light.background(matter, mu) * background() + beam * sun();
}

}  // namespace stratus
