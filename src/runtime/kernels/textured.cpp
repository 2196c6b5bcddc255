#include "textured.h"

#include "kernels.h"
#include "lanes.h"

namespace stratus::STRATUS_ISA {
namespace {

constexpr int window = 4;  // samples of a cubic

// ---- what light.h does not ask of its lanes

STRATUS_INLINE void load(const float* from, float& x) { x = *from; }
STRATUS_INLINE void load(const float* from, Floats& x) { __builtin_memcpy(&x.v, from, sizeof x.v); }
STRATUS_INLINE void store(float x, float* to) { *to = x; }
STRATUS_INLINE void store(Floats x, float* to) { __builtin_memcpy(to, &x.v, sizeof x.v); }
STRATUS_INLINE void store(std::int32_t n, std::int32_t* to) { *to = n; }
STRATUS_INLINE void store(Ints n, std::int32_t* to) { __builtin_memcpy(to, &n.v, sizeof n.v); }
STRATUS_INLINE float gathered(const float* samples, std::int32_t index) { return samples[index]; }

/// x = 2^exponent mantissa, the mantissa in [sqrt(1/2), sqrt(2)); x > 0 and normal.
struct SplitFloat {
    float exponent, mantissa;
};
struct SplitFloats {
    Floats exponent, mantissa;
};
constexpr std::int32_t bits_of_root_half = 0x3f3504f3;
STRATUS_INLINE SplitFloat split(float x) {
    std::int32_t bits;
    __builtin_memcpy(&bits, &x, sizeof bits);
    const std::int32_t n = (bits - bits_of_root_half) >> 23;
    bits -= n * (1 << 23);
    SplitFloat parts{static_cast<float>(n), 0};
    __builtin_memcpy(&parts.mantissa, &bits, sizeof bits);
    return parts;
}
STRATUS_INLINE SplitFloats split(Floats x) {
    const IntLanes bits = reinterpret_cast<IntLanes>(x.v);
    const IntLanes n = (bits - bits_of_root_half) >> 23;
    return {as_float(Ints{n}), Floats(reinterpret_cast<FloatLanes>(bits - (n << 23)))};
}

/// Accuracy 2e-7 of the larger of the result and 1.
template <class F>
STRATUS_INLINE F binary_logarithm(F x) {
    const auto parts = split(x);
    const F s = (parts.mantissa - 1.0f) / (parts.mantissa + 1.0f);  // artanh series, |s| < 0.172
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
    const FunctionRow* coefficient[width];  // first of the window
    int coefficient_stride[width];          // from one albedo to the next
    const FunctionRow* function[width];     // (mu, mu') of both places, first azimuth
    int next_mu[width];                     // rows to the next mu
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

/// (1 - exp(-z)) / z.
template <class F>
STRATUS_INLINE F mean_decay(F z) {
    const F safe = larger(z, F(1e-30f));
    return attenuation(safe).taken / safe;
}

template <class F>
STRATUS_INLINE F deficit_of(F depth, F exponent, float length) {  // diffusion.h
    const F reach = depth + length;
    return length / reach * attenuation(exponent * depth * 2.0f).passed *
           mean_decay(exponent * (2 * length)) / mean_decay(exponent * reach * 2.0f);
}

template <class F>
STRATUS_INLINE F transmission_scale_of(F depth, F exponent, float length) {
    const F reach = depth + length;
    const F z = exponent * reach;
    return length / reach * attenuation(z).passed / mean_decay(z * 2.0f);
}

/// Place of a cosine among those of a block.
template <class F, class Index>
STRATUS_INLINE F mu_place(const TexturedSide& side, Index block, F mu) {
    const F v = root(larger(1.0f - root(root(mu)), F(0.0f)));
    const F s = clamped((v - side.v_first) * side.segments_per_v, 0, segments * (1 - 1e-6f));
    const auto segment = truncated(s);
    const Neighbours<F> at = neighbours(side.place, block * (segments + 1) + segment, 1);
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
    const F inverse_in = 1.0f / path.mu_in, inverse_out = 1.0f / path.mu_out;
    const F inverse_sum = 1.0f / (path.mu_in + path.mu_out);
    const Attenuation<F> in = attenuation(inverse_in * depth);
    const Attenuation<F> out = attenuation(inverse_out * depth);
    const F shares = in.taken * out.taken, passed = in.passed * out.passed;
    F curve[3];  // phase function, nothing, that of a layer beneath
    if constexpr (form == PhaseForm::composed)
        sampled_values<3>(side.phase, versines_reflected(path), curve);
    else
        curve[0] = phase_value<form>(side.phase, versines_reflected(path));
    F single = curve[0] * (in.taken + out.taken - shares) * inverse_sum * albedo * 0.25f +
               passed * side.surface_albedo;
    if constexpr (form == PhaseForm::composed)
        single = single + curve[2] * passed * inverse_sum * side.beneath_quarter;
    if (side.divided) return {single, shares};
    if (!side.over_surface) return {single, F(1.0f)};
    // A surface alone scatters once; what a thin layer adds is what it takes out of the beams.
    const F least = attenuation(inverse_in * side.lowest_depth).taken +
                    attenuation(inverse_out * side.lowest_depth).taken;
    return {single,
            where_less(depth, F(side.lowest_depth), (in.taken + out.taken) / least, F(1.0f))};
}

template <PhaseForm form, class F>
STRATUS_INLINE Closed<F> closed_transmission(const TexturedSide& side, F albedo, F depth,
                                             const LightPathOf<F>& path) {
    const F inverse_in = 1.0f / path.mu_in, inverse_out = 1.0f / path.mu_out;
    const F steep = smaller(inverse_in, inverse_out), shallow = larger(inverse_in, inverse_out);
    const F path_depth = steep * depth;
    const Attenuation<F> beam = attenuation(path_depth);
    // The mean of exp(-x) over [0, z] knows no singularity at equal cosines.
    const F mean = mean_decay((shallow - steep) * depth);
    const F phase = phase_value<form>(side.phase, versines_transmitted(path));
    return {phase * beam.passed * smaller(path_depth, F(1e30f)) * shallow * mean * albedo * 0.25f,
            beam.taken * attenuation(shallow * depth).taken};
}

enum class Lit { above, below };  // R, T

/// Which coefficients speak for an albedo and optical depth, and by how much.
template <class F>
struct LayerWindow {
    F weight[window * window];  // over (albedo, optical depth)
    F first_albedo, first_depth;
    F cell;  // over (albedo, optical depth)
};

template <Lit lit, class F>
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
            exponent = exponent + of_albedo[l] * gathered(side.diffusion_exponent + l,
                                                          truncated(at.first_albedo));
        exponent = larger(exponent, F(0.0f));
        F scale;
        if constexpr (lit == Lit::above)
            scale = 1.0f / (deficit_of(within, exponent, side.extrapolation_length) + 1.0f);
        else
            scale = transmission_scale_of(within, exponent, side.extrapolation_length);
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
    const float deficit =
        deficit_of(smaller(depth, side.deepest), larger(exponent, 0.0f), side.extrapolation_length);
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
    const F in = mu_place(side, block, path.mu_in), out = mu_place(side, block, path.mu_out);
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
template <Lit lit, PhaseForm form, bool azimuthal, class F, int width>
STRATUS_INLINE void prepare(const TexturedSide& side, F albedo, F co_albedo, F optical_depth,
                            F mu_in, F mu_out, F azimuth, int n, Plan<width>& plan) {
    constexpr int lanes = static_cast<int>(sizeof(F) / sizeof(float));
    const F depth = clamped(optical_depth, 0, 1e30f);
    const LightPathOf<F> path = light_path(mu_in, mu_out, azimuth);
    Closed<F> closed;
    if constexpr (lit == Lit::above)
        closed = closed_reflection<form>(side, albedo, depth, path);
    else
        closed = closed_transmission<form>(side, albedo, depth, path);
    store(closed.single, plan.single + n);
    store(closed.factor, plan.factor + n);

    const LayerWindow<F> layers = layer_window<lit>(side, albedo, co_albedo, depth);
    for (int s = 0; s < window * window; ++s) store(layers.weight[s], plan.layer_weight[s] + n);
    const auto block = truncated(gathered(side.block_of_cell, truncated(layers.cell)));
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
            for (int a = 0; a < (azimuthal ? window : 1); ++a) {
                __builtin_prefetch(function + a);
                __builtin_prefetch(function + rows + a);
                __builtin_prefetch(function + next + a);
                __builtin_prefetch(function + next + rows + a);
            }
    }
}

// ---- what it adds up to

STRATUS_INLINE FloatLanes words(const FunctionRow& row, int word) {
    FloatLanes values;
    __builtin_memcpy(&values, row.value + word * lane_width, sizeof values);
    return values;
}

STRATUS_INLINE float sum_of(FloatLanes lanes) {
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
    const FunctionRow* const coefficient = plan.coefficient[n];
    const FunctionRow* const function = plan.function[n];
    const int stride = plan.coefficient_stride[n];
    const int corner[4] = {0, rows, plan.next_mu[n], plan.next_mu[n] + rows};
    FloatLanes sum{};
    for (int word = 0; word < functions / lane_width; ++word) {
        FloatLanes of_layers{};
        for (int l = 0; l < window; ++l)
            for (int t = 0; t < window; ++t)
                of_layers +=
                    plan.layer_weight[l * window + t][n] * words(coefficient[l * stride + t], word);
        FloatLanes of_directions{};
        for (int c = 0; c < 4; ++c) {
            const FunctionRow* const at = function + corner[c];
            if constexpr (azimuthal) {
                FloatLanes around{};
                for (int a = 0; a < window; ++a)
                    around += plan.azimuth_weight[a][n] * words(at[a], word);
                of_directions += plan.corner_weight[c][n] * around;
            } else {
                of_directions += plan.corner_weight[c][n] * words(*at, word);
            }
        }
        sum += of_layers * of_directions;
    }
    return plan.factor[n] * sum_of(sum);
}

template <Lit lit, PhaseForm form, bool azimuthal>
void evaluate_one(const TexturedSide& side, const TexturedPoint& at, float* single_multiple) {
    Plan<1> plan;
    prepare<lit, form, azimuthal>(side, at.albedo, at.co_albedo, at.optical_depth, at.mu_in,
                                  at.mu_out, at.azimuth, 0, plan);
    single_multiple[0] = plan.single[0];
    single_multiple[1] = contracted<azimuthal>(side, plan, 0);
}

template <Lit lit, PhaseForm form, bool azimuthal>
void prepare_many(const TexturedSide& side, const TexturedPoints& at, std::size_t first,
                  Plan<points_at_once>& plan) {
    for (int n = 0; n < points_at_once; n += lane_width) {
        const std::size_t from = first + static_cast<std::size_t>(n);
        Floats albedo, depth, mu_in, mu_out, azimuth;
        load(at.albedo + from, albedo);
        load(at.optical_depth + from, depth);
        load(at.mu_in + from, mu_in);
        load(at.mu_out + from, mu_out);
        load(at.azimuth + from, azimuth);
        prepare<lit, form, azimuthal>(side, albedo, 1.0f - albedo, depth, mu_in, mu_out, azimuth, n,
                                      plan);
    }
}

/// While some lookups are added up, the memory that the next ones will read is on its way.
template <Lit lit, PhaseForm form, bool azimuthal>
void evaluate_many(const TexturedSide& side, const TexturedPoints& at, std::size_t count,
                   float* total) {
    Plan<points_at_once> plan[2];
    constexpr auto step = static_cast<std::size_t>(points_at_once);
    if (count > 0) prepare_many<lit, form, azimuthal>(side, at, 0, plan[0]);
    for (std::size_t first = 0; first < count; first += step) {
        const Plan<points_at_once>& now = plan[first / step % 2];
        if (first + step < count)
            prepare_many<lit, form, azimuthal>(side, at, first + step, plan[1 - first / step % 2]);
        for (int n = 0; n < points_at_once; ++n)
            total[first + static_cast<std::size_t>(n)] =
                now.single[n] + contracted<azimuthal>(side, now, n);
    }
}

template <Lit lit, PhaseForm form, bool azimuthal>
constexpr TexturedKernel kernel() {
    if constexpr (form == PhaseForm::none || (form == PhaseForm::composed && lit == Lit::below))
        return {nullptr, nullptr};
    else
        return {evaluate_one<lit, form, azimuthal>, evaluate_many<lit, form, azimuthal>};
}

#define STRATUS_FORM(lit, form) \
    { kernel<lit, form, false>(), kernel<lit, form, true>() }
#define STRATUS_LIST(lit)                                                                    \
    {                                                                                        \
        STRATUS_FORM(lit, PhaseForm::none), STRATUS_FORM(lit, PhaseForm::polynomial),        \
            STRATUS_FORM(lit, PhaseForm::one_lobe), STRATUS_FORM(lit, PhaseForm::two_lobes), \
            STRATUS_FORM(lit, PhaseForm::sampled), STRATUS_FORM(lit, PhaseForm::composed)    \
    }

}  // namespace

extern const TexturedKernels textured_kernels;
constexpr TexturedKernels textured_kernels{STRATUS_LIST(Lit::above), STRATUS_LIST(Lit::below)};

}  // namespace stratus::STRATUS_ISA
