// Two numbers that the same is done to: of the ways in and out, or 1 - cos Theta and 1 + cos Theta.
// The two of one lookup lie side by side in a register and take the time of one.
#pragma once

#include "lanes.h"

namespace stratus {
namespace {

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

}  // namespace
}  // namespace stratus
