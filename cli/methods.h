// The ways in which `stratus solve` can solve: the solver itself and the reference solvers.
#pragma once

#include <stratus/bake/stack_file.h>
#include <stratus/transfer/solve.h>

#include <cstdint>

namespace stratus {

/// One layer and how to solve it; 0 or "" stands for what suits the scheme.
struct SolveRequest {
    PhaseFunction phase_function;
    double albedo = 0, optical_depth = 0;
    std::string scheme = "harmonic";
    int nodes = 0;            // harmonic: 0: as many as the tolerance needs
    double tolerance = 1e-4;  // harmonic, relative
    int orders = 0;           // harmonic, markov: one by one; photons: the last one followed
    std::string start;        // classic
    double start_depth = 0;   // classic
    int sublayers = 0;        // markov
    std::uint64_t photons = 0, seed = 1;  // photons
    int backward_collisions = 0;          // photons
    int threads = 0;                      // photons
};

/// R and T at one geometry, and the values of the method's own columns.
struct MethodRow {
    PerSide<SolvedValue> value;
    std::vector<double> more;
    PerSide<bool> misses{};  // the tolerance
};

/// Fluxes by name, in output order: under uniform illumination, and lists of
/// them at cosines or by order.
struct MethodFluxes {
    std::vector<std::pair<std::string, double>> uniform;
    std::vector<std::pair<std::string, std::vector<double>>> lists;
    bool misses = false;  // the tolerance
};

struct Method {
    std::vector<std::string> more_columns;
    std::size_t max_cosines = 64;  // solved at once: extra directions cost as much as nodes do
    std::function<std::vector<MethodRow>(const std::vector<Geometry>&)> rows;
    std::function<MethodFluxes(const std::vector<double>& mu)> fluxes;
};

/// Options of the solver, harmonic, without orders.
SolverOptions make_options(const SolveRequest& request);

/// Errors   std::invalid_argument for what a scheme cannot solve.
Method make_method(const SolveRequest& request);
Method make_method(const Stack& stack, const SolveRequest& how);  // by the solver

}  // namespace stratus
