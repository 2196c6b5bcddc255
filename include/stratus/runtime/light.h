// The arithmetic of a bound slice (slice.h) in single precision: closed-form single scattering and
// higher orders interpolated linearly, for effects that are known when the program is compiled.
//
// Slices call these functions through pointers that `bind` picked; a renderer that knows what it
// wants calls them itself, with nothing in between. F is float, or a class of many floats side by
// side that has the arithmetic operators and its own versions of the functions under "lanes";
// nothing here branches on a number. All functions have internal linkage: copies that were compiled
// for different processors stay apart.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include <stratus/runtime/angle.h>
#include <stratus/runtime/phase_curve.h>
#include <stratus/runtime/single_scattering.h>

namespace stratus {

/// A direction in the local frame of a surface, z along its normal; unit length, pointing away.
struct Vector {
    float x, y, z;
};

/// Directions of one scattering, as the functions below want them.
template <class F>
struct LightPathOf {
    F mu_in, mu_out;  // (0, 1]
    // 1 - cos Theta and 1 + cos Theta, each to the last bits of its small values.
    F forward, backward;
    F half_azimuth;  // sin^2(azimuth / 2), [0, 1]
};
using LightPath = LightPathOf<float>;

/// How orders n >= 2 are stored.
enum class Orders {
    none,
    without_azimuth,
    with_azimuth,
};

/// One side of a slice for `channels` colours.
template <int channels>
struct SideView {
    PhaseCurveView phase;
    static constexpr int padded = channels == 1 ? 1 : 4;
    float optical_depth[padded];   // at most 1e30
    float quarter_albedo[padded];  // w / 4
    float surface[padded];         // R of a Lambert surface beneath; 0: none
    float beneath[padded];         // w / 4 of a layer beneath; 0: none

