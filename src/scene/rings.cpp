// Rings: their light along a ray, then the orders of scattering that it is made of.
#include <stratus/bake/parallel.h>

#include "ring_light.h"
#include "subjects.h"

#include <span>

namespace stratus {
namespace {

/// Where a ray meets the plane of the rings; infinity: nowhere.
struct Crossing {
    double distance = infinity, radius = infinity;
};

Crossing ring_crossing(const Ray& ray) {
    const double distance = -ray.origin.z / ray.direction.z;
    if (!(distance > 0) || std::isinf(distance)) return {};
    const Vector3 point = ray.at(distance);
    return {distance, std::sqrt(point.x * point.x + point.y * point.y)};
}

bool meets_rings(const Rings& rings, const RingFootprint& footprint) {
    return footprint.end() >= rings.profile.inner() && footprint.begin() <= rings.profile.outer();
}

/// Footprint of the view's cell, from `radius_along(ray)` of its middle and its sides.
template <class RadiusAlong>
RingFootprint cell_footprint(const View& view, const RadiusAlong& radius_along) {
    const double radius = radius_along(view.ray);
    if (!view.cell || std::isinf(radius)) return RingFootprint(radius);
    std::array<double, 4> radii;
    std::ranges::transform(view.cell->sides(), radii.begin(), radius_along);
    return {radius, radii};
}

/// Share of the sunlight that the rings let pass to a point of the globe, which the view's cell is
/// around if it has one.
Rgb3 ring_shadow(const Rings& rings, const View& view, const Vector3& point) {
    const auto radius_over = [&](const Vector3& at) {
        return ring_crossing({at, view.to_sun}).radius;
    };
    const RingFootprint footprint =
        view.cell
            ? cell_footprint(view,
                             [&](const Ray& ray) {
                                 const double distance = distance_to_globe(ray, rings.flattening);
                                 return distance > 0 ? radius_over(ray.at(distance)) : infinity;
                             })
            : RingFootprint(radius_over(point));
    if (!meets_rings(rings, footprint)) return {1, 1, 1};
    const double mu = std::max(std::abs(view.to_sun.z), least_cosine);
    Rgb3 share{};
    footprint.visit(rings.profile, view.scene.layer.albedo, seen_depth(view.scene, 1) / mu,
                    [&](const Matter& matter, double, double part) {
                        share += part * view.light.beam(matter, mu);
                    });
    return share;
}

}  // namespace

std::array<Ray, 4> Cell::sides() const {
    const double x = (left + right) / 2, y = (top + bottom) / 2;
    return {rays.through(left, y), rays.through(right, y), rays.through(x, top),
            rays.through(x, bottom)};
}

RingFootprint::RingFootprint(double radius, const std::array<double, 4>& sides) : centre_(radius) {
    const double sum = sides[0] + sides[1] + sides[2] + sides[3];
    if (!std::isfinite(sum)) return;
    const double by_columns = std::abs(sides[1] - sides[0]),
                 by_rows = std::abs(sides[3] - sides[2]);
    centre_ = sum / 4;
    wide_ = std::max(by_columns, by_rows);
    narrow_ = std::min(by_columns, by_rows);
}

double RingFootprint::within(double radius) const {
    const double beyond = std::abs(radius - centre_), flat = (wide_ - narrow_) / 2,
                 edge = (wide_ + narrow_) / 2;
    double outside = 0.5 - beyond / wide_;  // share farther out on the same side
    if (beyond >= edge)
        outside = 0;
    else if (beyond > flat)
        outside = (edge - beyond) * (edge - beyond) / (2 * wide_ * narrow_);
    return radius < centre_ ? outside : 1 - outside;
}

Matter RingProfile::at(double at_radius, const Rgb3& tint) const {
    if (!(at_radius >= inner() && at_radius <= outer())) return {};
    return after(interval_with(radius, at_radius), at_radius, tint);
}

Matter RingProfile::after(std::size_t row, double at_radius, const Rgb3& tint) const {
    const double share = (at_radius - radius[row]) / (radius[row + 1] - radius[row]);
    auto linear = [&](const std::vector<double>& rows) {
        return rows[row] + share * (rows[row + 1] - rows[row]);
    };
    const double first = linear(w1), both = first + linear(w2);
    return {linear(optical_depth),
            {both * tint[0], both * tint[1], both * tint[2]},
            both > 0 ? first / both : 1};
}

Rgb3 globe_light(const Rings& rings, const View& view, const Vector3& point) {
    const Vector3 normal = globe_normal(point, rings.flattening);
    const double mu_in = dot(normal, view.to_sun);
    Rgb3 sunlit{};
    if (mu_in > 0)
        sunlit = view.scene.effects.shadows ? ring_shadow(rings, view, point) : Rgb3{1, 1, 1};
    if (const LayerLight* const layer = view.light.planet()) {
        const auto lit_from = [&](const Vector3& direction) {
            return planet_light(std::get<Planet>(layer->scene().subject),
                                {layer->scene(), *layer, view.ray, direction}, normal);
        };
        Rgb3 light{};
        if (mu_in > 0) light = sunlit * lit_from(view.to_sun);
        if (const RingShine* const shine =
                view.scene.effects.ringshine ? view.light.ring_shine() : nullptr)
            for (const LightSource& source : shine->sources(point)) {
                if (source.irradiance == Rgb3{}) continue;
                const Vector3 direction = normalised(source.direction);
                light += 1 / std::max(std::abs(dot(normal, direction)), least_cosine) *
                         (source.irradiance * lit_from(direction));
            }
        return light;
    }
    const Rgb3 share =
        (view.scene.effects.ringshine ? view.light.ringshine(point) : Rgb3{}) + mu_in * sunlit;
    return view.scene.sun_colour * share * widened(rings.surface.at(sphere_point(normal)));
}

/// Rings count by area (ring_light.h).
double waves_within(const Rings&, const SceneLayer&, const Cell&) { return 0; }

Rgb3 ray_radiance(const Rings& rings, const View& view) {
    const double to_planet = distance_to_globe(view.ray, rings.flattening);
    const Crossing crossing = ring_crossing(view.ray);
    auto planet = [&] { return globe_light(rings, view, view.ray.at(to_planet)); };
    auto behind = [&] {
        return to_planet > 0 ? planet() : light_beyond(view.scene, view.ray.direction);
    };
    if (std::isinf(crossing.distance) || (to_planet > 0 && to_planet < crossing.distance))
        return behind();
    const RingFootprint footprint =
        cell_footprint(view, [](const Ray& ray) { return ring_crossing(ray).radius; });
    if (!meets_rings(rings, footprint)) return behind();
    const Vector3 point = view.ray.at(crossing.distance);
    const bool dark =
        view.scene.effects.shadows && distance_to_globe({point, view.to_sun}, rings.flattening) > 0;
    const PlanetShine* const shine =
        view.scene.effects.planetshine ? view.light.planetshine() : nullptr;
    const bool is_to_camera =
                   length(to_camera(view.scene.camera, point) + view.ray.direction) <= 1e-9,
               is_suns_centre = length(view.to_sun - view.scene.to_sun) <= 1e-9;
    const Geometry geometry = scattering_geometry({0, 0, 1}, view.to_sun, -view.ray.direction);
    const double mu = geometry.mu_out;
    Scattering scattering;  // of sunlight
    if (!dark)
        scattering =
            view.light.scattering(side_of_plane(view.to_sun, -view.ray.direction), geometry);
    const bool background_behind = to_planet <= 0 && !view.scene.background.is_black(),
               beam_behind = to_planet > 0 || view.scene.sun_visible;
    const RingOrders* const orders =
        is_to_camera && is_suns_centre ? view.light.ring_orders() : nullptr;
    const AzimuthPlace orders_place = orders ? orders->place(point) : AzimuthPlace(),
                       shine_place = shine && is_to_camera ? shine->place(point) : AzimuthPlace();
    Rgb3 sunlight{}, planetlight{}, beam{}, background_share{};
    footprint.visit(rings.profile, view.scene.layer.albedo,
                    seen_depth(view.scene, 1) * (1 / mu + 1 / geometry.mu_in),
                    [&](const Matter& matter, double radius, double part) {
                        if (!dark && matter.optical_depth > 0)
                            sunlight += part * (orders ? view.light.once(matter, scattering) +
                                                             orders->light(orders_place, radius)
                                                       : view.light.light(matter, scattering));
                        if (shine && matter.optical_depth > 0)
                            planetlight +=
                                part * (is_to_camera ? shine->to_camera(shine_place, radius)
                                                     : PlanetShine::to_elsewhere(rings, view, point,
                                                                                 radius, matter));
                        if (!view.scene.effects.background) return;
                        if (beam_behind) beam += part * view.light.beam(matter, mu);
                        if (background_behind)
                            background_share += part * view.light.background(matter, mu);
                    });
    const Rgb3 light = irradiance(view, geometry.mu_in) * sunlight + planetlight;
    if (!view.scene.effects.background) return light;
    if (to_planet > 0) return light + beam * planet();
    return light + background_share * background_along(view.scene, view.ray.direction) +
           beam * sun_along(view.scene, view.ray.direction);
}

namespace {

constexpr std::size_t least_azimuths = 24, most_azimuths = 96;
constexpr double share_of_tolerance = 0.05;
constexpr double faint = 0.01;         // light, below which errors need not be a share of it
constexpr double min_interval = 1e-6;  // planet radii

using LightAt = std::function<Rgb3(double radius, double azimuth)>;

double difference(const Rgb3& a, const Rgb3& b) {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(a[c] - b[c]) / std::max(std::abs(a[c]), faint));
    return worst;
}

/// The parabola through values at 0, 1/2 and 1.
Rgb3 parabola(const Rgb3& first, const Rgb3& middle, const Rgb3& last, double t) {
    return ((1 - t) * (1 - 2 * t)) * first + (4 * t * (1 - t)) * middle + (t * (2 * t - 1)) * last;
}

/// Ends of intervals after `from` up to `to`, halved until parabolas hold at some azimuths.
void divide(const LightAt& light, std::span<const double> azimuths, double from, double to,
            double accuracy, std::vector<double>& ends) {
    const double middle = (from + to) / 2;
    bool holds = true;
    for (const double azimuth : azimuths) {
        const Rgb3 first = light(from, azimuth), centre = light(middle, azimuth),
                   last = light(to, azimuth);
        for (const double t : {0.25, 0.75})
            holds = holds && difference(light(from + t * (to - from), azimuth),
                                        parabola(first, centre, last, t)) <= accuracy;
    }
    if (holds || to - from < min_interval) {
        ends.push_back(to);
        return;
    }
    divide(light, azimuths, from, middle, accuracy, ends);
    divide(light, azimuths, middle, to, accuracy, ends);
}

/// Nodes of the grid at which azimuths between its own are tested: a share of all, and most of those
/// where a camera close to rings sees them under angles that change fast.
std::vector<std::size_t> tested_nodes(const RingProfile& profile, const Vector3& eye,
                                      const std::vector<double>& node_radius) {
    const double eye_radius = std::hypot(eye.x, eye.y);
    double aside = infinity;  // of matter from the plane's point below the camera
    for (const double radius : node_radius)
        if (profile.at(radius, {1, 1, 1}).optical_depth > 0)
            aside = std::min(aside, std::abs(radius - eye_radius));
    std::vector<std::size_t> tested;
    const auto add_some = [&](auto begin, auto end) {
        constexpr std::ptrdiff_t least = 16, largest_step = 16;
        const std::ptrdiff_t step =
            std::clamp((end - begin) / least, std::ptrdiff_t{1}, largest_step);
        for (; begin < end; begin += std::min(step, end - begin))
            tested.push_back(size(begin - node_radius.begin()));
    };
    add_some(node_radius.begin(), node_radius.end());
    const double reach = aside + std::abs(eye.z);
    add_some(std::ranges::lower_bound(node_radius, eye_radius - reach),
             std::ranges::upper_bound(node_radius, eye_radius + reach));
    std::ranges::sort(tested);
    tested.erase(std::unique(tested.begin(), tested.end()), tested.end());
    return tested;
}

}  // namespace

