// The solver: reflection and transmission of a homogeneous plane-parallel layer at any geometry.
//
// All azimuthal modes are doubled from a thin layer to the requested depth; single scattering is
// subtracted from every mode in closed form and added again with the exact phase function, so that
// the Fourier series only carries orders n >= 2. Conventions (docs/conventions.md): R = pi I /
// (mu0 F0), T its diffuse counterpart, f = f_0 + 2 sum f_m cos(m dphi).
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solution.h>
#include <stratus/transfer/solver_options.h>

#include <vector>

namespace stratus {

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
/// Accuracy every order to rounding, however weak (src/transfer/ordered_ladder.h).
std::vector<LayerSolution> solve_orders(const PhaseFunction& phase_function, double albedo,
                                        double optical_depth, const std::vector<double>& mu,
                                        const SolverOptions& options);

/// Solves several albedos at all depths of a ladder: result[a][d], infinity last. The lower
/// boundary is solved once for all depths.
std::vector<std::vector<LayerSolution>> solve_ladder(const PhaseFunction& phase_function,
                                                     const std::vector<double>& albedos,
                                                     const DepthLadder& ladder,
                                                     const std::vector<double>& mu,
                                                     const SolverOptions& options = {},
                                                     const LowerBoundary& boundary = {});

/// Diffusion exponent k: light deep inside an unbounded medium decays as exp(-k tau). 0 at w = 1.
///
/// Source   1/k^2 is the largest eigenvalue of (B A)^-1 in mode 0, A and B as in
///          simd/thin_layer.cpp.
double compute_diffusion_exponent(const PhaseFunction& phase_function, double albedo,
                                  const SolverOptions& options = {});

/// Returns the exponents of several albedos: the phase kernels are computed once.
std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos,
                                                const SolverOptions& options = {});

}  // namespace stratus
