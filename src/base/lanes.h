// Numbers of a lookup: float, or floats side by side in a SIMD register with the same operations.
//
// The arithmetic of fast lookups (light_path.h, phase_values.h, interpolation.h,
// closed_form.h) is written once for a number type F: float for one lookup,
// LookupLanes for many, ChannelLanes for the channels of one. Nothing there branches on a number.
//
// All of it has internal linkage and is inlined: copies that were compiled for different processors
// stay apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define STRATUS_INLINE [[gnu::always_inline]] inline
#define STRATUS_FRIEND [[gnu::always_inline]] friend inline

namespace stratus {
namespace {

// ---- one number

STRATUS_INLINE float square_root(float x) { return __builtin_sqrtf(x); }
STRATUS_INLINE float reciprocal(float x) { return 1 / x; }
STRATUS_INLINE float reciprocal_root(float x) { return 1 / __builtin_sqrtf(x); }

#if defined(__SSE2__)
/// The register that a number is in, whatever is beside it.
STRATUS_INLINE __m128 to_register(float x) {
#if defined(__clang__)
    return _mm_set_ss(x);  // it sees that what is beside is not used
#else
    __m128 all;  // _mm_set_ss would clear what is beside
    asm("" : "=x"(all) : "0"(x));
    return all;
#endif
}
// Compilers would rather branch, and the branch would mispredict.
STRATUS_INLINE float maximum(float a, float b) {
    return _mm_cvtss_f32(_mm_max_ss(to_register(a), to_register(b)));
}
STRATUS_INLINE float minimum(float a, float b) {
    return _mm_cvtss_f32(_mm_min_ss(to_register(a), to_register(b)));
}
#else
STRATUS_INLINE float maximum(float a, float b) { return a > b ? a : b; }
STRATUS_INLINE float minimum(float a, float b) { return a < b ? a : b; }
#endif

STRATUS_INLINE float magnitude(float x) { return __builtin_fabsf(x); }

/// Towards 0; |x| < 2^31.
STRATUS_INLINE std::int32_t truncated(float x) { return static_cast<std::int32_t>(x); }

STRATUS_INLINE float as_float(std::int32_t n) { return static_cast<float>(n); }

/// Halves a number that is not negative.
STRATUS_INLINE std::int32_t halved(std::int32_t n) { return n >> 1; }

/// Added to a small number and subtracted again, it rounds to an integer: 1.5 * 2^23.
constexpr float rounding_shift = 12582912.0f;
constexpr std::int32_t bits_of_1 = 0x3f800000;

/// 2^-n of n + rounding_shift, n in [0, 126]: n is in the last bits.
STRATUS_INLINE float power_of_half(float shifted) {
    std::uint32_t bits;
    __builtin_memcpy(&bits, &shifted, sizeof bits);
    bits = std::uint32_t{bits_of_1} - (bits << 23);
    float power;
    __builtin_memcpy(&power, &bits, sizeof power);
    return power;
}

/// x = 2^exponent mantissa, the mantissa in [sqrt(1/2), sqrt(2)).
template <class F>
struct BinaryParts {
    F exponent, mantissa;
};
constexpr std::int32_t bits_of_root_half = 0x3f3504f3;

/// Takes x > 0, normal.
STRATUS_INLINE BinaryParts<float> binary_parts(float x) {
    std::int32_t bits;
    __builtin_memcpy(&bits, &x, sizeof bits);
    const std::int32_t n = (bits - bits_of_root_half) >> 23;
    bits -= n * (1 << 23);
    BinaryParts<float> parts{static_cast<float>(n), 0};
    __builtin_memcpy(&parts.mantissa, &bits, sizeof bits);
    return parts;
}

/// x = 2^exponent (1 + fraction / 2^bits + ...): place among samples evenly spaced in each octave.
template <class F, class Index>
struct OctavePlace {
    Index sample;              // counted from x = 2^-127
    F fraction;                // of the way to the next
    F octave, octave_inverse;  // 2^exponent, 2^-exponent
};

/// Takes x > 0, normal.
template <int bits>
STRATUS_INLINE OctavePlace<float, std::int32_t> octave_place(float x) {
    constexpr int shift = 23 - bits;
    std::int32_t n;
    __builtin_memcpy(&n, &x, sizeof n);
    const std::int32_t exponent = n & 0x7f800000, inverse = 0x7f000000 - exponent;
    OctavePlace<float, std::int32_t> place{
        n >> shift, static_cast<float>(n & ((1 << shift) - 1)) * (1.0f / (1 << shift)), 0, 0};
    __builtin_memcpy(&place.octave, &exponent, sizeof exponent);
    __builtin_memcpy(&place.octave_inverse, &inverse, sizeof inverse);
    return place;
}

/// n where a < b, 0 elsewhere.
STRATUS_INLINE std::int32_t where_less(float a, float b, std::int32_t n) { return a < b ? n : 0; }
/// yes where a < b, no elsewhere.
STRATUS_INLINE float choose_less(float a, float b, float yes, float no) { return a < b ? yes : no; }

// ---- registers

#if defined(__AVX512F__)
constexpr int lane_width = 16;
#elif defined(__AVX2__)
constexpr int lane_width = 8;
#else
constexpr int lane_width = 4;
#endif

template <int width>
struct SimdRegister {
    typedef float Floats __attribute__((vector_size(4 * width)));
    typedef std::int32_t Ints __attribute__((vector_size(4 * width)));
};
using FourFloats = SimdRegister<4>::Floats;
using EightFloats = SimdRegister<8>::Floats;
using SixteenFloats = SimdRegister<16>::Floats;

// Operations on two registers. Compilers make a comparison and a blend of a ternary operator.
template <class Floats>
STRATUS_INLINE Floats maximum(Floats a, Floats b) {
    return a > b ? a : b;
}
template <class Floats>
STRATUS_INLINE Floats minimum(Floats a, Floats b) {
    return a < b ? a : b;
}

/// To 12 bits or more; exact where the processor has nothing faster.
template <class Floats>
STRATUS_INLINE Floats estimated_reciprocal(Floats x) {
    return 1.0f / x;
}
template <class Floats>
STRATUS_INLINE Floats estimated_reciprocal_root(Floats x) {
    for (std::size_t k = 0; k < sizeof x / sizeof x[0]; ++k) x[k] = 1 / __builtin_sqrtf(x[k]);
    return x;
}
#if defined(__SSE2__)
STRATUS_INLINE FourFloats maximum(FourFloats a, FourFloats b) { return _mm_max_ps(a, b); }
STRATUS_INLINE FourFloats minimum(FourFloats a, FourFloats b) { return _mm_min_ps(a, b); }
STRATUS_INLINE FourFloats estimated_reciprocal(FourFloats x) { return _mm_rcp_ps(x); }
STRATUS_INLINE FourFloats estimated_reciprocal_root(FourFloats x) { return _mm_rsqrt_ps(x); }
#endif
#if defined(__AVX2__)
STRATUS_INLINE EightFloats maximum(EightFloats a, EightFloats b) { return _mm256_max_ps(a, b); }
STRATUS_INLINE EightFloats minimum(EightFloats a, EightFloats b) { return _mm256_min_ps(a, b); }
STRATUS_INLINE EightFloats estimated_reciprocal(EightFloats x) { return _mm256_rcp_ps(x); }
STRATUS_INLINE EightFloats estimated_reciprocal_root(EightFloats x) { return _mm256_rsqrt_ps(x); }
#endif
#if defined(__AVX512F__)
STRATUS_INLINE SixteenFloats maximum(SixteenFloats a, SixteenFloats b) {
    return _mm512_max_ps(a, b);
}
STRATUS_INLINE SixteenFloats minimum(SixteenFloats a, SixteenFloats b) {
    return _mm512_min_ps(a, b);
}
STRATUS_INLINE SixteenFloats estimated_reciprocal(SixteenFloats x) {
    return _mm512_maskz_rcp14_ps(0xffff, x);
}
STRATUS_INLINE SixteenFloats estimated_reciprocal_root(SixteenFloats x) {
    return _mm512_maskz_rsqrt14_ps(0xffff, x);
}
#endif

/// Sooner there than 1 / sqrt(x), which is exact.
STRATUS_INLINE float prompt_reciprocal_root(float x) {
#if defined(__SSE2__)
    const float y = _mm_cvtss_f32(_mm_rsqrt_ss(to_register(x))), half = y * 0.5f;
    return y + half * (1.0f - x * y * y);
#else
    return reciprocal_root(x);
#endif
}

STRATUS_INLINE FourFloats rounded_root(FourFloats x) {
#if defined(__SSE2__)
    return _mm_sqrt_ps(x);
#else
    for (int k = 0; k < 4; ++k) x[k] = __builtin_sqrtf(x[k]);
    return x;
#endif
}

/// The kind of numbers that lie side by side.
enum class LaneContent { lookups, channels, quantities };

template <int width, LaneContent content>
struct IntLanes {
    typename SimdRegister<width>::Ints v;

