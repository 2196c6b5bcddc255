// Layers and stacks solved without a table.
#include <stratus/io/phase_file.h>
#include <stratus/stratus_baker.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "errors.h"
#include "handles.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <variant>
#include <vector>

namespace stratus::c {
namespace {

constexpr std::size_t cosines_at_once = 64;  // extra directions cost as much as nodes do

struct Problem {
    std::vector<StackLayer> layers;
    LowerBoundary below;
    SolverOptions options;
};

LowerBoundary below_of(const stratus_problem& problem, const char* function) {
    require(problem.below >= STRATUS_NOTHING_BELOW && problem.below <= STRATUS_LAYER_BELOW,
            function, "problem.below", "nothing, a surface or a layer, 0 to 2", problem.below);
    if (problem.below == STRATUS_NOTHING_BELOW) return {};
    const double albedo = problem.below_albedo;
    require(albedo >= 0 && albedo <= 1, function, "problem.below_albedo", "in [0, 1]", albedo);
    if (problem.below == STRATUS_SURFACE_BELOW) return LowerBoundary::surface(albedo);
    require_given(problem.below_phase_function, function, "problem.below_phase_function");
    return LowerBoundary::layer(read_phase_function(problem.below_phase_function), albedo);
}

Problem problem_of(const stratus_problem* asked, const char* function) {
    require_given(asked, function, "problem");
    require_size(*asked, function, "problem");
    Problem problem{
        layers_of(asked->layers, asked->layer_count, function), below_of(*asked, function), {}};
    check_layers(problem.layers, problem.below.is_present(), function);
    if (asked->nodes != 0) problem.options.nodes = asked->nodes;
    problem.options.orders = asked->orders;
    return problem;
}

std::variant<LayerSolution, StackSolution> solved(const Problem& problem,
                                                  const std::vector<double>& mu) {
    if (problem.layers.size() > 1)
        return solve_stack(problem.layers, problem.below, mu, problem.options);
    const StackLayer& layer = problem.layers.front();
    return solve_layer(layer.phase_function, layer.albedo, layer.optical_depth, mu, problem.options,
                       problem.below);
}

stratus_scattered in_c(const SolvedValue& value) { return {value.single, value.multiple}; }

/// Solves geometries from `first` on, as many as share a list of cosines; returns the next one.
std::size_t solve_some(const Problem& problem, const stratus_geometry* geometries,
                       std::size_t first, std::size_t count, stratus_scattered* reflection,
                       stratus_scattered* transmission) {
    std::map<double, int> places;
    std::vector<double> mu;
    std::size_t end = first;
    for (; end < count && mu.size() + 2 <= cosines_at_once; ++end)
        for (const double cosine : {geometries[end].mu_in, geometries[end].mu_out})
            if (places.try_emplace(cosine, static_cast<int>(mu.size())).second)
                mu.push_back(cosine);
    std::visit(
        [&](const auto& solution) {
            for (std::size_t i = first; i < end; ++i) {
                const stratus_geometry& at = geometries[i];
                const int in = places.at(at.mu_in), out = places.at(at.mu_out);
                if (reflection != nullptr)
                    reflection[i] = in_c(solution.reflection(in, out, at.azimuth));
                if (transmission != nullptr)
                    transmission[i] = in_c(solution.transmission(in, out, at.azimuth));
            }
        },
        solved(problem, mu));
    return end;
}

void require_cosine(double mu, const char* function, const char* argument) {
    require(mu > 0 && mu <= 1, function, argument, "in (0, 1]", mu);
}

}  // namespace
}  // namespace stratus::c

using namespace stratus::c;
using stratus::require;

int stratus_solve(const stratus_problem* problem, size_t count, const stratus_geometry* geometries,
                  stratus_scattered* reflection, stratus_scattered* transmission) {
    const char* const function = __func__;
    return status_of([&] {
        const Problem asked = problem_of(problem, function);
        if (count == 0) return;
        require_given(geometries, function, "geometries");
        for (std::size_t i = 0; i < count; ++i) {
            require_cosine(geometries[i].mu_in, function, "mu_in");
            require_cosine(geometries[i].mu_out, function, "mu_out");
            require(std::isfinite(geometries[i].azimuth), function, "azimuth", "finite",
                    geometries[i].azimuth);
        }
        for (std::size_t i = 0; i < count;)
            i = solve_some(asked, geometries, i, count, reflection, transmission);
    });
}

int stratus_solve_fluxes(const stratus_problem* problem, size_t count, const double* mu,
                         double* plane_albedo, double* diffuse_transmittance,
                         stratus_fluxes* uniform) {
    const char* const function = __func__;
    return status_of([&] {
        Problem asked = problem_of(problem, function);
        if (uniform != nullptr) require_size(*uniform, function, "uniform");
        require_arrays(count, {mu}, function);
        for (std::size_t i = 0; i < count; ++i) require_cosine(mu[i], function, "mu");
        asked.options.modes = 1;  // fluxes are made of the first azimuthal mode alone
        const auto solution =
            solved(asked, count == 0 ? std::vector<double>{} : std::vector<double>(mu, mu + count));
        const stratus::ModeSolution& found =
            std::visit([](const auto& of) -> const stratus::ModeSolution& { return of; }, solution);
        if (plane_albedo != nullptr) std::copy_n(found.plane_albedo.data(), count, plane_albedo);
        if (diffuse_transmittance != nullptr)
            std::copy_n(found.diffuse_transmittance.data(), count, diffuse_transmittance);
        if (uniform != nullptr)
            fill(*uniform, {sizeof(stratus_fluxes), found.spherical_albedo,
                            found.total_transmittance, found.spherical_ground_absorptance});
    });
}
