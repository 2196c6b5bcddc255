// Samples in memory: fetched into lanes, then interpolated.
//
// Between memory and lanes: samples at an index of each lane, one, two neighbours, or four; and some lanes
// of a register.
#pragma once

#include "lanes.h"

namespace stratus {
namespace {

STRATUS_INLINE LookupLanes gathered(const float* samples, LookupLanes::Ints index) {
#if defined(__AVX512F__)
    return LookupLanes(_mm512_i32gather_ps(__m512i(index.v), samples, 4));
#elif defined(__AVX2__)
    return LookupLanes(_mm256_i32gather_ps(samples, __m256i(index.v), 4));
#else
    LookupLanes::Floats y{};
    for (int k = 0; k < lane_width; ++k) y[k] = samples[index.v[k]];
    return y;
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
        return {F(_mm512_permutex2var_ps(low, even, high)),
                F(_mm512_permutex2var_ps(low, odd, high))};
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
    return {{LookupLanes(_mm512_shuffle_ps(low_ab, low_cd, 0x44)),
             LookupLanes(_mm512_shuffle_ps(low_ab, low_cd, 0xee)),
             LookupLanes(_mm512_shuffle_ps(high_ab, high_cd, 0x44)),
             LookupLanes(_mm512_shuffle_ps(high_ab, high_cd, 0xee))}};
#else
    const auto rows = [&](int lane) {
        return _mm256_insertf128_ps(_mm256_castps128_ps256(read(lane)), read(lane + 4), 1);
    };
    const __m256 a = rows(0), b = rows(1), c = rows(2), d = rows(3);
    const __m256 low_ab = _mm256_unpacklo_ps(a, b), high_ab = _mm256_unpackhi_ps(a, b);
    const __m256 low_cd = _mm256_unpacklo_ps(c, d), high_cd = _mm256_unpackhi_ps(c, d);
    return {{LookupLanes(_mm256_shuffle_ps(low_ab, low_cd, 0x44)),
             LookupLanes(_mm256_shuffle_ps(low_ab, low_cd, 0xee)),
             LookupLanes(_mm256_shuffle_ps(high_ab, high_cd, 0x44)),
             LookupLanes(_mm256_shuffle_ps(high_ab, high_cd, 0xee))}};
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
    return LookupLanes(
        _mm512_maskz_expand_ps(static_cast<__mmask16>(lanes), _mm512_loadu_ps(from)));
#elif defined(__AVX2__)
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i set = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(lanes)), bit);
    const __m256 spread =
        _mm256_permutevar8x32_ps(_mm256_loadu_ps(from), widened(lane_orders.before[lanes & 0xff]));
    return LookupLanes(_mm256_and_ps(spread, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bit))));
#else
    LookupLanes::Floats y{};
    for (int k = 0; k < lane_width; ++k) {
        y[k] = lanes >> k & 1 ? *from : 0;
        from += lanes >> k & 1;
    }
    return y;
#endif
}

}  // namespace

// Interpolation between samples: places on axes, and weights of straight lines and of cubics.