RingOrders::RingOrders(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
                       LightDetail detail)
    : azimuth_count_(least_azimuths), radius_{rings.profile.inner()} {
    const RingProfile& profile = rings.profile;
    const auto light_at = [&](double radius, double azimuth) {
        const Vector3 to_eye = to_camera(scene.camera, radius * direction_at(0, azimuth));
        return light.multiple(profile.at(radius, scene.layer.albedo),
                              {side_of_plane(scene.to_sun, to_eye),
                               scattering_geometry({0, 0, 1}, scene.to_sun, to_eye),
                               0,
                               {}});
    };
    const double accuracy = share_of_tolerance * scene.tolerance;
    // Light varies most at the point of the plane that is below the camera, or above it.
    const double eye_radius = std::hypot(scene.camera.position.x, scene.camera.position.y),
                 eye_azimuth = std::atan2(scene.camera.position.y, scene.camera.position.x);
    const std::array azimuths{eye_azimuth, eye_azimuth + 2, eye_azimuth + 4};
    // All rows of the profile at once.
    std::vector<std::vector<double>> ends(profile.radius.size() - 1);
    parallel_for(int_size(ends), threads, [&](int row) {
        const auto k = size(row);
        double from = profile.radius[k];
        const double to = profile.radius[k + 1];
        if (detail == LightDetail::sketch) return ends[k].push_back(to);
        if (!scene.camera.orthographic && from < eye_radius && eye_radius < to) {
            divide(light_at, azimuths, from, eye_radius, accuracy, ends[k]);
            from = eye_radius;
        }
        divide(light_at, azimuths, from, to, accuracy, ends[k]);
    });
    for (const auto& some : ends) radius_.insert(radius_.end(), some.begin(), some.end());
    std::vector<double> node_radius{radius_[0]};
    for (std::size_t k = 1; k < radius_.size(); ++k) {
        node_radius.push_back((radius_[k - 1] + radius_[k]) / 2);
        node_radius.push_back(radius_[k]);
    }
    const std::size_t nodes = node_radius.size();
    const std::vector<std::size_t> tested =
        tested_nodes(profile, scene.camera.position, node_radius);
    for (;; azimuth_count_ *= 2) {
        grid_.clear();
        if (azimuth_count_ > most_azimuths) return;
        grid_.resize(nodes * azimuth_count_);
        const double step = 2 * pi / static_cast<double>(azimuth_count_);
        std::vector<double> worst(azimuth_count_ + 1);
        parallel_for(static_cast<int>(azimuth_count_), threads, [&](int k) {
            const auto column = size(k);
            for (std::size_t node = 0; node < nodes; ++node)
                grid_[node * azimuth_count_ + column] = light_at(node_radius[node], k * step);
        });
        if (detail == LightDetail::sketch) return;
        parallel_for(static_cast<int>(worst.size()), threads, [&](int k) {
            const double azimuth = size(k) < azimuth_count_ ? (k + 0.5) * step : eye_azimuth;
            const AzimuthPlace between = place(direction_at(0, azimuth));
            double& most = worst[size(k)];
            for (const std::size_t node : tested)
                most = std::max(
                    most, difference(light_at(node_radius[node], azimuth), at(between, node)));
        });
        if (std::ranges::max(worst) <= accuracy) return;
    }
}

Rgb3 RingOrders::at(const AzimuthPlace& place, std::size_t node) const {
    return place.interpolated(&grid_[node * azimuth_count_]);
}

Rgb3 RingOrders::light(const AzimuthPlace& place, double radius) const {
    const std::size_t interval = interval_with(radius_, radius);
    const double t = (radius - radius_[interval]) / (radius_[interval + 1] - radius_[interval]);
    return parabola(at(place, 2 * interval), at(place, 2 * interval + 1),
                    at(place, 2 * interval + 2), t);
}

}  // namespace stratus
