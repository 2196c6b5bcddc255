// Planets, the shells of their layers, and slabs.
#include <stratus/base/gauss_legendre.h>

#include "ring_light.h"
#include "subjects.h"

namespace stratus {
namespace {

/// Distance at which a ray enters the unit sphere; negative: nowhere.
double distance_to_sphere(const Ray& ray) {
    const double along = dot(ray.origin, ray.direction);
    // By the ray's nearest point, as below.
    const Vector3 nearest = ray.origin - along * ray.direction;
    const double under = 1 - dot(nearest, nearest);
    return under > 0 ? -along - std::sqrt(under) : -1;
}

}  // namespace

double distance_to_globe(const Ray& ray, double flattening) {
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

Vector3 globe_normal(const Vector3& point, double flattening) {
    const double stretch = 1 / (1 - flattening);
    return normalised({point.x, point.y, point.z * stretch * stretch});
}

double waves_within(const Planet& planet, const SceneLayer& layer, const Cell& cell) {
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

PlanetPlace planet_place(const Planet& planet, const SceneLayer& layer, const Vector3& normal) {
    const bool placed = layer.optical_depth.uses_image_place() || planet.surface.uses_image_place();
    const SurfacePoint point = placed ? sphere_point(normal) : SurfacePoint{normal, 0, 0};
    return {point, {layer.optical_depth.at(point), layer.albedo, 1}};
}

Rgb3 planet_light(const Planet& planet, const View& view, const Vector3& normal) {
    const Geometry geometry = scattering_geometry(normal, view.to_sun, -view.ray.direction);
    const auto [point, matter] = planet_place(planet, view.scene.layer, normal);
    const Rgb3 light = layer_light(view, matter, geometry, Side::reflection);
    if (planet.surface.is_black()) return light;
    return light + mirrored_sun(view, planet.surface, matter, matter, geometry) +
           irradiance(view, geometry.mu_in) *
               (view.light.total_transmittance(matter, geometry.mu_out) *
                view.light.ground(matter, geometry.mu_in, planet.surface.at(point)));
}

Rgb3 ray_radiance(const Planet& planet, const View& view) {
    if (seen_shell(view.scene) > 0) return shell_radiance(planet, view);
    const double distance = distance_to_sphere(view.ray);
    if (distance < 0) return light_beyond(view.scene, view.ray.direction);
    const Vector3 normal = normalised(view.ray.at(distance));
    return dot(normal, view.to_sun) > 0 ? planet_light(planet, view, normal) : Rgb3{};
}

// A planet's layer as a homogeneous spherical shell over it.
//
// Light scattered once is exact: the integral along the ray of what reaches each point from the sun
// through the shell, by Gauss quadrature over the share of the ray's light that is scattered there.
// The orders n >= 2 are those of a plane layer under beams that take as much out of the sun's light,
// and of light towards the eye, as the shell's column does where the ray meets the planet or comes
// nearest to it, each colour's by its own depth. The depth there stands for that of the whole shell.
// Chapman's function of the shell is the slant depth of a beam over the vertical one.

namespace {

constexpr std::size_t nodes = 24;

const GaussLegendre& gauss() {
    static const GaussLegendre rule(nodes);
    return rule;
}

/// From radius r along a direction of cosine mu to the vertical, out of the sphere of radius `top`.
double path_out(double top, double r, double mu) {
    return std::sqrt(std::max(0.0, top * top - r * r * (1 - mu * mu))) - r * mu;
}

/// The cosine at which light leaves a plane layer from a mean depth, in its optical depth: x = optical_depth
/// / cosine solves 1 / x - 1 / (exp(x) - 1) = depth, by Newton's method from below; 1 at most.
double cosine_of_mean_depth(double optical_depth, double depth) {
    const auto excess = [&](double x) { return 1 / x - 1 / std::expm1(x) - depth; };
    double x = std::max(optical_depth, 6 - 12 * depth);
    if (x < 1e-3) return std::min(1.0, optical_depth / x);  // to x^2 / 60 of it
    for (int step = 0; step < 60 && excess(x) > 1e-12; ++step) {
        const double grown = std::expm1(x);
        x += excess(x) / (1 / (x * x) - (1 + 1 / grown) / grown);
    }
    return std::min(1.0, optical_depth / x);
}

}  // namespace

double shell_cosine(double optical_depth, double height, double mu) {
    constexpr double deepest = 30;  // slant depth, beyond which nothing arrives
    const double top = 1 + height, extinction = optical_depth / height, squared_sine = 1 - mu * mu;
    double low = mu < 0 ? std::max(1.0, 1 / std::sqrt(squared_sine)) : 1;
    const double longest = deepest / extinction;
    if (longest < top)
        low = std::max(low, std::sqrt(top * top - longest * longest * squared_sine) - longest * mu);
    if (!(low < top)) return 0;
    // A beam leaves in the column the integral of exp(-slant depth) over the depth. It is taken over
    // the depth's root, to which the slant depth of a level grazing beam is proportional.
    const double lit = extinction * (top - low);
    double taken = 0;
    for (std::size_t k = 0; k < nodes; ++k) {
        const double root = (1 + gauss().x[k]) / 2;
        const double r = top - lit * root * root / extinction;
        taken += gauss().weight[k] * lit * root * std::exp(-extinction * path_out(top, r, mu));
    }
    // taken = mu (1 - exp(-optical_depth / mu)): by Newton's method in x = optical_depth / mu, from below,
    // as the share (1 - exp(-x)) / x is convex.
    const double share = std::min(1.0, taken / optical_depth);
    double x = std::max(2 * (1 - share), 1e-12);
    for (int step = 0; step < 60; ++step) {
        const double f = -std::expm1(-x) / x - share,
                     slope = x < 1e-3 ? -0.5 + x / 3 - x * x / 8
                                      : (std::exp(-x) * (1 + x) - 1) / (x * x);
        const double next = x - f / slope;
        if (!(next > x * (1 + 1e-12))) break;
        x = next;
    }
    return std::min(1.0, optical_depth / x);
}

namespace {

/// A ray within a shell, from where it enters to the ground, or to where it leaves again.
struct ShellRay {
    Ray ray;
    double height;   // of the shell
    double chord;    // length
    double mu;       // cosine at the top
    Vector3 normal;  // where it meets the planet or comes nearest to it
};

/// One colour's light along it, and the beams of the plane layer that stands for the shell.
struct ShellBeams {
    double through = 1;  // share of light that passes along the ray
    double lit = 0;      // share of sunlight that reaches what is scattered there, in the mean
    double mu_in, mu_out;
    double seen = 0;  // the ray's share of the plane layer's light
};

ShellBeams shell_beams(const ShellRay& along, const Vector3& to_sun, double optical_depth) {
    const double top = 1 + along.height, extinction = optical_depth / along.height,
                 mu_sun = dot(along.normal, to_sun);
    ShellBeams beams;
    beams.mu_in = std::max(0.0, mu_sun);
    beams.mu_out = along.mu;
    if (optical_depth == 0) return beams;
    beams.through = std::exp(-extinction * along.chord);
    double scattered_at = 0;  // mean depth of what is scattered, over that of the shell
    for (std::size_t k = 0; k < nodes; ++k) {
        const double share = (1 + gauss().x[k]) / 2 * (1 - beams.through);
        const Vector3 point = along.ray.at(-std::log1p(-share) / extinction);
        const double r = length(point), mu = dot(point, to_sun) / r;
        scattered_at += gauss().weight[k] / 2 * (top - r) / along.height;
        if (mu >= 0 || r * r * (1 - mu * mu) >= 1)  // the planet does not hide the sun
            beams.lit += gauss().weight[k] / 2 * std::exp(-extinction * path_out(top, r, mu));
    }
    beams.mu_in = shell_cosine(optical_depth, along.height, mu_sun);
    // Nowhere along the ray is its cosine larger than at the top.
    beams.mu_out = std::min(along.mu, cosine_of_mean_depth(optical_depth, scattered_at));
    beams.seen = (1 - beams.through) / -std::expm1(-optical_depth / beams.mu_out);
    return beams;
}

}  // namespace

Rgb3 shell_radiance(const Planet& planet, const View& view) {
    const Scene& scene = view.scene;
    const auto& [origin, direction] = view.ray;
    const double top = 1 + planet.shell, along = -dot(origin, direction);
    const Vector3 nearest = view.ray.at(along);
    const double squared_impact = dot(nearest, nearest);
    Rgb3 light{};
    if (squared_impact >= top * top || along <= 0) return light_beyond(scene, direction);
    const bool hits = squared_impact < 1;
    const double half = std::sqrt(top * top - squared_impact),
                 chord = half + (hits ? -std::sqrt(1 - squared_impact) : half);
    const Ray inside{view.ray.at(along - half), direction};
    const Vector3 normal = normalised(hits ? inside.at(chord) : nearest);
    const ShellRay ray{inside, planet.shell, chord, half / top, normal};
    const SceneLayer& layer = scene.layer;
    const PlanetPlace place = planet_place(planet, layer, normal);
    const Matter& matter = place.matter;  // no binding: lambdas capture it
    const double depth = seen_depth(scene, matter.optical_depth);
    const Rgb3 sun = irradiance(view, 1);
    const double cosine = dot(view.to_sun, direction);  // of the scattering angle
    std::array<ShellBeams, 3> beams;
    Rgb3 through;
    const auto as_before = [&](std::size_t c) {
        return c > 0 && layer.extinction[c] == layer.extinction[c - 1];
    };
    for (std::size_t c = 0; c < 3; ++c) {
        beams[c] = as_before(c) ? beams[c - 1]
                                : shell_beams(ray, view.to_sun, layer.extinction[c] * depth);
        through[c] = beams[c].through;
        if (!scene.effects.single || !scene.effects.reflection) continue;
        const PhaseFunction& phase =
            layer.channels.empty() ? layer.components[0] : layer.channels[c];
        light[c] = sun[c] * layer.albedo[c] * phase(cosine) / 4 * (1 - through[c]) * beams[c].lit;
    }
    // `value(beams)` of each channel under its own beams, evaluated once where neighbours are as deep.
    const auto each_beams = [&](const auto& value) {
        Rgb3 all, last;
        for (std::size_t c = 0; c < 3; ++c) {
            if (!as_before(c)) last = value(beams[c]);
            all[c] = last[c];
        }
        return all;
    };
    Geometry geometry = scattering_geometry(normal, view.to_sun, -direction);
    const double to_sun = dot(normal, view.to_sun);
    const bool mirrors = planet.surface.mirror && to_sun > 0 && scene.effects.background;
    const double glint =
        mirrors ? (*planet.surface.mirror)(geometry)-planet.surface.mirror_albedo : 0;
    light += each_beams([&](const ShellBeams& own) {
        if (own.seen == 0) return Rgb3{};
        geometry.mu_in = std::max(own.mu_in, least_cosine);
        geometry.mu_out = own.mu_out;
        return own.seen * own.mu_in * (sun * view.light.reflection(matter, geometry));
    });
    if (!hits && scene.effects.background) light += through * light_beyond(scene, direction);
    if (!hits) return light;
    const bool is_dark = std::ranges::all_of(beams, [](auto& own) { return own.mu_in <= 0; });
    if (planet.surface.is_black() || is_dark) return light;
    // The ground's beams are those of the shell; what is diffuse is that of the plane layer. Light that
    // reaches the ground and what the layer sends back to it make `lit`, as beneath a vertical beam.
    const auto diffuse_along = [&](double ShellBeams::*mu) {
        return each_beams([&](const ShellBeams& own) {
            const double at = std::max(own.*mu, least_cosine);
            return view.light.total_transmittance(matter, at) + -1.0 * view.light.beam(matter, at);
        });
    };
    const Rgb3 down = diffuse_along(&ShellBeams::mu_in), up = diffuse_along(&ShellBeams::mu_out),
               vertical = view.light.total_transmittance(matter, 1),
               lit = view.light.ground(matter, 1, planet.surface.at(place.point));
    for (std::size_t c = 0; c < 3; ++c) {
        if (vertical[c] == 0) continue;
        const double extinction = layer.extinction[c] * depth / planet.shell,
                     beam =
                         to_sun > 0 ? to_sun * std::exp(-extinction * path_out(top, 1, to_sun)) : 0;
        light[c] += sun[c] * (lit[c] / vertical[c] * (beam + beams[c].mu_in * down[c]) *
                                  (up[c] + through[c]) +
                              glint * beam * through[c]);
    }
    return light;
}

namespace {

/// Beyond it, an integer no longer counts the cells of patterns: the horizon.
constexpr double max_distance = 1e13;

bool is_on(const Slab& slab, const Vector3& point) {
    return std::abs(point.x) <= slab.half_size && std::abs(point.y) <= slab.half_size;
}

/// Empty beyond the slab's edges.
Matter matter_at(const Slab& slab, const SceneLayer& layer, const Vector3& point) {
    if (!is_on(slab, point)) return {0, layer.albedo, 1};
    return {layer.optical_depth.at(plane_point(point.x, point.y, slab.image_size)), layer.albedo,
            1};
}

/// The layer through which the sun lights a point of the ground.
Matter lit_through(const Slab& slab, const View& view, const Vector3& point) {
    return matter_at(slab, view.scene.layer, point + (slab.height / view.to_sun.z) * view.to_sun);
}

/// Radiance of the ground at one of its points, by Lambert's law.
Rgb3 ground_light(const Slab& slab, const View& view, const Vector3& point) {
    const double mu_in = view.to_sun.z;
    if (!slab.surface || mu_in <= least_cosine) return {};
    const Matter lit = lit_through(slab, view, point);
    const Rgb albedo = slab.surface->at(plane_point(point.x, point.y, slab.image_size));
    return irradiance(view, mu_in) * view.light.ground(lit, mu_in, albedo);
}

/// The sun that an ocean mirrors at one of its points.
Rgb3 sun_in_water(const Slab& slab, const View& view, const Vector3& point, const Matter& seen) {
    if (!slab.surface || !slab.surface->mirror || view.to_sun.z <= least_cosine) return {};
    return mirrored_sun(view, *slab.surface, lit_through(slab, view, point), seen,
                        scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction));
}

/// The ray crosses the layer and goes on to the background. Over ground it comes from below, and the
/// layer reflects down what the ground sends up: A t(mu_in) / (1 - A s) times the plane albedo, the
/// sum over all orders of light between the two. Of ground and layers that vary, the ground straight
/// below stands for all.
Rgb3 sky_light(const Slab& slab, const View& view, const Vector3& crossing) {
    const Vector3& direction = view.ray.direction;
    const Matter matter = matter_at(slab, view.scene.layer, crossing);
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -direction);
    Rgb3 light{};
    if (!slab.surface || view.to_sun.z > 0)
        light = layer_light(view, matter, geometry, side_of_plane(view.to_sun, -direction));
    if (!view.scene.effects.background) return light;
    if (slab.surface && matter.optical_depth > 0)
        light += view.light.plane_albedo(matter, geometry.mu_out) *
                 ground_light(slab, view, crossing - Vector3{0, 0, slab.height});
    if (!view.scene.background.is_black())
        light += view.light.background(matter, geometry.mu_out) *
                 background_along(view.scene, direction);
    if (is_sun_along(view.scene, direction))
        light += view.light.beam(matter, geometry.mu_out) * sun_along(view.scene, direction);
    return light;
}

/// The ray crosses the layer from above and ends on the ground.
Rgb3 light_over_ground(const Slab& slab, const View& view, const Vector3& crossing) {
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
double distance_to_plane(const Ray& ray, double z) {
    const double distance = (z - ray.origin.z) / ray.direction.z;
    return distance > 0 && distance <= max_distance ? distance : infinity;
}

}  // namespace

double waves_within(const Slab& slab, const SceneLayer& layer, const Cell& cell) {
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

Rgb3 ray_radiance(const Slab& slab, const View& view) {
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
    return light_beyond(view.scene, view.ray.direction);
}

}  // namespace stratus
