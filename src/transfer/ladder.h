// Layers of one phase function: all albedos at all depths of a ladder, mode after mode.
#pragma once

#include <stratus/transfer/solution.h>
#include <stratus/transfer/solver_options.h>

#include "depth_regime.h"

#include <vector>

namespace stratus {

struct LadderProblem {
    const PhaseFunction& phase_function;
    const std::vector<double>& albedos;
    std::vector<Eigen::VectorXd> order_weights;  // of each albedo; empty: all orders
    DepthLadder ladder;
    std::vector<DepthTarget> targets;  // depths that the last ones of the ladder lead to
    const std::vector<double>& mu;
    const SolverOptions& options;
    const LowerBoundary& boundary;
};

/// Every depth of a ladder is its own target.
std::vector<DepthTarget> targets_of(const DepthLadder& ladder);

/// result[albedo][target].
std::vector<std::vector<LayerSolution>> solve_problem(const LadderProblem& problem);

}  // namespace stratus
