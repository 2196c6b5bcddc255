#include "ring_light.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/gauss_legendre.h>

#include "subjects.h"

#include <utility>

namespace stratus {
namespace {

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

// ---- ringlets -----------------------------------------------------------------------------------

constexpr double even_ringlets = 64;   // that bright rings share, and as many for faint ones
constexpr double faint_share = 3e-5;   // of the most light that a place returns
constexpr double narrow_share = 0.25;  // of the widest ringlet: narrower gaps are part of rings

/// Width of the widest ringlet that may begin at a radius: less where that is close to the globe.
double widest_ringlet(double radius) { return std::max(0.02, 0.1 * (radius - 1)); }

double total_width(const std::vector<Range>& radii) {
    double sum = 0;
    for (const Range& span : radii) sum += span.max - span.min;
    return sum;
}

/// Bounds of the light that is returned between neighbouring rows of a profile.
std::vector<double> returned_light(const RingProfile& profile, double to_sun) {
    std::vector<double> most;
    for (std::size_t k = 1; k < profile.radius.size(); ++k) {
        const auto of_both = [&](const auto& at_row) { return std::max(at_row(k - 1), at_row(k)); };
        most.push_back(of_both([&](std::size_t row) { return profile.w1[row] + profile.w2[row]; }) *
                       of_both([&](std::size_t row) {
                           return -std::expm1(-profile.optical_depth[row] / to_sun);
                       }));
    }
    return most;
}

/// Radii between which more than `least` light is returned. Gaps are part of them where they are narrower
/// than the ringlets.
std::vector<Range> rings_above(const RingProfile& profile, const std::vector<double>& light,
                               double least) {
    std::vector<Range> intervals;
    for (std::size_t k = 0; k < light.size(); ++k)
        if (light[k] > least) intervals.push_back({profile.radius[k], profile.radius[k + 1]});
    const double even = total_width(intervals) / even_ringlets;
    std::vector<Range> rings;
    for (const Range& next : intervals) {
        const double gap = rings.empty() ? infinity : next.min - rings.back().max;
        if (gap <= std::max(even, narrow_share * widest_ringlet(next.min)))
            rings.back().max = next.max;
        else
            rings.push_back(next);
    }
    return rings;
}

/// The parts of rings that are beside others; both ascend.
std::vector<Range> rings_beside(const std::vector<Range>& rings, const std::vector<Range>& others) {
    std::vector<Range> left;
    for (Range ring : rings) {
        for (const Range& other : others) {
            if (other.max <= ring.min || other.min >= ring.max) continue;
            if (other.min > ring.min) left.push_back({ring.min, other.min});
            ring.min = other.max;
        }
        if (ring.min < ring.max) left.push_back(ring);
    }
    return left;
}

/// Adds the ringlets into which rings are divided, of equal width or less.
void add_ringlets(const std::vector<Range>& rings, std::vector<Range>& divided) {
    const double total = total_width(rings);
    for (const Range& ring : rings) {
        const double width = ring.max - ring.min,
                     even = width / std::max(1.0, std::round(even_ringlets * width / total));
        for (double from = ring.min; from < ring.max;) {
            const double step = std::min(even, widest_ringlet(from)),
                         to = ring.max - from < 1.5 * step ? ring.max : from + step;
            divided.push_back({from, to});
            from = to;
        }
    }
}

/// Ringlets, the bright ones first, so narrow that one radius stands for each.
struct Ringlets {
    std::vector<Range> divided;
    std::size_t bright_count;
};

Ringlets divided_rings(const RingProfile& profile, double to_sun) {
    const std::vector<double> light = returned_light(profile, to_sun);
    const std::vector<Range> bright =
        rings_above(profile, light, faint_share * std::ranges::max(light));
    std::vector<Range> divided;
    add_ringlets(bright, divided);
    const std::size_t bright_ringlets = divided.size();
    add_ringlets(rings_beside(rings_above(profile, light, 0), bright), divided);
    return {divided, bright_ringlets};
}

/// Latitudes from the equator up to the last that sees any ringlet: as many as are given up to the last
/// that sees a bright one, and up to four times as many in all.
Axis latitudes_that_see(const Ringlets& rings, int bright_count) {
    double bright = 0, all = 0;
    for (std::size_t k = 0; k < rings.divided.size(); ++k) {
        all = std::max(all, std::acos(1 / rings.divided[k].max));
        if (k < rings.bright_count) bright = all;
    }
    if (all == 0) return make_axis(AxisScale::linear, 0, pi / 2, bright_count);
    const double more = std::clamp(all / bright, 1.0, 4.0);
    return make_axis(AxisScale::linear, 0, all, static_cast<int>(std::ceil(more * bright_count)));
}

}  // namespace

/// Light that leaves the rings, averaged over ringlets, for the sun's own direction: what was
/// scattered once over the phase function, which may be narrow, apart from the orders n >= 2.
struct RingShine::Light {
    Light(const Scene& scene, const Rings& rings, const LayerLight& layer,
          const std::vector<Range>& ringlets, int threads, const Counts& counts)
        : cosine_count(size(counts.cosines)),
          azimuth_count(size(counts.azimuths)),
          to_sun(std::max(std::abs(scene.to_sun.z), least_cosine)),
          divided(ringlets),
          components(scene.layer.components),
          has_more(scene.effects.multiple) {
        for (const Side side : both_sides) {
            once[side].resize(divided.size() * components.size() * cosine_count);
            if (has_more) orders[side].resize(divided.size() * cosine_count * azimuth_count);
        }
        parallel_for(int_size(divided), threads, [&](int k) {
            const std::size_t ringlet = size(k);
            const auto parts = ringlet_parts(scene, rings, ringlet, counts.profile_rows);
            if (scene.effects.single) fill_once(layer, parts, ringlet);
            if (has_more) fill_orders(layer, parts, ringlet);
        });
    }

