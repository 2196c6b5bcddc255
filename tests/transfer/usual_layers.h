// Directions, phase functions and options of the tests of layers.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/layer/lower_boundary.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solver_options.h>

#include <vector>

namespace stratus {

inline const std::vector<double> cosines{0.02, 0.1, 0.5, 0.9, 1.0};
inline const std::vector<double> azimuths{0, 1, 2, pi};

inline const PhaseFunction isotropic = PhaseFunction::isotropic();
inline const PhaseFunction rayleigh = PhaseFunction::rayleigh();
inline const PhaseFunction saturn =
    parse_phase_function("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
inline const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.75);
inline const PhaseFunction peaked = PhaseFunction::henyey_greenstein(0.95);

inline const LowerBoundary nothing;

inline SolverOptions with_nodes(int nodes) {
    SolverOptions options;
    options.nodes = nodes;
    return options;
}

}  // namespace stratus
