#include "solved_stack.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>

namespace stratus {

bool is_transparent(const Stack& stack) {
    return !stack.lower_boundary.is_present() && !std::isinf(stack.optical_depth());
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

std::vector<double> even_cosines(int count) {
    std::vector<double> mu;
    for (int k = 0; k < count; ++k) {
        const double root = std::sin(pi / 2 * k / (count - 1));
        mu.push_back(k == 0 ? grazing : std::min(1.0, root * root));
    }
    return mu;
}

std::vector<double> even_azimuths(int count) {
    std::vector<double> azimuths;
    for (int k = 0; k < count; ++k) azimuths.push_back(k * pi / (count - 1));
    return azimuths;
}

std::vector<LitSide> lit_sides(const Material& material, const std::vector<SolvedStack>& colours) {
    std::vector<LitSide> sides{{"reflection", &SolvedStack::reflection}};
    if (material.is_opaque()) return sides;
    sides.push_back({"transmission", &SolvedStack::transmission});
    if (!std::all_of(colours.begin(), colours.end(),
                     [](const SolvedStack& of) { return of.is_symmetric(); }))
        sides.push_back({"reflection_below", &SolvedStack::reflection_below});
    return sides;
}

std::vector<double> beam_depths(const Material& material) {
    std::vector<double> depths;
    for (const Stack& stack : material.colours)
        depths.push_back(is_transparent(stack) ? stack.optical_depth() : infinity);
    return depths;
}

}  // namespace stratus
