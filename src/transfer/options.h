// What the solver's options mean: checks, truncation and modes.
#pragma once

#include <stratus/runtime/lower_boundary.h>
#include <stratus/transfer/layer.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solution.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

namespace stratus {

/// Throws std::invalid_argument, naming the option, when one is out of its range.
void check_options(const SolverOptions& options);

/// As many moments of a phase function as the nodes resolve, truncated where the options say so;
/// `delta_m` in stacks, where nothing puts back what a narrow peak scatters more than once.
Truncation truncation_of(const PhaseFunction& phase_function, const SolverOptions& options,
                         bool delta_m);

/// Of the lower boundary's phase function; a surface has none.
Truncation truncation_of(const LowerBoundary& boundary, const SolverOptions& options);

/// The lower boundary with the albedo that its single scattering has after truncation. [NT88]
LowerBoundary truncated(const LowerBoundary& boundary, const Truncation& truncation);

/// Throws std::invalid_argument when its albedo is out of range.
void check_boundary(const LowerBoundary& boundary);

/// Throws std::runtime_error, asking for more nodes, when a mode of a layer came out not finite.
void require_finite(const ModeMatrices& layer, int mode, const Directions& directions);

/// A value from its closed form, the same after truncation, and the orders above.
SolvedValue put_together(double single, double corrected, double orders);

/// Modes up to the last moment that is not 0; nothing is scattered into those beyond.
int count_modes(const std::vector<double>& moments);

/// The cosines of a solution: those that were asked for, or the Gauss nodes.
Eigen::VectorXd solved_cosines(const Directions& directions);

/// The map that serves both.
NodeMap joint_map(NodeMap a, NodeMap b);

}  // namespace stratus