namespace {

/// v = sqrt(1 - mu) (1 - mu^(1/4) / 2), along which samples of cosines lie evenly (slice_refinement.cpp).
///
/// Range    [0, 1].
template <class F>
STRATUS_INLINE F mu_coordinate(F mu) {
    return square_root(1.0f - mu) * (1.0f - square_root(square_root(mu)) * 0.5f);
}

/// acos(mu^(1/4)), in which tables sample cosines evenly (axis.h): 2 asin(u) with u^2 half of
/// 1 - mu^(1/4). The polynomial is off by 6e-8 of its value at most.
template <class F>
STRATUS_INLINE F mu_angle(F mu) {
    const F root = square_root(mu), fourth = square_root(root);
    const F rest = 1.0f - mu;
    const F z = (rest * 0.5f) * reciprocal((fourth + 1.0f) * (root + 1.0f));
    // In pairs, for shorter chains of dependent operations.
    const F z2 = z * z;
    const F low = z2 * (z * 0.045064493f + 0.074986517f) + (z * 0.16666674f + 1.0f);
    const F high = z2 * (z * 0.084298202f + -0.047614748f) + (z * 0.04787879f + 0.025548843f);
    const F u = square_root(z) * 2.0f;
    return u * (z2 * z2 * high + low);
}

/// A place on an axis: the sample before it, and the share of the way to the next.
template <class F, class Index>
struct AxisPlace {
    Index sample;
    F fraction;
};

template <class F>
STRATUS_INLINE auto axis_place(F place) {
    const auto sample = truncated(place);
    return AxisPlace<F, std::remove_const_t<decltype(sample)>>{sample, place - as_float(sample)};
}

/// Bilinear weights of the four samples around a place: over (mu, other).
template <class F>
struct CornerWeights {
    F at[4];
};

template <class F>
STRATUS_INLINE CornerWeights<F> corner_weights(F mu_fraction, F other_fraction) {
    const F both = mu_fraction * other_fraction;
    const F other = other_fraction - both, mu = mu_fraction - both;
    return {{(1.0f - mu_fraction) - other, other, mu, both}};
}

/// Weights of the cubic through the samples at 0, 1, 2 and 3.
template <class F>
STRATUS_INLINE void cubic_weights(F t, F* weight) {
    if constexpr (std::is_same_v<F, float>) {
        using Four = QuantityLanes::Floats;
        const Four all = (t - Four{1, 0, 0, 0}) * (t - Four{2, 2, 1, 1}) * (t - Four{3, 3, 3, 2}) *
                         Four{-1 / 6.0f, 0.5f, -0.5f, 1 / 6.0f};
        __builtin_memcpy(weight, &all, sizeof all);
    } else {
        const F a = t - 1.0f, b = t - 2.0f, c = t - 3.0f;
        const F bc = b * c * (1 / 6.0f), ta = t * a * (1 / 6.0f);
        weight[0] = a * bc * -1.0f;
        weight[1] = t * bc * 3.0f;
        weight[2] = ta * c * -3.0f;
        weight[3] = ta * b;
    }
}

/// Between samples over (mu, other, azimuth, channel), `column` apart along other: straight lines along
/// both cosines from `here`, and from `next` for the next mu; the cubic through four azimuths, from
/// the second of which `azimuth` is the share of the way to the third.
template <int channels, class F, class Index>
STRATUS_INLINE void between_samples(const float* sample, int column, Index here, Index next, F mu,
                                    F other, F azimuth, F* value) {
    F along[4];
    cubic_weights(azimuth + 1.0f, along);
    if constexpr (std::is_same_v<F, float>) {
        using Four = QuantityLanes;
        const auto row = [&](Index at) { return load<Four>(sample + at); };
        const Four p = row(here), q = row(here + column), r = row(next), s = row(next + column);
        const Four near = p + Four(other) * (q - p), far = r + Four(other) * (s - r);
        *value = sum_of_all(load<Four>(along) * (near + Four(mu) * (far - near)));
        return;
    }
    const CornerWeights<F> weight = corner_weights(mu, other);
    const auto& w = weight.at;
    if constexpr (std::is_same_v<F, ChannelLanes>) {
        const auto corners = [&](int at) {
            return (w[0] * load<F>(sample + at + here) +
                    w[1] * load<F>(sample + at + here + column)) +
                   (w[2] * load<F>(sample + at + next) +
                    w[3] * load<F>(sample + at + next + column));
        };
        *value = (along[0] * corners(0) + along[1] * corners(channels)) +
                 (along[2] * corners(2 * channels) + along[3] * corners(3 * channels));
    } else if constexpr (std::is_same_v<F, LookupLanes>) {
        F sum[4 * channels];  // over (azimuth, channel)
#pragma GCC unroll 3
        for (int n = 0; n < channels; ++n) {
            const float *const from = sample + 4 * n, *const beside = from + column;
            const FourSamples p = four_samples(from, here), q = four_samples(beside, here),
                              r = four_samples(from, next), s = four_samples(beside, next);
#pragma GCC unroll 4
            for (int k = 0; k < 4; ++k)
                sum[4 * n + k] =
                    (w[0] * p.at[k] + w[1] * q.at[k]) + (w[2] * r.at[k] + w[3] * s.at[k]);
        }
#pragma GCC unroll 3
        for (int c = 0; c < channels; ++c)
            value[c] = (along[0] * sum[c] + along[1] * sum[channels + c]) +
                       (along[2] * sum[2 * channels + c] + along[3] * sum[3 * channels + c]);
    }
}

/// Same, cubic along both cosines, too: from the first of 4 by 4 cells, `row` apart along mu. Without azimuth a
/// cell is one sample. A function of its own: few lookups need it, and it would double the code of all.
template <int channels, bool azimuthal, class F, class Index>
[[gnu::noinline]] void between_cubics(const float* sample, int row, int column, Index here, F mu,
                                      F other, F azimuth, F* value) {
    F along_mu[4], along_other[4], along[4];
    cubic_weights(mu + 1.0f, along_mu);
    cubic_weights(other + 1.0f, along_other);
    cubic_weights(azimuth + 1.0f, along);
    constexpr bool is_one = std::is_same_v<F, float>, is_many = std::is_same_v<F, LookupLanes>;
    constexpr int steps = is_many ? channels : 1;
    F sum[4 * steps];  // over (azimuth, channel), azimuth 0 alone without
    for (F& each : sum) each = F(0.0f);
    QuantityLanes four(0.0f);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const float* const cell = sample + i * row + j * column;
            const F weight = along_mu[i] * along_other[j];
            if constexpr (!azimuthal) {
                for (int c = 0; c < steps; ++c)
                    sum[c] = sum[c] + weight * sample_at<F>(cell + c, here);
            } else if constexpr (is_one) {
                four = four + QuantityLanes(weight) * load<QuantityLanes>(cell + here);
            } else if constexpr (is_many) {
                for (int n = 0; n < channels; ++n) {
                    const FourSamples samples = four_samples(cell + 4 * n, here);
                    for (int k = 0; k < 4; ++k)
                        sum[4 * n + k] = sum[4 * n + k] + weight * samples.at[k];
                }
            } else {
                for (int k = 0; k < 4; ++k)
                    sum[k] = sum[k] + weight * load<F>(cell + k * channels + here);
            }
        }
    if constexpr (azimuthal && is_one) {
        *value = sum_of_all(load<QuantityLanes>(along) * four);
        return;
    }
    for (int c = 0; c < steps; ++c)
        value[c] = !azimuthal ? sum[c]
                              : (along[0] * sum[c] + along[1] * sum[steps + c]) +
                                    (along[2] * sum[2 * steps + c] + along[3] * sum[3 * steps + c]);
}

}  // namespace
}  // namespace stratus
