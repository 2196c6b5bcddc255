// `stratus solve --levels`: the light inside a layer or a stack, as CSV.
#pragma once

#include <stratus/bake/stack_file.h>
#include <stratus/transfer/solver_options.h>

#include <string>
#include <vector>

namespace stratus {

struct LevelsCommand {
    Stack stack;
    std::vector<double> levels, mu_in;
    std::string query, output;
    SolverOptions options;
};

/// Writes fluxes at every level for every mu_in. Returns what misses the tolerance, in words; "" where
/// nothing does.
std::string answer_fluxes_inside(const LevelsCommand& command);

/// Writes radiance at every level for every row of the query, and returns what misses likewise.
std::string answer_query_inside(const LevelsCommand& command);

}  // namespace stratus