    STRATUS_FRIEND IntLanes operator+(IntLanes a, IntLanes b) { return {a.v + b.v}; }
    STRATUS_FRIEND IntLanes operator*(IntLanes a, IntLanes b) { return {a.v * b.v}; }
    STRATUS_FRIEND IntLanes operator+(IntLanes a, int b) { return {a.v + b}; }
    STRATUS_FRIEND IntLanes operator*(IntLanes a, int b) { return {a.v * b}; }
    STRATUS_FRIEND IntLanes halved(IntLanes a) { return {a.v >> 1}; }
    STRATUS_FRIEND IntLanes clamped(IntLanes a, int low, IntLanes high) {
        const auto least = low + decltype(a.v){};
        a.v = a.v < high.v ? a.v : high.v;
        return {a.v > least ? a.v : least};
    }
};

template <int width, LaneContent content>
struct FloatLanes {
    using Floats = typename SimdRegister<width>::Floats;
    using Ints = IntLanes<width, content>;
    using Bits = typename SimdRegister<width>::Ints;
    Floats v;

    FloatLanes() = default;
    STRATUS_INLINE FloatLanes(float x) : v(x - Floats{}) {}
    STRATUS_INLINE FloatLanes(Floats x) : v(x) {}

    STRATUS_FRIEND FloatLanes operator+(FloatLanes a, FloatLanes b) { return a.v + b.v; }
    STRATUS_FRIEND FloatLanes operator-(FloatLanes a, FloatLanes b) { return a.v - b.v; }
    STRATUS_FRIEND FloatLanes operator*(FloatLanes a, FloatLanes b) { return a.v * b.v; }
    STRATUS_FRIEND FloatLanes maximum(FloatLanes a, FloatLanes b) { return maximum(a.v, b.v); }
    STRATUS_FRIEND FloatLanes minimum(FloatLanes a, FloatLanes b) { return minimum(a.v, b.v); }
    STRATUS_FRIEND FloatLanes magnitude(FloatLanes x) {
        return reinterpret_cast<Floats>(reinterpret_cast<Bits>(x.v) & 0x7fffffff);
    }
    STRATUS_FRIEND Ints truncated(FloatLanes x) { return {__builtin_convertvector(x.v, Bits)}; }
    STRATUS_FRIEND FloatLanes power_of_half(FloatLanes shifted) {
        return reinterpret_cast<Floats>(bits_of_1 - (reinterpret_cast<Bits>(shifted.v) << 23));
    }
    STRATUS_FRIEND BinaryParts<FloatLanes> binary_parts(FloatLanes x) {
        const Bits bits = reinterpret_cast<Bits>(x.v);
        const Bits n = (bits - bits_of_root_half) >> 23;
        return {__builtin_convertvector(n, Floats), reinterpret_cast<Floats>(bits - (n << 23))};
    }

