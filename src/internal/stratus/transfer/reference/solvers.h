// The reference solvers: isotropic scattering by H, X and Y, the Markov chain, and photons.
//
// Isotropic scattering solved exactly by Chandrasekhar's functions: a reference solver that
// shares neither equations nor code with doubling, only the Gauss nodes.
//
// A semi-infinite layer is described by one function, H, a finite one by two, X and Y; R and T
// between any two directions follow in closed form [C60]:
//
//     R = (w/4) (X X0 - Y Y0) / (mu + mu0)        T = (w/4) (X Y0 - Y X0) / (mu0 - mu)
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve.h>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <vector>

namespace stratus {

/// Chandrasekhar's H function for isotropic scattering.
///
/// Source   1/H(mu) = sqrt(1 - w) + (w/2) int_0^1 mu' H(mu') / (mu + mu') dmu'.  [C60] V, 36
class HFunction {
  public:
    /// Range    albedo [0, 1].
    /// Errors   std::invalid_argument naming the range and the value met.
    explicit HFunction(double albedo);

    /// H at a cosine in (0, 1].
    ///
    /// Accuracy 1e-13.
    double operator()(double mu) const;

    /// Integral of mu^order H over (0, 1), to 1e-13.
    double moment(int order) const;

  private:
    double albedo_;
    std::vector<double> mu_, weight_, H_;
};

/// An isotropic layer at the cosines `mu`. T is diffuse.
struct IsotropicSolution {
    Eigen::VectorXd mu;
    Eigen::VectorXd X, Y;          // H and 0 at infinite depth
    Eigen::MatrixXd reflection;    // of all orders
    Eigen::MatrixXd transmission;  // likewise
    Eigen::VectorXd plane_albedo;  // at mu
    Eigen::VectorXd diffuse_transmittance;
    double spherical_albedo = 0;
    double total_transmittance = 1;  // uniform illumination, diffuse and beam
};

/// Solves an isotropic layer by the equations of invariance in depth.
///
/// Source   dX/dtau = b Y,  dY/dtau = b X - Y/mu,  X(0) = Y(0) = 1,
///          b = (w/2) int_0^1 Y dmu'/mu' [C60]; unlike the integral equations of X and Y they have
///          a unique solution at w = 1 too, and lose no digits in deep layers.
/// Range    albedo [0, 1]; optical_depth [0, 1024] or inf; mu in [1e-12, 1]; nodes [1, 512].
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy R, T relative: 1e-10 up to depth 64; at w = 1 rounding grows as tau^2, to 2e-9 at 1024.
/// Cost     in proportion to nodes and depth: 15 ms at depth 8, 40 ms at 64, 0.4 s at 1024.
IsotropicSolution solve_isotropic(double albedo, double optical_depth,
                                  const std::vector<double>& mu, int nodes = 64);

// Multiple scattering as a Markov chain [EH78]: a reference solver that neither doubles nor adds;
// it shares nodes and single scattering with the solver.
//
// The layer is divided into sublayers. A state of light is the sublayer of its last scattering and
// its direction since; from there it is scattered again in some sublayer (Q) or leaves. With B the
// first collisions of a beam and E the light that every state sends into the exit directions, order
// n >= 2 of the Neumann series is E Q^(n-2) B, and their sum E (I - Q)^-1 B. Paths are integrated
// exactly over sublayers of uniform source; that leaves an error of order K^-2 in their number K,
// which is extrapolated from K/2, K and 2 K. Order 1 is the closed form.

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

struct MarkovSolution {
    LayerSolution layer;  // R, T and fluxes up to the highest order; no truncation
    // Modes of order n at [n - 2], n = 2 .. orders; none when all are solved.
    std::vector<PerSide<std::vector<AzimuthalMode>>> order;
    double flux_error = 0;           // of every flux in `layer`
    PerSide<Eigen::MatrixXd> error;  // between layer.mu, at any azimuth

    /// R between layer.mu(in) and layer.mu(out) at an azimuth in radians.
    MarkovValue reflection(int in, int out, double azimuth) const;
    /// Diffuse T likewise.
    MarkovValue transmission(int in, int out, double azimuth) const;

