// The reference solvers' own phase kernels: independent of simd/phase_kernels.cpp on purpose, so
// that comparing classic doubling or the Markov chain with the solver also checks the kernels.
#pragma once

#include "../layer.h"

#include <vector>

namespace stratus {

/// Mode kernels by the addition theorem, mode 0 rescaled to conserve energy.
PhaseKernels reference_phase_kernels(const Directions& directions,
                                     const std::vector<double>& moments, int mode);

}  // namespace stratus
