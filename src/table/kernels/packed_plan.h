// Where the lookups of a packed table (packed.h) read, the weights of what they read, and what is
// known in closed form.
#pragma once

#include <stratus/layer/diffusion.h>
#include <stratus/table/kernels/packed.h>

#include "base/interpolation.h"
#include "layer/kernels/closed_form.h"
#include "phase/kernels/path_law.h"

#include <algorithm>

namespace stratus {
namespace {

constexpr int stencil_area = stencil_size * stencil_size;

/// The memory that `width` lookups read, and its weights.
template <int width>
struct Plan {
    alignas(64) float layer_weight[stencil_area][width];   // over (albedo, optical depth)
    alignas(64) float cosine_weight[stencil_area][width];  // over (mu, mu')
    alignas(64) float azimuth_weight[stencil_size][width];
    alignas(64) float single[width], along_path[width], factor[width];
    // Coefficients of lookups beyond the deepest sample.
    alignas(64) float mixed[width][stencil_size * most_functions];
    const float* coefficient[width];           // first of the stencil
    std::ptrdiff_t coefficient_stride[width];  // numbers from one albedo to the next
    const char* function[width];               // first of the stencils
    int next_mu[width];                        // rows of functions to the next mu
};

/// A coordinate on its axis: the sample before it, the first of its cubic's, and the way from there.
template <class F, class Index>
struct CubicPlace {
    Index cell, first;
    F way;
};

template <class F>
STRATUS_INLINE auto cubic_place(F place, F last) {
    const auto cell = truncated(place);
    const auto first = clamped(cell + -1, 0, truncated(last) + -3);
    return CubicPlace<F, std::remove_const_t<decltype(first)>>{cell, first,
                                                               place - as_float(first)};
}

template <class F>
using IndexOf = std::remove_const_t<decltype(truncated(F()))>;

/// Cubics along two coordinates.
template <class F>
struct CubicPlaces {
    CubicPlace<F, IndexOf<F>> a, b;
};

template <class F>
STRATUS_INLINE CubicPlaces<F> cubic_places(const PackedAxis& a, const PackedAxis& b,
                                           const Pair<F>& coordinate) {
    const auto of_axes = [&](float PackedAxis::*number) {
        return Pair<F>(F(a.*number), F(b.*number));
    };
    const Pair<F> last = of_axes(&PackedAxis::last);
    const Pair<F> along =
        (coordinate - of_axes(&PackedAxis::first)) * of_axes(&PackedAxis::inverse_step);
    const Pair<F> place = each([](auto x, auto end) { return clamped(x, 0.0f, end); }, along, last);
    if constexpr (std::is_same_v<F, float>) {
        const auto both = cubic_place(place.lanes(), last.lanes());
        return {{both.cell.v[0], both.first.v[0], both.way.v[0]},
                {both.cell.v[1], both.first.v[1], both.way.v[1]}};
    } else {
        return {cubic_place(place.first(), last.first()),
                cubic_place(place.second(), last.second())};
    }
}

constexpr float min_exponent = 1e-20f;  // of diffusion, in place of 0

/// Which coefficients an albedo and optical depth read, and their weights but for a scale.
template <class F>
struct LayerWindow {
    F of_albedo[stencil_size], of_depth[stencil_size];
    IndexOf<F> first_albedo, first_depth;
    IndexOf<F> cell;  // over (albedo, optical depth)
    F within;         // optical depth clamped to the table
    F diffusion_exponent;
};

template <class F>
STRATUS_INLINE LayerWindow<F> layer_window(const PackedSide& side, F co_albedo, F depth) {
    LayerWindow<F> at;
    const F root = square_root(maximum(co_albedo, 0.0f));
    at.within = clamped(depth, 1e-30f, side.max_depth);
    const CubicPlaces<F> places =
        cubic_places(side.albedo, side.optical_depth,
                     Pair<F>((side.fourth_root_of_albedo ? square_root(root) : root) * -1.0f,
                             binary_logarithm(at.within)));
    cubic_weights(places.a.way, at.of_albedo);
    cubic_weights(places.b.way, at.of_depth);
    at.first_albedo = places.a.first;
    at.first_depth = places.b.first;
    at.cell = places.a.cell * (truncated(side.optical_depth.last) + 1) + places.b.cell;
    F exponent(0.0f);
    for (int l = 0; l < stencil_size; ++l)
        exponent =
            exponent + at.of_albedo[l] * sample_at<F>(side.diffusion_exponent + l, at.first_albedo);
    at.diffusion_exponent = maximum(exponent, min_exponent);
    return at;
}

/// Single scattering, and what the functions' sum is to be multiplied by.
template <class F>
struct ClosedForm {
    F single, factor;
};

template <PhaseForm form, class F>
STRATUS_INLINE ClosedForm<F> closed_reflection(const PackedSide& side, F albedo, F depth,
                                               const LayerWindow<F>& layers,
                                               const LightPathOf<F>& path) {
    const ReflectedPath<F> directions(path);
    const F exponent = layers.diffusion_exponent;
    const Pair<F> depths = directions.depths(depth);
    Attenuation<F> of[4];
    attenuate({depths.first(), depths.second(), exponent * (2 * side.extrapolation_length),
               exponent * layers.within * 2.0f},
              of);
    const auto& [in, out, length, deep] = of;
    const BothWays<F> both = both_ways(in, out);
    const PhaseValues<F> phase = phase_values<form>(side.phase, path);
    const BoundaryAlbedos<float> boundary{side.surface_albedo, side.boundary_quarter_albedo};
    const F single = single_reflected<form>(directions, phase, both.sum, albedo * 0.25f, boundary);
    if (side.divided)
        return {single, both.shares * ReflectionDeficit<F>(length, deep).scale() *
                            clamped(albedo, side.min_albedo, side.max_albedo)};
    if (!side.over_surface) return {single, F(1.0f)};
    // A surface alone scatters once; what a thin layer adds is what it takes out of the beams.
    const F thinnest = sum(attenuations(directions.depths(side.min_depth)).extinguished);
    return {single, minimum((in.extinguished + out.extinguished) * reciprocal(thinnest), 1.0f)};
}

template <PhaseForm form, class F>
STRATUS_INLINE ClosedForm<F> closed_transmission(const PackedSide& side, F albedo, F optical_depth,
                                                 const LayerWindow<F>& layers,
                                                 const LightPathOf<F>& path) {
    const TransmittedPath<F> directions(path);
    const F depth = directions.depth(optical_depth), excess = directions.excess(optical_depth);
    const F exponent = layers.diffusion_exponent;
    Attenuation<F> of[4];
    attenuate({depth, excess, exponent * (2 * side.extrapolation_length), exponent * layers.within},
              of);
    const auto& [beam, more, length, deep] = of;
    return {single_transmitted(directions, phase_value<form>(side.phase, path), depth, excess, beam,
                               more, albedo * 0.25f),
            transmitted_shares(beam, more) * transmission_fall(length, deep) *
                clamped(albedo, side.min_albedo, side.max_albedo)};
}

/// The product of the shares intercepted along both directions.
STRATUS_INLINE float shares_at(float depth, float mu_in, float mu_out) {
    return attenuation(depth / mu_in).extinguished * attenuation(depth / mu_out).extinguished;
}

/// Lookup n of a plan, deeper than the last finite sample: from there to infinity reflection
/// follows the law of diffusion (lookup.h). Both are the last samples of the last block.
template <int width>
void follow_diffusion(const PackedSide& side, const LayerBlock& block, const PackedPoint& point,
                      int n, Plan<width>& plan) {
    const LayerWindow<float> at = layer_window(side, point.co_albedo, point.optical_depth);
    const int first = at.first_albedo;
    const float exponent = at.diffusion_exponent;
    const float deficit =
        ReflectionDeficit<float>(attenuation(exponent * (2 * side.extrapolation_length)),
                                 attenuation(exponent * at.within * 2.0f))
            .deficit();
    float handed_on = 0;
    float* const mixed = plan.mixed[n];
    std::fill_n(mixed, stencil_size * side.functions, 0.0f);
    for (int l = 0; l < stencil_size; ++l) {
        const float own = at.of_albedo[l], inverse = side.inverse_deficit[first + l];
        const float share = (own + handed_on) * deficit * inverse;
        handed_on = inverse == 0 ? own + handed_on : 0;
        const float* const infinite =
            block.coefficient +
            ((first + l - block.first_albedo + 1) * block.depths - 1) * side.functions;
        const float* const deepest = infinite - side.functions;
        for (int f = 0; f < side.functions; ++f)
            mixed[f] +=
                share * side.deepest_scale[first + l] * deepest[f] + (own - share) * infinite[f];
    }
    // The first row alone counts, and the scale of the finite samples does not.
    for (int s = 0; s < stencil_area; ++s) plan.layer_weight[s][n] = s == 0 ? 1.0f : 0.0f;
    plan.coefficient[n] = mixed;
    plan.coefficient_stride[n] = 0;
    if (side.divided)
        plan.factor[n] = shares_at(point.optical_depth, point.mu_in, point.mu_out) *
                         clamped(point.albedo, side.min_albedo, side.max_albedo);
}

/// Lookup n of a plan, thinner than the first sample (ThinLayers, diffusion.h).
template <int width>
void extrapolate_thin(const PackedSide& side, double depth, int n, Plan<width>& plan) {
    const ThinLayers& thin = side.thin;
    const ThinLayers::Weights weights = thin.higher_orders(depth);
    float deeper[stencil_size];
    cubic_weights(side.thin_place, deeper);
    for (int l = 0; l < stencil_size; ++l) {
        const float of_albedo = plan.layer_weight[stencil_size * l][n];
        for (int t = 0; t < stencil_size; ++t)
            plan.layer_weight[stencil_size * l + t][n] =
                of_albedo * static_cast<float>((t == 0 ? weights.of_thinnest : 0) +
                                               weights.of_deeper * double{deeper[t]});
    }
    plan.factor[n] *= static_cast<float>(thin_growth_of_samples(depth) / thin.growth);
}

/// Which function values of a block a lookup reads, and their weights.
template <class F>
struct DirectionWindow {
    IndexOf<F> mu, other_mu, first_azimuth;  // samples
    F of_mu[stencil_size], of_other[stencil_size], of_azimuth[stencil_size];
};

template <bool azimuthal, class F>
STRATUS_INLINE DirectionWindow<F> direction_window(const PackedSide& side,
                                                   const LightPathOf<F>& path, F azimuth) {
    DirectionWindow<F> at{};
    Pair<F> angles = each([](auto mu) { return mu_angle(mu) * -1.0f; }, path.mu);
    if (side.symmetric) angles = higher_first(angles);
    const CubicPlaces<F> places = cubic_places(side.mu_in, side.mu_out, angles);
    cubic_weights(places.a.way, at.of_mu);
    cubic_weights(places.b.way, at.of_other);
    at.mu = places.a.first;
    at.other_mu = places.b.first;
    if constexpr (azimuthal) {
        const float last = static_cast<float>(side.azimuths - 1) * (1 - 1e-6f);
        const F turns = magnitude(azimuth) * static_cast<float>(0.5 / pi);
        const F half_turn = magnitude(turns - whole(turns + 0.5f));  // [0, 1/2]
        const F along =
            side.square_root_of_azimuth ? square_root(half_turn * 2.0f) : half_turn * 2.0f;
        const F place =
            clamped((along - side.azimuth_first) * side.azimuth_step_inverse, 0.0f, last);
        const F cell = whole(place);
        const F first = clamped(cell - 1.0f, side.azimuth_window, side.last_azimuth_window);
        at.first_azimuth = truncated(first + 1.0f);  // a mirrored sample lies before the first
        cubic_weights(place - first, at.of_azimuth);
    }
    return at;
}

template <int count, class F, int width>
STRATUS_INLINE void store_weights(const F (&weight)[count], float (&to)[count][width], int n) {
    for (int k = 0; k < count; ++k) store(weight[k], to[k] + n);
}

/// Products of two cubics' weights.
template <class F, int width>
STRATUS_INLINE void store_products(const F (&a)[stencil_size], const F (&b)[stencil_size],
                                   float (&to)[stencil_area][width], int n) {
    if constexpr (std::is_same_v<F, float> && width == 1) {
        const auto row = load<QuantityLanes>(b);
        for (int k = 0; k < stencil_size; ++k) store(row * a[k], to[stencil_size * k]);
    } else {
        for (int k = 0; k < stencil_area; ++k)
            store(a[k / stencil_size] * b[k % stencil_size], to[k] + n);
    }
}

/// Function values of one (mu, mu').
template <bool azimuthal>
STRATUS_INLINE int values_per_pair(const PackedSide& side) {
    return azimuthal ? side.azimuths + 2 : 1;
}

STRATUS_INLINE int row_bytes(const PackedSide& side) {
    return side.functions * (side.halves ? int{sizeof(Half)} : int{sizeof(float)});
}

/// Samples that one lookup reads.
struct SampleIndices {
    std::int32_t block, first_albedo, first_depth, mu, other_mu, first_azimuth;
};

/// Where lookup n of a plan reads.
template <bool azimuthal, int width>
STRATUS_INLINE void set_addresses(const PackedSide& side, const SampleIndices& at,
                                  const PackedPoint& point, int n, Plan<width>& plan) {
    const LayerBlock& block = side.block[at.block];
    plan.coefficient[n] =
        block.coefficient +
        std::ptrdiff_t{side.functions} * ((at.first_albedo - block.first_albedo) * block.depths +
                                          at.first_depth - block.first_depth);
    plan.coefficient_stride[n] = std::ptrdiff_t{block.depths} * side.functions;
    if (point.optical_depth > side.max_finite_depth) {
        if (side.ends_at_infinity)
            follow_diffusion(side, block, point, n, plan);
        else if (side.divided && point.optical_depth > side.max_depth)  // clamped, as in lookup.h
            plan.factor[n] *= shares_at(side.max_depth, point.mu_in, point.mu_out) /
                              shares_at(point.optical_depth, point.mu_in, point.mu_out);
    } else if (side.divided && point.optical_depth < side.min_depth) {
        extrapolate_thin(side, double{point.optical_depth}, n, plan);
    }
    const int rows = values_per_pair<azimuthal>(side);
    const int row = side.symmetric ? halved(at.mu * (at.mu + 7)) * rows : at.mu * side.row_step;
    plan.function[n] =
        static_cast<const char*>(block.function) +
        static_cast<std::ptrdiff_t>(row + at.other_mu * side.column_step + at.first_azimuth) *
            row_bytes(side);
    plan.next_mu[n] = side.symmetric ? (at.mu + 4) * rows : side.row_step;
}

/// Orders n >= 2 of the path law: cubic in v = (w + w^2) / 2, with which T grows about as
/// exp(g s^2 / (s + 8) v), s the slant depth and g the side's `path_growth`: the cubic is of what is left.
template <Side which, class F>
STRATUS_INLINE F along_path(const PackedSide& side, const LightPathOf<F>& path, F albedo, F depth) {
    const PathSheetView& sheet = side.path;
    const F square = albedo * albedo,
            place = at_least(side.path_first, (albedo + square) * (0.5f * side.path_steps));
    const F first = clamped(whole(place) - 1.0f, side.path_first, side.path_steps - 3);
    F weight[stencil_size];
    cubic_weights(place - first, weight);
    const auto angle = path_angle(sheet, path);
    const auto channel = [&](int a) {
        return truncated(first - side.path_first + static_cast<float>(a)) * sheet.channel;
    };
    F sum(0.0f);
    if constexpr (which == Side::reflection) {
        const ReflectedPath<F> directions(path);
        for (int a = 0; a < stencil_size; ++a)
            sum = sum + weight[a] * path_reflected(sheet, channel(a), angle,
                                                   directions.depth_of_both(depth),
                                                   directions.reciprocal_sum);
    } else {
        const TransmittedPath<F> directions(path);
        const F slant = directions.depth(depth), excess = directions.excess(depth);
        const F growth = slant * (slant * reciprocal(slant + path_onset));
        const F rate = at_most(8.0f, growth * (side.path_growth / side.path_steps));  // over a step
        const F step = attenuation(rate).transmitted;
        for (int a = stencil_size - 1; a >= 0; --a)
            sum = sum * step + weight[a] * path_transmitted(sheet, channel(a), angle, slant, excess,
                                                            directions.shallow);
        sum = sum * reciprocal(attenuation(rate * (place - first)).transmitted);
    }
    return sum * square;
}

/// Lookups n .. n + lanes of F of a plan.
template <Side which, PhaseForm form, bool azimuthal, class F, int width>
STRATUS_INLINE void prepare(const PackedSide& side, const PackedPointOf<F>& point,
                            const LightPathOf<F>& path, const DirectionWindow<F>& directions, int n,
                            Plan<width>& plan) {
    constexpr int lanes = sizeof(F) / sizeof(float);  // NOLINT(bugprone-sizeof-expression): or one
    const F depth = clamped(point.optical_depth, 0, 1e30f);
    const LayerWindow<F> layers = layer_window(side, point.co_albedo, depth);
    store_products(layers.of_albedo, layers.of_depth, plan.layer_weight, n);
    ClosedForm<F> closed;
    if constexpr (which == Side::reflection)
        closed = closed_reflection<form>(side, point.albedo, depth, layers, path);
    else
        closed = closed_transmission<form>(side, point.albedo, depth, layers, path);
    // 0, or not-a-number where an argument is: closed forms pass cosines on.
    const F unknown =
        path.unknown + (point.albedo + at_least(0, at_most(1e30f, point.optical_depth))) * 0.0f;
    store(closed.single + unknown, plan.single + n);
    F along(0.0f);
    if (side.path.sample != nullptr) along = along_path<which>(side, path, point.albedo, depth);
    store(along, plan.along_path + n);
    store(closed.factor, plan.factor + n);

    const auto block = truncated(sample_at<F>(side.block_of_cell, layers.cell));
    store_products(directions.of_mu, directions.of_other, plan.cosine_weight, n);
    if constexpr (azimuthal) store_weights(directions.of_azimuth, plan.azimuth_weight, n);

    std::int32_t index[6][lanes];
    store(block, index[0]);
    store(layers.first_albedo, index[1]);
    store(layers.first_depth, index[2]);
    store(directions.mu, index[3]);
    store(directions.other_mu, index[4]);
    store(directions.first_azimuth, index[5]);
    float number[5][lanes];
    store(point.albedo, number[0]);
    store(point.co_albedo, number[1]);
    store(depth, number[2]);
    store(path.mu_in(), number[3]);
    store(path.mu_out(), number[4]);
    for (int k = 0; k < lanes; ++k)
        set_addresses<azimuthal>(
            side, {index[0][k], index[1][k], index[2][k], index[3][k], index[4][k], index[5][k]},
            {number[0][k], number[1][k], number[2][k], number[3][k], number[4][k], 0}, n + k, plan);
}

template <Side which, PhaseForm form, bool azimuthal, class F, int width>
STRATUS_INLINE void prepare(const PackedSide& side, const PackedPointOf<F>& point, int n,
                            Plan<width>& plan) {
    const LightPathOf<F> path = light_path<which>(point.mu_in, point.mu_out, point.azimuth);
    prepare<which, form, azimuthal>(
        side, point, path, direction_window<azimuthal>(side, path, point.azimuth), n, plan);
}

}  // namespace
}  // namespace stratus
