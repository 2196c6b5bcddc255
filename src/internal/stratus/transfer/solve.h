// Solutions, then the functions that solve for them.
//
// A solved layer: its azimuthal modes, its fluxes, and R and T from them.
//
// The Fourier series carries orders n >= 2 of the truncated problem; single scattering is added in
// closed form with the exact phase function. Values at many directions: fourier_sum.h.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve_to_tolerance.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

namespace stratus {

/// Thrown where the phase function's series, of as many moments as the nodes hold, is so negative that a mode
/// is not finite.
class TooFewNodes : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// The correction for truncation at one pair of cosines: TMS minus the closed form of the layer
/// itself; where the peak is narrow, the path law and its rest (truncation.h), or the line law
/// of a backward peak. 0 without truncation.
struct PeakCorrection {
    double single = 0;  // per unit of phase function
    std::vector<double> legendre;

    double operator()(double phase_value, double cos_scattering_angle) const {
        return single * phase_value + sum_legendre(legendre, cos_scattering_angle);
    }
};

/// One azimuthal mode between the cosines of a solution.
struct AzimuthalMode {
    // mu.size() rows and columns; for a symmetric mode one column: the upper triangle, column by column
    Eigen::MatrixXd values;

    /// Returns the mode of a symmetric matrix, of which it keeps half.
    static AzimuthalMode symmetric(const Eigen::MatrixXd& all);

    /// Returns the value out of mu(in), into mu(out).
    double operator()(Eigen::Index in, Eigen::Index out) const {
        if (values.cols() > 1) return values(in, out);
        const Eigen::Index column = std::max(in, out);
        return values(column * (column + 1) / 2 + std::min(in, out));
    }
};

/// Fluxes of all orders over the incident flux. [HT74] Over a lower boundary the transmitted ones are
/// those incident on it, interreflection with the layer included.
struct ModeFluxes {
    Eigen::VectorXd plane_albedo;           // at mu
    Eigen::VectorXd diffuse_transmittance;  // at mu
    double spherical_albedo = 0;            // URU
    double total_transmittance = 1;         // UTU: uniform illumination, diffuse and beam

    // Share of the incident flux absorbed by the lower boundary; empty and 0 without one.
    Eigen::VectorXd ground_absorptance;  // at mu
    double spherical_ground_absorptance = 0;
};

/// Results at a list of cosines, common to all solutions.
struct ModeSolution : ModeFluxes {
    Eigen::VectorXd mu;  // the requested cosines, or the Gauss nodes
    LowerBoundary lower_boundary;
    Truncation boundary_truncation;

    // Orders n >= 2 of each mode of the problem after truncation. T is 0
    // where nothing is transmitted: at infinite depth and over a lower boundary.
    PerSide<std::vector<AzimuthalMode>> modes;
    PerSide<std::vector<double>> series;  // sums of the modes that a TakeMode took, as it sums them
};

/// Takes a solution's next mode, which is then not kept: many modes take more memory than their sums at some
/// directions. Returns whether it does.
using TakeMode =
    std::function<bool(ModeSolution& solution, Side side, int number, const AzimuthalMode& mode)>;

class BackwardPath;   // src/transfer/paths.h
class StackSolution;  // stack.h

/// A layer of one albedo and depth. Over a lower boundary reflection is that of both, and `single`
/// then counts light scattered once, by the layer or by the boundary.
class LayerSolution : public ModeSolution {
  public:
    double albedo = 0;
    double optical_depth = 0;

    // weight of order n in everything here, w^n or 0; empty: all orders
    Eigen::VectorXd order_weights;

    /// R or diffuse T between mu(in) and mu(out) at azimuths in radians. Only a truncated phase series
    /// that is itself negative makes them negative: more nodes help.
    std::vector<SolvedValue> values(Side side, int in, int out,
                                    const std::vector<double>& azimuths) const;
    SolvedValue reflection(int in, int out, double azimuth) const {
        return values(Side::reflection, in, out, {azimuth})[0];
    }
    SolvedValue transmission(int in, int out, double azimuth) const {
        return values(Side::transmission, in, out, {azimuth})[0];
    }

    /// The correction for truncation of R or T between mu(in) and mu(out), to be added to the modes.
    PeakCorrection peak_correction(Side side, int in, int out) const;

    /// Returns the weights of the path law's orders, w^n unless these are limited; needs `path`.
    Eigen::VectorXd path_orders() const;
    /// Returns the same times the factors of path_weights (path_law.h), between mu(in) and mu(out).
    PathWeights path_weights(Side side, int in, int out) const;

    /// The correction for light scattered once by the lower boundary, per unit of its phase function.
    double boundary_correction(int in, int out) const;

    PhaseFunction phase_function;
    Truncation truncation;
    std::shared_ptr<const TruncatedPath> path;          // null unless the peak is narrow
    std::shared_ptr<const BackwardPath> backward_path;  // null unless truncation.backward

    /// The stack that R, T and evaluate() (fourier_sum.h) describe; null: the layer itself. See as_one_layer (stack.h).
    std::shared_ptr<const StackSolution> stack;
};

// The solver: reflection and transmission of a homogeneous plane-parallel layer at any geometry.
//
// All azimuthal modes are doubled from a thin layer to the requested depth; single scattering is
// subtracted from every mode in closed form and added again with the exact phase function, so that
// the Fourier series only carries orders n >= 2. Conventions (docs/conventions.md): R = pi I /
// (mu0 F0), T its diffuse counterpart, f = f_0 + 2 sum f_m cos(m dphi).

/// Solves one layer at the cosines `mu`.
///
/// Range    albedo [0, 1]; optical_depth [0, inf]; mu in [1e-100, 1], none: at the Gauss nodes;
///          options as stated there.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy to rounding as nodes grow (docs/accuracy.md); energy is conserved to 1e-13 at w = 1 for
///          every depth.
/// Cost     2.3 N^3 operations a doubling and mode, N = nodes; some 30 doublings.
LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options = {},
                          const LowerBoundary& boundary = {});

/// The Neumann orders 1 to `options.orders` one by one: result[n - 1] is the light scattered
/// exactly n times, w^n times the order of the series; its total_transmittance leaves out the beam.
///
/// Range    options.orders [1, 200], with the harmonic scheme; the rest as for solve_layer.
/// Accuracy every order to rounding, however weak (src/transfer/doubling_ladder.h).
std::vector<LayerSolution> solve_orders(const PhaseFunction& phase_function, double albedo,
                                        double optical_depth, const std::vector<double>& mu,
                                        const SolverOptions& options);

/// Solves several albedos at all depths of a ladder: result[a][d], infinity last. The lower
/// boundary is solved once for all depths. Where modes are taken, options say how many there are.
std::vector<std::vector<LayerSolution>> solve_ladder(
    const PhaseFunction& phase_function, const std::vector<double>& albedos,
    const DepthLadder& ladder, const std::vector<double>& mu, const SolverOptions& options = {},
    const LowerBoundary& boundary = {}, const TakeMode& take = {});

/// Diffusion exponents k of some albedos: light deep inside an unbounded medium decays as
/// exp(-k tau). 0 at w = 1.
///
/// Source   1/k^2 is the largest eigenvalue of (B A)^-1 in mode 0, A and B as in
///          simd/doubling.cpp.
std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos);

}  // namespace stratus
