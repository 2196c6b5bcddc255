#include "ring_light.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>

#include "subjects.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace stratus {
namespace {

constexpr std::size_t least_azimuths = 24, most_azimuths = 96;
constexpr double share_of_tolerance = 0.05;
constexpr double faint = 0.01;         // light, below which errors need not be a share of it
constexpr double min_interval = 1e-6;  // planet radii

using LightAt = std::function<Rgb3(double radius, double azimuth)>;

double difference(const Rgb3& a, const Rgb3& b) noexcept {
    double worst = 0;
    for (std::size_t c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(a[c] - b[c]) / std::max(std::abs(a[c]), faint));
    return worst;
}

/// The parabola through values at 0, 1/2 and 1.
Rgb3 parabola(const Rgb3& first, const Rgb3& middle, const Rgb3& last, double t) noexcept {
    return ((1 - t) * (1 - 2 * t)) * first + (4 * t * (1 - t)) * middle + (t * (2 * t - 1)) * last;
}

/// Ends of intervals after `from` up to `to`, halved until parabolas hold.
void divide(const LightAt& light, double from, double to, double accuracy,
            std::vector<double>& ends) {
    const double middle = (from + to) / 2;
    bool holds = true;
    for (const double azimuth : {0.0, 2.0, 4.0}) {
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
    divide(light, from, middle, accuracy, ends);
    divide(light, middle, to, accuracy, ends);
}

}  // namespace

RingOrders::RingOrders(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
                       LightDetail detail)
    : azimuth_count_(least_azimuths), radius_{rings.profile.inner()} {
    const RingProfile& profile = rings.profile;
    const auto light_at = [&](double radius, double azimuth) {
        const Vector3 to_eye = to_camera(scene.camera, radius * direction_at(0, azimuth));
        const Side side =
            (scene.to_sun.z > 0) == (to_eye.z > 0) ? Side::reflection : Side::transmission;
        return light.multiple(profile.at(radius, scene.layer.albedo),
                              {side, scattering_geometry({0, 0, 1}, scene.to_sun, to_eye), 0, {}});
    };
    const double accuracy = share_of_tolerance * scene.tolerance;
    // All rows of the profile at once.
    std::vector<std::vector<double>> ends(profile.radius.size() - 1);
    parallel_for(static_cast<int>(ends.size()), threads, [&](int row) {
        const auto k = static_cast<std::size_t>(row);
        if (detail == LightDetail::sketch)
            ends[k].push_back(profile.radius[k + 1]);
        else
            divide(light_at, profile.radius[k], profile.radius[k + 1], accuracy, ends[k]);
    });
    for (const auto& some : ends) radius_.insert(radius_.end(), some.begin(), some.end());
    const auto node_radius = [&](std::size_t node) {
        const std::size_t k = node / 2;
        return node % 2 == 0 ? radius_[k] : (radius_[k] + radius_[k + 1]) / 2;
    };
    const std::size_t nodes = 2 * radius_.size() - 1;
    for (;; azimuth_count_ *= 2) {
        grid_.clear();
        if (azimuth_count_ > most_azimuths) return;
        grid_.resize(nodes * azimuth_count_);
        const double step = 2 * pi / static_cast<double>(azimuth_count_);
        std::vector<double> worst(azimuth_count_);
        parallel_for(static_cast<int>(azimuth_count_), threads, [&](int k) {
            const auto column = static_cast<std::size_t>(k);
            for (std::size_t node = 0; node < nodes; ++node)
                grid_[node * azimuth_count_ + column] = light_at(node_radius(node), k * step);
        });
        if (detail == LightDetail::sketch) return;
        parallel_for(static_cast<int>(azimuth_count_), threads, [&](int k) {
            const double azimuth = (k + 0.5) * step;
            const AzimuthPlace between = place(direction_at(0, azimuth));
            double& most = worst[static_cast<std::size_t>(k)];
            for (std::size_t node = 0; node < nodes; node += 16)
                most = std::max(
                    most, difference(light_at(node_radius(node), azimuth), at(between, node)));
        });
        if (std::ranges::max(worst) <= accuracy) return;
    }
}

Rgb3 RingOrders::at(const AzimuthPlace& place, std::size_t node) const noexcept {
    return place.interpolated(&grid_[node * azimuth_count_]);
}

Rgb3 RingOrders::light(const AzimuthPlace& place, double radius) const noexcept {
    const auto above = std::lower_bound(radius_.begin() + 1, radius_.end() - 1, radius);
    const auto interval = static_cast<std::size_t>(above - radius_.begin()) - 1;
    const double t = (radius - radius_[interval]) / (radius_[interval + 1] - radius_[interval]);
    return parabola(at(place, 2 * interval), at(place, 2 * interval + 1),
                    at(place, 2 * interval + 2), t);
}

}  // namespace stratus
