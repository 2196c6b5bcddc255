// Between memory and lanes: samples at an index of each lane, one, two neighbours, or four; and some lanes
// of a register.
#pragma once

#include "lanes.h"

namespace stratus {
namespace {

STRATUS_INLINE LookupLanes gathered(const float* samples, LookupLanes::Ints index) {
#if defined(__AVX512F__)
    return LookupLanes(LookupLanes::Floats(_mm512_i32gather_ps(__m512i(index.v), samples, 4)));
#elif defined(__AVX2__)
    return LookupLanes(LookupLanes::Floats(_mm256_i32gather_ps(samples, __m256i(index.v), 4)));
#else
    LookupLanes::Floats y{};
    for (int k = 0; k < lane_width; ++k) y[k] = samples[index.v[k]];
    return LookupLanes(y);
#endif
}

/// samples[index], with the channels that follow it.
template <class F, class Index>
STRATUS_INLINE F sample_at(const float* samples, Index index) {
    if constexpr (std::is_same_v<F, LookupLanes>)
        return gathered(samples, index);
    else
        return load<F>(samples + index);
}

/// Two neighbouring samples.
template <class F>
struct Neighbours {
    F here, next;
};

/// samples[index] and samples[index + stride], with the channels that follow them.
template <int stride, class F, class Index>
STRATUS_INLINE Neighbours<F> neighbours(const float* samples, Index index) {
#if defined(__AVX512F__)
    if constexpr (stride == 1 && std::is_same_v<F, LookupLanes>) {  // both in one read of 64 bits
        const __m512i at = __m512i(index.v);
        const __m512 low =
            _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(at), samples, 4));
        const __m512 high =
            _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(at, 1), samples, 4));
        const __m512i even =
            _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        const __m512i odd =
            _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
        return {F(LookupLanes::Floats(_mm512_permutex2var_ps(low, even, high))),
                F(LookupLanes::Floats(_mm512_permutex2var_ps(low, odd, high)))};
    }
#endif
    return {sample_at<F>(samples, index), sample_at<F>(samples + stride, index)};
}

/// samples[index] to samples[index + 3], each lane's by one read.
struct FourSamples {
    LookupLanes at[4];
};
STRATUS_INLINE FourSamples four_samples(const float* samples, LookupLanes::Ints index) {
#if defined(__AVX2__)
    using Floats = LookupLanes::Floats;
    alignas(64) std::int32_t place[lane_width];
    store(index, place);
    const auto read = [&](int lane) { return _mm_loadu_ps(samples + place[lane]); };
#if defined(__AVX512F__)
    const auto rows = [&](int lane) {  // of every fourth lane
        const __m512 half =
            _mm512_insertf32x4(_mm512_castps128_ps512(read(lane)), read(lane + 4), 1);
        return _mm512_insertf32x4(_mm512_insertf32x4(half, read(lane + 8), 2), read(lane + 12), 3);
    };
    const __m512 a = rows(0), b = rows(1), c = rows(2), d = rows(3);
    const __m512 low_ab = _mm512_unpacklo_ps(a, b), high_ab = _mm512_unpackhi_ps(a, b);
    const __m512 low_cd = _mm512_unpacklo_ps(c, d), high_cd = _mm512_unpackhi_ps(c, d);
    return {{LookupLanes(Floats(_mm512_shuffle_ps(low_ab, low_cd, 0x44))),
             LookupLanes(Floats(_mm512_shuffle_ps(low_ab, low_cd, 0xee))),
             LookupLanes(Floats(_mm512_shuffle_ps(high_ab, high_cd, 0x44))),
             LookupLanes(Floats(_mm512_shuffle_ps(high_ab, high_cd, 0xee)))}};
#else
    const auto rows = [&](int lane) {
        return _mm256_insertf128_ps(_mm256_castps128_ps256(read(lane)), read(lane + 4), 1);
    };
    const __m256 a = rows(0), b = rows(1), c = rows(2), d = rows(3);
    const __m256 low_ab = _mm256_unpacklo_ps(a, b), high_ab = _mm256_unpackhi_ps(a, b);
    const __m256 low_cd = _mm256_unpacklo_ps(c, d), high_cd = _mm256_unpackhi_ps(c, d);
    return {{LookupLanes(Floats(_mm256_shuffle_ps(low_ab, low_cd, 0x44))),
             LookupLanes(Floats(_mm256_shuffle_ps(low_ab, low_cd, 0xee))),
             LookupLanes(Floats(_mm256_shuffle_ps(high_ab, high_cd, 0x44))),
             LookupLanes(Floats(_mm256_shuffle_ps(high_ab, high_cd, 0xee)))}};
#endif
#else
    return {{gathered(samples, index), gathered(samples + 1, index), gathered(samples + 2, index),
             gathered(samples + 3, index)}};
#endif
}

// ---- compress-store and expand-load by mask

#if defined(__AVX2__) && !defined(__AVX512F__)
/// For each mask: the lanes in it, contiguously, and how many of them come before each lane.
struct LaneOrders {
    std::uint8_t chosen[256][8] = {}, before[256][8] = {};

    constexpr LaneOrders() {
        for (unsigned set = 0; set < 256; ++set) {
            std::uint8_t count = 0;
            for (std::uint8_t lane = 0; lane < 8; ++lane) {
                before[set][lane] = count & 7;
                if ((set >> lane & 1u) == 0) continue;
                chosen[set][count] = lane;
                ++count;
            }
        }
    }
};
constexpr LaneOrders lane_orders;

STRATUS_INLINE __m256i widened(const std::uint8_t (&order)[8]) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(order)));
}
#endif

/// Stores the lanes of the mask `lanes` contiguously. Memory after them, up to a whole register, may
/// change.
STRATUS_INLINE void compress_store(LookupLanes x, unsigned lanes, float* to) {
#if defined(__AVX512F__)
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(lanes), x.v));
#elif defined(__AVX2__)
    _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(x.v, widened(lane_orders.chosen[lanes])));
#else
    for (int k = 0; k < lane_width; ++k) {
        *to = x.v[k];
        to += lanes >> k & 1;
    }
#endif
}

/// Loads contiguous numbers into the lanes of the mask, 0 into the others. A whole register is read.
STRATUS_INLINE LookupLanes expand_load(const float* from, unsigned lanes) {
#if defined(__AVX512F__)
    return LookupLanes(LookupLanes::Floats(
        _mm512_maskz_expand_ps(static_cast<__mmask16>(lanes), _mm512_loadu_ps(from))));
#elif defined(__AVX2__)
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(lanes)), bit);
    const __m256 spread =
        _mm256_permutevar8x32_ps(_mm256_loadu_ps(from), widened(lane_orders.before[lanes & 0xff]));
    return LookupLanes(LookupLanes::Floats(
        _mm256_and_ps(spread, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit)))));
#else
    LookupLanes::Floats y{};
    for (int k = 0; k < lane_width; ++k) {
        y[k] = lanes >> k & 1 ? *from : 0;
        from += lanes >> k & 1;
    }
    return LookupLanes(y);
#endif
}

}  // namespace
}  // namespace stratus
