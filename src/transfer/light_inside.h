// The light inside a layer or a stack, at levels of optical depth: fluxes, actinic flux, heating, and
// radiance.
//
// Layers are divided at the levels and what is above a level is added to what is below [HT74]: the
// light between the two is that of the level. Everything is over the incident flux mu0 F0 of a beam
// from above, as R and T are (docs/conventions.md).
#pragma once

#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solve.h>

namespace stratus {

class StackPath;  // paths.h

/// Layers as single scattering knows them: themselves, or truncated.
struct SingleLayers {
    std::vector<double> albedos, depths;

    /// `albedo`: that of the truncation which counts.
    SingleLayers(const StackLayers& layers, const std::vector<Truncation>& truncations,
                 double (Truncation::*albedo)(double) const);

    /// The optical depth of the layers `first` to before `end`.
    double depth(std::size_t first, std::size_t end) const;

    /// Light that layer k scatters once to the level below the first `above` layers: down if it is one
    /// of them, up otherwise.
    double scattered(std::size_t k, std::size_t above, double phase, double mu_in,
                     double mu_out) const;
    /// Returns that for phase 1 between all `mu`, out of row, into column.
    Eigen::MatrixXd factors(std::size_t k, std::size_t above, const Eigen::VectorXd& mu) const;
};

/// Light at a level. What ModeSolution calls plane_albedo is the upward flux, diffuse_transmittance the
/// downward one without the beam; modes are the light of orders n >= 2 that goes up (Side::reflection)
/// and down.
struct LightAtLevel : ModeSolution {
    double optical_depth = 0;
    std::size_t pieces_above = 0;  // of InsideSolution

    Eigen::VectorXd direct_flux;   // at mu: exp(-tau / mu)
    Eigen::VectorXd actinic_flux;  // at mu: 4 pi times the mean intensity, the beam included
    Eigen::VectorXd
        heating_rate;  // at mu: what is absorbed of it, per unit of optical depth; between
                       // two layers, in the lower one
};

/// A stack solved at levels.
struct InsideSolution {
    std::vector<LightAtLevel> levels;       // as asked
    StackLayers layers;                     // divided at the levels
    std::vector<Truncation> truncations;    // of these
    std::shared_ptr<const StackPath> path;  // null unless a layer's peak is narrow
    LowerBoundary lower_boundary;
    Truncation boundary_truncation;

    /// pi I / (mu0 F0) of the diffuse light at a level, going up (Side::reflection) or down, between
    /// mu(in) and mu(out) at azimuths in radians. `single` is light scattered once, by the layers or
    /// the lower boundary.
    std::vector<SolvedValue> values(Side side, int in, int out, const std::vector<double>& azimuths,
                                    std::size_t level = 0) const;
};

/// Solves a stack on a lower boundary at levels, lit from above by beams at the cosines `mu`.
///
/// Range    layers, boundary, mu and options as of solve_stack (stack.h), all orders; levels finite,
///          in [0, the whole depth].
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy net fluxes differ from level to level by what is absorbed between, to 1e-13 of the incident
///          flux at moderate depth. Radiance in narrow peaks is as exact as that of stacks; fluxes
///          are, as there, with Truncate::delta_m and some 64 nodes.
/// Cost     for each level that of a layer more (stack.h).
InsideSolution solve_inside(const StackLayers& layers, const LowerBoundary& boundary,
                            const std::vector<double>& levels, const std::vector<double>& mu,
                            const SolverOptions& options = {});

}  // namespace stratus
