#include <stratus/scene/contents.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace stratus {
namespace {

double sun_radius(const Scene& scene) {
    return scene.effects.sun_size ? scene.sun_diameter / 2 : 0;
}

/// The sun's height over z = 0, radians.
double sun_elevation(const Scene& scene) {
    return std::asin(std::clamp(scene.to_sun.z, -1.0, 1.0));
}

/// The ground of a planet or slab; null where it is black or there is none.
const Texture* reflecting_ground(const Scene& scene) {
    const Texture* ground = nullptr;
    if (const Planet* const planet = scene.subject_as<Planet>()) ground = &planet->surface;
    if (const Slab* const slab = scene.subject_as<Slab>())
        if (slab->surface) ground = &*slab->surface;
    return ground && !ground->is_black() ? ground : nullptr;
}

/// Whether there is ground under a slab, black or not.
bool has_ground(const Scene& scene) {
    const Slab* const slab = scene.subject_as<Slab>();
    return slab && slab->surface;
}

/// The sides of a plane in z = 0 are told apart by the signs of z.
SeenLight seen_light_of_plane(const Scene& scene) {
    const Camera& camera = scene.camera;
    const double ahead = camera.forward().z;
    const bool from_above = camera.orthographic ? ahead < 0 : camera.position.z > 0,
               from_below = camera.orthographic ? ahead > 0 : camera.position.z < 0;
    const double elevation = sun_elevation(scene), radius = sun_radius(scene);
    const bool sun_above = elevation + radius > 0,
               sun_below = elevation - radius <= 0 && !has_ground(scene);
    SeenLight seen;
    seen.reflection = (sun_above && from_above) || (sun_below && from_below);
    seen.transmission = (sun_above && from_below) || (sun_below && from_above);
    const bool shines_through = scene.background.is_one_colour();
    if (has_ground(scene)) {
        const bool lit_ground = sun_above && reflecting_ground(scene) != nullptr;
        seen.fluxes = lit_ground || (from_below && shines_through);
        seen.underside = lit_ground && from_below;
    } else {
        seen.fluxes = (from_above || from_below) && shines_through;
    }
    return seen;
}

bool is_shining(const Scene& scene) {
    const Rings* const rings = scene.subject_as<Rings>();
    return rings && !rings->has_black_planet() &&
           (scene.effects.ringshine || scene.effects.planetshine);
}

// ---- directions ---------------------------------------------------------------------------------

/// z / |v| along v = start + t step, t in [0, 1]: its ends, and the one place between where it may
/// be largest or smallest.
void widen_along(Range& range, const Vector3& start, const Vector3& step) {
    auto add = [&](double t) {
        const Vector3 v = start + t * step;
        widen(range, v.z / length(v));
    };
    add(0);
    add(1);
    const double b = dot(start, step), c = dot(step, step);
    const double slope = step.z * b - start.z * c;
    if (slope == 0) return;
    const double turn = (start.z * b - step.z * dot(start, start)) / slope;
    if (turn > 0 && turn < 1) add(turn);
}

/// Directions through a picture: z, and the azimuth about z, of all of its rays.
struct PictureDirections {
    Range z{1, -1};
    Range azimuth{0, 2 * pi};  // from the x axis; unwrapped
};

PictureDirections picture_directions(const Scene& scene) {
    const PictureRays rays(scene.camera, scene.width, scene.height);
    const double w = scene.width, h = scene.height;
    const Vector3 forward = scene.camera.forward();
    PictureDirections all;
    if (scene.camera.orthographic) {
        const double azimuth = std::atan2(forward.y, forward.x);
        return {{forward.z, forward.z}, {azimuth, azimuth}};
    }
    const auto at_unit_depth = [&](double x, double y) {
        const Vector3 along = rays.through(x, y).direction;
        return (1 / dot(along, forward)) * along;
    };
    // In order around the picture.
    const std::array corners{at_unit_depth(0, 0), at_unit_depth(w, 0), at_unit_depth(w, h),
                             at_unit_depth(0, h)};
    for (std::size_t k = 0; k < 4; ++k)
        widen_along(all.z, corners[k], corners[(k + 1) % 4] - corners[k]);
    // Straight up or down within the picture: every azimuth, and the pole itself.
    const auto reaches_pole = [&](const Vector3& axis) {
        return std::abs(axis.z / forward.z) <= std::abs(dot(corners[1], axis));
    };
    if (reaches_pole(scene.camera.right()) && reaches_pole(scene.camera.up())) {
        widen(all.z, forward.z > 0 ? 1 : -1);
        return all;
    }
    const double middle = std::atan2(forward.y, forward.x);
    all.azimuth = {middle, middle};
    for (const Vector3& corner : corners)
        widen(all.azimuth,
              middle + std::remainder(std::atan2(corner.y, corner.x) - middle, 2 * pi));
    return all;
}

/// Distance from the plane's axis up to which there may be a layer. Cells of pixels that reach rings
/// are looked up at their middle, which may lie beside these.
double farthest_layer(const Scene& scene) {
    const Slab* const slab = scene.subject_as<Slab>();
    return slab && !slab->surface ? std::sqrt(2.0) * slab->half_size : infinity;
}

/// Cosines at which the part of the plane that may be seen is seen.
Range cosines_of_view(const Scene& scene, const Range& z) {
    const Camera& camera = scene.camera;
    Range mu{0, 0};
    if (camera.orthographic) {
        mu = {std::abs(z.min), std::abs(z.min)};
    } else {
        // Only rays to the other side of the camera's height meet the plane.
        mu = camera.position.z > 0 ? Range{std::max(0.0, -z.max), std::max(0.0, -z.min)}
                                   : Range{std::max(0.0, z.min), std::max(0.0, z.max)};
        const double height = std::abs(camera.position.z),
                     aside = std::hypot(camera.position.x, camera.position.y);
        const double farthest = farthest_layer(scene), near = std::max(0.0, aside - farthest),
                     far = farthest + aside;
        mu.min = std::max(mu.min, std::isinf(far) ? 0 : height / std::hypot(height, far));
        mu.max = std::min(mu.max, height > 0 ? height / std::hypot(height, near) : 0);
        mu.max = std::max(mu.max, mu.min);
    }
    return {std::clamp(mu.min, least_cosine, 1.0), std::clamp(mu.max, least_cosine, 1.0)};
}

/// Azimuths between 0 and 180 degrees of a range of differences.
Range folded(const Range& range) {
    if (range.max - range.min >= 2 * pi) return {0, 180};
    Range around{180, 0};
    for (const double end : {range.min, range.max})
        widen(around, degrees(std::abs(std::remainder(end, 2 * pi))));
    const auto holds = [&](double angle) {
        const double turn = 2 * pi * std::ceil((range.min - angle) / (2 * pi));
        return angle + turn <= range.max;
    };
    if (holds(0)) around.min = 0;
    if (holds(pi)) around.max = 180;
    return around;
}

SeenDirections directions_over_plane(const Scene& scene) {
    const PictureDirections picture = picture_directions(scene);
    const double elevation = sun_elevation(scene), radius = sun_radius(scene);
    SeenDirections seen;
    const auto cosine = [&](double angle) {
        return std::clamp(std::abs(std::sin(angle)), least_cosine, 1.0);
    };
    seen.mu_in = {1, 0};
    if (radius == 0)
        widen(seen.mu_in, std::clamp(std::abs(scene.to_sun.z), least_cosine, 1.0));
    else
        for (const double end : {elevation - radius, elevation + radius})
            widen(seen.mu_in, cosine(end));
    if (std::abs(elevation) < radius) seen.mu_in.min = least_cosine;
    if (std::abs(elevation) + radius > pi / 2) seen.mu_in.max = 1;
    seen.mu_out = cosines_of_view(scene, picture.z);
    // The sun's light travels away from it, towards the azimuth of -to_sun; an eye straight ahead
    // of it, with the camera's rays reversed, sees azimuth 0.
    const double aside = std::hypot(scene.to_sun.x, scene.to_sun.y);
    if (aside <= std::sin(radius) || seen.mu_out.max >= 1 || aside == 0) {
        seen.azimuth = {0, 180};
    } else {
        const double width = radius == 0 ? 0 : std::asin(std::sin(radius) / aside);
        const double sun = std::atan2(scene.to_sun.y, scene.to_sun.x);
        // travelling in: -to_sun; travelling out: -ray. The angle between is that of to_sun and ray.
        seen.azimuth =
            folded({picture.azimuth.min - sun - width, picture.azimuth.max - sun + width});
    }
    return seen;
}

/// Between the directions to the sun and to the eye on a globe, radians.
Range phase_angles(const Scene& scene) {
    const Camera& camera = scene.camera;
    const double distance = length(camera.position);
    double spread = sun_radius(scene);
    Vector3 to_eye = -camera.forward();
    if (!camera.orthographic) {
        if (distance <= 1) return {0, pi};
        to_eye = normalised(camera.position);
        spread += std::asin(1 / distance);
    }
    const double phase = std::acos(std::clamp(dot(to_eye, scene.to_sun), -1.0, 1.0));
    return {std::max(0.0, phase - spread), std::min(pi, phase + spread)};
}

/// On a globe all directions occur whose scattering angle is that between sun and eye. Beyond a phase
/// angle of 90 degrees the brightest point of the visible part lies on its edge.
SeenDirections directions_on_globe(const Scene& scene, const Planet& planet) {
    if (planet.has_rings || seen_shell(scene) > 0) return {};
    const double least = phase_angles(scene).min;
    const Range mu{least_cosine, least > pi / 2 ? std::sin(least) : 1.0};
    return {mu, mu};
}

/// Over a box of directions, degrees.
Range scattering_angles_over(const SeenDirections& seen, Side side) {
    Range angles{180, 0};
    // Over cosines the angle may turn between the corners; so many steps miss little of it, and the
    // range is widened by as much.
    constexpr int steps = 64;
    const auto at_step = [](const Range& range, int k) {
        return std::min(1.0, range.min + (range.max - range.min) * k / steps);
    };
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; j <= steps; ++j)
            for (const double azimuth : {seen.azimuth.min, seen.azimuth.max}) {
                const Geometry geometry{at_step(seen.mu_in, i), at_step(seen.mu_out, j),
                                        radians(azimuth)};
                const double cosine = cos_scattering_angle(side, geometry);
                widen(angles, degrees(std::acos(std::clamp(cosine, -1.0, 1.0))));
            }
    const bool one = seen.mu_in.min == seen.mu_in.max && seen.mu_out.min == seen.mu_out.max;
    const double margin = one ? 0 : 2;
    return {std::max(0.0, angles.min - margin), std::min(180.0, angles.max + margin)};
}

}  // namespace

