// Interpolation between samples: places on axes, and weights of straight lines and of cubics.
#pragma once

#include "gathers.h"

namespace stratus {
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

}  // namespace
}  // namespace stratus
