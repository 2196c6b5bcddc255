#include "ring_shine.h"

#include <stratus/bake/parallel.h>
#include <stratus/runtime/angle.h>

#include "gauss_legendre.h"
#include "subjects.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr int ringlets = 64;                               // of equal width
constexpr int cosine_count = 16, azimuth_count = 13;       // of light that leaves the rings
constexpr int latitude_count = 20, solar_time_count = 25;  // of the grid
constexpr std::size_t azimuth_nodes = 8;                   // for each part of a ringlet

/// sum of weight * value over 4 x 4 samples; rows of `width`.
Rgb3 interpolated(const Rgb3* values, int width, const Stencil& row,
                  const Stencil& column) noexcept {
    Rgb3 sum{};
    for (int i = 0; i < stencil_size; ++i)
        for (int k = 0; k < stencil_size; ++k) {
            const double weight = double{row.weight[i]} * double{column.weight[k]};
            if (weight != 0)
                sum = sum + weight * values[(row.first + i) * width + column.first + k];
        }
    return sum;
}

}  // namespace

/// Light that leaves the rings, averaged over ringlets, for the sun's own direction.
struct RingShine::Light {
    Light(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads)
        : inner(rings.profile.inner()), width((rings.profile.outer() - inner) / ringlets) {
        const double to_sun = std::abs(scene.to_sun.z);
        for (auto& side : sides)
            side.resize(static_cast<std::size_t>(ringlets * cosine_count * azimuth_count));
        parallel_for(ringlets, threads,
                     [&](int ringlet) { fill(scene, rings, layer, ringlet, to_sun); });
    }

    void fill(const Scene& scene, const Rings& rings, const LayerLight& layer, int ringlet,
              double to_sun) {
        const double from = inner + ringlet * width, to = from + width;
        std::vector<double> edges{from, from + width / 2, to};
        for (const double radius : rings.profile.radius)
            if (radius > from && radius < to) edges.push_back(radius);
        std::ranges::sort(edges);
        double area = 0;
        std::vector<std::pair<double, Matter>> parts;
        for (std::size_t k = 1; k < edges.size(); ++k) {
            const double middle = (edges[k] + edges[k - 1]) / 2,
                         part = middle * (edges[k] - edges[k - 1]);
            parts.emplace_back(part, rings.profile.at(middle, scene.layer.albedo));
            area += part;
        }
        for (int i = 0; i < cosine_count; ++i)
            for (int k = 0; k < azimuth_count; ++k) {
                const Geometry geometry{std::max(to_sun, 1e-6),
                                        cosine.values[static_cast<std::size_t>(i)],
                                        azimuth.values[static_cast<std::size_t>(k)]};
                const auto at =
                    static_cast<std::size_t>((ringlet * cosine_count + i) * azimuth_count + k);
                for (const auto& [part, matter] : parts) {
                    const double share = part / area * geometry.mu_in;
                    sides[0][at] = sides[0][at] + share * layer.transmission(matter, geometry);
                    sides[1][at] = sides[1][at] + share * layer.reflection(matter, geometry);
                }
            }
    }

    Rgb3 at(int ringlet, const Geometry& geometry, bool lit) const noexcept {
        return interpolated(
            &sides[lit][static_cast<std::size_t>(ringlet * cosine_count * azimuth_count)],
            azimuth_count, cosine_view.stencil(geometry.mu_out),
            azimuth_view.mirrored_stencil(geometry.azimuth));
    }

    double inner, width;
    Axis cosine = make_axis(AxisScale::arcsine_of_fourth_root, 1e-3, 1, cosine_count),
         azimuth = make_axis(AxisScale::linear, 0, pi, azimuth_count);
    AxisView cosine_view = cosine.view(), azimuth_view = azimuth.view();
    std::vector<Rgb3> sides[2];  // unlit and lit, over ringlet, cosine and azimuth
};

