// The scales of diffusion.h in single precision, from attenuations: each is a ratio of numbers that
// keep their relative accuracy.
//
// k is the diffusion exponent, q the extrapolation length.
#pragma once

#include "elementary.h"

namespace stratus {
namespace {

/// What reflection lacks towards infinite depth: remaining / whole.
template <class F>
struct ReflectionDeficit {
    F remaining, whole;

    /// From attenuations at 2 k q and at 2 k tau; `whole` is 1 - exp(-2 k (tau + q)).
    STRATUS_INLINE ReflectionDeficit(const Attenuation<F>& length, const Attenuation<F>& depth)
        : remaining(depth.transmitted * length.extinguished),
          whole(length.extinguished + depth.extinguished -
                length.extinguished * depth.extinguished) {}

    STRATUS_INLINE F deficit() const { return remaining * reciprocal(whole); }

    /// 1 / (1 + deficit)
    STRATUS_INLINE F scale() const { return whole * reciprocal(whole + remaining); }
};

/// k q / sinh(k (tau + q)), from the attenuation at k (tau + q).
template <class F>
STRATUS_INLINE F transmission_scale(F exponent, float length, const Attenuation<F>& depth) {
    return exponent * (2 * length) * depth.transmitted *
           reciprocal(depth.extinguished * (depth.transmitted + 1.0f));
}

}  // namespace
}  // namespace stratus
