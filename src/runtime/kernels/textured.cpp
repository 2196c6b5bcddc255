#include "textured.h"

#include "kernels.h"
#include "lanes.h"

namespace stratus::STRATUS_ISA {
namespace {

constexpr int window = 4;  // samples of a cubic

// ---- what light.h does not ask of its lanes

STRATUS_INLINE void load(const float* from, Lookups& x) {
    __builtin_memcpy(&x.v, from, sizeof x.v);
}
STRATUS_INLINE void store(float x, float* to) { *to = x; }
STRATUS_INLINE void store(Lookups x, float* to) { __builtin_memcpy(to, &x.v, sizeof x.v); }
STRATUS_INLINE void store(std::int32_t n, std::int32_t* to) { *to = n; }
STRATUS_INLINE void store(Lookups::Ints n, std::int32_t* to) {
    __builtin_memcpy(to, &n.v, sizeof n.v);
}

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
    return larger(smaller(x, F(high)), F(low));
}

template <class F>
STRATUS_INLINE F whole(F x) {
    return as_float(truncated(x));
}

// ---- where a lookup reads

/// Lookups made ready: what to read and how to weigh it.
template <int width>
struct Plan {
    alignas(64) float layer_weight[window * window][width];  // over (albedo, optical depth)
    alignas(64) float corner_weight[4][width];
    alignas(64) float azimuth_weight[window][width];
    alignas(64) float single[width], factor[width];
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

constexpr float least_exponent = 1e-20f;  // of diffusion, in place of 0

/// diffusion.h, written with what exp keeps its relative accuracy of: numerator / denominator is
/// the deficit of reflection.
template <class F>
struct Deficit {
    F numerator, denominator;
};
template <class F>
STRATUS_INLINE Deficit<F> deficit_of(F depth, F exponent, float length) {
    const Attenuation<F> a = attenuation(exponent * (2 * length));
    const Attenuation<F> b = attenuation(exponent * depth * 2.0f);
    return {b.passed * a.taken, a.taken + b.taken - a.taken * b.taken};
}

template <class F>
STRATUS_INLINE F transmission_scale_of(F depth, F exponent, float length) {
    const Attenuation<F> c = attenuation(exponent * (depth + length));
    return exponent * (2 * length) * c.passed * inverse(c.taken * (c.passed + 1.0f));
}

/// Places of a cosine among those of a block, at a coordinate of mu_places.h.
template <class F, class Index>
STRATUS_INLINE F mu_place(const TexturedSide& side, Index block, F v) {
    const F s = clamped((v - side.v_first) * side.segments_per_v, 0, segments * (1 - 1e-6f));
    const auto segment = truncated(s);
    const Neighbours<F> at = neighbours<1>(side.place, block * (segments + 1) + segment, F());
    return at.here + (s - as_float(segment)) * (at.next - at.here);
}

/// Light scattered once, and what the functions' sum is to be multiplied by but for albedo and
/// diffusion.
template <class F>
struct Closed {
    F single, factor;
};

template <PhaseForm form, class F>
STRATUS_INLINE Closed<F> closed_reflection(const TexturedSide& side, F albedo, F depth,
                                           const LightPathOf<F>& path) {
    const F sum = path.mu_in + path.mu_out, product = path.mu_in * path.mu_out;
    const F one_for_all = inverse(sum * product);  // one division
    const F inverse_sum = one_for_all * product;
    const F inverse_in = one_for_all * sum * path.mu_out,
            inverse_out = one_for_all * sum * path.mu_in;
    const Attenuation<F> in = attenuation(inverse_in * depth);
    const Attenuation<F> out = attenuation(inverse_out * depth);
    const F shares = in.taken * out.taken;
    F curve[3];  // phase function, nothing, that of a layer beneath
    if constexpr (form == PhaseForm::composed)
        sampled_values<3>(side.phase, path, curve);
    else
        curve[0] = phase_value<form>(side.phase, path);
    F single = curve[0] * (in.taken + out.taken - shares) * inverse_sum * (albedo * 0.25f);
    if (side.divided) return {single, shares};
    const F passed = in.passed * out.passed;
    single = single + passed * side.surface_albedo;
    if constexpr (form == PhaseForm::composed)
        single = single + curve[2] * passed * inverse_sum * side.beneath_quarter;
    if (!side.over_surface) return {single, F(1.0f)};
    // A surface alone scatters once; what a thin layer adds is what it takes out of the beams.
    const F least = attenuation(inverse_in * side.lowest_depth).taken +
                    attenuation(inverse_out * side.lowest_depth).taken;
    return {single, smaller((in.taken + out.taken) * inverse(least), F(1.0f))};
}

template <PhaseForm form, class F>
STRATUS_INLINE Closed<F> closed_transmission(const TexturedSide& side, F albedo, F depth,
                                             const LightPathOf<F>& path) {
    const F one_for_both = inverse(path.mu_in * path.mu_out);
    const F steep = one_for_both * smaller(path.mu_in, path.mu_out);  // 1 / the larger cosine
    const F shallow = one_for_both * larger(path.mu_in, path.mu_out);
    const F path_depth = steep * depth;
    const Attenuation<F> beam = attenuation(path_depth);
    // The mean of exp(-x) over [0, z] knows no singularity at equal cosines.
    const F z = larger((shallow - steep) * depth, F(1e-30f));
    const F taken = attenuation(z).taken;
    const F phase = phase_value<form>(side.phase, path);
    return {phase * beam.passed * path_depth * shallow * (taken * inverse(z)) * (albedo * 0.25f),
            beam.taken * (beam.taken + beam.passed * taken)};
}

/// Which coefficients speak for an albedo and optical depth, and by how much.
template <class F>
struct LayerWindow {
    F weight[window * window];  // over (albedo, optical depth)
    F first_albedo, first_depth;
    F cell;  // over (albedo, optical depth)
};

template <Leaves leaves, class F>
STRATUS_INLINE LayerWindow<F> layer_window(const TexturedSide& side, F albedo, F co_albedo,
                                           F depth) {
    LayerWindow<F> at;
    F of_albedo[window], of_depth[window];
    const CubicPlace<F> in_albedo =
        cubic_place(side.albedo, root(larger(co_albedo, F(0.0f))) * -1.0f, of_albedo);
    const F within = clamped(depth, 1e-30f, side.deepest);
    const CubicPlace<F> in_depth =
        cubic_place(side.optical_depth, binary_logarithm(within), of_depth);
    at.first_albedo = in_albedo.first;
    at.first_depth = in_depth.first;
    at.cell = in_albedo.cell * (side.optical_depth.last + 1) + in_depth.cell;
    if (side.divided) {
        F exponent(0.0f);
        for (int l = 0; l < window; ++l)
            exponent = exponent + of_albedo[l] * sample_at(side.diffusion_exponent + l,
                                                           truncated(at.first_albedo), F());
        exponent = larger(exponent, F(least_exponent));
        F scale;
        if constexpr (leaves == Leaves::on_the_lit_side) {
            const Deficit<F> of = deficit_of(within, exponent, side.extrapolation_length);
            scale = of.denominator * inverse(of.denominator + of.numerator);
        } else {
            scale = transmission_scale_of(within, exponent, side.extrapolation_length);
        }
        scale = scale * clamped(albedo, side.lowest_albedo, side.highest_albedo);
        for (int t = 0; t < window; ++t) of_depth[t] = of_depth[t] * scale;
    }
    for (int l = 0; l < window; ++l)
        for (int t = 0; t < window; ++t) at.weight[l * window + t] = of_albedo[l] * of_depth[t];
    return at;
}

/// Between the deepest finite sample and the one at infinity reflection follows the law of
/// diffusion (lookup.h); they are the last two of the last block.
template <int width>
void follow_diffusion(const TexturedSide& side, float albedo, float co_albedo, float depth, int n,
                      Plan<width>& plan) {
    float of_albedo[window];
    const auto first =
        static_cast<int>(cubic_place(side.albedo, -root(larger(co_albedo, 0.0f)), of_albedo).first);
    float exponent = 0;
    for (int l = 0; l < window; ++l) exponent += of_albedo[l] * side.diffusion_exponent[first + l];
    const Deficit<float> of =
        deficit_of(depth, larger(exponent, least_exponent), side.extrapolation_length);
    const float deficit = of.numerator / of.denominator;
    const float factor =
        side.divided ? clamped(albedo, side.lowest_albedo, side.highest_albedo) : 1;
    float handed_on = 0;
    for (int l = 0; l < window; ++l) {
        const float inverse = side.inverse_deficit[first + l];
        const float share = (of_albedo[l] + handed_on) * deficit * inverse;
        handed_on = inverse == 0 ? of_albedo[l] + handed_on : 0;
        float(*const row)[width] = plan.layer_weight + l * window;
        row[0][n] = row[1][n] = 0;
        row[2][n] = factor * share * side.deepest_scale[first + l];
        row[3][n] = factor * (of_albedo[l] - share);
    }
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
    F in = path.mu_in, out = path.mu_out;
    F in_complement = larger(1.0f - in, F(0.0f)), out_complement = larger(1.0f - out, F(0.0f));
    take_roots(in, out, in_complement, out_complement);
    take_roots(in, out);
    in = mu_place(side, block, in_complement * (1.0f - in * 0.5f));
    out = mu_place(side, block, out_complement * (1.0f - out * 0.5f));
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
        const F place = smaller(larger(turn, turn * -1.0f) * (2 * last), F(last * (1 - 1e-6f)));
        at.first_azimuth = whole(place);
        cubic(place - at.first_azimuth + 1.0f, at.azimuth);
    }
    return at;
}

/// Lookups n .. n + lanes of F of a plan.
template <Leaves leaves, PhaseForm form, bool azimuthal, class F, int width>
STRATUS_INLINE void prepare(const TexturedSide& side, F albedo, F co_albedo, F optical_depth,
                            F mu_in, F mu_out, F azimuth, int n, Plan<width>& plan) {
    constexpr int lanes = static_cast<int>(sizeof(F) / sizeof(float));
    const F depth = clamped(optical_depth, 0, 1e30f);
    const LightPathOf<F> path = light_path<leaves>(mu_in, mu_out, azimuth);
    Closed<F> closed;
    if constexpr (leaves == Leaves::on_the_lit_side)
        closed = closed_reflection<form>(side, albedo, depth, path);
    else
        closed = closed_transmission<form>(side, albedo, depth, path);
    store(closed.single, plan.single + n);
    store(closed.factor, plan.factor + n);

    const LayerWindow<F> layers = layer_window<leaves>(side, albedo, co_albedo, depth);
    for (int s = 0; s < window * window; ++s) store(layers.weight[s], plan.layer_weight[s] + n);
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
    float depths[lanes], albedos[lanes], co_albedos[lanes];
    store(depth, depths);
    float cosines[2][lanes];
    store(path.mu_in, cosines[0]);
    store(path.mu_out, cosines[1]);
    if (side.ends_at_infinity) {
        store(albedo, albedos);
        store(co_albedo, co_albedos);
    }
    const int rows = azimuthal ? side.azimuths + 2 : 1;  // of one (mu, mu')
    for (int k = 0; k < lanes; ++k) {
        const TexturedBlock& of = side.block[block_at[k]];
        int first = first_depth[k] - of.first_depth;
        if (side.ends_at_infinity && depths[k] > side.highest_depth) {
            follow_diffusion(side, albedos[k], co_albedos[k], depths[k], n + k, plan);
            first = of.depths - window;
        } else if (side.divided && depths[k] > side.deepest) {  // clamped, as in lookup.h
            plan.factor[n + k] = attenuation(side.deepest / cosines[0][k]).taken *
                                 attenuation(side.deepest / cosines[1][k]).taken;
        }
        const int next = (mu[k] + 2) * rows;
        const FunctionRow* const function =
            of.function + (mu[k] * (mu[k] + 3) / 2 + other_mu[k]) * rows + first_azimuth[k];
        plan.coefficient[n + k] =
            of.coefficient + (first_albedo[k] - of.first_albedo) * of.depths + first;
        plan.coefficient_stride[n + k] = of.depths;
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

STRATUS_INLINE float sum_of(Lookups::Floats lanes) {
    float value[lane_width];
    __builtin_memcpy(value, &lanes, sizeof value);
    for (int half = lane_width / 2; half > 0; half /= 2)
        for (int k = 0; k < half; ++k) value[k] += value[k + half];
    return value[0];
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
        for (int l = 0; l < window; ++l)
            for (int t = 0; t < window; ++t)
                of_layers +=
                    plan.layer_weight[l * window + t][n] * words(coefficient[l * stride + t], word);
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
    return plan.factor[n] * (function_unit * sum_of(sum));
}

template <Leaves leaves, PhaseForm form, bool azimuthal>
void evaluate_one(const TexturedSide& side, const TexturedPoint& at, float* single_multiple) {
    Plan<1> plan;
    prepare<leaves, form, azimuthal>(side, at.albedo, at.co_albedo, at.optical_depth, at.mu_in,
                                     at.mu_out, at.azimuth, 0, plan);
    single_multiple[0] = plan.single[0];
    single_multiple[1] = contracted<azimuthal>(side, plan, 0);
}

template <Leaves leaves, PhaseForm form, bool azimuthal>
void prepare_many(const TexturedSide& side, const TexturedPoints& at, std::size_t first,
                  Plan<points_at_once>& plan) {
    for (int n = 0; n < points_at_once; n += lane_width) {
        const std::size_t from = first + static_cast<std::size_t>(n);
        Lookups albedo, depth, mu_in, mu_out, azimuth;
        load(at.albedo + from, albedo);
        load(at.optical_depth + from, depth);
        load(at.mu_in + from, mu_in);
        load(at.mu_out + from, mu_out);
        load(at.azimuth + from, azimuth);
        prepare<leaves, form, azimuthal>(side, albedo, 1.0f - albedo, depth, mu_in, mu_out, azimuth,
                                         n, plan);
    }
}

/// While some lookups are added up, the memory that the next ones will read is on its way.
template <Leaves leaves, PhaseForm form, bool azimuthal>
void evaluate_many(const TexturedSide& side, const TexturedPoints& at, std::size_t count,
                   float* total) {
    Plan<points_at_once> plan[2];
    constexpr auto step = static_cast<std::size_t>(points_at_once);
    if (count > 0) prepare_many<leaves, form, azimuthal>(side, at, 0, plan[0]);
    for (std::size_t first = 0; first < count; first += step) {
        const Plan<points_at_once>& now = plan[first / step % 2];
        if (first + step < count)
            prepare_many<leaves, form, azimuthal>(side, at, first + step,
                                                  plan[1 - first / step % 2]);
        for (int n = 0; n < points_at_once; ++n)
            total[first + static_cast<std::size_t>(n)] =
                now.single[n] + contracted<azimuthal>(side, now, n);
    }
}

template <Leaves leaves, PhaseForm form, bool azimuthal>
constexpr TexturedKernel kernel() {
    if constexpr (form == PhaseForm::none ||
                  (form == PhaseForm::composed && leaves == Leaves::on_the_far_side))
        return {nullptr, nullptr};
    else
        return {evaluate_one<leaves, form, azimuthal>, evaluate_many<leaves, form, azimuthal>};
}

#define STRATUS_FORM(leaves, form) \
    { kernel<leaves, form, false>(), kernel<leaves, form, true>() }
#define STRATUS_LIST(leaves)                                                                       \
    {                                                                                              \
        STRATUS_FORM(leaves, PhaseForm::none), STRATUS_FORM(leaves, PhaseForm::polynomial),        \
            STRATUS_FORM(leaves, PhaseForm::one_lobe), STRATUS_FORM(leaves, PhaseForm::two_lobes), \
            STRATUS_FORM(leaves, PhaseForm::sampled), STRATUS_FORM(leaves, PhaseForm::composed)    \
    }

}  // namespace

extern const TexturedKernels textured_kernels;
constexpr TexturedKernels textured_kernels{STRATUS_LIST(Leaves::on_the_lit_side),
                                           STRATUS_LIST(Leaves::on_the_far_side)};

}  // namespace stratus::STRATUS_ISA
