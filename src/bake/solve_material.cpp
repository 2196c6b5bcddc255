#include "solve_material.h"

#include <stratus/transfer/stack.h>

namespace stratus {

std::vector<std::vector<LayerSolution>> solve_material(
    const std::vector<StackLayer>& layers, const PhaseFunction& phase_function,
    const std::vector<double>& albedos, const DepthLadder& ladder, const std::vector<double>& mu,
    const SolverOptions& options, const LowerBoundary& boundary) {
    if (layers.empty()) return solve_ladder(phase_function, albedos, ladder, mu, options, boundary);
    std::vector<std::vector<LayerSolution>> alone(1);
    alone[0].push_back(as_one_layer(solve_stack(layers, boundary, mu, options)));
    return alone;
}

std::vector<PhaseFunction> list_phase_functions(const std::vector<StackLayer>& layers,
                                                const PhaseFunction& phase_function,
                                                const LowerBoundary& boundary) {
    std::vector<PhaseFunction> all;
    for (const StackLayer& layer : layers) all.push_back(layer.phase_function);
    if (layers.empty()) all.push_back(phase_function);
    if (boundary.kind == LowerBoundary::Kind::layer) all.push_back(boundary.phase_function);
    return all;
}

}  // namespace stratus
