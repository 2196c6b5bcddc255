// Numbers of one scattering: elementary functions, then the directions that they are of.
//
// Pairs of numbers, and elementary functions of fast lookups, in single precision: exp(-x) with its
// complement, log2, and the square of a sine.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/base/direction.h>

#include "lanes.h"

namespace stratus {
namespace {

// ---- Two numbers that the same is done to: of the ways in and out, or 1 - cos Theta and 1 + cos Theta. The two
// of one lookup lie side by side in a register and take the time of one.

template <class F>
class Pair {
  public:
    Pair() = default;
    STRATUS_INLINE Pair(F a, F b) : a_(a), b_(b) {}
    /// Both the same.
    STRATUS_INLINE explicit Pair(F x) : a_(x), b_(x) {}

    STRATUS_INLINE F first() const { return a_; }
    STRATUS_INLINE F second() const { return b_; }

  private:
    F a_, b_;
};

template <>
class Pair<float> {
  public:
    Pair() = default;
    STRATUS_INLINE Pair(float a, float b) : lanes_(two_quantities(a, b)) {}
    STRATUS_INLINE explicit Pair(float x) : lanes_(x) {}
    /// The first two.
    STRATUS_INLINE explicit Pair(QuantityLanes lanes) : lanes_(lanes) {}

    STRATUS_INLINE float first() const { return lanes_.v[0]; }
    STRATUS_INLINE float second() const { return lanes_.v[1]; }
    STRATUS_INLINE QuantityLanes lanes() const { return lanes_; }

