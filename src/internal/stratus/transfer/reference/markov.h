// Multiple scattering as a Markov chain [EH78]: a reference solver that neither doubles nor adds;
// it shares nodes and single scattering with the solver.
//
// The layer is divided into sublayers. A state of light is the sublayer of its last scattering and
// its direction since; from there it is scattered again in some sublayer (Q) or leaves. With B the
// first collisions of a beam and E the light that every state sends into the exit directions, order
// n >= 2 of the Neumann series is E Q^(n-2) B, and their sum E (I - Q)^-1 B. Paths are integrated
// exactly over sublayers of uniform source; that leaves an error of order K^-2 in their number K,
// which is extrapolated from K/2, K and 2 K. Order 1 is the closed form.
#pragma once

#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve.h>

#include <Eigen/Core>

#include <vector>

namespace stratus {

struct MarkovOptions {
    int nodes = 16;           // Gauss nodes in (0, 1)
    int sublayers = 32;       // K, even; 2 K x nodes at most 8192
    int modes = 0;            // azimuthal modes; 0: until negligible
    int orders = 0;           // the highest order of scattering; 0: all
    bool extrapolate = true;  // false: 2 K sublayers as they are, for studies of convergence
};

/// R or T and an estimate of its error in K: the change from the extrapolation of K/2 and K to that
/// of K and 2 K.
struct MarkovValue {
    SolvedValue value;
    double error;
};

/// Mode m of one order, between all requested cosines.
struct MarkovOrder {
    std::vector<Eigen::MatrixXd> reflection_modes, transmission_modes;
};

struct MarkovSolution {
    LayerSolution layer;             // R, T and fluxes up to the highest order; no truncation
    std::vector<MarkovOrder> order;  // order[n - 2] for n = 2 .. orders; empty when all are solved
    double flux_error = 0;           // of every flux in `layer`
    Eigen::MatrixXd reflection_error, transmission_error;  // between layer.mu, at any azimuth

    /// R between layer.mu(in) and layer.mu(out) at an azimuth in radians.
    MarkovValue reflection(int in, int out, double azimuth) const;
    /// Diffuse T likewise.
    MarkovValue transmission(int in, int out, double azimuth) const;

    /// Order n of R, n = 1 .. orders; 1 is the closed form.
    double reflection_of_order(int n, int in, int out, double azimuth) const;
    /// Order n of T likewise.
    double transmission_of_order(int n, int in, int out, double azimuth) const;
};

/// Solves one layer at the cosines `mu` (none: at the Gauss nodes) by the chain.
///
/// Source   [EH78]; the layer is folded at its mid-plane, which halves the matrices.
/// Range    albedo [0, 1]; optical_depth [0, inf): sublayers cannot fill a semi-infinite
///          layer; mu [1e-100, 1].
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy K = 32: 1e-5 of R and T at depth 1, 5e-4 at depth 8 (cosines from 0.02), eight times
///          better with each doubling of K. The stated error is some 3 to 50 times the true error
///          in K; that of the nodes (quadrature.h) comes on top.
/// Cost     (4/3) (2 K nodes)^3 operations a mode, and a seventh more.
MarkovSolution solve_markov(const PhaseFunction& phase_function, double albedo,
                            double optical_depth, const std::vector<double>& mu,
                            const MarkovOptions& options = {});

}  // namespace stratus