    // Orders n >= 2 over (mu, mu', azimuth), channels innermost, with one number to spare at the
    // end. Row i over mu has mu' = 0 .. i + 1: the larger of both places comes first, R and T being
    // symmetric.
    const float* sample;
    int last_mu, azimuths;
    float mu_first, mu_step_inverse;  // place = (coordinate - first) * step_inverse
    // What samples were divided by: level + slope * (shares intercepted along both directions).
    float level, slope;
};

// ---- lanes

[[gnu::always_inline]] static inline float root(float x) { return std::sqrt(x); }
[[gnu::always_inline]] static inline float inverse(float x) { return 1 / x; }
[[gnu::always_inline]] static inline float inverse_root(float x) { return 1 / std::sqrt(x); }

/// The number of channel c, for every lane; the last argument only says for which type of lanes.
[[gnu::always_inline]] static inline float of_channel(const float* number, int c, float) {
    return number[c];
}

/// Steps of a loop over channels: one for a type whose lanes are the channels of one lookup.
template <int channels, class F>
static constexpr int channel_steps = channels;

#if defined(__SSE2__)
// Compilers like to branch, and here a branch is as good as never foreseen.
[[gnu::always_inline]] static inline float larger(float a, float b) {
    return _mm_cvtss_f32(_mm_max_ss(_mm_set_ss(a), _mm_set_ss(b)));
}
[[gnu::always_inline]] static inline float smaller(float a, float b) {
    return _mm_cvtss_f32(_mm_min_ss(_mm_set_ss(a), _mm_set_ss(b)));
}

// Four floats side by side: what one lookup wants more than once is worked out at once.
[[gnu::always_inline]] static inline __m128 pair(float a, float b) {
    return _mm_unpacklo_ps(_mm_set_ss(a), _mm_set_ss(b));
}
[[gnu::always_inline]] static inline float first(__m128 x) { return _mm_cvtss_f32(x); }
[[gnu::always_inline]] static inline float second(__m128 x) {
    return _mm_cvtss_f32(_mm_shuffle_ps(x, x, 1));
}
[[gnu::always_inline]] static inline __m128 larger(__m128 a, float b) {
    return _mm_max_ps(a, _mm_set1_ps(b));
}
[[gnu::always_inline]] static inline __m128 smaller(__m128 a, float b) {
    return _mm_min_ps(a, _mm_set1_ps(b));
}
[[gnu::always_inline]] static inline __m128 power_of_half(__m128 rounded) {
    return _mm_castsi128_ps(
        _mm_sub_epi32(_mm_set1_epi32(0x3f800000), _mm_slli_epi32(_mm_castps_si128(rounded), 23)));
}
#else
[[gnu::always_inline]] static inline float larger(float a, float b) { return a > b ? a : b; }
[[gnu::always_inline]] static inline float smaller(float a, float b) { return a < b ? a : b; }
#endif

/// Without its fraction, towards 0; |x| < 2^31.
[[gnu::always_inline]] static inline std::int32_t truncated(float x) {
    return static_cast<std::int32_t>(x);
}

[[gnu::always_inline]] static inline float as_float(std::int32_t n) {
    return static_cast<float>(n);
}

/// Added to a small number, and taken away again, it rounds: 1.5 * 2^23.
constexpr float rounding = 12582912.0f;

/// 2^-n of n + rounding, n in [0, 126]: n is in the last bits.
[[gnu::always_inline]] static inline float power_of_half(float rounded) {
    std::uint32_t bits;
    std::memcpy(&bits, &rounded, sizeof bits);
    bits = 0x3f800000u - (bits << 23);
    float power;
    std::memcpy(&power, &bits, sizeof power);
    return power;
}

[[gnu::always_inline]] static inline std::int32_t halved(std::int32_t n) { return n / 2; }

/// samples[index]; the last argument only says for which type of lanes.
[[gnu::always_inline]] static inline float sample_at(const float* samples, std::int32_t index,
                                                     float) {
    return samples[index];
}

/// samples[index] and the one `stride` further on.
template <class F>
struct Neighbours {
    F here, next;
};
template <int stride>
[[gnu::always_inline]] static inline Neighbours<float> neighbours(const float* samples,
                                                                  std::int32_t index, float) {
    return {samples[index], samples[index + stride]};
}

/// The same where all channels share the samples.
template <int stride, class F, class Index>
[[gnu::always_inline]] static inline Neighbours<F> shared_neighbours(const float* samples,
                                                                     Index index, F) {
    return neighbours<stride>(samples, index, F());
}

// ---- elementary functions

/// exp(-x) and 1 - exp(-x), each with its relative accuracy.
template <class F>
struct Attenuation {
    F transmitted, extinguished;
};

/// Range    x >= 0; beyond 80 nothing passes. Accuracy 2e-7 of either, down to 1e-28.
template <class F>
[[gnu::always_inline]] static inline Attenuation<F> attenuation(F x) {
    const F at = smaller(x, 80.0f);
    const F rounded =
        at * 1.44269504f + rounding;  // n + rounding, n the nearest number of halvings
    const F n = rounded - rounding;
    const F r = (n * 0.693359375f - at) - n * 2.12194440e-4f;  // |r| <= ln(2) / 2
    // exp(r) - 1, Taylor; in pairs, for the terms then wait less for one another.
    const F r2 = r * r;
    const F high =
        r2 * (r * 0.000198412698f + 0.00138888889f) + (r * 0.00833333333f + 0.0416666667f);
    const F p = r2 * (r2 * high + (r * 0.166666667f + 0.5f)) + r;
    const F power = power_of_half(rounded);
    const F below = power * p;
    constexpr float nothing = 1.9e-35f;  // above exp(-80), and all of it a normal number
    return {larger((power - nothing) + below, 0.0f), (1.0f - power) - below};
}

template <int n, class F>
[[gnu::always_inline]] static inline void take_attenuations(const F (&x)[n],
                                                            Attenuation<F> (&of)[n]) {
    for (int k = 0; k < n; ++k) of[k] = attenuation(x[k]);
}

#if defined(__SSE2__)
template <int n>
[[gnu::always_inline]] static inline void take_attenuations(const float (&x)[n],
                                                            Attenuation<float> (&of)[n]) {
    static_assert(n <= 4);
    const auto at = attenuation(
        _mm_setr_ps(x[0], x[1], n > 2 ? x[n > 2 ? 2 : 0] : 0, n > 3 ? x[n > 3 ? 3 : 0] : 0));
    for (int k = 0; k < n; ++k) of[k] = {at.transmitted[k], at.extinguished[k]};
}
#endif

/// sin^2(azimuth / 2) for any azimuth in radians, below a million.
template <class F>
[[gnu::always_inline]] static inline F half_azimuth_of(F azimuth) {
    // sin^2(azimuth / 2) has period 2 pi.
    const F turns = azimuth * static_cast<float>(0.5 / pi);
    const F x = (turns - ((turns + rounding) - rounding)) * static_cast<float>(pi);
    const F q = x * x, q2 = q * q;  // x = azimuth / 2 in [-pi/2, pi/2]
    const F low = q * -0.166666667f + 1.0f;
    const F high =
        (q * -0.000198412701f + 0.00833333315f) + q2 * (q * -2.50507e-8f + 2.75573137e-6f);
    const F sine = x * (q2 * high + low);
    return smaller(sine * sine, 1.0f);
}

constexpr float min_cosine = 1e-6f;  // smaller ones count as this, so that nothing is divided by 0

/// Sines of two directions with these cosines.
template <class F>
struct Sines {
    F in, out;
};

template <class F>
[[gnu::always_inline]] static inline Sines<F> sines_of(F mu_in, F mu_out) {
    return {root(larger((1.0f - mu_in) * (mu_in + 1.0f), 0.0f)),
            root(larger((1.0f - mu_out) * (mu_out + 1.0f), 0.0f))};
}

#if defined(__SSE2__)
[[gnu::always_inline]] static inline Sines<float> sines_of(float mu_in, float mu_out) {
    const __m128 mu = pair(mu_in, mu_out);
    const __m128 sine = _mm_sqrt_ps(larger((1.0f - mu) * (mu + 1.0f), 0.0f));
    return {first(sine), second(sine)};
}
#endif

template <Side which, class F>
[[gnu::always_inline]] static inline LightPathOf<F> light_path(F mu_in, F mu_out, F azimuth) {
    const Sines<F> sine = sines_of(mu_in, mu_out);
    const F half_azimuth = half_azimuth_of(azimuth);
    // Squares of half the sum and half the difference of the directions of propagation.
    const F sum = mu_in + mu_out, difference = mu_in - mu_out, along = sine.in - sine.out;
    const F sines = sine.in * sine.out * 2.0f;
    const F far = (difference * difference + along * along) * 0.5f;
    const F near = (sum * sum + along * along) * 0.5f;
    const bool lit = which == Side::reflection;
    return {larger(mu_in, min_cosine), larger(mu_out, min_cosine),
            (lit ? near : far) + sines * half_azimuth,
            (lit ? far : near) + sines * (1.0f - half_azimuth), half_azimuth};
}

/// Between two unit vectors in a frame whose z is the normal, both pointing away from the layer.
template <class F>
[[gnu::always_inline]] static inline LightPathOf<F> light_path(F xi, F yi, F zi, F xo, F yo, F zo) {
    // Light travels along -wi: its azimuth to wo has the cosine -(wi . wo) / (s s0) of both
    // vectors' horizontal parts.
    const F sines = (xi * xi + yi * yi) * (xo * xo + yo * yo);
    const F half = (xi * xo + yi * yo) * inverse_root(larger(sines, 1e-30f)) * 0.5f + 0.5f;
    const F xs = xi + xo, ys = yi + yo, zs = zi + zo, xd = xi - xo, yd = yi - yo, zd = zi - zo;
    return {larger(larger(zi, zi * -1.0f), min_cosine), larger(larger(zo, zo * -1.0f), min_cosine),
            (xs * xs + ys * ys + zs * zs) * 0.5f, (xd * xd + yd * yd + zd * zd) * 0.5f,
            larger(smaller(half, 1.0f), 0.0f)};
}

// ---- phase functions

template <class F>
[[gnu::always_inline]] static inline F lobe_value(const PhaseLobe& lobe,
                                                  const LightPathOf<F>& path) {
    const F r =
        inverse_root(path.forward * lobe.forward + (path.backward * lobe.backward + lobe.offset));
    return r * r * (r * lobe.scale);
}

/// The `width` values side by side at a scattering angle.
template <int width, class F>
[[gnu::always_inline]] static inline void sampled_values(const PhaseCurveView& curve,
                                                         const LightPathOf<F>& path, F* value) {
    const F x = (root(path.forward * 0.5f) - root(path.backward * 0.5f)) * 0.5f + 0.5f;
    // Never the last sample itself: there is one beyond each.
    const F place = larger(smaller(x, 1 - 1e-6f), 0.0f) * static_cast<float>(curve.last);
    const auto index = truncated(place);
    const F fraction = place - as_float(index);
    for (int k = 0; k < width; ++k) {
        const Neighbours<F> at = shared_neighbours<width>(curve.sample + k, index * width, F());
        value[k] = at.here + fraction * (at.next - at.here);
    }
}

template <PhaseForm form, class F>
[[gnu::always_inline]] static inline F phase_value(const PhaseCurveView& curve,
                                                   const LightPathOf<F>& path) {
    if constexpr (form == PhaseForm::sampled) {
        F value[1];
        sampled_values<1>(curve, path, value);
        return value[0];
    } else if constexpr (form == PhaseForm::constant) {
        return F(curve.polynomial[0]);
    } else {
        F value = path.forward * (path.forward * curve.polynomial[2] + curve.polynomial[1]) +
                  curve.polynomial[0];
        if constexpr (form == PhaseForm::one_lobe || form == PhaseForm::two_lobes)
            value = value + lobe_value(curve.lobe[0], path);
        if constexpr (form == PhaseForm::two_lobes) value = value + lobe_value(curve.lobe[1], path);
        return value;
    }
}

// ---- higher orders

/// sqrt(1 - mu) (1 - mu^(1/4) / 2), along which samples of cosines lie evenly.
template <class F>
[[gnu::always_inline]] static inline F mu_coordinate(F mu) {
    return root(larger(1.0f - mu, 0.0f)) * (1.0f - root(root(mu)) * 0.5f);
}

/// Of two cosines.
template <class F>
struct MuCoordinates {
    F in, out;
};

template <class F>
[[gnu::always_inline]] static inline MuCoordinates<F> mu_coordinates(F in, F out) {
    return {mu_coordinate(in), mu_coordinate(out)};
}

#if defined(__SSE2__)
[[gnu::always_inline]] static inline __m128 mu_coordinates_of_pair(__m128 mu) {
    const __m128 roots = _mm_sqrt_ps(_mm_movelh_ps(mu, larger(1.0f - mu, 0.0f)));
    return _mm_movehl_ps(roots, roots) * (1.0f - _mm_sqrt_ps(roots) * 0.5f);
}

[[gnu::always_inline]] static inline MuCoordinates<float> mu_coordinates(float in, float out) {
    const __m128 at = mu_coordinates_of_pair(pair(in, out));
    return {first(at), second(at)};
}
#endif

/// Among the samples of a slice: the sample before a place, and how far it is to the next.
template <class F, class Index>
struct Cell {
    Index sample;
    F fraction;
};

template <class F>
[[gnu::always_inline]] static inline auto cell_at(F place) {
    const auto sample = truncated(place);
    return Cell<F, std::remove_const_t<decltype(sample)>>{sample, place - as_float(sample)};
}

/// Of two cosines, the one further along the samples first.
template <class F, class Index>
struct MuCells {
    Cell<F, Index> high, low;
};

template <int channels, class F>
[[gnu::always_inline]] static inline auto mu_cells(const SideView<channels>& side, F in, F out) {
    // Never the last sample itself: there is one beyond each.
    const float last = static_cast<float>(side.last_mu) * (1 - 1e-6f);
    const MuCoordinates<F> at = mu_coordinates(in, out);
    const F a = larger(smaller((at.in - side.mu_first) * side.mu_step_inverse, last), 0.0f);
    const F b = larger(smaller((at.out - side.mu_first) * side.mu_step_inverse, last), 0.0f);
    const auto high = cell_at(larger(a, b)), low = cell_at(smaller(a, b));
    return MuCells<F, decltype(high.sample + 0)>{high, low};
}

#if defined(__SSE2__)
template <int channels>
[[gnu::always_inline]] static inline MuCells<float, std::int32_t> mu_cells(
    const SideView<channels>& side, float in, float out) {
    const float last = static_cast<float>(side.last_mu) * (1 - 1e-6f);
    const __m128 coordinates = mu_coordinates_of_pair(pair(in, out));
    const __m128 at =
        larger(smaller((coordinates - side.mu_first) * side.mu_step_inverse, last), 0.0f);
    const __m128 turned = _mm_shuffle_ps(at, at, 1);
    const __m128 sorted = _mm_unpacklo_ps(_mm_max_ss(at, turned), _mm_min_ss(at, turned));
    const __m128i cell = _mm_cvttps_epi32(sorted);
    const __m128 fraction = sorted - _mm_cvtepi32_ps(cell);
    return {{_mm_cvtsi128_si32(cell), first(fraction)},
            {_mm_cvtsi128_si32(_mm_shuffle_epi32(cell, 1)), second(fraction)}};
}
#endif

template <int channels, class F>
[[gnu::always_inline]] static inline auto azimuth_cell(const SideView<channels>& side,
                                                       F half_azimuth) {
    return cell_at(root(half_azimuth) * (static_cast<float>(side.azimuths - 1) * (1 - 1e-6f)));
}

/// Orders n >= 2 as they are stored, bilinear or trilinear.
template <Orders orders, int channels, class F>
[[gnu::always_inline]] static inline void interpolate(const SideView<channels>& side,
                                                      const LightPathOf<F>& path, F* value) {
    const auto [high, low] = mu_cells(side, path.mu_in, path.mu_out);
    const F fi = high.fraction, fj = low.fraction;
    const int azimuths = orders == Orders::with_azimuth ? side.azimuths : 1;
    const int column = azimuths * channels;
    const auto row = (halved(high.sample * (high.sample + 3)) + low.sample) * column;
    const auto next = row + (high.sample + 2) * column;
    constexpr int steps = channel_steps<channels, F>;
    if constexpr (orders == Orders::without_azimuth) {
        for (int c = 0; c < steps; ++c) {
            const F a = sample_at(side.sample + c, row, F());
            const F b = sample_at(side.sample + column + c, row, F());
            const F d = sample_at(side.sample + c, next, F());
            const F e = sample_at(side.sample + column + c, next, F());
            const F near = a + fj * (b - a), far = d + fj * (e - d);
            value[c] = near + fi * (far - near);
        }
    } else {
        const auto [k, f] = azimuth_cell(side, path.half_azimuth);
        const F w11 = fi * fj, w01 = fj - w11, w10 = fi - w11, w00 = (1.0f - fi) - w01;
        for (int c = 0; c < steps; ++c) {
            const auto at = row + k * channels, at_next = next + k * channels;
            const Neighbours<F> p = neighbours<channels>(side.sample + c, at, F());
            const Neighbours<F> q = neighbours<channels>(side.sample + column + c, at, F());
            const Neighbours<F> r = neighbours<channels>(side.sample + c, at_next, F());
            const Neighbours<F> s = neighbours<channels>(side.sample + column + c, at_next, F());
            const F near = (w00 * p.here + w01 * q.here) + (w10 * r.here + w11 * s.here);
            const F far = (w00 * p.next + w01 * q.next) + (w10 * r.next + w11 * s.next);
            value[c] = near + f * (far - near);
        }
    }
}

// ---- one side of a layer

/// R of the layer, per channel.
template <PhaseForm form, Orders orders, int channels, class F>
[[gnu::always_inline]] static inline void reflected(const SideView<channels>& side,
                                                    const LightPathOf<F>& path, F* value) {
    const F sum = path.mu_in + path.mu_out, product = path.mu_in * path.mu_out;
    const F one_for_all = inverse(sum * product);  // one division
    const F inverse_sum = one_for_all * product;
    F curve[3];  // phase function, the same times opposition's bump, that of a layer beneath
    if constexpr (form == PhaseForm::composed)
        sampled_values<3>(side.phase, path, curve);
    else if constexpr (form != PhaseForm::none)
        curve[0] = phase_value<form>(side.phase, path);
    if constexpr (orders != Orders::none) interpolate<orders>(side, path, value);
    for (int c = 0; c < channel_steps<channels, F>; ++c) {
        const auto depth = of_channel(side.optical_depth, c, F());
        const auto quarter_albedo = of_channel(side.quarter_albedo, c, F());
        Attenuation<F> both;
        F shares;
        if constexpr (orders == Orders::none) {
            both = attenuation(one_for_all * (sum * sum * depth));
        } else {
            Attenuation<F> of[2];
            take_attenuations({one_for_all * (sum * path.mu_out * depth),
                               one_for_all * (sum * path.mu_in * depth)},
                              of);
            const auto& [in, out] = of;
            shares = in.extinguished * out.extinguished;
            both = {in.transmitted * out.transmitted, in.extinguished + out.extinguished - shares};
        }
        // [Blinn82] 2.4, and what lies beneath seen through the layer
        F single(0.0f);
        if constexpr (form != PhaseForm::none)
            single = curve[0] * both.extinguished * inverse_sum * quarter_albedo +
                     both.transmitted * of_channel(side.surface, c, F());
        if constexpr (form == PhaseForm::composed) {
            const F half_way =
                root(both.transmitted) + 1.0f;  // taken / half_way^2: the tanh of effects.h
            single = single +
                     inverse_sum * (curve[1] * (both.extinguished * both.extinguished) *
                                        inverse(half_way * half_way) * quarter_albedo +
                                    curve[2] * both.transmitted * of_channel(side.beneath, c, F()));
        }
        if constexpr (orders == Orders::none)
            value[c] = single;
        else
            value[c] = single + value[c] * (shares * side.slope + side.level);
    }
}

/// Diffuse T of the layer, per channel.
template <PhaseForm form, Orders orders, int channels, class F>
[[gnu::always_inline]] static inline void transmitted(const SideView<channels>& side,
                                                      const LightPathOf<F>& path, F* value) {
    const F one_for_both = inverse(path.mu_in * path.mu_out);
    const F steep = one_for_both * smaller(path.mu_in, path.mu_out);  // 1 / the larger cosine
    const F shallow = one_for_both * larger(path.mu_in, path.mu_out);
    F phase;
    if constexpr (form != PhaseForm::none) phase = phase_value<form>(side.phase, path);
    if constexpr (orders != Orders::none) interpolate<orders>(side, path, value);
    for (int c = 0; c < channel_steps<channels, F>; ++c) {
        const auto depth = of_channel(side.optical_depth, c, F());
        const F path_depth = steep * depth;
        // The mean of exp(-x) over [0, z] knows no singularity at equal cosines.
        const F z = larger((shallow - steep) * depth, 1e-30f);
        Attenuation<F> of[2];
        take_attenuations({path_depth, z}, of);
        const auto& [beam, more] = of;
        F single(0.0f);
        if constexpr (form != PhaseForm::none)
            single = phase * beam.transmitted * path_depth * shallow *
                     (more.extinguished * inverse(z)) * of_channel(side.quarter_albedo, c, F());
        if constexpr (orders == Orders::none) {
            value[c] = single;
        } else {
            const F shares =
                beam.extinguished * (beam.extinguished + beam.transmitted * more.extinguished);
            value[c] = single + value[c] * (shares * side.slope + side.level);
        }
    }
}

}  // namespace stratus
