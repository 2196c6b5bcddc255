// Peaked phase functions: truncation of the forward peak and the single scattering that goes with
// it.
//
// Where a phase function has more moments than the quadrature resolves, a share f of the light is
// treated as unscattered [W77]:
//
//     tau* = (1 - w f) tau      w* = w (1 - f)/(1 - w f)
//     chi*_l = (chi_l - f p_l)/(1 - f),   l < L
//
// delta-M ends the series abruptly, f = chi_L and p_l = 1, and leaves a phase function that ripples
// at all angles. Where f exceeds 1e-4, p_l falls off smoothly over the last moments instead, so
// that a narrow peak is removed: with g = 0.99 and 48 nodes the errors are 100 times smaller
// (docs/accuracy.md).
//
// A backward peak cannot pass for unscattered light. Where |chi_L| exceeds 1e-7, the series of a
// narrow one ends smoothly, chi*_l = chi_l p_l and f = 0; what that changes is known in closed form
// (paths.h).
//
// [NT88], TMS: single scattering is then added in closed form with the true phase function, albedo
// w*/(1 - f) and tau*. Multiple scattering in a narrow peak follows below.
#pragma once

#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_function.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace stratus {

/// The truncated problem for L moments; f = 0 changes nothing.
struct Truncation {
    double fraction = 0;          // f
    std::vector<double> moments;  // chi*_l, l < L
    bool narrow = false;          // p_l falls off smoothly
    bool backward = false;        // the series of a backward peak, which ends smoothly

    /// tau*.
    double optical_depth(double tau, double albedo) const { return (1 - albedo * fraction) * tau; }
    /// w*.
    double albedo(double albedo) const { return albedo * (1 - fraction) / (1 - albedo * fraction); }
    /// 1 - w*, exactly 0 at w = 1.
    double co_albedo(double albedo) const { return (1 - albedo) / (1 - albedo * fraction); }
    /// w*/(1 - f).
    double single_scattering_albedo(double albedo) const {
        return albedo / (1 - albedo * fraction);
    }
};

/// Truncates to L = `moment_count` moments where the peak is a forward one (chi_L above rounding
/// and chi_{L+1} positive), or ends the series of a narrow backward one smoothly;
/// else f = 0. At least the moments below 0.4 L stay exact, f + (1 - f) chi*_l = chi_l. `delta_m`:
/// of forward peaks, delta-M whatever the share.
Truncation truncate_peak(const PhaseFunction& phase_function, int moment_count,
                         bool delta_m = false);

/// The first `moment_count` moments as they are, f = 0.
Truncation no_truncation(const PhaseFunction& phase_function, int moment_count);

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