  private:
    QuantityLanes lanes_;
};

/// of(x, ...) of both.
template <class F, class Of, class... Pairs>
STRATUS_INLINE Pair<F> each(const Of& of, const Pair<F>& x, const Pairs&... more) {
    if constexpr (std::is_same_v<F, float>)
        return Pair<F>(of(x.lanes(), more.lanes()...));
    else
        return {of(x.first(), more.first()...), of(x.second(), more.second()...)};
}

template <class F>
STRATUS_INLINE Pair<F> operator+(const Pair<F>& a, const Pair<F>& b) {
    return each([](auto x, auto y) { return x + y; }, a, b);
}
template <class F>
STRATUS_INLINE Pair<F> operator-(const Pair<F>& a, const Pair<F>& b) {
    return each([](auto x, auto y) { return x - y; }, a, b);
}
template <class F>
STRATUS_INLINE Pair<F> operator*(const Pair<F>& a, const Pair<F>& b) {
    return each([](auto x, auto y) { return x * y; }, a, b);
}
/// Times a number of type F, or one that all lanes share.
template <class F, class N>
STRATUS_INLINE Pair<F> scaled(const Pair<F>& a, N factor) {
    return each([&](auto x) { return x * factor; }, a);
}

template <class F>
STRATUS_INLINE Pair<F> swapped(const Pair<F>& p) {
    if constexpr (std::is_same_v<F, float>) {
        const QuantityLanes x = p.lanes();
        return Pair<F>(quantities(x.v[1], x.v[0], x.v[2], x.v[3]));
    } else {
        return {p.second(), p.first()};
    }
}

/// first(a, b) and second(a, b), which do not mind the order of a and b.
template <class F, class First, class Second>
STRATUS_INLINE Pair<F> combined(const Pair<F>& p, const First& first, const Second& second) {
    if constexpr (std::is_same_v<F, float>) {
        const QuantityLanes a = p.lanes(), b = swapped(p).lanes();
        return Pair<F>(with_first(first(a, b), second(a, b)));
    } else {
        return {first(p.first(), p.second()), second(p.first(), p.second())};
    }
}

template <class F>
STRATUS_INLINE Pair<F> lower_first(const Pair<F>& p) {
    return combined(
        p, [](auto a, auto b) { return minimum(a, b); },
        [](auto a, auto b) { return maximum(a, b); });
}
template <class F>
STRATUS_INLINE Pair<F> higher_first(const Pair<F>& p) {
    return combined(
        p, [](auto a, auto b) { return maximum(a, b); },
        [](auto a, auto b) { return minimum(a, b); });
}

template <class F>
STRATUS_INLINE F sum(const Pair<F>& p) {
    return p.first() + p.second();
}
template <class F>
STRATUS_INLINE F product(const Pair<F>& p) {
    return p.first() * p.second();
}

/// a + b and a - b.
template <class F>
STRATUS_INLINE Pair<F> sum_and_difference(const Pair<F>& p) {
    if constexpr (std::is_same_v<F, float>)
        return swapped(p) + p * Pair<F>(quantities(1, -1));
    else
        return {p.first() + p.second(), p.first() - p.second()};
}

// ---- functions

/// exp(-x) and 1 - exp(-x), each with its relative accuracy.
template <class F>
struct Attenuation {
    F transmitted, extinguished;
};

/// Range    x >= 0; beyond 80 nothing is transmitted. Both are not-a-number where x is.
/// Accuracy 2e-7 of either, down to 1e-28.
template <class F>
STRATUS_INLINE Attenuation<F> attenuation(F x) {
    const F at = at_most(80, x);
    // n + shift, n the nearest number of halvings
    const F shifted = at * 1.44269504f + rounding_shift;
    const F n = shifted - rounding_shift;
    const F r = (n * 0.693359375f - at) - n * 2.12194440e-4f;  // |r| <= ln(2) / 2
    // exp(r) - 1, Taylor; in pairs, for shorter chains of dependent operations.
    const F r2 = r * r;
    const F high =
        r2 * (r * 0.000198412698f + 0.00138888889f) + (r * 0.00833333333f + 0.0416666667f);
    const F p = r2 * (r2 * high + (r * 0.166666667f + 0.5f)) + r;
    const F power = power_of_half(shifted);
    const F correction = power * p;
    constexpr float nothing = 1.9e-35f;  // above exp(-80), and all of it a normal number
    return {at_least(0, (power - nothing) + correction), (1.0f - power) - correction};
}

/// Attenuations of two arguments.
template <class F>
struct Attenuations {
    Pair<F> transmitted, extinguished;
};

template <class F>
STRATUS_INLINE Attenuations<F> attenuations(const Pair<F>& x) {
    if constexpr (std::is_same_v<F, float>) {
        const Attenuation<QuantityLanes> at = attenuation(x.lanes());
        return {Pair<F>(at.transmitted), Pair<F>(at.extinguished)};
    } else {
        const Attenuation<F> a = attenuation(x.first()), b = attenuation(x.second());
        return {{a.transmitted, b.transmitted}, {a.extinguished, b.extinguished}};
    }
}

/// Evaluates `n` arguments at once.
template <int n, class F>
STRATUS_INLINE void attenuate(const F (&x)[n], Attenuation<F> (&result)[n]) {
    if constexpr (std::is_same_v<F, float>) {
        static_assert(n >= 2 && n <= 4);
        const Attenuation<QuantityLanes> at = attenuation(
            quantities(x[0], x[1], n > 2 ? x[n > 2 ? 2 : 0] : 0, n > 3 ? x[n > 3 ? 3 : 0] : 0));
        for (int k = 0; k < n; ++k) result[k] = {at.transmitted.v[k], at.extinguished.v[k]};
    } else {
        for (int k = 0; k < n; ++k) result[k] = attenuation(x[k]);
    }
}

/// sin^2 and cos^2 of azimuth / 2 for any azimuth in radians, below a million; each is accurate where it is
/// small.
template <class F>
STRATUS_INLINE Pair<F> half_azimuth_squares(F azimuth) {
    // They have period 2 pi.
    const F turns = azimuth * static_cast<float>(0.5 / pi);
    const F rest = turns - ((turns + rounding_shift) - rounding_shift);  // in [-1/2, 1/2]
    return each(
        [](auto half_turns) {
            const auto x = half_turns * static_cast<float>(pi);  // in [-pi/2, pi/2]
            const auto q = x * x, q2 = q * q;
            const auto low = q * -0.166666667f + 1.0f;
            const auto high =
                (q * -0.000198412701f + 0.00833333315f) + q2 * (q * -2.50507e-8f + 2.75573137e-6f);
            const auto sine = x * (q2 * high + low);
            return at_most(1, sine * sine);
        },
        Pair<F>(rest, 0.5f - magnitude(rest)));
}

/// Range    x > 0, normal.
/// Accuracy 2e-7 of the larger of the result and 1.
template <class F>
STRATUS_INLINE F binary_logarithm(F x) {
    const BinaryParts<F> parts = binary_parts(x);
    // artanh series, |s| < 0.172
    const F s = (parts.mantissa - 1.0f) * reciprocal(parts.mantissa + 1.0f);
    const F q = s * s;
    return parts.exponent +
           s * (q * (q * (q * 0.41219859f + 0.57707802f) + 0.96179669f) + 2.88539008f);
}

}  // namespace

// Directions of one scattering, from angles or from vectors.

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
    const Pair<F> halves = half_azimuth_squares(azimuth);
    // Half the squares of sum and difference of the directions of propagation, at azimuth 0.
    const F along = sine.first() - sine.second();
    Pair<F> across = sum_and_difference(mu);
    if constexpr (side == Side::transmission) across = swapped(across);
    const Pair<F> level = scaled(across * across + Pair<F>(along * along), 0.5f);
    return {mu, level + scaled(halves, product(sine) * 2.0f), halves.first(), azimuth * 0.0f};
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
