// Numbers that one lookup needs more than once, side by side in a register: putting them there, moving
// them about and adding them up.
#pragma once

#include "lanes.h"

namespace stratus {
namespace {

STRATUS_INLINE QuantityLanes quantities(float a, float b, float c = 0, float d = 0) {
    return QuantityLanes(QuantityLanes::Floats{a, b, c, d});
}

/// Two, and 0.
STRATUS_INLINE QuantityLanes two_quantities(float a, float b) {
#if defined(__SSE4_1__)
    return QuantityLanes(
        QuantityLanes::Floats(_mm_insert_ps(to_register(a), to_register(b), 0x1c)));
#else
    return quantities(a, b);
#endif
}

/// The first of one, and what follows of another.
STRATUS_INLINE QuantityLanes with_first(QuantityLanes x, QuantityLanes rest) {
    return quantities(x.v[0], rest.v[1], rest.v[2], rest.v[3]);
}

/// The first two of either.
STRATUS_INLINE QuantityLanes low_and_low(QuantityLanes a, QuantityLanes b) {
    return quantities(a.v[0], a.v[1], b.v[0], b.v[1]);
}

STRATUS_INLINE float sum_of_all(QuantityLanes x) {
    const QuantityLanes halves = x + quantities(x.v[2], x.v[3], x.v[2], x.v[3]);
    return halves.v[0] + halves.v[1];
}

}  // namespace
}  // namespace stratus
