// A layer of a stack as the lookups of a bound slice read it.
#pragma once

#include <stratus/phase/phase_curve.h>

namespace stratus {

/// A layer of a stack, or a semi-infinite one that it lies on.
struct SliceLayer {
    PhaseCurveView phase;  // sampled
    float above, below;    // optical depths of the layers around it
    float optical_depth, quarter_albedo;
};

}  // namespace stratus
