// Interpolation between samples: places on axes, and weights of straight lines and of cubics.
#pragma once

#include "quantities.h"

namespace stratus {
namespace {

/// v = sqrt(1 - mu) (1 - mu^(1/4) / 2), along which samples of cosines lie evenly (mu_places.h).
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

/// Between samples over (mu, other, azimuth), `stride` apart along azimuth and `column` along other:
/// straight lines along both cosines from `here`, and from `next` for the next mu; the cubic through
/// four azimuths, from the second of which `azimuth` is the share of the way to the third.
template <int stride, class F, class Index>
STRATUS_INLINE F between_samples(const float* sample, int column, Index here, Index next, F mu,
                                 F other, F azimuth) {
    F along[4];
    cubic_weights(azimuth + 1.0f, along);
    if constexpr (std::is_same_v<F, float> && stride == 1) {
        using Four = QuantityLanes;
        const auto row = [&](Index at) { return load<Four>(sample + at); };
        const Four p = row(here), q = row(here + column), r = row(next), s = row(next + column);
        const Four near = p + Four(other) * (q - p), far = r + Four(other) * (s - r);
        return sum_of_all(load<Four>(along) * (near + Four(mu) * (far - near)));
    } else {
        const CornerWeights<F> weight = corner_weights(mu, other);
        const auto& w = weight.at;
        F sum(0.0f);
        for (int k = 0; k < 4; k += 2) {
            const auto pair = [&](int from, Index at) {
                return neighbours<stride, F>(sample + k * stride + from, at);
            };
            const auto p = pair(0, here), q = pair(column, here), r = pair(0, next),
                       s = pair(column, next);
            sum =
                sum +
                along[k] * ((w[0] * p.here + w[1] * q.here) + (w[2] * r.here + w[3] * s.here)) +
                along[k + 1] * ((w[0] * p.next + w[1] * q.next) + (w[2] * r.next + w[3] * s.next));
        }
        return sum;
    }
}

}  // namespace
}  // namespace stratus