    /// Order n of R or T, n = 1 .. orders; 1 is the closed form.
    double of_order(Side side, int n, int in, int out, double azimuth) const;
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

// Monte Carlo in a homogeneous layer: a reference solver that shares nothing with the solver but
// the closed form of single scattering.
//
// Photons carry a weight; their flights are forced to end inside the layer, and Russian roulette
// ends paths of low weight. Before each flight the expected contribution of its collision to every
// requested direction is tallied (next-event estimation), averaged over the whole flight: a flight
// is a beam onto the part of the layer ahead, which scatters it once. One path serves all
// geometries of its mu_in. Order 1 is the closed form; photons estimate n >= 2.
//
// In a forward peak few photons fly nearly towards an exit, and those few count thousands of times.
// Paths are therefore also followed back from the exits, against the light, and each flight of a
// photon is joined to each of theirs by one collision. The layer is plane, so that flights which
// overlap in depth meet: the joint is single scattering by what both cross. A path of n collisions
// arises in several ways, joined at one or another of its last collisions. Each way counts with the
// share (1/phi at the joint) / (sum of 1/phi over these collisions); the shares of a path sum to 1
// and no way counts more than the smallest phi.

/// Calls body(i) once for every i = 0 .. count - 1, in any order, on any threads.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

struct PhotonOptions {
    std::uint64_t photons = 1'000'000;  // per distinct mu_in and for uniform illumination, >= 2
    std::uint64_t seed = 1;
    int highest_order = 0;        // paths end after this many scatterings; 0: followed to their end
    int backward_collisions = 0;  // of paths from the exits, [0, 100]; 0: next-event estimation
    ParallelFor parallel_for;     // none: serial
};

/// A mean and its standard error, from the spread of single photons.
struct Estimate {
    double value = 0;
    double standard_error = 0;
};

/// R or T at one geometry.
struct PhotonValue {
    SolvedValue value{};        // single is the closed form; single + multiple = total
    double standard_error = 0;  // of multiple, hence of total
    Estimate single;  // the photons' estimate of value.single, from their first collisions
};

struct PhotonGeometry {
    Geometry geometry{};
    PhotonValue reflection, transmission;
};

/// Fluxes of all orders followed, relative to the incident flux.
struct PhotonFluxes {
    Estimate albedo;         // plane or spherical
    Estimate transmittance;  // diffuse
    Estimate absorptance;
    double direct_transmittance = 1;  // closed form
};

struct PhotonSolution {
    std::vector<PhotonGeometry> geometries;  // as requested
    std::vector<double> mu_in;               // the distinct ones, in order of appearance
    std::vector<PhotonFluxes> plane;         // at mu_in
    PhotonFluxes uniform;                    // under uniform illumination
};

/// R, T and fluxes of one layer from photons.
///
/// Range    albedo [0, 1]; optical_depth [0, inf], finite at albedo 1 when all orders are followed;
///          cosines (0, 1].
/// Errors   std::invalid_argument naming argument, range and value; std::runtime_error when a
///          photon has not ended after 1e8 collisions.
/// Accuracy unbiased for every phase function, negative lobes of moment series included. Standard
///          errors are reliable (spread over seeds within 20 % of them from 5000 photons on) up to
///          g = 0.75, grazing cosines and layers of 1e-6 included; up to g = 0.99 and for a water
///          cloud's 768 moments from 10,000 photons on with 8 backward collisions. They are too
///          small where few photons carry the answer: forward peaks without backward collisions
///          (g = 0.99: 1e6 photons are not enough), T of absorbing layers below 1e-5 (below 1e-4
///          where paths end after a few orders), and, for `single` alone, cosines below 0.02.
///          Legendre series are tabulated, to 1e-7 of their values.
/// Cost     photons x collisions x geometries x (1 + backward_collisions); collisions grow like the
///          depth at w = 1.
/// Threads  bit-identical with every `parallel_for`; results of a beam depend on its mu_in only, with
///          backward collisions on its geometries too.
PhotonSolution solve_photons(const PhaseFunction& phase_function, double albedo,
                             double optical_depth, const std::vector<Geometry>& geometries,
                             const PhotonOptions& options = {});

}  // namespace stratus
