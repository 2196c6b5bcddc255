#include <stratus/table/lookup.h>

#include <stratus/table/packed_table.h>

#include "layer_blend.h"
#include "lookup_arguments.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace stratus {
namespace {

/// Stencils of the three directions, and where their samples lie.
struct Directions {
    Stencil in, out, azimuth;
    int in_sample[stencil_size], out_sample[stencil_size];
    int azimuth_count;
};

/// Samples of a stencil; weights beyond a short axis are 0 and point at its last sample.
void set_samples(const AxisView& axis, const Stencil& stencil,
                 int (&sample)[stencil_size]) noexcept {
    for (int i = 0; i < stencil_size; ++i) sample[i] = std::min(stencil.first + i, axis.count - 1);
}

Directions place_directions(const TableView& table, const Geometry& geometry) noexcept {
    Directions at;
    at.in = table.mu_in.stencil(geometry.mu_in);
    at.out = table.mu_out.stencil(geometry.mu_out);
    at.azimuth = table.azimuth.mirrored_stencil(geometry.azimuth);
    at.azimuth_count = used_samples(table.azimuth);
    set_samples(table.mu_in, at.in, at.in_sample);
    set_samples(table.mu_out, at.out, at.out_sample);
    return at;
}

/// Neighbouring azimuths side by side, added and scaled together: of an array g++ 12 makes four numbers, and
/// takes a quarter longer.
using Azimuths = float __attribute__((vector_size(stencil_size * sizeof(float))));

/// Sum over terms and directions; `width` is how many azimuths a stencil holds.
template <int width>
double summed(const TableView& table, const LayerBlend& blend, const Directions& at) noexcept {
    const std::ptrdiff_t in_count = table.mu_in.count, out_count = table.mu_out.count;
    const std::ptrdiff_t out_stride = table.azimuth.count, in_stride = out_stride * out_count;
    std::ptrdiff_t in_offset[stencil_size], out_offset[stencil_size];
    for (int i = 0; i < stencil_size; ++i) {
        in_offset[i] = at.in_sample[i] * in_stride + at.azimuth.first;
        out_offset[i] = at.out_sample[i] * out_stride;
    }
    Azimuths sum{};
    float in[stencil_size], out[stencil_size];
    for (int n = 0; n < blend.count; ++n) {
        const BlendTerm& term = blend.term[n];
        if (n == 0 || term.depth != blend.term[n - 1].depth) {
            const float* const in_weight = table.mu_in_weight + term.depth * in_count;
            const float* const out_weight = table.mu_out_weight + term.depth * out_count;
            for (int i = 0; i < stencil_size; ++i) {
                in[i] = at.in.weight[i] * in_weight[at.in_sample[i]];
                out[i] = at.out.weight[i] * out_weight[at.out_sample[i]];
            }
        }
        for (int i = 0; i < stencil_size; ++i) {
            const float share = term.share * in[i];
            const float* const rows = blend.samples + term.first + in_offset[i];
            const auto out_row = [&](int j) {
                Azimuths values{};
                std::memcpy(&values, rows + out_offset[j], width * sizeof(float));
                return values;
            };
            sum += share * ((out[0] * out_row(0) + out[1] * out_row(1)) +
                            (out[2] * out_row(2) + out[3] * out_row(3)));
        }
    }
    double total = 0;
    for (int k = 0; k < width; ++k) total += double{at.azimuth.weight[k]} * double{sum[k]};
    return total;
}

/// The blend's sum over directions, times what the samples were divided by along both of them.
double summed(const TableView& table, const LayerBlend& blend, const Geometry& geometry) noexcept {
    const Directions at = place_directions(table, geometry);
    const double factor = directional_factor(table, blend, geometry.mu_in, geometry.mu_out);
    switch (at.azimuth_count) {
        case 1: return factor * summed<1>(table, blend, at);
        case 2: return factor * summed<2>(table, blend, at);
        case 3: return factor * summed<3>(table, blend, at);
        default: return factor * summed<4>(table, blend, at);
    }
}

Scattered looked_up(const TableView& table, Side side, const TablePoint& point) noexcept {
    const auto& [albedo, optical_depth, geometry] = point;
    Scattered scattered{};
    if (side == Side::transmission && table.has_lower_boundary()) return scattered;
    scattered.single =
        table.is_stack()
            ? stack_single_scattering(side, *table.layers, geometry)
            : single_scattering(side, table.phase(cos_scattering_angle(side, geometry)), albedo,
                                optical_depth, geometry.mu_in, geometry.mu_out);
    if (table.has_lower_boundary() && table.lower_boundary->has_closed_form())
        scattered.single +=
            single_reflection_of_boundary(*table.lower_boundary, optical_depth, geometry);
    const bool held = table.has(side);
    if (table.packed != nullptr)
        scattered.multiple =
            table.packed->multiple(side, albedo, optical_depth, geometry, table.members);
    else if (held)
        scattered.multiple =
            summed(table, layer_blend(table, side, albedo, optical_depth), geometry);
    // The functions of a packed family leave the path law out; those of other packed tables hold it.
    if (held && (table.packed == nullptr || table.has_family()) && table.path_law != nullptr)
        scattered.multiple +=
            (*table.path_law)(side, albedo, optical_depth, geometry, table.highest_order);
    return scattered;
}

}  // namespace

Scattered scattering(const TableView& table, Side side, double albedo, double optical_depth,
                     const Geometry& geometry) noexcept {
    const TablePoint point(albedo, optical_depth, geometry);
    if (point.is_unknown()) return {double{not_a_number}, double{not_a_number}};
    return not_negative(looked_up(table, side, point));
}

double thin_layer_error(const TableView& table, Side side, double albedo, double optical_depth,
                        const Geometry& geometry) noexcept {
    const AxisView& depths = table.optical_depth;
    const double thinnest = depths.lowest;
    if (table.keeps_light() || albedo == 0 || !(optical_depth > 0 && optical_depth < thinnest))
        return 0;
    if (depths.count < 2) return 1;
    const bool over_surface = table.has_lower_boundary();
    const auto law = [&](double depth) {
        return over_surface ? share_of_thinnest(depth, thinnest, geometry.mu_in, geometry.mu_out)
                            : thin_law(table, side, albedo, depth, geometry);
    };
    const auto over_law = [&](double depth) {  // orders n >= 2, without the path law
        double multiple = scattering(table, side, albedo, depth, geometry).multiple;
        if (table.path_law != nullptr)
            multiple -= (*table.path_law)(side, albedo, depth, geometry, table.highest_order);
        return multiple / law(depth);
    };
    const double last = std::min(4 * thinnest, depths.highest), middle = std::sqrt(thinnest * last),
                 of_thinnest = over_law(thinnest), of_middle = over_law(middle);
    double expected = 0;
    if (over_surface) {
        const double octaves = std::log(thinnest / optical_depth) / std::log(middle / thinnest);
        expected = of_thinnest + octaves * (of_thinnest - of_middle);
    } else {
        const double slope = (of_middle - of_thinnest) / (middle - thinnest),
                     next_slope = (over_law(last) - of_middle) / (last - middle),
                     bend = (next_slope - slope) / (last - thinnest);
        expected =
            of_thinnest + (optical_depth - thinnest) * (slope + bend * (optical_depth - middle));
    }
    const double off = std::abs(expected - over_law(optical_depth)) * law(optical_depth),
                 total = scattering(table, side, albedo, optical_depth, geometry).total();
    return off > 0 ? off / std::max(off, total) : 0;
}

}  // namespace stratus
