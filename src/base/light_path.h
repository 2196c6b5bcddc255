// Directions of one scattering, from angles or from vectors.
#pragma once

#include <stratus/base/direction.h>

#include "elementary.h"

namespace stratus {

/// Directions of one scattering, as closed forms and interpolation take them.
template <class F>
struct LightPathOf {
    Pair<F> mu;  // in and out, [min_cosine, 1]
    // 1 - cos Theta and 1 + cos Theta, each accurate where it is small.
    Pair<F> turn;
    F half_azimuth;  // sin^2(azimuth / 2), not negative
    F unknown{};     // 0, or not-a-number where the azimuth is

    STRATUS_INLINE F mu_in() const { return mu.first(); }
    STRATUS_INLINE F mu_out() const { return mu.second(); }
    STRATUS_INLINE F forward() const { return turn.first(); }
    STRATUS_INLINE F backward() const { return turn.second(); }
};
using LightPath = LightPathOf<float>;

constexpr float min_cosine = 1e-6f;  // smaller ones count as this, so that nothing is divided by 0

namespace {

/// The nearest in range; not-a-number stays that.
template <class F>
STRATUS_INLINE Pair<F> cosines_in_range(const Pair<F>& mu) {
    return each([](auto x) { return at_least(min_cosine, at_most(1, x)); }, mu);
}

template <Side side, class F>
STRATUS_INLINE LightPathOf<F> light_path(F mu_in, F mu_out, F azimuth) {
    const Pair<F> mu = cosines_in_range(Pair<F>(mu_in, mu_out));
    const Pair<F> sine = each([](auto x) { return square_root((1.0f - x) * (x + 1.0f)); }, mu);
    const F half_azimuth = half_azimuth_sine_squared(azimuth);
    // Half the squares of sum and difference of the directions of propagation, at azimuth 0.
    const F along = sine.first() - sine.second();
    Pair<F> across = sum_and_difference(mu);
    if constexpr (side == Side::transmission) across = swapped(across);
    const Pair<F> level = scaled(across * across + Pair<F>(along * along), 0.5f);
    const Pair<F> halves(half_azimuth, 1.0f - half_azimuth);
    return {mu, level + scaled(halves, product(sine) * 2.0f), half_azimuth, azimuth * 0.0f};
}

/// Between two unit vectors in a frame whose z is the normal, both pointing away from the layer.
template <class F>
STRATUS_INLINE LightPathOf<F> light_path(F xi, F yi, F zi, F xo, F yo, F zo) {
    // Light travels along -wi: its azimuth to wo has the cosine -(wi . wo) / (s s0) of both
    // vectors' horizontal parts.
    const Pair<F> x(xi, xo), y(yi, yo), z(zi, zo);
    const F sines = product(x * x + y * y) + 1e-30f, level = (xi * xo + yi * yo) * 0.5f;
    const F half = level * prompt_reciprocal_root(sines) + 0.5f;
    const Pair<F> xs = sum_and_difference(x), ys = sum_and_difference(y),
                  zs = sum_and_difference(z);
    return {cosines_in_range(each([](auto c) { return magnitude(c); }, z)),
            scaled(xs * xs + ys * ys + zs * zs, 0.5f), magnitude(half), level * 0.0f};
}

}  // namespace
}  // namespace stratus