    STRATUS_FRIEND Ints where_less(FloatLanes a, FloatLanes b, std::int32_t n) {
        return {(a.v < b.v) & n};
    }
    STRATUS_FRIEND FloatLanes choose_less(FloatLanes a, FloatLanes b, FloatLanes yes,
                                          FloatLanes no) {
        return a.v < b.v ? yes.v : no.v;
    }

    // For lookups and channels, 12 bits or more from the processor and one step of Newton: 2e-7, at a
    // fraction of the time of a division or an exact root. For quantities, as for a float.
    STRATUS_FRIEND FloatLanes reciprocal(FloatLanes x) {
        if constexpr (content == LaneContent::quantities) return 1.0f / x.v;
        const Floats y = estimated_reciprocal(x.v);
        return y + y * (1.0f - x.v * y);
    }
    STRATUS_FRIEND FloatLanes reciprocal_root(FloatLanes x) {
        if constexpr (content == LaneContent::quantities) return 1.0f / rounded_root(x.v);
        return prompt_reciprocal_root(x);
    }
    STRATUS_FRIEND FloatLanes prompt_reciprocal_root(FloatLanes x) {
        const Floats y = estimated_reciprocal_root(x.v), half = y * 0.5f;
        return y + half * (1.0f - x.v * y * y);
    }
    /// Takes numbers that are 0 or not below 1e-30.
    STRATUS_FRIEND FloatLanes square_root(FloatLanes x) {
        if constexpr (content == LaneContent::quantities)
            return rounded_root(x.v);
        else
            return x * reciprocal_root(maximum(x, 1e-30f));
    }
};

template <int width, LaneContent content>
STRATUS_INLINE FloatLanes<width, content> as_float(IntLanes<width, content> n) {
    return __builtin_convertvector(n.v, typename SimdRegister<width>::Floats);
}

template <int bits, int width, LaneContent content>
STRATUS_INLINE auto octave_place(FloatLanes<width, content> x) {
    using Lanes = FloatLanes<width, content>;
    using Floats = typename Lanes::Floats;
    using Bits = typename Lanes::Bits;
    constexpr int shift = 23 - bits;
    const Bits n = reinterpret_cast<Bits>(x.v), exponent = n & 0x7f800000;
    return OctavePlace<Lanes, typename Lanes::Ints>{
        {n >> shift},
        __builtin_convertvector(n & ((1 << shift) - 1), Floats) * (1.0f / (1 << shift)),
        reinterpret_cast<Floats>(exponent),
        reinterpret_cast<Floats>(0x7f000000 - exponent)};
}

/// Many lookups.
using LookupLanes = FloatLanes<lane_width, LaneContent::lookups>;
/// Three channels of one lookup, and a fourth that is ignored.
using ChannelLanes = FloatLanes<4, LaneContent::channels>;
/// Up to four numbers that one lookup needs, for the time of one.
using QuantityLanes = FloatLanes<4, LaneContent::quantities>;

// ---- any of them

/// `high` is a number of type F, or one that all lanes share.
template <class F, class N>
STRATUS_INLINE F clamped(F x, float low, N high) {
    return maximum(minimum(x, high), low);
}

// Bounds that keep not-a-number; those above turn it into an end, which may be an index: where one
// of two numbers is not-a-number, maxima and minima are the second.
template <class F>
STRATUS_INLINE F at_least(float low, F x) {
    return maximum(F(low), x);
}
template <class F>
STRATUS_INLINE F at_most(float high, F x) {
    return minimum(F(high), x);
}

/// Without its fraction.
template <class F>
STRATUS_INLINE F whole(F x) {
    return as_float(truncated(x));
}

template <class F>
STRATUS_INLINE F load(const float* from) {
    F x;
    __builtin_memcpy(&x, from, sizeof x);
    return x;
}
template <class Numbers, class Number>
STRATUS_INLINE void store(Numbers x, Number* to) {
    __builtin_memcpy(to, &x, sizeof x);
}

/// A bit for each lane in which a < b.
STRATUS_INLINE unsigned lanes_less(LookupLanes a, LookupLanes b) {
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ);
#elif defined(__AVX2__)
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)));
#elif defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)));
#else
    unsigned lanes = 0;
    for (int k = 0; k < lane_width; ++k) lanes |= (a.v[k] < b.v[k] ? 1u : 0u) << k;
    return lanes;
