// Multiple scattering in a truncated forward peak: the light that TMS leaves out.
//
// Truncation treats the share f of the light as unscattered; TMS corrects single scattering alone.
// Light scattered several times by the peak, or by the peak and near forward by the rest of the
// phase function, stays close to its path: along a path of slant depth s with one turn, its
// Legendre moments are exponentials. With c_l = (1 - f) chi*_l and q_l = chi_l - c_l, the
// difference between the true layer and the truncated layer with TMS has the moments
//
//     F_l(s) = exp(-(1 - w f) s) {exp(w c_l s) [exp(w (q_l - f) s) - 1] - w (q_l - f) s} / s
//
// for each depth of the turn. Integrated over it, with G_l(s) = int_0^s F_l ds in exponential
// integrals,
//
//     R += sum_l (2l+1) P_l(cos Theta) G_l(tau/mu + tau/mu0) / (4 (mu + mu0))
//     T += sum_l (2l+1) P_l(cos Theta) [G_l(tau/mu0) - G_l(tau/mu)] / (4 (mu - mu0))
//
// With delta-M the term of order f^2 in T is the second-order correction (IMS) of [NT88].
#pragma once

#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace stratus {

/// R (T) per unit of albedo^n of light scattered n times on its way in and out, one of them the
/// turn: P(n, tau/mu + tau/mu0) / (4 (mu + mu0)) for R, [P(n, tau/mu0) - P(n, tau/mu)] /
/// (4 (mu - mu0)) for T. n = 1 is single scattering of phase value 1.
double reflected_path(int n, double optical_depth, double mu_in, double mu_out);
double transmitted_path(int n, double optical_depth, double mu_in, double mu_out);
using OrderPath = double (*)(int n, double optical_depth, double mu_in, double mu_out);

class ForwardPeak {
  public:
    /// `moments` of the phase function, as far as they matter (peak_moments).
    ForwardPeak(const std::vector<double>& moments, const Truncation& truncation, double albedo);

    /// Coefficients of P_l(cos Theta) to add to R (to T) between two cosines.
    ///
    /// With weights: sum_n weights[n] times order n of the expansion in w; without: all orders.
    /// With P the regularised gamma function, order n of G_l(s) is
    ///
    ///     [chi_l^n - (f + c_l)^n - n f^(n-1) (q_l - f)] P(n, s) / n
    ///
    /// Range    optical_depth [0, inf], that of the layer itself; cosines (0, 1].
    std::vector<double> reflection(double optical_depth, double mu_in, double mu_out,
                                   const Eigen::VectorXd& weights = {}) const;
    std::vector<double> transmission(double optical_depth, double mu_in, double mu_out,
                                     const Eigen::VectorXd& weights = {}) const;

  private:
    std::vector<double> sum_orders(const Eigen::VectorXd& weights, OrderPath path,
                                   double optical_depth, double mu_in, double mu_out) const;
    std::vector<double> path_moments(double s) const;  // G_l(s), scaled by 2l + 1
    double path_curvature(std::size_t l) const;
    std::vector<double> path_moments_slope(double s) const;  // F_l(s) likewise

    double albedo_, fraction_, kappa_;  // w, f, 1 - w f
    std::vector<bool> exact_;           // chi_l = f + c_l
    std::vector<double> chi_, rest_;    // chi_l and c_l
};

/// Moments of a phase function until they are negligible; none where 8192 do not suffice (g above
/// 0.998), where only TMS is applied.
std::vector<double> peak_moments(const PhaseFunction& phase_function);

/// sum_l coefficients[l] P_l(x), of one x or of many at once.
double sum_legendre(const std::vector<double>& coefficients, double x);
std::vector<double> sum_legendre(const std::vector<double>& coefficients,
                                 std::span<const double> x);

}  // namespace stratus
