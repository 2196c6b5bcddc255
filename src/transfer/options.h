// What the solver's options mean to those who follow them.
#pragma once

#include <stratus/transfer/solve.h>

#include "lanes/lanes.h"

namespace stratus {

/// Throws std::invalid_argument, naming the option, when one is out of its range.
void check_options(const SolverOptions& options);

const LaneMethods& methods_of(const SolverOptions& options);

/// As many moments of a phase function as the nodes resolve, truncated where the options say so.
Truncation truncation_of(const PhaseFunction& phase_function, const SolverOptions& options);

}  // namespace stratus
