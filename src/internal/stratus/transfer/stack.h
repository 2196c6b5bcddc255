// The solver for stacks: homogeneous layers on top of one another, on a lower boundary.
//
// Each layer is doubled separately (solve.h) with its own truncation; the modes are then added from
// the top down [HT74]. Single scattering of the stack is in closed form: that of each layer,
// attenuated by the layers on the way in and out. What narrow peaks scatter again keeps to its path,
// through all layers (paths.h). One layer over nothing is solved as solve_layer does.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace stratus {

class StackPath;  // src/transfer/paths.h

/// A stack solved at a list of cosines. Lit from above; `solve_stack` of the layers in reverse
/// order is the stack lit from below.
class StackSolution : public ModeSolution {
  public:
    StackLayers layers;                 // top first; neighbours that scatter alike are one
    double spherical_albedo_below = 0;  // lit uniformly from below; 0 where nothing is transmitted

    /// R between mu(in) and mu(out) at an azimuth in radians; `single` counts light scattered once,
    /// by a layer or by the lower boundary.
    SolvedValue reflection(int in, int out, double azimuth) const {
        return values(Side::reflection, in, out, {azimuth})[0];
    }
    /// Diffuse T likewise.
    SolvedValue transmission(int in, int out, double azimuth) const {
        return values(Side::transmission, in, out, {azimuth})[0];
    }

    /// R or T at many azimuths.
    std::vector<SolvedValue> values(Side side, int in, int out,
                                    const std::vector<double>& azimuths) const;

    bool is_opaque() const;

    int order = 0;  // the only one that all of it is of (solve_orders); 0: all orders

    std::vector<Truncation> truncations;                // of the layers
    std::shared_ptr<const StackPath> path;              // null unless a layer's peak is narrow
    std::shared_ptr<const BackwardPath> backward_path;  // of a single layer over ground, likewise
    std::shared_ptr<const LayerSolution> alone;  // of a single layer over nothing: its solution
};

/// Solves a stack at the cosines `mu`.
///
/// Range    one layer or more; albedos [0, 1]; optical depths [0, inf), of the last one [0, inf]
///          without a lower boundary; mu in [1e-100, 1], none: at the Gauss nodes; options as
///          for solve_layer, of the harmonic scheme.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy that of solve_layer; splitting a layer changes R by rounding, and T by 1e-16 tau where
///          conservative.
StackSolution solve_stack(const StackLayers& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options = {});

/// The Neumann orders 1 to `options.orders` one by one: result[n - 1] is the light scattered exactly
/// n times, by layers or the lower boundary; its transmittances leave out the beam.
///
/// Range    options.orders [1, 200]; the rest as for solve_stack. Several layers, and any over a
///          lower boundary, are not truncated: narrow peaks take more nodes.
std::vector<StackSolution> solve_orders(const StackLayers& layers, const LowerBoundary& boundary,
                                        const std::vector<double>& mu,
                                        const SolverOptions& options);

/// The stack as one material: R, T and fluxes are its own; phase function, albedo and depth those
/// of its mean layer (stack_layers.h).
LayerSolution as_one_layer(StackSolution solution);

}  // namespace stratus
