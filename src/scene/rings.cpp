#include <stratus/runtime/constants.h>

#include "ring_footprint.h"
#include "subjects.h"

#include <algorithm>
#include <array>
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
    return {distance, std::sqrt(point.x * point.x + point.y * point.y)};
}

bool meets_rings(const Rings& rings, const RingFootprint& footprint) noexcept {
    return footprint.end() >= rings.profile.inner() && footprint.begin() <= rings.profile.outer();
}

/// Of the view's cell: `radius_along(ray)` of its middle and its sides.
template <class RadiusAlong>
RingFootprint footprint_of(const View& view, const RadiusAlong& radius_along) noexcept {
    const double radius = radius_along(view.ray);
    if (!view.cell || std::isinf(radius)) return RingFootprint(radius);
    std::array<double, 4> radii;
    std::ranges::transform(view.cell->sides(), radii.begin(), radius_along);
    return {radius, radii};
}

/// Share of the sunlight that the rings let pass to where the view's ray meets the planet.
double ring_shadow(const Rings& rings, const View& view) noexcept {
    const RingFootprint footprint = footprint_of(view, [&](const Ray& ray) {
        const double distance = distance_to_globe(ray, rings.flattening);
        return distance > 0 ? ring_crossing({ray.at(distance), view.to_sun}).radius : infinity;
    });
    if (!meets_rings(rings, footprint)) return 1;
    const double mu = std::max(std::abs(view.to_sun.z), 1e-6);
    double share = 0;
    footprint.visit(
        rings.profile, view.scene.layer.albedo, seen_depth(view.scene, 1) / mu,
        [&](const Matter& matter, double part) { share += part * view.light.beam(matter, mu); });
    return share;
}

/// Lambert's law for the sunlight that the rings transmit directly; what they scatter onto the
/// planet is neglected.
Rgb3 planet_light(const Rings& rings, const View& view, double distance) noexcept {
    const Vector3 point = view.ray.at(distance);
    const Vector3 normal = globe_normal(point, rings.flattening);
    double mu_in = dot(normal, view.to_sun);
    if (mu_in <= 0) return {};
    if (view.scene.effects.shadows) mu_in *= ring_shadow(rings, view);
    const Rgb albedo = rings.surface.at(sphere_point(normal));
    return {mu_in * double{albedo.r}, mu_in * double{albedo.g}, mu_in * double{albedo.b}};
}

/// Light of the rings' matter where they are not in the planet's shadow.
Rgb3 ring_light(const Matter& matter, const View& view, const Geometry& geometry) noexcept {
    const bool lit = (view.to_sun.z > 0) == (view.ray.direction.z < 0);
    return geometry.mu_in * (lit ? view.light.reflection(matter, geometry)
                                 : view.light.transmission(matter, geometry));
}

Rgb3 grey(double light) noexcept { return {light, light, light}; }

}  // namespace

Matter RingProfile::at(double at_radius, const std::array<double, 3>& tint) const noexcept {
    if (!(at_radius >= inner() && at_radius <= outer())) return {};
    const auto above = std::lower_bound(radius.begin() + 1, radius.end() - 1, at_radius);
    return after(static_cast<std::size_t>(above - radius.begin()) - 1, at_radius, tint);
}

Matter RingProfile::after(std::size_t row, double at_radius,
                          const std::array<double, 3>& tint) const noexcept {
    const double share = (at_radius - radius[row]) / (radius[row + 1] - radius[row]);
    auto linear = [&](const std::vector<double>& rows) {
        return rows[row] + share * (rows[row + 1] - rows[row]);
    };
    const double first = linear(w1), both = first + linear(w2);
    return {linear(optical_depth),
            {both * tint[0], both * tint[1], both * tint[2]},
            both > 0 ? first / both : 1};
}

Rgb3 radiance_of(const Rings& rings, const View& view) noexcept {
    const double to_planet = distance_to_globe(view.ray, rings.flattening);
    const Crossing crossing = ring_crossing(view.ray);
    auto behind = [&] {
        return to_planet > 0 ? planet_light(rings, view, to_planet)
                             : background_along(view.scene, view.ray.direction);
    };
    if (std::isinf(crossing.distance) || (to_planet > 0 && to_planet < crossing.distance))
        return behind();
    const RingFootprint footprint =
        footprint_of(view, [](const Ray& ray) { return ring_crossing(ray).radius; });
    if (!meets_rings(rings, footprint)) return behind();
    const bool dark =
        view.scene.effects.shadows &&
        distance_to_globe({view.ray.at(crossing.distance), view.to_sun}, rings.flattening) > 0;
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction);
    const double mu = geometry.mu_out;
    Rgb3 light{}, share{};  // what the rings send, and let pass of what is behind
    footprint.visit(rings.profile, view.scene.layer.albedo,
                    seen_depth(view.scene, 1) * (1 / mu + 1 / geometry.mu_in),
                    [&](const Matter& matter, double part) {
                        if (!dark) light = light + part * ring_light(matter, view, geometry);
                        if (!view.scene.effects.background) return;
                        share = share + part * (to_planet > 0 ? grey(view.light.beam(matter, mu))
                                                              : view.light.background(matter, mu));
                    });
    return view.scene.effects.background ? light + share * behind() : light;
}

}  // namespace stratus
