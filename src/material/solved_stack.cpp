#include "solved_stack.h"

#include <algorithm>
#include <cmath>

namespace stratus {

bool is_transparent(const Stack& stack) {
    return !stack.lower_boundary.is_present() && !std::isinf(optical_depth(stack));
}

double optical_depth(const Stack& stack) {
    double depth = 0;
    for (const StackLayer& layer : stack.layers) depth += layer.optical_depth;
    return depth;
}

SolvedStack::SolvedStack(const Stack& stack, const std::vector<double>& mu, int nodes)
    : transparent_(stratus::is_transparent(stack)) {
    SolverOptions options;
    options.nodes = nodes;
    above_ = solve_stack(stack.layers, stack.lower_boundary, mu, options);
    if (stack.layers.size() == 1 || !transparent_) return;
    std::vector<StackLayer> upside_down = stack.layers;
    std::reverse(upside_down.begin(), upside_down.end());
    below_ = solve_stack(upside_down, {}, mu, options);
}

std::vector<SolvedValue> SolvedStack::reflection(int in, int out,
                                                 const std::vector<double>& azimuths) const {
    return above_.values(Side::reflection, in, out, azimuths);
}

std::vector<SolvedValue> SolvedStack::reflection_below(int in, int out,
                                                       const std::vector<double>& azimuths) const {
    if (!transparent_) return std::vector<SolvedValue>(azimuths.size());
    return (below_ ? *below_ : above_).values(Side::reflection, in, out, azimuths);
}

std::vector<SolvedValue> SolvedStack::transmission(int in, int out,
                                                   const std::vector<double>& azimuths) const {
    if (!transparent_) return std::vector<SolvedValue>(azimuths.size());
    return above_.values(Side::transmission, in, out, azimuths);
}

}  // namespace stratus
