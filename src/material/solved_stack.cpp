#include "solved_stack.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

std::variant<LayerSolution, StackSolution> solve(const Stack& stack, const std::vector<double>& mu,
                                                 const SolverOptions& options) {
    if (stack.layers.size() > 1)
        return solve_stack(stack.layers, stack.lower_boundary, mu, options);
    const StackLayer& layer = stack.layers.front();
    return solve_layer(layer.phase_function, layer.albedo, layer.optical_depth, mu, options,
                       stack.lower_boundary);
}

template <class Value>
std::vector<SolvedValue> at_each(const std::vector<double>& azimuths, const Value& value) {
    std::vector<SolvedValue> values;
    for (const double azimuth : azimuths) values.push_back(value(azimuth));
    return values;
}

}  // namespace

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
    above_ = solve(stack, mu, options);
    if (stack.layers.size() == 1 || !transparent_) return;
    std::vector<StackLayer> upside_down = stack.layers;
    std::reverse(upside_down.begin(), upside_down.end());
    below_ = solve_stack(upside_down, {}, mu, options);
}

std::vector<SolvedValue> SolvedStack::reflection(int in, int out,
                                                 const std::vector<double>& azimuths) const {
    if (const auto* layer = std::get_if<LayerSolution>(&above_))
        return layer->reflection(in, out, azimuths);
    const auto& layers = std::get<StackSolution>(above_);
    return at_each(azimuths, [&](double phi) { return layers.reflection(in, out, phi); });
}

std::vector<SolvedValue> SolvedStack::reflection_below(int in, int out,
                                                       const std::vector<double>& azimuths) const {
    if (!transparent_) return std::vector<SolvedValue>(azimuths.size());
    if (!below_) return reflection(in, out, azimuths);
    return at_each(azimuths, [&](double phi) { return below_->reflection(in, out, phi); });
}

std::vector<SolvedValue> SolvedStack::transmission(int in, int out,
                                                   const std::vector<double>& azimuths) const {
    if (!transparent_) return std::vector<SolvedValue>(azimuths.size());
    if (const auto* layer = std::get_if<LayerSolution>(&above_))
        return layer->transmission(in, out, azimuths);
    const auto& layers = std::get<StackSolution>(above_);
    return at_each(azimuths, [&](double phi) { return layers.transmission(in, out, phi); });
}

const ModeSolution& SolvedStack::solution() const {
    return std::visit([](const auto& solution) -> const ModeSolution& { return solution; }, above_);
}

}  // namespace stratus
