// Interpolation between samples: places on axes, and weights of straight lines and of cubics.
#pragma once

#include "lanes.h"

namespace stratus {
namespace {

/// v = sqrt(1 - mu) (1 - mu^(1/4) / 2), along which samples of cosines lie evenly (mu_places.h).
template <class F>
STRATUS_INLINE F mu_coordinate(F mu) {
    const F rest = maximum(1.0f - mu, 0.0f);
    if constexpr (std::is_same_v<F, QuantityLanes>) {  // of two cosines: four roots at once
        const F roots = square_root(quantities(mu.v[0], mu.v[1], rest.v[0], rest.v[1]));
        return quantities(roots.v[2], roots.v[3]) * (1.0f - square_root(roots) * 0.5f);
    } else {
        return square_root(rest) * (1.0f - square_root(square_root(mu)) * 0.5f);
    }
}

/// Of two cosines.
template <class F>
struct MuCoordinates {
    F in, out;
};

template <class F>
STRATUS_INLINE MuCoordinates<F> mu_coordinates(F mu_in, F mu_out) {
    if constexpr (std::is_same_v<F, float>) {
        const QuantityLanes v = mu_coordinate(quantities(mu_in, mu_out));
        return {v.v[0], v.v[1]};
    } else {
        return {mu_coordinate(mu_in), mu_coordinate(mu_out)};
    }
}

/// acos(mu^(1/4)), in which tables sample cosines evenly (axis.h): 2 asin(u) with u^2 half of
/// 1 - mu^(1/4). The polynomial is off by 6e-8 of its value at most.
template <class F>
STRATUS_INLINE F mu_angle(F mu) {
    const F root = square_root(mu), fourth = square_root(root);
    const F rest = maximum(1.0f - mu, 0.0f);
    const F z = rest * reciprocal((fourth + 1.0f) * (root + 1.0f)) * 0.5f;
    F p = z * 0.084298202f + -0.047614748f;
    p = z * p + 0.04787879f;
    p = z * p + 0.025548843f;
    p = z * p + 0.045064493f;
    p = z * p + 0.074986517f;
    p = z * p + 0.16666674f;
    const F u = square_root(z) * 2.0f;
    return u + u * z * p;
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

/// Of two cosines.
template <class F, class Index>
struct CosinePlaces {
    AxisPlace<F, Index> mu, other;
};

template <class F>
STRATUS_INLINE auto places_of(F a, F b) {
    const auto mu = axis_place(a), other = axis_place(b);
    return CosinePlaces<F, decltype(mu.sample + 0)>{mu, other};
}

/// The higher one first.
template <class F>
STRATUS_INLINE auto sorted_places(F a, F b) {
    return places_of(maximum(a, b), minimum(a, b));
}

/// Of the first two quantities.
STRATUS_INLINE CosinePlaces<float, std::int32_t> sorted_places(QuantityLanes both) {
    const QuantityLanes swapped = quantities(both.v[1], both.v[0], both.v[2], both.v[3]);
    const QuantityLanes high = maximum(both, swapped), low = minimum(both, swapped);
    const auto [sample, fraction] = axis_place(quantities(high.v[0], low.v[0]));
    return {{sample.v[0], fraction.v[0]}, {sample.v[1], fraction.v[1]}};
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

}  // namespace
}  // namespace stratus