void widen(Range& range, double value) {
    range = {std::min(range.min, value), std::max(range.max, value)};
}

void widen(Range& range, const Range& other) {
    widen(range, other.min);
    widen(range, other.max);
}

SeenLight seen_light(const Scene& scene) {
    SeenLight seen;
    if (scene.subject_as<Planet>()) {
        seen.reflection = true;
        seen.fluxes = reflecting_ground(scene) != nullptr;
    } else {
        seen = seen_light_of_plane(scene);
    }
    if (is_shining(scene)) seen.reflection = seen.transmission = seen.shine = true;
    const SceneEffects& effects = scene.effects;
    seen.reflection &= effects.reflection;
    seen.transmission &= effects.transmission;
    seen.fluxes &= effects.background;
    seen.underside &= effects.background;
    seen.shine &= seen.reflection || seen.transmission;
    return seen;
}

SeenDirections seen_directions(const Scene& scene) {
    if (const Planet* const planet = scene.subject_as<Planet>())
        return directions_on_globe(scene, *planet);
    return is_shining(scene) ? SeenDirections{} : directions_over_plane(scene);
}

Range seen_scattering_angles(const Scene& scene, Side side) {
    const Planet* const planet = scene.subject_as<Planet>();
    if (planet && !planet->has_rings) {
        const Range phase = phase_angles(scene);
        return {180 - degrees(phase.max), 180 - degrees(phase.min)};
    }
    return scattering_angles_over(seen_directions(scene), side);
}

