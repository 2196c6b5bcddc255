#include "ring_light.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/gauss_legendre.h>

#include "subjects.h"

#include <utility>

namespace stratus {
namespace {

constexpr int ringlets = 64;  // of equal width

/// Samples of light that leaves the rings, and of the grid.
struct Counts {
    int cosines, azimuths, latitudes, solar_times;
    bool profile_rows;  // each of them counts, else the middle of a ringlet
};
constexpr Counts sample_counts(LightDetail detail) {
    return detail == LightDetail::fine ? Counts{20, 9, 32, 25, true} : Counts{7, 4, 9, 8, false};
}

/// Number of nodes on a part of a ringlet: more where light is scattered by narrow angles.
std::size_t azimuth_nodes(const std::vector<PhaseFunction>& components) {
    const bool narrow = std::ranges::any_of(
        components, [](const PhaseFunction& each) { return each.asymmetry() > 0.6; });
    return narrow ? 12 : 6;
}

/// sum of weight * value over 4 samples.
template <class Value>
Value interpolated(const Value* values, const Stencil& stencil) {
    Value sum{};
    for (int k = 0; k < stencil_size; ++k)
        if (stencil.weight[k] != 0) sum += double{stencil.weight[k]} * values[stencil.first + k];
    return sum;
}

/// Interpolates over 4 x 4 samples; rows of `width`.
template <class Value>
Value interpolated(const Value* values, int width, const Stencil& row, const Stencil& column) {
    Value sum{};
    for (int i = 0; i < stencil_size; ++i)
        if (row.weight[i] != 0)
            sum += double{row.weight[i]} * interpolated(values + (row.first + i) * width, column);
    return sum;
}

}  // namespace

/// Light that leaves the rings, averaged over ringlets, for the sun's own direction: what was
/// scattered once over the phase function, which may be narrow, apart from the orders n >= 2.
struct RingShine::Light {
    Light(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads,
          const Counts& counts)
        : cosine_count(size(counts.cosines)),
          azimuth_count(size(counts.azimuths)),
          inner(rings.profile.inner()),
          width((rings.profile.outer() - inner) / ringlets),
          to_sun(std::max(std::abs(scene.to_sun.z), least_cosine)),
          components(scene.layer.components),
          has_more(scene.effects.multiple) {
        for (const Side side : both_sides) {
            once[side].resize(ringlets * components.size() * cosine_count);
            if (has_more) orders[side].resize(ringlets * cosine_count * azimuth_count);
        }
        parallel_for(ringlets, threads, [&](int ringlet) {
            const auto parts = ringlet_parts(scene, rings, ringlet, counts.profile_rows);
            if (scene.effects.single) fill_once(layer, parts, ringlet);
            if (has_more) fill_orders(layer, parts, ringlet);
        });
    }

    /// Matter of a ringlet, and its shares in the area.
    using Parts = std::vector<std::pair<double, Matter>>;
    Parts ringlet_parts(const Scene& scene, const Rings& rings, int ringlet,
                        bool profile_rows) const {
        const double from = inner + ringlet * width, to = from + width;
        std::vector<double> edges{from, to};
        if (profile_rows) edges.push_back(from + width / 2);
        for (const double radius : rings.profile.radius)
            if (profile_rows && radius > from && radius < to) edges.push_back(radius);
        std::ranges::sort(edges);
        Parts parts;
        for (std::size_t k = 1; k < edges.size(); ++k) {
            const double middle = (edges[k] + edges[k - 1]) / 2,
                         area = middle * (edges[k] - edges[k - 1]);
            parts.emplace_back(2 * area / (to * to - from * from),
                               rings.profile.at(middle, scene.layer.albedo));
        }
        return parts;
    }

    void fill_once(const LayerLight& light, const Parts& parts, int ringlet) {
        for (std::size_t i = 0; i < cosine_count; ++i)
            for (const auto& [part, matter] : parts)
                for (std::size_t component = 0; component < components.size(); ++component) {
                    const double mixed = component == 0 ? matter.mixture : 1 - matter.mixture;
                    for (const Side side : both_sides) {
                        if (!light.is_wanted(side)) continue;
                        Rgb3& sum = once[side][once_row(ringlet, component) + i];
                        for (std::size_t c = 0; c < 3; ++c)
                            sum[c] += part * to_sun * mixed *
                                      single_scattering(side, 1, matter.albedo[c],
                                                        light.channel_depth(matter, c), to_sun,
                                                        cosine.values[i]);
                    }
                }
    }

    void fill_orders(const LayerLight& light, const Parts& parts, int ringlet) {
        std::size_t at = orders_row(ringlet);
        for (const double mu : cosine.values)
            for (const double phi : azimuth.values) {
                // The other way round: of the table's mu_out, shine has few (needed_recipes.cpp).
                const Geometry geometry{mu, to_sun, phi};
                for (const auto& [part, matter] : parts)
                    for (const Side side : both_sides)
                        orders[side][at] +=
                            part * to_sun *
                            light.multiple(matter, {side, geometry, 0, {}}, LightPath::shine);
                ++at;
            }
    }

    std::size_t orders_row(int ringlet) const {
        return size(ringlet) * cosine_count * azimuth_count;
    }
    std::size_t once_row(int ringlet, std::size_t component) const {
        return (size(ringlet) * components.size() + component) * cosine_count;
    }

