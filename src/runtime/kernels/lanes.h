// Floats side by side in one register, as light.h wants them of its type F: many lookups, or the
// channels of one.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <stratus/runtime/light.h>

#define STRATUS_INLINE [[gnu::always_inline]] inline
#define STRATUS_FRIEND [[gnu::always_inline]] friend inline

namespace stratus {
namespace {

#if defined(__AVX512F__)
constexpr int lane_width = 16;
#elif defined(__AVX2__)
constexpr int lane_width = 8;
#else
constexpr int lane_width = 4;
#endif

template <int width>
struct Register {
    typedef float Floats __attribute__((vector_size(4 * width)));
    typedef std::int32_t Ints __attribute__((vector_size(4 * width)));
};

/// To 12 bits or more; exact where the processor has nothing faster.
template <class Floats>
STRATUS_INLINE Floats estimated_inverse(Floats x) {
    return 1.0f / x;
}
template <class Floats>
STRATUS_INLINE Floats estimated_inverse_root(Floats x) {
    for (std::size_t k = 0; k < sizeof x / sizeof x[0]; ++k) x[k] = 1 / __builtin_sqrtf(x[k]);
    return x;
}
#if defined(__SSE2__)
STRATUS_INLINE Register<4>::Floats estimated_inverse(Register<4>::Floats x) {
    return _mm_rcp_ps(x);
}
STRATUS_INLINE Register<4>::Floats estimated_inverse_root(Register<4>::Floats x) {
    return _mm_rsqrt_ps(x);
}
#endif
#if defined(__AVX2__)
STRATUS_INLINE Register<8>::Floats estimated_inverse(Register<8>::Floats x) {
    return _mm256_rcp_ps(x);
}
STRATUS_INLINE Register<8>::Floats estimated_inverse_root(Register<8>::Floats x) {
    return _mm256_rsqrt_ps(x);
}
#endif
#if defined(__AVX512F__)
STRATUS_INLINE Register<16>::Floats estimated_inverse(Register<16>::Floats x) {
    return _mm512_maskz_rcp14_ps(0xffff, x);
}
STRATUS_INLINE Register<16>::Floats estimated_inverse_root(Register<16>::Floats x) {
    return _mm512_maskz_rsqrt14_ps(0xffff, x);
}
#endif

enum class LanesAre { lookups, channels };

template <int width, LanesAre are>
struct IntLanes {
    typename Register<width>::Ints v;

    STRATUS_FRIEND IntLanes operator+(IntLanes a, IntLanes b) { return {a.v + b.v}; }
    STRATUS_FRIEND IntLanes operator*(IntLanes a, IntLanes b) { return {a.v * b.v}; }
    STRATUS_FRIEND IntLanes operator+(IntLanes a, int b) { return {a.v + b}; }
    STRATUS_FRIEND IntLanes operator*(IntLanes a, int b) { return {a.v * b}; }
    STRATUS_FRIEND IntLanes halved(IntLanes a) { return {a.v >> 1}; }
};

template <int width, LanesAre are>
struct FloatLanes {
    using Floats = typename Register<width>::Floats;
    using Ints = IntLanes<width, are>;
    Floats v;

    FloatLanes() = default;
    STRATUS_INLINE explicit FloatLanes(float x) : v(x - Floats{}) {}
    STRATUS_INLINE explicit FloatLanes(Floats x) : v(x) {}

    STRATUS_FRIEND FloatLanes operator+(FloatLanes a, FloatLanes b) {
        return FloatLanes(a.v + b.v);
    }
    STRATUS_FRIEND FloatLanes operator-(FloatLanes a, FloatLanes b) {
        return FloatLanes(a.v - b.v);
    }
    STRATUS_FRIEND FloatLanes operator*(FloatLanes a, FloatLanes b) {
        return FloatLanes(a.v * b.v);
    }
    STRATUS_FRIEND FloatLanes operator+(FloatLanes a, float b) { return FloatLanes(a.v + b); }
    STRATUS_FRIEND FloatLanes operator-(FloatLanes a, float b) { return FloatLanes(a.v - b); }
    STRATUS_FRIEND FloatLanes operator*(FloatLanes a, float b) { return FloatLanes(a.v * b); }
    STRATUS_FRIEND FloatLanes operator-(float a, FloatLanes b) { return FloatLanes(a - b.v); }
    STRATUS_FRIEND FloatLanes larger(FloatLanes a, FloatLanes b) {
        return FloatLanes(a.v > b.v ? a.v : b.v);
    }
    STRATUS_FRIEND FloatLanes smaller(FloatLanes a, FloatLanes b) {
        return FloatLanes(a.v < b.v ? a.v : b.v);
    }
    STRATUS_FRIEND FloatLanes larger(FloatLanes a, float b) { return larger(a, FloatLanes(b)); }
    STRATUS_FRIEND FloatLanes smaller(FloatLanes a, float b) { return smaller(a, FloatLanes(b)); }
    STRATUS_FRIEND Ints truncated(FloatLanes x) {
        return {__builtin_convertvector(x.v, decltype(Ints::v))};
    }
    STRATUS_FRIEND FloatLanes power_of_half(FloatLanes rounded) {
        using Bits = decltype(Ints::v);
        return FloatLanes(
            reinterpret_cast<Floats>(0x3f800000 - (reinterpret_cast<Bits>(rounded.v) << 23)));
    }

