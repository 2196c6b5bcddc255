// Isotropic scattering solved exactly by Chandrasekhar's functions: a reference solver that
// shares neither equations nor code with doubling, only the Gauss nodes.
//
// A semi-infinite layer is described by one function, H, a finite one by two, X and Y; R and T
// between any two directions follow in closed form [C60]:
//
//     R = (w/4) (X X0 - Y Y0) / (mu + mu0)        T = (w/4) (X Y0 - Y X0) / (mu0 - mu)
#pragma once

#include <Eigen/Core>

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

}  // namespace stratus
