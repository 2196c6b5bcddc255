// Tables filled from a function, for tests of lookups.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/lookup.h>
#include <stratus/table/metadata.h>
#include <stratus/table/packed_table.h>
#include <stratus/table/table.h>

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace stratus {

/// Where a sample stands.
struct SamplePoint {
    double albedo, optical_depth, mu_in, mu_out, azimuth;
};

/// Samples along each axis.
struct Counts {
    int albedo, optical_depth, mu_in, mu_out, azimuth;
};

struct Depths {
    double lowest, highest;
    bool and_infinity;
};

constexpr Geometry three_geometries[] = {{0.3, 0.8, 0.4}, {1, 0.05, 2}, {0.6, 0.6, 3.1}};

constexpr double small_table_tolerance = 1e-3;
constexpr double small_table_length = 0.7;

/// A diffusion exponent that a cubic in sqrt(1 - albedo) follows exactly.
inline double small_table_exponent(double albedo) { return 1.1 * std::sqrt(1 - albedo); }

/// The coordinate in which cosines are sampled.
inline double cosine_coordinate(double mu) { return std::asin(std::sqrt(std::sqrt(mu))); }

inline Axis axis_of(AxisScale scale, double lowest, double highest, int count) {
    return make_axis(scale, count == 1 ? highest : lowest, highest, count);
}

/// Albedo 0.19 to 1, cosines 0.01 to 1, azimuth 0 to pi; not yet filled.
inline Table empty_table(const Counts& counts, const Depths& depths) {
    Table table;
    table.phase_function = PhaseFunction::henyey_greenstein(0.3);
    table.albedo = axis_of(AxisScale::square_root_of_complement, 0.19, 1, counts.albedo);
    const double lowest = counts.optical_depth == 1 ? depths.highest : depths.lowest;
    table.optical_depth = make_axis(AxisScale::logarithmic, lowest, depths.highest,
                                    counts.optical_depth, depths.and_infinity);
    table.mu_in = axis_of(AxisScale::arcsine_of_fourth_root, 0.01, 1, counts.mu_in);
    table.mu_out = axis_of(AxisScale::arcsine_of_fourth_root, 0.01, 1, counts.mu_out);
    table.azimuth = counts.azimuth == 1 ? Axis{AxisScale::linear, {0}}
                                        : make_axis(AxisScale::linear, 0, pi, counts.azimuth);
    for (const double albedo : table.albedo.values)
        table.diffusion_exponent.push_back(small_table_exponent(albedo));
    table.extrapolation_length = small_table_length;
    return table;
}

using FunctionOfPoint = std::function<double(const SamplePoint&)>;

/// All samples of a table, in its order.
inline std::vector<SamplePoint> sample_points(const Table& table) {
    std::vector<SamplePoint> points;
    points.reserve(table.sample_count());
    for (const double w : table.albedo.values)
        for (const double tau : table.optical_depth.values)
            for (const double mu_in : table.mu_in.values)
                for (const double mu_out : table.mu_out.values)
                    for (const double azimuth : table.azimuth.values)
                        points.push_back({w, tau, mu_in, mu_out, azimuth});
    return points;
}

inline std::vector<float> tabulate(const Table& table, const FunctionOfPoint& function) {
    std::vector<float> samples;
    for (const SamplePoint& p : sample_points(table))
        samples.push_back(static_cast<float>(function(p)));
    return samples;
}

inline Table filled(const Counts& counts, const Depths& depths, const FunctionOfPoint& reflected,
                    const FunctionOfPoint& transmitted) {
    Table table = empty_table(counts, depths);
    table.reflection_multiple = tabulate(table, reflected);
    table.transmission_multiple = tabulate(table, transmitted);
    prepare(table);
    return table;
}

/// R or T that a slice has at a geometry.
template <class Slice>
double value_of(const Slice& slice, Side side, const Geometry& at) {
    const auto in = static_cast<float>(at.mu_in), out = static_cast<float>(at.mu_out),
               azimuth = static_cast<float>(at.azimuth);
    return double{slice.scattering(side, in, out, azimuth)};
}

inline Geometry geometry(const SamplePoint& p) { return {p.mu_in, p.mu_out, p.azimuth}; }

/// R or T of a table.
inline Scattered scattering_at(const Table& table, Side side, const SamplePoint& p) {
    return scattering(table.view(), side, p.albedo, p.optical_depth, geometry(p));
}
inline Scattered scattering_at(const PackedTable& table, Side side, const SamplePoint& p) {
    return table.scattering(side, p.albedo, p.optical_depth, geometry(p));
}

/// Points as lookups of many take them: albedo, optical depth, both cosines and azimuth.
struct PointArrays {
    std::vector<float> of[5];

    explicit PointArrays(const std::vector<SamplePoint>& points) {
        for (const SamplePoint& p : points) {
            const double all[] = {p.albedo, p.optical_depth, p.mu_in, p.mu_out, p.azimuth};
            for (int q = 0; q < 5; ++q) of[q].push_back(static_cast<float>(all[q]));
        }
    }
    PackedPoints view() const {
        return {of[0].data(), of[1].data(), of[2].data(), of[3].data(), of[4].data(), of[0].size()};
    }
};

inline void set_mixture(Table& table, Axis shares) {
    table.family = {{PhaseParameter::mixture, std::move(shares), false}};
}

/// Adds the samples, fluxes and exponents of one table to those of another.
inline void append_members(Table& table, const Table& more) {
    const auto append = [](auto& all, const auto& added) {
        all.insert(all.end(), added.begin(), added.end());
    };
    for (const SampleField& field : sample_fields)
        append(table.*field.samples, more.*field.samples);
    append(table.diffusion_exponent, more.diffusion_exponent);
}

/// The table of two alike but for samples and phase function, in any mixture; the first of them at
/// mixture 1.
inline Table mixed(const Table& first, const Table& second) {
    Table table = second;
    table.phase_function = first.phase_function;
    table.second_phase_function = second.phase_function;
    table.extrapolation_length = first.extrapolation_length;
    table.extrapolation_lengths = {second.extrapolation_length, first.extrapolation_length};
    set_mixture(table, make_axis(AxisScale::linear, 0, 1, 2));
    append_members(table, first);
    prepare(table);
    return table;
}

/// What a lookup divides samples by along albedo and both cosines.
inline double small_table_incidence(const SamplePoint& p) {
    return p.albedo * intercepted_share(p.optical_depth, p.mu_in) *
           intercepted_share(p.optical_depth, p.mu_out);
}

/// All that a lookup divides samples of a side by: what is left is interpolated.
inline double small_table_scale(Side side, const SamplePoint& p) {
    const auto scale = side == Side::reflection ? reflection_scale : transmission_scale;
    return small_table_incidence(p) *
           scale(p.optical_depth, small_table_exponent(p.albedo), small_table_length);
}

/// What a lookup of a layer thinner than all samples makes of what it interpolates there: divided by
/// the growth of thin layers a line from the first depth and one an octave deeper.
inline double thin_line(const Table& table, double depth, double first = 1, double deeper = 1) {
    const double thinnest = table.optical_depth.values[0], share = 0.8 * (thinnest - depth) / thinnest;
    if (share <= 0) return first;
    return thin_growth(depth) * ((1 + share) * first / thin_growth(thinnest) -
                                 share * deeper / thin_growth(2 * thinnest));
}

/// Fills both sides with all that lookups divide by, times what they interpolate, `shape`.
inline void fill(Table& table, const FunctionOfPoint& shape) {
    const auto samples = [&](Side side) {
        return tabulate(
            table, [&](const SamplePoint& p) { return small_table_scale(side, p) * shape(p); });
    };
    table.reflection_multiple = samples(Side::reflection);
    table.transmission_multiple = samples(Side::transmission);
    prepare(table);
}

/// Between 1 and 3, smooth, even in azimuth, symmetric in the cosines.
inline double smooth_shape(const SamplePoint& p) {
    const double depth = p.optical_depth < infinity ? p.optical_depth / (1 + p.optical_depth) : 1;
    const double sines = std::sqrt((1 - p.mu_in * p.mu_in) * (1 - p.mu_out * p.mu_out));
    return 2 + 0.6 * std::sin(3 * depth + p.albedo) * std::cos(2 * (p.mu_in + p.mu_out)) +
           0.4 * sines * std::cos(p.azimuth) * (1 + p.albedo * depth) / 2;
}

/// R of the like over a lower boundary, where nothing is divided out.
inline double shape_over_boundary(const SamplePoint& p) {
    return 0.1 * smooth_shape(p) * (1 - std::exp(-p.optical_depth)) * p.albedo +
           0.05 * smooth_shape(p);
}

/// A ridge over the cosines that moves with the layer: layers have so many functions that packing takes
/// rows of the most (table/kernels/packed.h).
inline double ridge(const SamplePoint& p) {
    const double depth = p.optical_depth < infinity ? p.optical_depth / (1 + p.optical_depth) : 1,
                 across = (p.mu_in + p.mu_out) / 2 - 0.2 - 0.6 * depth - 0.2 * p.albedo;
    return 1 + std::exp(-1000 * across * across) * (2 + std::cos(p.azimuth)) / 3;
}

/// Samples that such layers take.
constexpr Counts samples_of_ridges{13, 20, 20, 20, 9};

/// A table that is all that lookups divide by, and 1 in between.
inline Table plain_table(const Counts& counts, const Depths& depths) {
    Table table = empty_table(counts, depths);
    fill(table, [](const SamplePoint&) { return 1; });
    return table;
}

/// A table over a lower boundary instead, so without transmission.
inline Table over(const LowerBoundary& boundary, Table table) {
    table.lower_boundary = boundary;
    table.transmission_multiple.clear();
    prepare(table);
    return table;
}

/// A table that is smooth along every axis, as solved ones are.
inline Table smooth_table(bool with_azimuth, AxisScale azimuth_scale = AxisScale::linear) {
    Table table = empty_table({5, 8, 20, 20, with_azimuth ? 13 : 1}, {0.1, 8, true});
    if (with_azimuth)
        table.azimuth = make_axis(azimuth_scale, 0, pi, 13);
    else
        table.phase_function = PhaseFunction::isotropic();
    table.tolerance = small_table_tolerance;
    fill(table, [](const SamplePoint& p) {
        return 1 + 0.3 * p.albedo + 0.2 * std::sqrt(p.mu_in + p.mu_out) +
               0.3 * std::sqrt((1 - p.mu_in * p.mu_in) * (1 - p.mu_out * p.mu_out)) *
                   std::cos(p.azimuth);
    });
    return table;
}

}  // namespace stratus
