// The solver's options applied: checks, truncation and modes.
#pragma once

#include <stratus/transfer/solve.h>

#include "layer.h"

namespace stratus {

/// Throws std::invalid_argument, naming the option, when one is out of its range.
void check_options(const SolverOptions& options);

/// The moments of a phase function that the nodes resolve, truncated as the options say; `delta_m`
/// where what narrow peaks scatter again is not corrected for; backward ones then stay as they are.
Truncation choose_truncation(const PhaseFunction& phase_function, const SolverOptions& options,
                             bool delta_m);

/// Whether what a forward peak scatters again is left to the path law (path_law.h); `truncation` is
/// that without delta-M.
bool follows_paths(const PhaseFunction& phase_function, const Truncation& truncation,
                   const SolverOptions& options);

/// The moments that a path law is summed from, 2^20 at most: Henyey-Greenstein needs these at
/// g = 0.99998; tabulated functions 8,192, which take the square of their number to integrate.
///
/// Errors   std::invalid_argument where they do not suffice.
std::vector<double> path_moments(const PhaseFunction& phase_function);

/// Truncation of the lower boundary's phase function; none for a surface.
Truncation choose_truncation(const LowerBoundary& boundary, const SolverOptions& options);

/// The lower boundary with the albedo that its single scattering has after truncation. [NT88]
LowerBoundary truncated(const LowerBoundary& boundary, const Truncation& truncation);

/// Moments to a node where peaks between nodes stay in their direction (docs/accuracy.md).
inline constexpr int moments_completed = 4;

/// Throws std::invalid_argument when its albedo is out of range.
void check_boundary(const LowerBoundary& boundary);

/// Throws TooFewNodes when a mode is not finite.
void require_finite(const ModeMatrices& layer, int mode, const Directions& directions);

/// Modes up to the last nonzero moment; nothing is scattered into higher ones.
int count_modes(const std::vector<double>& moments);

/// The cosines of a solution: the requested ones, or the Gauss nodes.
Eigen::VectorXd solved_cosines(const Directions& directions);

/// One set of directions for all layers, dense near mu = 1 if any layer needs it, or at grazing angles if
/// the options ask for these.
Directions stack_directions(const std::vector<Truncation>& truncations,
                            const Truncation& boundary_truncation, const std::vector<double>& mu,
                            const SolverOptions& options);

}  // namespace stratus
