// What `stratus cost` measures of one layer, for the tests of studies.
#pragma once

#include <stratus/bake/cost.h>
#include <stratus/bake/recipe.h>

#include <string>

namespace stratus {

/// One layer with these lines added.
inline Recipe cost_recipe(const std::string& lines, const std::string& phase_function) {
    return parse_recipe("phase_function = '" + phase_function +
                        "'\n"
                        "tolerance = 0.1\n"
                        "optical_depth = { min = 1.0, max = 1.0 }\n"
                        "albedo = { min = 0.9, max = 0.9 }\n"
                        "sides = ['reflection']\n" +
                        lines);
}

/// Measured to the end of the sweeps.
inline CostStudy study_of(const std::string& lines,
                          const std::string& phase_function = "isotropic") {
    CostOptions options;
    options.seconds = 1e6;
    options.rounds = 1;
    return measure_cost(cost_recipe(lines, phase_function), options);
}

}  // namespace stratus