#endif
}

/// Steps of a loop over the channels of a lookup.
template <int channels, class F>
constexpr int channel_steps = std::is_same_v<F, ChannelLanes> ? 1 : channels;

/// The numbers, one a channel, that a step of that loop reads.
template <class F>
STRATUS_INLINE auto channel_value(const float* number, int channel) {
    if constexpr (std::is_same_v<F, ChannelLanes>)
        return load<ChannelLanes>(number);
    else
        return number[channel];
}

// ---- numbers that one lookup needs more than once, side by side

STRATUS_INLINE QuantityLanes quantities(float a, float b, float c = 0, float d = 0) {
    return QuantityLanes::Floats{a, b, c, d};
}

/// Two, and 0.
STRATUS_INLINE QuantityLanes two_quantities(float a, float b) {
#if defined(__SSE4_1__)
    return QuantityLanes(_mm_insert_ps(to_register(a), to_register(b), 0x1c));
#else
    return quantities(a, b);
#endif
}

/// The first of one, and what follows of another.
STRATUS_INLINE QuantityLanes with_first(QuantityLanes x, QuantityLanes rest) {
    return quantities(x.v[0], rest.v[1], rest.v[2], rest.v[3]);
}

/// The first two of either.
STRATUS_INLINE QuantityLanes low_and_low(QuantityLanes a, QuantityLanes b) {
    return quantities(a.v[0], a.v[1], b.v[0], b.v[1]);
}

STRATUS_INLINE float sum_of_all(QuantityLanes x) {
    const QuantityLanes halves = x + quantities(x.v[2], x.v[3], x.v[2], x.v[3]);
    return halves.v[0] + halves.v[1];
}

}  // namespace
}  // namespace stratus
