#include "ring_light.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/gauss_legendre.h>

#include "subjects.h"

namespace stratus {
namespace {

constexpr std::size_t globe_nodes = 16;  // of chi and psi, on either half of the globe

/// Cells of either half, along chi and psi.
struct Cells {
    std::size_t chi, psi;
};
constexpr Cells small_cells{8, 12};  // for single scattering
constexpr Cells large_cells{2, 2};   // for orders n >= 2, which vary slowly

/// Azimuths of the grid, radii from which the globe is seen, linear between, the largest step between
/// these as a share of the radius, and which of the profile's rows count: one in so many.
struct GridCounts {
    std::size_t azimuths, globe_radii;
    double globe_step;
    std::size_t rows;
};
constexpr GridCounts grid_counts(LightDetail detail) {
    return detail == LightDetail::fine ? GridCounts{24, 16, 0.1, 1} : GridCounts{6, 6, 0.25, 3};
}

/// Linear interpolation between radii holds where neither changes by more.
constexpr double max_step = 0.05, max_intercepted_step = 0.1;

std::vector<double> tabulated_radii(const RingProfile& profile, const GridCounts& counts) {
    std::vector<double> radii{profile.inner()};
    if (counts.rows > 1) {
        for (std::size_t k = counts.rows; k + 1 < profile.radius.size(); k += counts.rows)
            radii.push_back(profile.radius[k]);
        radii.push_back(profile.outer());
        return radii;
    }
    for (std::size_t k = 1; k < profile.radius.size(); ++k) {
        const double from = profile.radius[k - 1], to = profile.radius[k];
        const double intercepted =
            std::abs(std::exp(-profile.optical_depth[k]) - std::exp(-profile.optical_depth[k - 1]));
        // An edge is narrower than what planetshine varies over.
        const bool is_edge = to - from < 1e-3;
        const int parts = static_cast<int>(std::ceil(
            std::max((to - from) / max_step, is_edge ? 1 : intercepted / max_intercepted_step)));
        for (int part = 1; part <= parts; ++part)
            radii.push_back(part == parts ? to : from + (to - from) * part / parts);
    }
    return radii;
}

/// Between neighbours on the grid light turns by less than such a share of its way to the camera, in
/// which nothing is shorter than `least_way`.
constexpr double share_of_way = 0.2, least_way = 1e-3;

/// Radii from which the globe is seen where the camera is close: between them its light is taken to change
/// linearly before it is scattered, so that they are more than a far camera's.
constexpr std::size_t close_globe_radii = 24;

/// The camera over the rings' plane.
struct Eye {
    double radius, azimuth, height;

    explicit Eye(const Camera& camera)
        : radius(std::hypot(camera.position.x, camera.position.y)),
          azimuth(std::atan2(camera.position.y, camera.position.x)),
          height(camera.orthographic ? infinity
                                     : std::max(std::abs(camera.position.z), least_way)) {}

