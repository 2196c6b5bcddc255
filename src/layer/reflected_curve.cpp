#include "reflected_curve.h"

#include <stratus/base/constants.h>

namespace stratus {

PhaseCurve reflected_curve(const PhaseFunction& phase_function, const Opposition& opposition,
                           const LowerBoundary* boundary) {
    const bool of_hapke = opposition.law == Opposition::Law::hapke;
    const bool of_blinn = opposition.law == Opposition::Law::blinn;
    const bool over_layer = boundary != nullptr && boundary->kind == LowerBoundary::Kind::layer;
    const auto layer = [&](double c) {  // Hapke's law is one for all depths and cosines
        return phase_function(c) *
               (of_hapke ? opposition_factor(opposition, c, infinity, 1, 1) : 1);
    };
    if (!of_blinn && !over_layer)
        return of_hapke
                   ? PhaseCurve::sampled(1, [&](double c, double* value) { *value = layer(c); })
                   : PhaseCurve(phase_function);
    const auto both = [&](double c, double* value) {
        value[0] = layer(c);
        value[1] = over_layer ? boundary->phase_function(c) : 0;
    };
    return PhaseCurve::sampled(
        2, both, of_blinn ? PhaseForm::with_opposition_and_boundary : PhaseForm::with_boundary);
}

}  // namespace stratus
