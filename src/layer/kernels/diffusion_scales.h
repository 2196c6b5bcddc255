// The scales of diffusion.h in single precision, from attenuations: each is a ratio of numbers that
// keep their relative accuracy.
//
// k is the diffusion exponent, q the extrapolation length.
#pragma once

#include "base/elementary.h"

namespace stratus {
namespace {

/// The reflection that is missing towards infinite depth: remaining / whole.
template <class F>
struct ReflectionDeficit {
    F remaining, whole;

    /// From attenuations at 2 k q and at 2 k tau; `whole` is 1 - exp(-2 k (tau + q)).
    STRATUS_INLINE ReflectionDeficit(const Attenuation<F>& length, const Attenuation<F>& depth)
        : remaining(depth.transmitted * length.extinguished),
          whole(length.extinguished + depth.extinguished -
                length.extinguished * depth.extinguished) {}

    STRATUS_INLINE F deficit() const { return remaining * reciprocal(whole); }

    /// 1 / (1 + d + d^2) for the deficit d.
    STRATUS_INLINE F scale() const {
        const F d = deficit();
        return reciprocal(d * (d + 1.0f) + 1.0f);
    }
};

/// sinh(k q) / sinh(k (tau + q)), from attenuations at 2 k q and at k tau.
template <class F>
STRATUS_INLINE F transmission_scale(const Attenuation<F>& length, const Attenuation<F>& depth) {
    const F twice = depth.extinguished * (depth.transmitted + 1.0f);  // extinguished at 2 k tau
    return depth.transmitted * length.extinguished *
           reciprocal(length.extinguished + twice - length.extinguished * twice);
}

}  // namespace
}  // namespace stratus
