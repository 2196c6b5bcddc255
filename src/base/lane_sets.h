// Compress-store and expand-load by mask.
#pragma once

#include "lanes.h"

#include <cstdint>

namespace stratus {
namespace {

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
