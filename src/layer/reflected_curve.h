// The curve read by fast lookups of single scattering on the lit side: the layer's phase function
// with its opposition, and that of a layer that is its lower boundary.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/effects.h>
#include <stratus/phase/phase_curve.h>

namespace stratus {

/// The phase function, times Hapke's opposition if that is the law, and side by side with it the
/// phase function of a layer that is the lower boundary, where there is one. Null: no lower
/// boundary.
PhaseCurve reflected_curve(const PhaseFunction& phase_function, const Opposition& opposition,
                           const LowerBoundary* boundary);

}  // namespace stratus