void MatterSpan::add(const Matter& matter, double depth) {
    widen(optical_depth, depth);
    for (const double each : matter.albedo) widen(albedo, each);
    widen(mixture, matter.mixture);
}

std::vector<MatterSpan> matter_spans(const Scene& scene) {
    std::vector<MatterSpan> spans;
    // Depths of red, green and blue.
    const auto& extinction = scene.layer.extinction;
    const auto channels = std::ranges::minmax(extinction);
    const Rings* const rings = scene.subject_as<Rings>();
    if (!rings) {
        const double deepest = seen_depth(scene, scene.layer.optical_depth.max);
        const double thinnest = scene.layer.optical_depth.is_plain() ? deepest : 0;
        MatterSpan span;
        for (const double depth : {thinnest * channels.min, deepest * channels.max})
            span.add({0, scene.layer.albedo}, depth);
        if (span.optical_depth.max > 0) spans.push_back(span);
        return spans;
    }
    const RingProfile& profile = rings->profile;
    for (std::size_t k = 1; k < profile.radius.size(); ++k) {
        MatterSpan span;
        for (const std::size_t knot : {k - 1, k}) {
            const Matter matter = profile.at(profile.radius[knot], scene.layer.albedo);
            for (const double factor : {channels.min, channels.max})
                span.add(matter, factor * seen_depth(scene, matter.optical_depth));
        }
        if (span.optical_depth.max > 0) spans.push_back(span);
    }
    return spans;
}

MatterSpan whole_matter_span(const Scene& scene) {
    MatterSpan all;
    for (const MatterSpan& span : matter_spans(scene)) {
        widen(all.optical_depth, span.optical_depth);
        widen(all.albedo, span.albedo);
        widen(all.mixture, span.mixture);
    }
    return all;
}

double brightest_ground(const Scene& scene) {
    const Texture* const ground = scene.effects.background ? reflecting_ground(scene) : nullptr;
    if (!ground) return 0;
    if (ground->pattern == Texture::Pattern::image) {
        return double{std::ranges::max(ground->image->rgb)};
    }
    return std::max(brightest(ground->colour), brightest(ground->other));
}

}  // namespace stratus