    // 12 bits or more from the processor and one step of Newton: 2e-7, at a fraction of the time of
    // a division or an exact root.
    STRATUS_FRIEND FloatLanes inverse(FloatLanes x) {
        const Floats y = estimated_inverse(x.v);
        return FloatLanes(y + y * (1.0f - x.v * y));
    }
    STRATUS_FRIEND FloatLanes inverse_root(FloatLanes x) {
        const Floats y = estimated_inverse_root(x.v), half = y * 0.5f;
        return FloatLanes(y + half * (1.0f - x.v * y * y));
    }
    /// Of numbers that are 0 or not below 1e-30.
    STRATUS_FRIEND FloatLanes root(FloatLanes x) {
        return x * inverse_root(larger(x, FloatLanes(1e-30f)));
    }
};

template <int width, LanesAre are>
STRATUS_INLINE FloatLanes<width, are> as_float(IntLanes<width, are> n) {
    using Lanes = FloatLanes<width, are>;
    return Lanes(__builtin_convertvector(n.v, typename Lanes::Floats));
}

// ---- many lookups side by side

using Lookups = FloatLanes<lane_width, LanesAre::lookups>;

/// One number, or as many as there are lanes.
template <class F>
STRATUS_INLINE F load(const float* from) {
    F x;
    __builtin_memcpy(&x, from, sizeof x);
    return x;
}
template <class F>
STRATUS_INLINE void store(F x, float* to) {
    __builtin_memcpy(to, &x, sizeof x);
}
STRATUS_INLINE void store(std::int32_t n, std::int32_t* to) { *to = n; }
STRATUS_INLINE void store(Lookups::Ints n, std::int32_t* to) {
    __builtin_memcpy(to, &n.v, sizeof n.v);
}

STRATUS_INLINE float of_channel(const float* number, int c, Lookups) { return number[c]; }

STRATUS_INLINE Lookups sample_at(const float* samples, Lookups::Ints index, Lookups) {
#if defined(__AVX512F__)
    return Lookups(Lookups::Floats(_mm512_i32gather_ps(__m512i(index.v), samples, 4)));
#elif defined(__AVX2__)
    return Lookups(Lookups::Floats(_mm256_i32gather_ps(samples, __m256i(index.v), 4)));
#else
    Lookups::Floats y{};
    for (int k = 0; k < lane_width; ++k) y[k] = samples[index.v[k]];
    return Lookups(y);
#endif
}

template <int stride>
STRATUS_INLINE Neighbours<Lookups> neighbours(const float* samples, Lookups::Ints index, Lookups) {
#if defined(__AVX512F__)
    if constexpr (stride == 1) {  // both in one read of 64 bits
        const __m512i at = __m512i(index.v);
        const __m512 low =
            _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(at), samples, 4));
        const __m512 high =
            _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(at, 1), samples, 4));
        const __m512i even =
            _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        const __m512i odd =
            _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
        return {Lookups(Lookups::Floats(_mm512_permutex2var_ps(low, even, high))),
                Lookups(Lookups::Floats(_mm512_permutex2var_ps(low, odd, high)))};
    }
#endif
    return {sample_at(samples, index, Lookups()), sample_at(samples + stride, index, Lookups())};
}

// ---- three channels of one lookup, and a fourth that nobody reads

using Channels = FloatLanes<4, LanesAre::channels>;

STRATUS_INLINE Channels of_channel(const float* number, int, Channels) {
    return load<Channels>(number);
}

STRATUS_INLINE Channels sample_at(const float* samples, std::int32_t index, Channels) {
    return load<Channels>(samples + index);
}

template <int stride>
STRATUS_INLINE Neighbours<Channels> neighbours(const float* samples, std::int32_t index, Channels) {
    return {load<Channels>(samples + index), load<Channels>(samples + index + stride)};
}

// All channels have one place.
template <int channels>
STRATUS_INLINE MuCells<Channels, std::int32_t> mu_cells(const SideView<channels>& side, Channels in,
                                                        Channels out) {
    const auto [high, low] = mu_cells(side, in.v[0], out.v[0]);
    return {{high.sample, Channels(high.fraction)}, {low.sample, Channels(low.fraction)}};
}
template <int channels>
STRATUS_INLINE Cell<Channels, std::int32_t> azimuth_cell(const SideView<channels>& side,
                                                         Channels half_azimuth) {
    const auto cell = azimuth_cell(side, half_azimuth.v[0]);
    return {cell.sample, Channels(cell.fraction)};
}

template <int stride>
STRATUS_INLINE Neighbours<Channels> shared_neighbours(const float* samples, Channels::Ints index,
                                                      Channels) {
    return {Channels(samples[index.v[0]]), Channels(samples[index.v[0] + stride])};
}

}  // namespace

template <int channels>
constexpr int channel_steps<channels, Channels> = 1;

}  // namespace stratus
