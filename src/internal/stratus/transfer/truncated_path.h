// The path law of a truncated layer, and of the part that truncation leaves out.
//
// Truncation treats the share f of the light as unscattered; the truncated layer scatters
// c_l = (1 - f) chi*_l. Light that keeps to its path (path_law.h) is known in closed form in the
// true layer and in the truncated one: of n scatterings there, any number pass for unscattered.
// Where the truncated layer scatters twice or more, its modes hold
//
//     (f + c_l)^n - f^n - n f^(n-1) c_l
//
// of order n, chi_l^n in the true layer. Orders n >= 2 of the true layer are then
//
//     modes + path law + sum_n w^n P(n, s) / n  sum_l (2l+1) k_nl P_l(cos Theta) / (4 (mu + mu0))
//     k_nl = r_l^n - (f + c_l)^n + f^n + n f^(n-1) c_l
//
// for R, for T likewise. The last sum ends where both the smooth part r and the truncated series
// do: it and the modes are what tables hold.
//
// Second order in T with delta-M is the correction IMS of [NT88].
#pragma once

#include <stratus/phase/path_law.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace stratus {

/// The law of one phase function and truncation, for all albedos, depths and directions.
class TruncatedPath {
  public:
    TruncatedPath(PathLaw law, const Truncation& truncation);

    const PathLaw& law() const { return law_; }

    /// Legendre coefficients of the sum of weights times k_n, n >= 2, the factor 2l + 1 included: a
    /// column for each of some weights.
    Eigen::MatrixXd rest(std::span<const PathWeights> weights) const;

    /// The sum over l of (2l+1) k_nl P_l at some cosines: orders from 2 on x cosines.
    Eigen::MatrixXd rest_of_orders(std::span<const double> cosines) const;

  private:
    PathLaw law_;
    Eigen::MatrixXd rest_;  // (2l+1) k_nl over (l, n), n from 2
};

/// sum_l coefficients[l] P_l(x), of one x or of many at once.
double sum_legendre(std::span<const double> coefficients, double x);
std::vector<double> sum_legendre(std::span<const double> coefficients, std::span<const double> x);

}  // namespace stratus
