// R, T and fluxes with their estimated errors, from as many Gauss nodes as a tolerance needs.
//
// The layer is solved with 8 nodes, then 12, 20, 32, 48, ..., half as many again at each step, until
// the changes from step to step say that what is asked for is within the tolerance
// (src/transfer/convergence.h). bench/tolerance_bench.cpp compares the estimates with the truth.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/light_inside.h>
#include <stratus/transfer/solution.h>
#include <stratus/transfer/solver_options.h>

#include <vector>

namespace stratus {

struct SolvedGeometry {
    SolvedValue reflection, transmission;
    double reflection_error = 0, transmission_error = 0;  // estimated, of the totals
};

struct SolvedGeometries {
    std::vector<SolvedGeometry> at;  // in the order asked
    int nodes = 0;                   // the most that any of them was solved with
};

/// R and T of a layer or a stack on a lower boundary, top first, at any number of geometries.
///
/// Range    layers, boundary and options as for solve_stack; cosines [1e-100, 1]. Where
///          options.tolerance is 0, options.nodes are used, and compared with fewer.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy 99 % of the errors are below 1.5 times their estimate (docs/accuracy.md). A tolerance
///          that 512 nodes do not reach, or would not by the pace so far, is missed: see the errors.
/// Cost     that of the last solution, and a third of it for the others; a solution for every 62
///          cosines; geometries with a cosine below 0.15, and below 0.05, have solutions of their own;
///          one layer of a narrow peak is solved otherwise there (docs/accuracy.md), at two to four
///          times the cost.
SolvedGeometries solve_geometries(const std::vector<StackLayer>& layers,
                                  const LowerBoundary& boundary,
                                  const std::vector<Geometry>& geometries,
                                  const SolverOptions& options);

/// The error of R or T as a tolerance judges it: relative to the value, but to no less than 1e-8, as
/// of tables.
double relative_error(double value, double error) noexcept;

struct ChosenNodes {
    int nodes = 0;
    double error = 0;  // the largest relative error that is estimated
};

/// Nodes for what is solved at too many directions to estimate the error of each: as options say,
/// judged between the cosines 0.15, 0.35, 0.6, 0.85 and 1, at azimuths from 0 to 180 degrees.
ChosenNodes choose_nodes(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                         const SolverOptions& options);

struct SolvedFluxes {
    ModeSolution fluxes;  // at `mu`; without modes
    double error = 0;     // the largest that is estimated of any of them
    double relative_error = 0;
    int nodes = 0;
};

/// Fluxes likewise, at the cosines `mu` or none, relative to which the tolerance is.
SolvedFluxes solve_fluxes(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options);

struct SolvedInside {
    std::vector<LightAtLevel> levels;  // as asked, without modes
    double error = 0;                  // the largest that is estimated of any flux
    double relative_error = 0;
    int nodes = 0;
};

/// Fluxes at levels inside (light_inside.h) likewise, all of them with the same nodes.
SolvedInside solve_fluxes_inside(const std::vector<StackLayer>& layers,
                                 const LowerBoundary& boundary, const std::vector<double>& levels,
                                 const std::vector<double>& mu, const SolverOptions& options);

/// Diffuse radiance at a level inside likewise, pi I / (mu0 F0): that going up as `reflection`, that
/// going down as `transmission`.
SolvedGeometries solve_geometries_inside(const std::vector<StackLayer>& layers,
                                         const LowerBoundary& boundary, double level,
                                         const std::vector<Geometry>& geometries,
                                         const SolverOptions& options);

}  // namespace stratus