    /// Number of parts of an interval between rows in each of which the sunlight that passes changes little.
    int part_count(const RingProfile& profile, double begin, double end) const {
        constexpr double largest_change = 0.15, narrowest = 1e-3;
        if (end - begin < narrowest) return 1;
        const auto passing = [&](double radius) {
            return std::exp(-profile.at(radius, {1, 1, 1}).optical_depth / to_sun);
        };
        const double change = std::abs(passing(end) - passing(begin));
        return std::max(1, static_cast<int>(std::ceil(change / largest_change)));
    }

    /// Matter of a ringlet, and its shares in the area.
    using Parts = std::vector<std::pair<double, Matter>>;
    Parts ringlet_parts(const Scene& scene, const Rings& rings, std::size_t ringlet,
                        bool profile_rows) const {
        const auto [from, to] = divided[ringlet];
        std::vector<double> edges{from, to};
        if (profile_rows) edges.push_back((from + to) / 2);
        for (const double radius : rings.profile.radius)
            if (profile_rows && radius > from && radius < to) edges.push_back(radius);
        std::ranges::sort(edges);
        Parts parts;
        for (std::size_t k = 1; k < edges.size(); ++k) {
            const double begin = edges[k - 1], width = edges[k] - begin;
            const int count = profile_rows ? part_count(rings.profile, begin, edges[k]) : 1;
            for (int part = 0; part < count; ++part) {
                const double middle = begin + width * (part + 0.5) / count,
                             area = middle * width / count;
                parts.emplace_back(2 * area / (to * to - from * from),
                                   rings.profile.at(middle, scene.layer.albedo));
            }
        }
        return parts;
    }

    void fill_once(const LayerLight& light, const Parts& parts, std::size_t ringlet) {
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

    void fill_orders(const LayerLight& light, const Parts& parts, std::size_t ringlet) {
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

    std::size_t orders_row(std::size_t ringlet) const {
        return ringlet * cosine_count * azimuth_count;
    }
    std::size_t once_row(std::size_t ringlet, std::size_t component) const {
        return (ringlet * components.size() + component) * cosine_count;
    }

    /// Towards a point that `towards` leads to, whose z counts up from the rings, on either side, of a
    /// sun above the x axis.
    PerSide<Rgb3> at(std::size_t ringlet, const Vector3& sun, const Vector3& towards) const {
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
    double to_sun;
    const std::vector<Range>& divided;
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
      solar_time_(make_axis(AxisScale::linear, 0, pi, sample_counts(detail).solar_times)) {
    const Counts counts = sample_counts(detail);
    const Ringlets ringlets =
        divided_rings(rings.profile, std::max(std::abs(to_sun_.z), least_cosine));
    const Light light(scene, rings, layer, ringlets.divided, threads, counts);
    latitude_ = latitudes_that_see(ringlets, counts.latitudes);
    const std::size_t latitude_count = latitude_.values.size(),
                      solar_time_count = solar_time_.values.size();
    for (const Side side : both_sides)
        for (auto& part : grid_[side]) part.resize(latitude_count * solar_time_count);
    parallel_for(int_size(latitude_.values), threads, [&](int i) {
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
    for (std::size_t ringlet = 0; ringlet < light.divided.size(); ++ringlet) {
        const double to = light.divided[ringlet].max,
                     from = std::max(light.divided[ringlet].min, 1 / std::cos(latitude));
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
