#include "even_grid.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>

namespace stratus {

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
        depths.push_back(is_transparent(stack) ? optical_depth(stack) : infinity);
    return depths;
}

}  // namespace stratus
