// Layers and stacks solved without a table.
#include <stratus/io/phase_file.h>
#include <stratus/stratus_baker.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "errors.h"
#include "handles.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stratus::c {
namespace {

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
    constexpr double default_tolerance = 1e-4;
    if (asked->nodes != 0)
        problem.options.nodes = asked->nodes;
    else
        problem.options.tolerance = asked->tolerance != 0 ? asked->tolerance : default_tolerance;
    problem.options.orders = asked->orders;
    return problem;
}

stratus_solved in_c(const SolvedValue& value, double error) {
    return {value.single, value.multiple, error};
}

void require_cosine(double mu, const char* function, const char* argument) {
    require(mu > 0 && mu <= 1, function, argument, "in (0, 1]", mu);
}

}  // namespace
}  // namespace stratus::c

using namespace stratus::c;
using stratus::require;

int stratus_solve(const stratus_problem* problem, size_t count, const stratus_geometry* geometries,
                  stratus_solved* reflection, stratus_solved* transmission) {
    const char* const function = __func__;
    return status_of([&] {
        const Problem asked = problem_of(problem, function);
        if (count == 0) return;
        require_given(geometries, function, "geometries");
        std::vector<stratus::Geometry> all;
        for (std::size_t i = 0; i < count; ++i) {
            require_cosine(geometries[i].mu_in, function, "mu_in");
            require_cosine(geometries[i].mu_out, function, "mu_out");
            require(std::isfinite(geometries[i].azimuth), function, "azimuth", "finite",
                    geometries[i].azimuth);
            all.push_back({geometries[i].mu_in, geometries[i].mu_out, geometries[i].azimuth});
        }
        const stratus::SolvedGeometries solved =
            stratus::solve_geometries(asked.layers, asked.below, all, asked.options);
        for (std::size_t i = 0; i < count; ++i) {
            const stratus::SolvedGeometry& at = solved.at[i];
            if (reflection != nullptr) reflection[i] = in_c(at.reflection, at.reflection_error);
            if (transmission != nullptr)
                transmission[i] = in_c(at.transmission, at.transmission_error);
        }
    });
}

int stratus_solve_fluxes(const stratus_problem* problem, size_t count, const double* mu,
                         double* plane_albedo, double* diffuse_transmittance,
                         stratus_fluxes* uniform) {
    const char* const function = __func__;
    return status_of([&] {
        const Problem asked = problem_of(problem, function);
        if (uniform != nullptr) require_size(*uniform, function, "uniform");
        require_arrays(count, {mu}, function);
        for (std::size_t i = 0; i < count; ++i) require_cosine(mu[i], function, "mu");
        const stratus::SolvedFluxes solved = stratus::solve_fluxes(
            asked.layers, asked.below,
            count == 0 ? std::vector<double>{} : std::vector<double>(mu, mu + count),
            asked.options);
        const stratus::ModeSolution& found = solved.fluxes;
        if (plane_albedo != nullptr) std::copy_n(found.plane_albedo.data(), count, plane_albedo);
        if (diffuse_transmittance != nullptr)
            std::copy_n(found.diffuse_transmittance.data(), count, diffuse_transmittance);
        if (uniform != nullptr)
            fill(*uniform,
                 {sizeof(stratus_fluxes), found.spherical_albedo, found.total_transmittance,
                  found.spherical_ground_absorptance, solved.error});
    });
}