    /// Towards a point that `towards` leads to, whose z counts up from the rings, on either side, of a
    /// sun above the x axis.
    PerSide<Rgb3> at(int ringlet, const Vector3& sun, const Vector3& towards) const {
        const Stencil along = cosine_view.stencil(towards.z);
        PerSide<Rgb3> sum;
        for (const Side side : both_sides) {
            const double sign = side == Side::transmission ? 1 : -1,
                         scattering = sign * sun.z * towards.z - sun.x * towards.x;
            for (std::size_t k = 0; k < components.size(); ++k)
                sum[side] += components[k](scattering) *
                             interpolated(&once[side][once_row(ringlet, k)], along);
        }
        if (!has_more) return sum;
        const Stencil around =
            azimuth_view.mirrored_stencil(std::atan2(std::abs(towards.y), -towards.x));
        for (const Side side : both_sides)
            sum[side] +=
                interpolated(&orders[side][orders_row(ringlet)], azimuth_view.count, along, around);
        return sum;
    }

    std::size_t cosine_count, azimuth_count;
    double inner, width, to_sun;
    const std::vector<PhaseFunction>& components;
    bool has_more;
    Axis cosine =
             make_axis(AxisScale::arcsine_of_fourth_root, 1e-3, 1, static_cast<int>(cosine_count)),
         azimuth = make_axis(AxisScale::linear, 0, pi, static_cast<int>(azimuth_count));
    AxisView cosine_view = cosine.view(), azimuth_view = azimuth.view();
    GaussLegendre gauss{azimuth_nodes(components)};
    // Over ringlet, component and cosine; over ringlet, cosine and azimuth.
    PerSide<std::vector<Rgb3>> once, orders;
};

RingShine::RingShine(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads,
                     LightDetail detail)
    : to_sun_(scene.to_sun),
      sun_azimuth_(std::atan2(to_sun_.y, to_sun_.x)),
      flattening_(rings.flattening),
      shadows_(scene.effects.shadows),
      latitude_(make_axis(AxisScale::linear, 0, std::acos(1 / rings.profile.outer()),
                          sample_counts(detail).latitudes)),
      solar_time_(make_axis(AxisScale::linear, 0, pi, sample_counts(detail).solar_times)) {
    const Counts counts = sample_counts(detail);
    const Light light(scene, rings, layer, threads, counts);
    const auto solar_time_count = size(counts.solar_times);
    for (const Side side : both_sides)
        for (auto& part : grid_[side]) part.resize(size(counts.latitudes) * solar_time_count);
    parallel_for(counts.latitudes, threads, [&](int i) {
        const auto row = size(i);
        for (std::size_t k = 0; k < solar_time_count; ++k) {
            const auto sides = integrals(light, latitude_.values[row], solar_time_.values[k]);
            for (const Side side : both_sides)
                for (std::size_t part = 0; part < parts; ++part)
                    grid_[side][part][row * solar_time_count + k] = sides[side][part];
        }
    });
}

PerSide<RingShine::Sources> RingShine::integrals(const Light& light, double latitude,
                                                 double solar_time) const {
    const GaussLegendre& gauss = light.gauss;
    const double pole = 1 - flattening_;
    const Vector3 sun{std::hypot(to_sun_.x, to_sun_.y), 0, std::abs(to_sun_.z)};  // z > 0 is lit
    // The point above the rings stands for those on either side.
    const Vector3 point{std::cos(latitude) * std::cos(solar_time),
                        std::cos(latitude) * std::sin(solar_time), pole * std::sin(latitude)};
    const Vector3 normal = globe_normal(point, flattening_);
    // A point is in shadow where, stretched along z until the globe is a sphere, it is within 1 of
    // the line from the globe's centre away from the sun.
    const double stretched = sun.x * sun.x + sun.z * sun.z / (pole * pole);
    PerSide<Sources> sources;
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
            const std::size_t part = begin < solar_time ? 0 : 1;
            for (std::size_t k = 0; begin < end && k < gauss.x.size(); ++k) {
                const double azimuth = begin + (end - begin) * (1 + gauss.x[k]) / 2;
                const Vector3 v =
                    Vector3{radius * std::cos(azimuth), radius * std::sin(azimuth), 0} - point;
                const double inverse = 1 / length(v);
                const double area = radius * (to - from) * gauss.weight[k] * (end - begin) / 2;
                const double cosines = dot(normal, v) * std::abs(v.z) * inverse * inverse;
                const double weight = area * cosines * inverse * inverse / pi;
                const PerSide<Rgb3> sides = light.at(ringlet, sun, -inverse * v);
                for (const Side side : both_sides) {
                    const Rgb3 irradiance = weight * sides[side];
                    sources[side][part] +=
                        LightSource{brightness(irradiance) * inverse * v, irradiance};
                }
            }
        }
    }
    return sources;
}

RingShine::Sources RingShine::sources(const Vector3& point) const {
    const AxisView latitudes = latitude_.view(), solar_times = solar_time_.view();
    const double latitude =
        std::atan2(std::abs(point.z) / (1 - flattening_), std::hypot(point.x, point.y));
    if (latitude >= latitudes.highest) return {};
    const double time = std::remainder(std::atan2(point.y, point.x) - sun_azimuth_, 2 * pi);
    const Stencil along = latitudes.stencil(latitude),
                  around = solar_times.mirrored_stencil(std::abs(time));
    const Vector3 sun = direction_at(0, sun_azimuth_),
                  aside = direction_at(0, sun_azimuth_ + pi / 2);
    Sources sources;
    for (std::size_t part = 0; part < parts; ++part) {
        const auto& grid = grid_[side_of_plane(to_sun_, point)][part];
        sources[part] = interpolated(grid.data(), solar_times.count, along, around);
        for (double& channel : sources[part].irradiance)
            channel = std::max(0.0, channel);  // cubics swing below 0 beside darkness
        Vector3& v = sources[part].direction;
        v = v.x * sun + (time < 0 ? -v.y : v.y) * aside + Vector3{0, 0, point.z < 0 ? -v.z : v.z};
    }
    return sources;
}

}  // namespace stratus
