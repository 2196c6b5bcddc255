// R, T and fluxes with their estimated errors, from as many Gauss nodes as a tolerance needs.
//
// The layer is solved with 8 nodes, then 12, 20, 32, 48, ..., half as many again at each step, until
// the changes from step to step say that what is asked for is within the tolerance
// (src/transfer/convergence.h). bench/tolerance_bench.cpp compares the estimates with the truth.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solver_options.h>

#include <vector>

namespace stratus {

/// R or T at one geometry. single + multiple = total to rounding; single is the closed form of the
/// layer itself.
struct SolvedValue {
    double total;
    double single;
    double multiple;
};

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
/// Range    one layer or more; albedos [0, 1]; optical depths [0, inf), of the last one [0, inf]
///          without a lower boundary; cosines [1e-100, 1]; options of the harmonic scheme. Where
///          options.tolerance is 0, options.nodes are used, and compared with fewer.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy 99 % of the errors are below 1.5 times their estimate (docs/accuracy.md). A tolerance
///          that 512 nodes do not reach, or would not by the pace so far, is missed: see the errors.
/// Cost     that of the last solution, and a third of it for the others; a solution for every 62
///          cosines; geometries with a cosine below 0.15, and below 0.05, have solutions of their own;
///          one layer of a narrow peak is solved otherwise there (docs/accuracy.md), at two to four
///          times the cost.
SolvedGeometries solve_geometries(const StackLayers& layers, const LowerBoundary& boundary,
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
ChosenNodes choose_nodes(const StackLayers& layers, const LowerBoundary& boundary,
                         const SolverOptions& options);

/// Fluxes of all orders over the incident flux [HT74]. Over a lower boundary the transmitted ones are
/// those incident on it, interreflection with the layer included.
struct SolvedFluxes {
    std::vector<double> plane_albedo, diffuse_transmittance;  // at `mu`
    std::vector<double> ground_absorptance;  // at `mu`, of the lower boundary; empty without one
    double spherical_albedo = 0;             // URU
    double total_transmittance = 1;          // UTU: uniform illumination, diffuse and beam
    double spherical_ground_absorptance = 0;

    double error = 0;  // the largest that is estimated of any of them
    double relative_error = 0;
    int nodes = 0;
};

/// Fluxes likewise, at the cosines `mu` or none, relative to which the tolerance is.
SolvedFluxes solve_fluxes(const StackLayers& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options);

/// Fluxes at a level inside, for beams at the cosines `mu`, over the incident flux.
struct FluxesAtLevel {
    double optical_depth;
    std::vector<double> direct, diffuse;  // going down: exp(-tau / mu), and scattered
    std::vector<double> upward;
    std::vector<double> actinic;       // 4 pi times the mean intensity, the beam included
    std::vector<double> heating_rate;  // what is absorbed of it, per unit of optical depth; between
                                       // two layers, in the lower one
};

struct SolvedInside {
    std::vector<FluxesAtLevel> levels;  // as asked
    double error = 0;                   // the largest that is estimated of any flux
    double relative_error = 0;
    int nodes = 0;
};

/// Fluxes at levels inside likewise, lit from above, all of them with the same nodes.
///
/// Range    levels finite, in [0, the whole depth]; one cosine or more.
SolvedInside solve_fluxes_inside(const StackLayers& layers, const LowerBoundary& boundary,
                                 const std::vector<double>& levels, const std::vector<double>& mu,
                                 const SolverOptions& options);

/// Diffuse radiance at a level inside likewise, pi I / (mu0 F0): that going up as `reflection`, that
/// going down as `transmission`.
SolvedGeometries solve_geometries_inside(const StackLayers& layers, const LowerBoundary& boundary,
                                         double level, const std::vector<Geometry>& geometries,
                                         const SolverOptions& options);

}  // namespace stratus