    /// Largest step on the grid at a distance from the point below the camera.
    double step(double aside) const { return share_of_way * std::hypot(height, aside); }
};

/// Ends of intervals after `from` up to `to`, halved until they are as short as the camera demands.
void divide(const Eye& eye, double from, double to, std::vector<double>& ends) {
    const double aside = std::max({0.0, from - eye.radius, eye.radius - to});
    if (to - from <= eye.step(aside)) return ends.push_back(to);
    const double middle = (from + to) / 2;
    divide(eye, from, middle, ends);
    divide(eye, middle, to, ends);
}

/// Radii, and more between them where the camera is close.
std::vector<double> divided(const Eye& eye, const std::vector<double>& radii) {
    std::vector<double> all{radii[0]};
    for (std::size_t k = 1; k < radii.size(); ++k) divide(eye, radii[k - 1], radii[k], all);
    return all;
}

/// Azimuths of the grid from the camera's on, in [0, 2 pi), whose steps grow with the distance from a
/// close camera up to that of `count` even ones; none where these suffice.
std::vector<double> graded_azimuths(const Eye& eye, const RingProfile& profile, std::size_t count) {
    const double largest = 2 * pi / static_cast<double>(count),
                 nearest = std::clamp(eye.radius, profile.inner(), profile.outer());
    std::vector<double> half{0};
    bool is_even = true;
    while (half.back() < pi) {
        const double aside = std::hypot(
            eye.radius - nearest, 2 * std::sqrt(eye.radius * nearest) * std::sin(half.back() / 2));
        const double step = eye.step(aside) / nearest;
        is_even = is_even && step >= largest;
        half.push_back(half.back() + std::min(step, largest));
    }
    if (is_even) return {};
    const double scale = pi / half.back();
    std::vector<double> all;
    for (const double each : half) all.push_back(scale * each);
    for (std::size_t k = half.size() - 1; k-- > 1;) all.push_back(2 * pi - scale * half[k]);
    return all;
}

/// From where rings begin to where they end, without empty rows; of empty rings, all of their profile.
Range radii_of_matter(const RingProfile& profile) {
    Range radii{infinity, 0};
    for (std::size_t k = 1; k < profile.radius.size(); ++k)
        if (profile.optical_depth[k - 1] > 0 || profile.optical_depth[k] > 0)
            radii = {std::min(radii.min, profile.radius[k - 1]), profile.radius[k]};
    return radii.max > 0 ? radii : Range{profile.inner(), profile.outer()};
}

/// Parts of the globe: upper half, lower half; chi; psi.
template <Cells cells>
using Sources = std::array<LightSource, 2 * cells.chi * cells.psi>;

/// The cell of `parts` that holds a cell of `whole`, or a node.
constexpr std::size_t cell_holding(std::size_t source, const Cells& whole, const Cells& parts) {
    const std::size_t psi = source % whole.psi, chi = source / whole.psi % whole.chi,
                      half = source / (whole.psi * whole.chi);
    return (half * parts.chi + chi * parts.chi / whole.chi) * parts.psi +
           psi * parts.psi / whole.psi;
}

/// Returns the globe as a point of the rings sees it. Directions of cells are sums weighted by light.
Sources<small_cells> sources_at(const Rings& rings, const Scene& scene, const LayerLight& light,
                                const Vector3& to_sun, const Vector3& point) {
    static const GaussLegendre gauss(globe_nodes);
    const double pole = 1 - rings.flattening, radius = std::hypot(point.x, point.y);
    const Vector3 inward{-point.x / radius, -point.y / radius, 0}, along = cross({0, 0, 1}, inward);
    Sources<small_cells> sources;
    for (std::size_t i = 0; i < globe_nodes; ++i) {
        const double chi = pi / 4 * (1 + gauss.x[i]), sine = std::sin(chi) / radius,
                     cosine = std::sqrt(1 - sine * sine);
        const double distance = radius * cosine - std::cos(chi);
        const double ring = gauss.weight[i] * pi / 4 * sine * std::cos(chi) / (radius * cosine);
        for (std::size_t k = 0; k < globe_nodes; ++k) {
            const double psi = pi / 2 * (1 + gauss.x[k]);
            for (const std::size_t half : {0u, 1u}) {
                Vector3 direction = cosine * inward + sine * std::cos(psi) * along +
                                    Vector3{0, 0, (half == 0 ? sine : -sine) * std::sin(psi)};
                Vector3 on_globe = point + distance * direction;
                on_globe.z *= pole;
                direction.z *= pole;
                const double stretch = length(direction);
                direction = 1 / stretch * direction;
                const double solid_angle =
                    ring * gauss.weight[k] * pi / 2 * pole / (stretch * stretch * stretch);
                const Ray to_globe{point, direction};
                const Rgb3 irradiance =
                    solid_angle * std::abs(direction.z) / pi *
                    globe_light(rings, {scene, light, to_globe, to_sun}, on_globe);
                LightSource& cell = sources[cell_holding((half * globe_nodes + i) * globe_nodes + k,
                                                         {globe_nodes, globe_nodes}, small_cells)];
                cell += LightSource{brightness(irradiance) * direction, irradiance};
            }
        }
    }
    return sources;
}

/// Returns the globe as a radius sees it, from ascending radii at one azimuth.
Sources<small_cells> sources_between(const std::vector<Sources<small_cells>>& sources,
                                     const std::vector<double>& radii, double radius) {
    const std::size_t k = interval_with(radii, radius);
    const double share = (radius - radii[k]) / (radii[k + 1] - radii[k]);
    if (share <= 0) return sources[k];
    if (share >= 1) return sources[k + 1];
    Sources<small_cells> between;
    for (std::size_t s = 0; s < between.size(); ++s)
        between[s] = (1 - share) * sources[k][s] + share * sources[k + 1][s];
    return between;
}

/// Neighbours as one.
Sources<large_cells> merged(const Sources<small_cells>& sources) {
    Sources<large_cells> few;
    for (std::size_t s = 0; s < sources.size(); ++s) {
        LightSource& cell = few[cell_holding(s, small_cells, large_cells)];
        cell += sources[s];
    }
    return few;
}

/// A source, and its light's way to the eye.
struct Lamp {
    Rgb3 irradiance;
    Scattering scattering;
};

template <class SomeSources>
std::vector<Lamp> lamps_towards(const SomeSources& sources, const LayerLight& light,
                                const Vector3& to_eye) {
    std::vector<Lamp> lamps;
    for (const LightSource& source : sources) {
        if (source.irradiance == Rgb3{}) continue;
        const Vector3 direction = normalised(source.direction);
        lamps.push_back({source.irradiance,
                         light.scattering(side_of_plane(direction, to_eye),
                                          scattering_geometry({0, 0, 1}, direction, to_eye))});
    }
    return lamps;
}

/// The globe as one point of the rings sees it: for single scattering, and for orders n >= 2.
struct GlobeLamps {
    std::vector<Lamp> small, large;
};

/// Light that some of the rings' matter there scatters towards the eye.
Rgb3 scattered(const GlobeLamps& lamps, const Scene& scene, const LayerLight& light,
               const Matter& matter) {
    const double depth = seen_depth(scene, matter.optical_depth);
    Rgb3 once{}, more{};
    for (const Lamp& lamp : lamps.small)
        once += light.single(matter.mixture, depth, lamp.scattering) * lamp.irradiance;
    for (const Lamp& lamp : lamps.large)
        more += lamp.irradiance * light.multiple(matter, lamp.scattering, LightPath::shine);
    return matter.albedo * once + more;
}

}  // namespace

PlanetShine::PlanetShine(const Scene& scene, const Rings& rings, const LayerLight& light,
                         int threads, LightDetail detail)
    : azimuths_(grid_counts(detail).azimuths),
      radius_(tabulated_radii(rings.profile, grid_counts(detail))) {
    const Eye eye(scene.camera);
    const GridCounts counts = grid_counts(detail);
    std::size_t globe_radii = counts.globe_radii;
    if (detail == LightDetail::fine) {
        radius_ = divided(eye, radius_);
        eye_azimuth_ = eye.azimuth;
        graded_azimuths_ = graded_azimuths(eye, rings.profile, azimuths_);
        if (!graded_azimuths_.empty()) {
            azimuths_ = graded_azimuths_.size();
            globe_radii = close_globe_radii;
        }
    }
    const Range matter_radii = radii_of_matter(rings.profile);
    std::vector<double> globe_radius{matter_radii.min};
    for (std::size_t r = 1; r < globe_radii; ++r) {
        const double share = static_cast<double>(r) / static_cast<double>(globe_radii - 1),
                     from = globe_radius.back(),
                     to = matter_radii.min + share * share * (matter_radii.max - matter_radii.min);
        const int parts = static_cast<int>(std::ceil((to - from) / (counts.globe_step * from)));
        for (int part = 1; part <= parts; ++part)
            globe_radius.push_back(part == parts ? to : from + (to - from) * part / parts);
    }
    const std::vector<double> lamp_radius =
        detail == LightDetail::fine ? divided(eye, globe_radius) : globe_radius;
    grid_.resize(radius_.size() * azimuths_);
    const auto towards_azimuth = [&](int k) {
        return direction_at(0, graded_azimuths_.empty()
                                   ? 2 * pi * k / static_cast<double>(azimuths_)
                                   : eye_azimuth_ + graded_azimuths_[size(k)]);
    };
    parallel_for(static_cast<int>(azimuths_), threads, [&](int k) {
        std::vector<Sources<small_cells>> globe;
        for (const double radius : globe_radius)
            globe.push_back(
                sources_at(rings, scene, light, scene.to_sun, radius * towards_azimuth(k)));
        std::vector<GlobeLamps> lamps;
        for (const double radius : lamp_radius) {
            const Vector3 to_eye = stratus::to_camera(scene.camera, radius * towards_azimuth(k));
            const auto sources = sources_between(globe, globe_radius, radius);
            lamps.push_back({lamps_towards(sources, light, to_eye),
                             lamps_towards(merged(sources), light, to_eye)});
        }
        std::size_t above = 1;
        for (std::size_t row = 0; row < radius_.size(); ++row) {
            const double radius = radius_[row];
            const Matter matter = rings.profile.at(radius, scene.layer.albedo);
            if (matter.optical_depth == 0) continue;
            while (above + 1 < lamps.size() && lamp_radius[above] < radius) ++above;
            const double below = lamp_radius[above - 1],
                         share = (radius - below) / (lamp_radius[above] - below);
            grid_[row * azimuths_ + size(k)] =
                (1 - share) * scattered(lamps[above - 1], scene, light, matter) +
                share * scattered(lamps[above], scene, light, matter);
        }
    });
}

AzimuthPlace PlanetShine::place(const Vector3& point) const {
    if (graded_azimuths_.empty()) return {point, azimuths_};
    const double turn = std::atan2(point.y, point.x) - eye_azimuth_;
    return {turn - 2 * pi * std::floor(turn / (2 * pi)), graded_azimuths_};
}

Rgb3 PlanetShine::to_camera(const AzimuthPlace& place, double radius) const {
    const std::size_t row = interval_with(radius_, radius);
    const double share =
        std::clamp((radius - radius_[row]) / (radius_[row + 1] - radius_[row]), 0.0, 1.0);
    Rgb3 radiance = (1 - share) * place.interpolated(&grid_[row * azimuths_]) +
                    share * place.interpolated(&grid_[(row + 1) * azimuths_]);
    for (double& channel : radiance)
        channel = std::max(0.0, channel);  // cubics swing below 0 beside darkness
    return radiance;
}

Rgb3 PlanetShine::to_elsewhere(const Rings& rings, const View& view, const Vector3& point,
                               double radius, const Matter& matter) {
    const Vector3 at = radius / std::hypot(point.x, point.y) * point;
    const std::vector<Lamp> lamps =
        lamps_towards(sources_at(rings, view.scene, view.light, view.to_sun, at), view.light,
                      -view.ray.direction);
    return scattered(GlobeLamps{lamps, lamps}, view.scene, view.light, matter);
}

}  // namespace stratus
