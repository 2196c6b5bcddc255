// Solutions that tables are made from: a layer at some albedos and depths, or a stack.
#pragma once

#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solve.h>

#include <vector>

namespace stratus {

/// Solutions over [albedo][depth] (solve_ladder); of a stack, whose `layers` are top first, the one
/// that there is. `phase_function`, `albedos` and `ladder` are those of a layer, or of the stack's
/// mean layer.
std::vector<std::vector<LayerSolution>> solve_material(
    const std::vector<StackLayer>& layers, const PhaseFunction& phase_function,
    const std::vector<double>& albedos, const DepthLadder& ladder, const std::vector<double>& mu,
    const SolverOptions& options, const LowerBoundary& boundary);

/// The phase functions in a layer, or in a stack's layers, and of a semi-infinite layer below.
std::vector<PhaseFunction> list_phase_functions(const std::vector<StackLayer>& layers,
                                                const PhaseFunction& phase_function,
                                                const LowerBoundary& boundary);

}  // namespace stratus
