// The line law: what a narrow backward peak scatters more than once, in closed form.
//
// Derived here. Light that is scattered straight back, again and again, runs to and fro along one
// line. Each Legendre moment of its directions by itself obeys a two-stream equation in optical
// depth t along a line of cosine mu, with b = w (-1)^l chi_l,
//
//     mu dD/dt = -D + b U      -mu dU/dt = -U + b D      k = sqrt(1 - b^2)   r = b / (1 + k)
//
// D downward, U upward. Lit from above, with K = k tau / mu,
//
//     D(t) = (e^(-k t/mu) - r^2 e^(k t/mu - 2 K)) / (1 - r^2 e^(-2 K))
//     U(t) = r (e^(-k t/mu) - e^(k t/mu - 2 K)) / (1 - r^2 e^(-2 K))
//
// Between two cosines light turns from one line (0) to another (1) at any of its n scatterings, at
// each as likely as at any other, as in path_law.h. The n-th term of a power series in b becomes
// 1/n of itself by integration:
//
//     R_l = (-1)^l / (4 mu mu0)  int_0^b db int_0^tau dt [D0(t) D1(t) + U0(t) U1(t)]
//     T_l =      1 / (4 mu mu0)  int_0^b db int_0^tau dt [D0(t) U1(tau - t) + U0(t) D1(tau - t)]
//
// Odd orders leave in R, even ones in T; order 1 is single scattering, exact. Nodes hold a series
// that ends smoothly (truncation.h), with moments c_l: orders n >= 2 are its modes, and the law of
// chi_l less that of c_l.
#pragma once

#include <stratus/layer/single_scattering.h>

#include <cstddef>
#include <vector>

namespace stratus {

class BackwardPath {
  public:
    /// All moments of a phase function as far as they matter, and those that the nodes hold.
    BackwardPath(std::vector<double> moments, std::vector<double> kept);

    /// Legendre coefficients, 2l + 1 included, of what is added to the modes and to single
    /// scattering of R (T). Of infinite depth there is no T.
    ///
    /// Accuracy 1e-9 of the largest coefficient.
    std::vector<double> legendre(Side side, double albedo, double optical_depth, double mu_in,
                                 double mu_out) const;

  private:
    std::vector<double> back_, kept_;  // (-1)^l chi_l and (-1)^l c_l
    std::size_t first_ = 0;            // l from which on they differ
    double largest_ = 0;               // of |back_| from there on
};

}  // namespace stratus
