#include "textured.h"

#include "kernels.h"
#include "lanes.h"

#include <utility>

namespace stratus::STRATUS_ISA {
namespace {

// ---- what light.h does not ask of its lanes

/// x = 2^exponent mantissa, the mantissa in [sqrt(1/2), sqrt(2)); x > 0 and normal.
template <class F>
struct Split {
    F exponent, mantissa;
};
constexpr std::int32_t bits_of_root_half = 0x3f3504f3;
STRATUS_INLINE Split<float> split(float x) {
    std::int32_t bits;
    __builtin_memcpy(&bits, &x, sizeof bits);
    const std::int32_t n = (bits - bits_of_root_half) >> 23;
    bits -= n * (1 << 23);
    Split<float> parts{static_cast<float>(n), 0};
    __builtin_memcpy(&parts.mantissa, &bits, sizeof bits);
    return parts;
}
STRATUS_INLINE Split<Lookups> split(Lookups x) {
    using Bits = decltype(Lookups::Ints::v);
    const Bits bits = reinterpret_cast<Bits>(x.v);
    const Bits n = (bits - bits_of_root_half) >> 23;
    return {as_float(Lookups::Ints{n}),
            Lookups(reinterpret_cast<Lookups::Floats>(bits - (n << 23)))};
}

/// Accuracy 2e-7 of the larger of the result and 1.
template <class F>
STRATUS_INLINE F binary_logarithm(F x) {
    const Split<F> parts = split(x);
    // artanh series, |s| < 0.172
    const F s = (parts.mantissa - 1.0f) * inverse(parts.mantissa + 1.0f);
    const F q = s * s;
    return parts.exponent +
           s * (q * (q * (q * 0.41219859f + 0.57707802f) + 0.96179669f) + 2.88539008f);
}

template <class F>
STRATUS_INLINE F clamped(F x, float low, float high) {
    return larger(smaller(x, high), low);
}

template <class F>
STRATUS_INLINE F whole(F x) {
    return as_float(truncated(x));
}

// ---- where a lookup reads

/// Lookups made ready: what to read and how to weigh it.
template <int width>
struct Plan {
    alignas(64) float albedo_weight[window][width];
    alignas(64) float depth_weight[window][width];
    alignas(64) float corner_weight[4][width];
    alignas(64) float azimuth_weight[window][width];
    alignas(64) float single[width], factor[width];
    CoefficientRow mixed[width][window];       // of lookups beyond the deepest sample
    const CoefficientRow* coefficient[width];  // first of the window
    int coefficient_stride[width];             // from one albedo to the next
    const FunctionRow* function[width];        // (mu, mu') of both places, first azimuth
    int next_mu[width];                        // rows to the next mu
};

/// Weights of the cubic through the samples at 0, 1, 2 and 3.
template <class F>
STRATUS_INLINE void cubic(F t, F* weight) {
    const F a = t - 1.0f, b = t - 2.0f, c = t - 3.0f;
    const F bc = b * c * (1 / 6.0f), ta = t * a * (1 / 6.0f);
    weight[0] = a * bc * -1.0f;
    weight[1] = t * bc * 3.0f;
    weight[2] = ta * c * -3.0f;
    weight[3] = ta * b;
}
STRATUS_INLINE void cubic(float t, float* weight) {  // the same, side by side
    using Four = Channels::Floats;
    const Four all = (t - Four{1, 0, 0, 0}) * (t - Four{2, 2, 1, 1}) * (t - Four{3, 3, 3, 2}) *
                     Four{-1 / 6.0f, 0.5f, -0.5f, 1 / 6.0f};
    __builtin_memcpy(weight, &all, sizeof all);
}

/// Where a coordinate is on an axis: the sample before it, the first of its window.
template <class F>
struct CubicPlace {
    F cell, first;
};

template <class F>
STRATUS_INLINE CubicPlace<F> cubic_place(const TexturedAxis& axis, F coordinate, F* weight) {
    const F place = clamped((coordinate - axis.first) * axis.inverse_step, 0, axis.last);
    const F cell = whole(place), first = clamped(cell - 1.0f, 0, axis.last - 3);
    cubic(place - first, weight);
    return {cell, first};
}

constexpr float min_exponent = 1e-20f;  // of diffusion, in place of 0

/// Places of a cosine among those of a block, at a coordinate of mu_places.h.
template <class F, class Index>
STRATUS_INLINE F mu_place(const TexturedSide& side, Index block, F v) {
    const F s = clamped((v - side.v_first) * side.segments_per_v, 0, segments * (1 - 1e-6f));
    const auto segment = truncated(s);
    const Neighbours<F> at = neighbours<1>(side.place, block * (segments + 1) + segment, F());
    return at.here + (s - as_float(segment)) * (at.next - at.here);
}

/// Which coefficients speak for an albedo and optical depth, and by how much but for their scale.
template <class F>
struct LayerWindow {
    F of_albedo[window], of_depth[window];
    F first_albedo, first_depth;
    F cell;    // over (albedo, optical depth)
    F within;  // optical depth clamped to the table
    F diffusion_exponent;
};

template <class F>
STRATUS_INLINE LayerWindow<F> layer_window(const TexturedSide& side, F co_albedo, F depth) {
    LayerWindow<F> at;
    const CubicPlace<F> in_albedo =
        cubic_place(side.albedo, root(larger(co_albedo, 0.0f)) * -1.0f, at.of_albedo);
    at.within = clamped(depth, 1e-30f, side.deepest);
    const CubicPlace<F> in_depth =
        cubic_place(side.optical_depth, binary_logarithm(at.within), at.of_depth);
    at.first_albedo = in_albedo.first;
    at.first_depth = in_depth.first;
    at.cell = in_albedo.cell * (side.optical_depth.last + 1) + in_depth.cell;
    F exponent(0.0f);
    for (int l = 0; l < window; ++l)
        exponent = exponent + at.of_albedo[l] * sample_at(side.diffusion_exponent + l,
                                                          truncated(at.first_albedo), F());
    at.diffusion_exponent = larger(exponent, min_exponent);
    return at;
}

/// Light scattered once, and what the functions' sum is to be multiplied by.
template <class F>
struct Closed {
    F single, factor;
};

/// The scales are those of diffusion.h, written with what exp keeps its relative accuracy of.
template <PhaseForm form, class F>
STRATUS_INLINE Closed<F> closed_reflection(const TexturedSide& side, F albedo, F depth,
                                           const LayerWindow<F>& layers,
                                           const LightPathOf<F>& path) {
    const F sum = path.mu_in + path.mu_out, product = path.mu_in * path.mu_out;
    const F one_for_all = inverse(sum * product);  // one division
    const F inverse_sum = one_for_all * product;
    const F inverse_in = one_for_all * sum * path.mu_out,
            inverse_out = one_for_all * sum * path.mu_in;
    const F exponent = layers.diffusion_exponent;
    Attenuation<F> of[4];
    take_attenuations({inverse_in * depth, inverse_out * depth,
                       exponent * (2 * side.extrapolation_length), exponent * layers.within * 2.0f},
                      of);
    const Attenuation<F>&in = of[0], &out = of[1], &length = of[2], &twice = of[3];
    const F shares = in.extinguished * out.extinguished;
    F curve[3];  // phase function, nothing, that of a layer beneath
    if constexpr (form == PhaseForm::composed)
        sampled_values<3>(side.phase, path, curve);
    else
        curve[0] = phase_value<form>(side.phase, path);
    F single =
        curve[0] * (in.extinguished + out.extinguished - shares) * inverse_sum * (albedo * 0.25f);
    if (side.divided) {
        const F whole =
            length.extinguished + twice.extinguished - length.extinguished * twice.extinguished;
        const F scale = whole * inverse(whole + twice.transmitted * length.extinguished);
        return {single, shares * scale * clamped(albedo, side.lowest_albedo, side.highest_albedo)};
    }
    const F passed = in.transmitted * out.transmitted;
    single = single + passed * side.surface_albedo;
    if constexpr (form == PhaseForm::composed)
        single = single + curve[2] * passed * inverse_sum * side.beneath_quarter;
    if (!side.over_surface) return {single, F(1.0f)};
    // A surface alone scatters once; what a thin layer adds is what it takes out of the beams.
    const F least = attenuation(inverse_in * side.lowest_depth).extinguished +
                    attenuation(inverse_out * side.lowest_depth).extinguished;
    return {single, smaller((in.extinguished + out.extinguished) * inverse(least), 1.0f)};
}

template <PhaseForm form, class F>
STRATUS_INLINE Closed<F> closed_transmission(const TexturedSide& side, F albedo, F depth,
                                             const LayerWindow<F>& layers,
                                             const LightPathOf<F>& path) {
    const F one_for_both = inverse(path.mu_in * path.mu_out);
    const F steep = one_for_both * smaller(path.mu_in, path.mu_out);  // 1 / the larger cosine
    const F shallow = one_for_both * larger(path.mu_in, path.mu_out);
    const F exponent = layers.diffusion_exponent, path_depth = steep * depth;
    // The mean of exp(-x) over [0, z] knows no singularity at equal cosines.
    const F z = larger((shallow - steep) * depth, 1e-30f);
    Attenuation<F> of[3];
    take_attenuations({path_depth, z, exponent * (layers.within + side.extrapolation_length)}, of);
    const Attenuation<F>&beam = of[0], &more = of[1], &diffuse = of[2];
    const F scale = exponent * (2 * side.extrapolation_length) * diffuse.transmitted *
                    inverse(diffuse.extinguished * (diffuse.transmitted + 1.0f));
    const F phase = phase_value<form>(side.phase, path);
    return {phase * beam.transmitted * path_depth * shallow * (more.extinguished * inverse(z)) *
                (albedo * 0.25f),
            beam.extinguished * (beam.extinguished + beam.transmitted * more.extinguished) * scale *
                clamped(albedo, side.lowest_albedo, side.highest_albedo)};
}

/// The shares of light intercepted along both directions.
STRATUS_INLINE float shares_at(float depth, float mu_in, float mu_out) {
    return attenuation(depth / mu_in).extinguished * attenuation(depth / mu_out).extinguished;
}

/// Lookup n of a plan, deeper than the last finite sample: from there to infinity reflection
/// follows the law of diffusion (lookup.h). Those two are the last of the last block.
template <int width>
void follow_diffusion(const TexturedSide& side, const TexturedBlock& block, float albedo,
                      float co_albedo, float depth, float mu_in, float mu_out, int n,
                      Plan<width>& plan) {
    const LayerWindow<float> at = layer_window(side, co_albedo, depth);
    const auto first = static_cast<int>(at.first_albedo);
    // As reflection_deficit, diffusion.h.
    const float exponent = at.diffusion_exponent;
    const Attenuation<float> length = attenuation(exponent * (2 * side.extrapolation_length));
    const Attenuation<float> twice = attenuation(exponent * at.within * 2.0f);
    const float deficit =
        twice.transmitted * length.extinguished /
        (length.extinguished + twice.extinguished - length.extinguished * twice.extinguished);
    float handed_on = 0;
    CoefficientRow(&mixed)[window] = plan.mixed[n];
    for (CoefficientRow& row : mixed) row = {};
    for (int l = 0; l < window; ++l) {
        const float own = at.of_albedo[l], least = side.inverse_deficit[first + l];
        const float share = (own + handed_on) * deficit * least;
        handed_on = least == 0 ? own + handed_on : 0;
        const CoefficientRow* const infinite =
            block.coefficient + (first + l - block.first_albedo + 1) * block.depths - 1;
        for (int f = 0; f < functions; ++f)
            mixed[0].value[f] += share * side.deepest_scale[first + l] * infinite[-1].value[f] +
                                 (own - share) * infinite->value[f];
    }
    // The first row alone counts, and the scale of the finite samples does not.
    for (int s = 0; s < window; ++s)
        plan.albedo_weight[s][n] = plan.depth_weight[s][n] = s == 0 ? 1.0f : 0.0f;
    plan.coefficient[n] = mixed;
    plan.coefficient_stride[n] = 0;
    if (side.divided)
        plan.factor[n] = shares_at(depth, mu_in, mu_out) *
                         clamped(albedo, side.lowest_albedo, side.highest_albedo);
}

/// Which function values of a block speak for the directions, and by how much.
template <class F>
struct DirectionWindow {
    F corner[4], azimuth[window];
    F mu, other_mu, first_azimuth;  // places
};

template <bool azimuthal, class F, class Index>
STRATUS_INLINE DirectionWindow<F> direction_window(const TexturedSide& side, Index block,
                                                   const LightPathOf<F>& path, F azimuth) {
    DirectionWindow<F> at;
    const MuCoordinates<F> coordinates = mu_coordinates(path.mu_in, path.mu_out);
    const F in = mu_place(side, block, coordinates.in),
            out = mu_place(side, block, coordinates.out);
    const F high = larger(in, out), low = smaller(in, out);
    at.mu = whole(high);
    at.other_mu = whole(low);
    const F f = high - at.mu, g = low - at.other_mu;
    at.corner[3] = f * g;
    at.corner[2] = f - at.corner[3];
    at.corner[1] = g - at.corner[3];
    at.corner[0] = (1.0f - f) - at.corner[1];
    if constexpr (azimuthal) {
        const float last = static_cast<float>(side.azimuths - 1);
        const F turns = larger(azimuth, azimuth * -1.0f) * static_cast<float>(0.5 / pi);
        const F turn = turns - whole(turns + 0.5f);  // [-1/2, 1/2]
        const F place = smaller(larger(turn, turn * -1.0f) * (2 * last), last * (1 - 1e-6f));
        at.first_azimuth = whole(place);
        cubic(place - at.first_azimuth + 1.0f, at.azimuth);
    }
    return at;
}

/// Lookups n .. n + lanes of F of a plan.
template <Side which, PhaseForm form, bool azimuthal, class F, int width>
STRATUS_INLINE void prepare(const TexturedSide& side, F albedo, F co_albedo, F optical_depth,
                            F mu_in, F mu_out, F azimuth, int n, Plan<width>& plan) {
    constexpr int lanes = sizeof(F) / sizeof(float);  // NOLINT(bugprone-sizeof-expression): or one
    const F depth = clamped(optical_depth, 0, 1e30f);
    const LightPathOf<F> path = light_path<which>(mu_in, mu_out, azimuth);
    const LayerWindow<F> layers = layer_window(side, co_albedo, depth);
    for (int s = 0; s < window; ++s) {
        store(layers.of_albedo[s], plan.albedo_weight[s] + n);
        store(layers.of_depth[s], plan.depth_weight[s] + n);
    }
    Closed<F> closed;
    if constexpr (which == Side::reflection)
        closed = closed_reflection<form>(side, albedo, depth, layers, path);
    else
        closed = closed_transmission<form>(side, albedo, depth, layers, path);
    store(closed.single, plan.single + n);
    store(closed.factor, plan.factor + n);

    const auto block = truncated(sample_at(side.block_of_cell, truncated(layers.cell), F()));
    const DirectionWindow<F> directions = direction_window<azimuthal>(side, block, path, azimuth);
    for (int c = 0; c < 4; ++c) store(directions.corner[c], plan.corner_weight[c] + n);
    std::int32_t first_azimuth[lanes] = {};
    if constexpr (azimuthal) {
        for (int k = 0; k < window; ++k) store(directions.azimuth[k], plan.azimuth_weight[k] + n);
        store(truncated(directions.first_azimuth), first_azimuth);
    }

    std::int32_t block_at[lanes], first_albedo[lanes], first_depth[lanes], mu[lanes],
        other_mu[lanes];
    store(block, block_at);
    store(truncated(layers.first_albedo), first_albedo);
    store(truncated(layers.first_depth), first_depth);
    store(truncated(directions.mu), mu);
    store(truncated(directions.other_mu), other_mu);
    float depths[lanes], albedos[lanes], co_albedos[lanes], cosines[2][lanes];
    store(depth, depths);
    store(albedo, albedos);
    store(co_albedo, co_albedos);
    store(path.mu_in, cosines[0]);
    store(path.mu_out, cosines[1]);
    const int rows = azimuthal ? side.azimuths + 2 : 1;  // of one (mu, mu')
    for (int k = 0; k < lanes; ++k) {
        const TexturedBlock& of = side.block[block_at[k]];
        plan.coefficient[n + k] = of.coefficient + (first_albedo[k] - of.first_albedo) * of.depths +
                                  first_depth[k] - of.first_depth;
        plan.coefficient_stride[n + k] = of.depths;
        if (depths[k] > side.highest_depth) {
            const float mu_in_here = cosines[0][k], mu_out_here = cosines[1][k];
            if (side.ends_at_infinity)
                follow_diffusion(side, of, albedos[k], co_albedos[k], depths[k], mu_in_here,
                                 mu_out_here, n + k, plan);
            else if (side.divided && depths[k] > side.deepest)  // clamped, as in lookup.h
                plan.factor[n + k] *= shares_at(side.deepest, mu_in_here, mu_out_here) /
                                      shares_at(depths[k], mu_in_here, mu_out_here);
        }
        const int next = (mu[k] + 2) * rows;
        const FunctionRow* const function =
            of.function + (mu[k] * (mu[k] + 3) / 2 + other_mu[k]) * rows + first_azimuth[k];
        plan.function[n + k] = function;
        plan.next_mu[n + k] = next;
        if constexpr (width > 1)
            for (const int corner : {0, rows, next, next + rows}) {
                const auto* const from = reinterpret_cast<const char*>(function + corner);
                constexpr int bytes = (azimuthal ? window : 1) * int{sizeof(FunctionRow)};
                for (int line = 0; line < bytes; line += 64) __builtin_prefetch(from + line);
                __builtin_prefetch(from + bytes - 1);
            }
    }
}

// ---- what it adds up to

STRATUS_INLINE Lookups::Floats words(const CoefficientRow& row, int word) {
    Lookups::Floats values;
    __builtin_memcpy(&values, row.value + word * lane_width, sizeof values);
    return values;
}

/// The values are these times `function_unit`.
STRATUS_INLINE Lookups::Floats words(const FunctionRow& row, int word) {
#if defined(__AVX512F__)
    static_cast<void>(word);
    return _mm512_maskz_cvtph_ps(0xffff,
                                 _mm256_load_si256(reinterpret_cast<const __m256i*>(row.value)));
#else
    using Bits = decltype(Lookups::Ints::v);
    std::int16_t halves __attribute__((vector_size(2 * lane_width)));
    __builtin_memcpy(&halves, row.value + word * lane_width, sizeof halves);
    const Bits shifted = (__builtin_convertvector(halves, Bits) << half_shift) & half_mask;
    return reinterpret_cast<Lookups::Floats>(shifted);
#endif
}
#if defined(__AVX512F__)
constexpr float function_unit = 1;
#else
constexpr float function_unit = half_unit;
#endif

template <int width>
STRATUS_INLINE float sum_of(typename Register<width>::Floats lanes) {
    if constexpr (width == 4) {
        return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    } else {
        typename Register<width / 2>::Floats half[2];
        __builtin_memcpy(half, &lanes, sizeof lanes);
        return sum_of<width / 2>(half[0] + half[1]);
    }
}

/// Orders n >= 2 of lookup n of a plan.
template <bool azimuthal, int width>
STRATUS_INLINE float contracted(const TexturedSide& side, const Plan<width>& plan, int n) {
    const int rows = azimuthal ? side.azimuths + 2 : 1;
    const CoefficientRow* const coefficient = plan.coefficient[n];
    const FunctionRow* const function = plan.function[n];
    const int stride = plan.coefficient_stride[n];
    const int corner[4] = {0, rows, plan.next_mu[n], plan.next_mu[n] + rows};
    Lookups::Floats sum{};
    for (int word = 0; word < functions / lane_width; ++word) {
        Lookups::Floats of_layers{};
        for (int l = 0; l < window; ++l) {
            Lookups::Floats of_albedo{};
            for (int t = 0; t < window; ++t)
                of_albedo += plan.depth_weight[t][n] * words(coefficient[l * stride + t], word);
            of_layers += plan.albedo_weight[l][n] * of_albedo;
        }
        Lookups::Floats of_directions{};
        for (int c = 0; c < 4; ++c) {
            const FunctionRow* const at = function + corner[c];
            if constexpr (azimuthal) {
                Lookups::Floats around{};
                for (int a = 0; a < window; ++a)
                    around += plan.azimuth_weight[a][n] * words(at[a], word);
                of_directions += plan.corner_weight[c][n] * around;
            } else {
                of_directions += plan.corner_weight[c][n] * words(*at, word);
            }
        }
        sum += of_layers * of_directions;
    }
    return plan.factor[n] * (function_unit * sum_of<lane_width>(sum));
}

template <Side which, PhaseForm form, bool azimuthal>
void evaluate_one(const TexturedSide& side, const TexturedPoint& at, float* single_multiple) {
    Plan<1> plan;
    prepare<which, form, azimuthal>(side, at.albedo, at.co_albedo, at.optical_depth, at.mu_in,
                                    at.mu_out, at.azimuth, 0, plan);
    single_multiple[0] = plan.single[0];
    single_multiple[1] = contracted<azimuthal>(side, plan, 0);
}

template <Side which, PhaseForm form, bool azimuthal>
void prepare_many(const TexturedSide& side, const TexturedPoints& at, std::size_t first,
                  Plan<points_at_once>& plan) {
    for (int n = 0; n < points_at_once; n += lane_width) {
        const std::size_t from = first + static_cast<std::size_t>(n);
        const auto albedo = load<Lookups>(at.albedo + from);
        prepare<which, form, azimuthal>(
            side, albedo, 1.0f - albedo, load<Lookups>(at.optical_depth + from),
            load<Lookups>(at.mu_in + from), load<Lookups>(at.mu_out + from),
            load<Lookups>(at.azimuth + from), n, plan);
    }
}

/// While some lookups are added up, the memory that the next ones will read is on its way.
template <Side which, PhaseForm form, bool azimuthal>
void evaluate_many(const TexturedSide& side, const TexturedPoints& at, std::size_t count,
                   float* total) {
    Plan<points_at_once> plan[2];
    constexpr auto step = static_cast<std::size_t>(points_at_once);
    if (count > 0) prepare_many<which, form, azimuthal>(side, at, 0, plan[0]);
    for (std::size_t first = 0; first < count; first += step) {
        const Plan<points_at_once>& now = plan[first / step % 2];
        if (first + step < count)
            prepare_many<which, form, azimuthal>(side, at, first + step,
                                                 plan[1 - first / step % 2]);
        for (int n = 0; n < points_at_once; ++n)
            total[first + static_cast<std::size_t>(n)] =
                now.single[n] + contracted<azimuthal>(side, now, n);
    }
}

template <Side which, PhaseForm form, bool azimuthal>
constexpr TexturedKernel kernel() {
    if constexpr (form == PhaseForm::none ||
                  (form == PhaseForm::composed && which == Side::transmission))
        return {nullptr, nullptr};
    else
        return {evaluate_one<which, form, azimuthal>, evaluate_many<which, form, azimuthal>};
}

template <Side which, int... place>
constexpr TexturedSideKernels all_kernels(std::integer_sequence<int, place...>) {
    return {{kernel<which, static_cast<PhaseForm>(place / 2), place % 2 == 1>()...}};
}
template <Side which>
constexpr TexturedSideKernels all_kernels() {
    return all_kernels<which>(std::make_integer_sequence<int, 2 * phase_forms>());
}

}  // namespace

extern const TexturedKernels textured_kernels;
constexpr TexturedKernels textured_kernels{all_kernels<Side::reflection>(),
                                           all_kernels<Side::transmission>()};

}  // namespace stratus::STRATUS_ISA