RingShine::RingShine(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads)
    : to_sun_(scene.to_sun),
      flattening_(rings.flattening),
      shadows_(scene.effects.shadows),
      latitude_(
          make_axis(AxisScale::linear, 0, std::acos(1 / rings.profile.outer()), latitude_count)),
      solar_time_(make_axis(AxisScale::linear, 0, pi, solar_time_count)) {
    const Light light(scene, rings, layer, threads);
    for (auto& side : grid_) side.resize(latitude_count * solar_time_count);
    parallel_for(latitude_count, threads, [&](int i) {
        for (std::size_t k = 0; k < solar_time_count; ++k)
            for (const bool lit : {false, true})
                grid_[lit][static_cast<std::size_t>(i) * solar_time_count + k] =
                    integral(light, latitude_.values[static_cast<std::size_t>(i)],
                             solar_time_.values[k], lit);
    });
}

Rgb3 RingShine::integral(const Light& light, double latitude, double solar_time, bool lit) const {
    static const GaussLegendre gauss(azimuth_nodes);
    const double pole = 1 - flattening_;
    const Vector3 sun{std::hypot(to_sun_.x, to_sun_.y), 0, std::abs(to_sun_.z)};  // z > 0 is lit
    const Vector3 point{std::cos(latitude) * std::cos(solar_time),
                        std::cos(latitude) * std::sin(solar_time),
                        (lit ? 1 : -1) * pole * std::sin(latitude)};
    const Vector3 normal = globe_normal(point, flattening_);
    // A point is in shadow where, stretched along z until the globe is a sphere, it is within 1 of
    // the line from the globe's centre away from the sun.
    const double stretched = sun.x * sun.x + sun.z * sun.z / (pole * pole);
    Rgb3 sum{};
    for (int ringlet = 0; ringlet < ringlets; ++ringlet) {
        const double to = light.inner + (ringlet + 1) * light.width,
                     from = std::max(to - light.width, 1 / std::cos(latitude));
        if (!(from < to)) continue;
        const double radius = (from + to) / 2;
        const double horizon = std::acos(std::min(1.0, 1 / (radius * std::cos(latitude))));
        const double shadow = std::sqrt((radius * radius - 1) * stretched) / (radius * sun.x);
        const double dark = shadows_ && shadow < 1 ? std::acos(shadow) : 0;
        // Nodes crowd at the ends of each part: near the point itself, and where light ends.
        const double low = solar_time - horizon, high = solar_time + horizon;
        const double ends[][2] = {{low, std::min(solar_time, pi - dark)},
                                  {solar_time, std::min(high, pi - dark)},
                                  {std::max(low, pi + dark), high}};
        for (const auto& [begin, end] : ends) {
            for (std::size_t k = 0; begin < end && k < azimuth_nodes; ++k) {
                const double azimuth = begin + (end - begin) * (1 + gauss.x[k]) / 2;
                const Vector3 v =
                    Vector3{radius * std::cos(azimuth), radius * std::sin(azimuth), 0} - point;
                const double inverse = 1 / length(v);
                const double area = radius * (to - from) * gauss.weight[k] * (end - begin) / 2;
                const double cosines = dot(normal, v) * std::abs(v.z) * inverse * inverse;
                const Geometry geometry = scattering_geometry({0, 0, 1}, sun, -inverse * v);
                sum = sum +
                      area * cosines * inverse * inverse / pi * light.at(ringlet, geometry, lit);
            }
        }
    }
    return sum;
}

Rgb3 RingShine::irradiance(const Vector3& point) const noexcept {
    const AxisView latitudes = latitude_.view();
    const double latitude =
        std::atan2(std::abs(point.z) / (1 - flattening_), std::hypot(point.x, point.y));
    if (latitude >= latitudes.highest) return {};
    const double solar_time = std::abs(
        std::remainder(std::atan2(point.y, point.x) - std::atan2(to_sun_.y, to_sun_.x), 2 * pi));
    const bool lit = (point.z > 0) == (to_sun_.z > 0);
    return interpolated(grid_[lit].data(), solar_time_count, latitudes.stencil(latitude),
                        solar_time_.view().mirrored_stencil(solar_time));
}

}  // namespace stratus
