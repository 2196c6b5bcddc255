// Directions of one scattering, from angles or from vectors.
#pragma once

#include <stratus/runtime/single_scattering.h>

#include "elementary.h"

namespace stratus {

/// Directions of one scattering, as closed forms and interpolation take them.
template <class F>
struct LightPathOf {
    F mu_in, mu_out;  // (0, 1]
    // 1 - cos Theta and 1 + cos Theta, each accurate where it is small.
    F forward, backward;
    F half_azimuth;  // sin^2(azimuth / 2), [0, 1]
};
using LightPath = LightPathOf<float>;

constexpr float min_cosine = 1e-6f;  // smaller ones count as this, so that nothing is divided by 0

namespace {

template <class F>
STRATUS_INLINE F sine_of(F mu) {
    return square_root(maximum((1.0f - mu) * (mu + 1.0f), 0.0f));
}

/// Of two directions.
template <class F>
struct Sines {
    F in, out;
};

template <class F>
STRATUS_INLINE Sines<F> sines_of(F mu_in, F mu_out) {
    if constexpr (std::is_same_v<F, float>) {
        const QuantityLanes sine = sine_of(quantities(mu_in, mu_out));
        return {sine.v[0], sine.v[1]};
    } else {
        return {sine_of(mu_in), sine_of(mu_out)};
    }
}

template <Side side, class F>
STRATUS_INLINE LightPathOf<F> light_path(F mu_in, F mu_out, F azimuth) {
    const Sines<F> sine = sines_of(mu_in, mu_out);
    const F half_azimuth = half_azimuth_sine_squared(azimuth);
    // Half the squares of sum and difference of the directions of propagation, at azimuth 0.
    const F sum = mu_in + mu_out, difference = mu_in - mu_out, along = sine.in - sine.out;
    const F sines = sine.in * sine.out * 2.0f;
    const F far = (difference * difference + along * along) * 0.5f;
    const F near = (sum * sum + along * along) * 0.5f;
    constexpr bool reflected = side == Side::reflection;
    return {maximum(mu_in, min_cosine), maximum(mu_out, min_cosine),
            (reflected ? near : far) + sines * half_azimuth,
            (reflected ? far : near) + sines * (1.0f - half_azimuth), half_azimuth};
}

/// Between two unit vectors in a frame whose z is the normal, both pointing away from the layer.
template <class F>
STRATUS_INLINE LightPathOf<F> light_path(F xi, F yi, F zi, F xo, F yo, F zo) {
    // Light travels along -wi: its azimuth to wo has the cosine -(wi . wo) / (s s0) of both
    // vectors' horizontal parts.
    const F sines = (xi * xi + yi * yi) * (xo * xo + yo * yo);
    const F half = (xi * xo + yi * yo) * reciprocal_root(maximum(sines, 1e-30f)) * 0.5f + 0.5f;
    const F xs = xi + xo, ys = yi + yo, zs = zi + zo, xd = xi - xo, yd = yi - yo, zd = zi - zo;
    return {maximum(maximum(zi, zi * -1.0f), min_cosine),
            maximum(maximum(zo, zo * -1.0f), min_cosine), (xs * xs + ys * ys + zs * zs) * 0.5f,
            (xd * xd + yd * yd + zd * zd) * 0.5f, clamped(half, 0.0f, 1.0f)};
}

}  // namespace
}  // namespace stratus
