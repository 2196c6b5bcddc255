#include <stratus/transfer/forward_peak.h>

#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/expint.hpp>
#include <boost/math/special_functions/gamma.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stratus {

namespace {

/// Slant depth below which F_l is expanded to second order: an error of 1e-5 of the correction.
constexpr double thin_path = 1e-5;

/// Ein(z) = int_0^z (1 - exp(-t))/t dt = E1(z) + log z + gamma, 0 <= z <= 1.
double ein_series(double z) {
    double term = z, sum = z;  // z - z^2/(2 2!) + z^3/(3 3!) - ...
    for (int k = 2; k < 20; ++k) {
        term *= -z / k;
        sum += term / k;
    }
    return sum;
}

double e1(double z) { return z < 700 ? boost::math::expint(1, z) : 0; }

/// Ein(a s) - Ein(b s) given a - b, which may be much smaller than either; s up to infinity.
double ein_difference(double a, double b, double a_less_b, double s) {
    const double middle = (a + b) / 2;
    if (std::abs(a_less_b) < 1e-5 * middle)  // by the derivative at the middle, to 1e-11
        return a_less_b * (middle * s < 1e-8 ? s : -std::expm1(-middle * s) / middle);
    const bool small_a = a * s < 1, small_b = b * s < 1;
    if (!small_a && !small_b) return std::log(a / b) + (e1(a * s) - e1(b * s));
    const auto ein = [s](double x, bool small) {
        return small ? ein_series(x * s)
                     : e1(x * s) + std::log(x * s) + boost::math::constants::euler<double>();
    };
    return ein(a, small_a) - ein(b, small_b);
}

/// exp(-b s) - exp(-a s) given a - b.
double exp_difference(double a, double b, double a_less_b, double s) {
    const double x = a_less_b * s;
    return std::abs(x) < 1 ? std::exp(-a * s) * std::expm1(x) : std::exp(-b * s) - std::exp(-a * s);
}

}  // namespace

ForwardPeak::ForwardPeak(const std::vector<double>& moments, const Truncation& truncation,
                         double albedo)
    : albedo_(albedo),
      fraction_(truncation.fraction),
      kappa_(1 - albedo * truncation.fraction),
      chi_(moments),
      rest_(truncation.moments) {
    for (double& c : rest_) c *= 1 - truncation.fraction;
    chi_.resize(std::max(chi_.size(), rest_.size()), 0);
    rest_.resize(chi_.size(), 0);
    for (std::size_t l = 0; l < chi_.size(); ++l)
        exact_.push_back(std::abs(chi_[l] - rest_[l] - fraction_) < 1e-15);
}

// G_l and F_l less their limit at large l, which belongs to the unscattered beam; with
// a_l = 1 - w f - w c_l and b_l = 1 - w chi_l.

std::vector<double> ForwardPeak::path_moments(double s) const {
    std::vector<double> G(chi_.size());
    if (s < thin_path) {  // the terms linear in s cancel
        for (std::size_t l = 0; l < G.size(); ++l)
            G[l] = (2 * static_cast<double>(l) + 1) * (s * s / 2 * path_curvature(l));
        return G;
    }
    const double w = albedo_, wf = w * fraction_;
    const double hit = -std::expm1(-kappa_ * s) / kappa_;
    const double straight = ein_difference(1, kappa_, wf, s);
    // Ein(s) - Ein((1 - x) s) = sum_n x^n P(n, s) / n, P the regularised gamma function.
    std::array<double, 12> of_power;  // to 1e-13 up to x = 0.1
    for (std::size_t n = 0; n < of_power.size(); ++n)
        of_power[n] = (std::isinf(s) ? 1 : boost::math::gamma_p(static_cast<double>(n + 1), s)) /
                      static_cast<double>(n + 1);
    const auto less = [&](double x) {
        double sum = 0;
        for (std::size_t n = of_power.size(); n-- > 0;) sum = x * (of_power[n] + sum);
        return sum;
    };
    for (std::size_t l = 0; l < G.size(); ++l) {
        const double q = chi_[l] - rest_[l], beyond = exact_[l] ? 0 : w * (q - fraction_);
        const double a = kappa_ - w * rest_[l], b = 1 - w * chi_[l];
        if (rest_[l] == 0)
            G[l] = (std::abs(w * chi_[l]) < 0.1 ? less(w * chi_[l])
                                                : ein_difference(1, b, w * chi_[l], s)) -
                   w * q * hit;
        else
            G[l] = straight + (beyond == 0 ? 0 : ein_difference(a, b, beyond, s)) - w * q * hit;
        G[l] *= 2 * static_cast<double>(l) + 1;
    }
    return G;
}

std::vector<double> ForwardPeak::path_moments_slope(double s) const {
    const double w = albedo_, wf = w * fraction_;
    const double beam = std::exp(-kappa_ * s), straight = exp_difference(1, kappa_, wf, s);
    std::vector<double> F(chi_.size());
    for (std::size_t l = 0; l < F.size(); ++l) {
        const double q = chi_[l] - rest_[l], beyond = exact_[l] ? 0 : w * (q - fraction_);
        const double a = kappa_ - w * rest_[l], b = 1 - w * chi_[l];
        if (s < thin_path)
            F[l] = s * path_curvature(l);
        else if (rest_[l] == 0)
            F[l] = exp_difference(1, b, w * chi_[l], s) / s - w * q * beam;
        else
            F[l] = (straight + exp_difference(a, b, beyond, s)) / s - w * q * beam;
        F[l] *= 2 * static_cast<double>(l) + 1;
    }
    return F;
}

/// dF_l/ds at s = 0.
double ForwardPeak::path_curvature(std::size_t l) const {
    const double w_chi = albedo_ * chi_[l], w_c = albedo_ * rest_[l];
    return (w_c * (2 * kappa_ - w_c) - w_chi * (2 - w_chi)) / 2 + (w_chi - w_c) * kappa_;
}

std::vector<double> ForwardPeak::reflection(double optical_depth, double mu_in, double mu_out,
                                            const Eigen::VectorXd& weights) const {
    if (weights.size()) return sum_orders(weights, reflected_path, optical_depth, mu_in, mu_out);
    std::vector<double> sum = path_moments(optical_depth / mu_in + optical_depth / mu_out);
    for (double& coefficient : sum) coefficient /= 4 * (mu_in + mu_out);
    return sum;
}

std::vector<double> ForwardPeak::transmission(double optical_depth, double mu_in, double mu_out,
                                              const Eigen::VectorXd& weights) const {
    if (weights.size()) return sum_orders(weights, transmitted_path, optical_depth, mu_in, mu_out);
    if (std::isinf(optical_depth)) return {};
    const double in = optical_depth / mu_in, out = optical_depth / mu_out;
    // The mean of F between the two slant depths, times tau / (4 mu mu0).
    const double factor = optical_depth / (4 * mu_in * mu_out);
    std::vector<double> sum;
    if (std::abs(in - out) > 0.05) {
        sum = path_moments(in);
        const std::vector<double> less = path_moments(out);
        for (std::size_t l = 0; l < sum.size(); ++l)
            sum[l] = factor * (sum[l] - less[l]) / (in - out);
        return sum;
    }
    // Three Gauss points suffice over so short an interval.
    const double reach = std::sqrt(0.6) * (in - out) / 2, middle = (in + out) / 2;
    sum = path_moments_slope(middle);
    const std::vector<double> before = path_moments_slope(middle - reach);
    const std::vector<double> after = path_moments_slope(middle + reach);
    for (std::size_t l = 0; l < sum.size(); ++l)
        sum[l] = factor * (8 * sum[l] + 5 * (before[l] + after[l])) / 18;
    return sum;
}

std::vector<double> ForwardPeak::sum_orders(const Eigen::VectorXd& weights, OrderPath path,
                                            double optical_depth, double mu_in,
                                            double mu_out) const {
    Eigen::VectorXd paths = weights;
    for (Eigen::Index n = 2; n < paths.size(); ++n)
        paths(n) *= path(static_cast<int>(n), optical_depth, mu_in, mu_out);
    std::vector<double> sum(chi_.size(), 0);
    for (std::size_t l = 0; l < sum.size(); ++l) {
        const double chi = chi_[l], f = fraction_, c = rest_[l];
        double chi_n = chi, straight_n = f + c, f_n = f;  // to the power of n
        for (Eigen::Index n = 2; n < paths.size(); ++n) {
            const double order = static_cast<double>(n), f_before = f_n;
            chi_n *= chi;
            straight_n *= f + c;
            f_n *= f;
            // less the limit at large l
            sum[l] += paths(n) / order * (chi_n - straight_n + f_n - order * f_before * (chi - c));
        }
        sum[l] *= 2 * static_cast<double>(l) + 1;
    }
    return sum;
}

double reflected_path(int n, double optical_depth, double mu_in, double mu_out) {
    const double s = optical_depth / mu_in + optical_depth / mu_out;
    const double share = std::isinf(s) ? 1 : boost::math::gamma_p(n, s);
    return share / (4 * (mu_in + mu_out));
}

double transmitted_path(int n, double optical_depth, double mu_in, double mu_out) {
    if (std::isinf(optical_depth)) return 0;
    const double in = optical_depth / mu_in, out = optical_depth / mu_out;
    const double factor = optical_depth / (4 * mu_in * mu_out);
    if (std::abs(in - out) > 0.5) {  // the form without cancellation
        const double difference = std::min(in, out) > n
                                      ? boost::math::gamma_q(n, out) - boost::math::gamma_q(n, in)
                                      : boost::math::gamma_p(n, in) - boost::math::gamma_p(n, out);
        return factor * difference / (in - out);
    }
    const auto density = [n](double s) { return boost::math::gamma_p_derivative(n, s); };
    const double middle = (in + out) / 2, half = (in - out) / 2;
    return factor / 2 * boost::math::quadrature::gauss<double, 7>::integrate([&](double x) {
               return density(middle + half * x);
           });
}

std::vector<double> peak_moments(const PhaseFunction& phase_function) {
    constexpr int most = 8192;
    for (int count = 256;; count *= 2) {
        std::vector<double> moments = phase_function.moments(count);
        const auto shows = [&](double least) {
            return std::abs(moments.back()) * 2 * static_cast<double>(moments.size()) >= least;
        };
        if (count == most && shows(1e-3)) return {};
        while (!moments.empty() && !shows(1e-9)) moments.pop_back();
        if (count == most || static_cast<int>(moments.size()) < count) return moments;
    }
}

std::vector<double> sum_legendre(const std::vector<double>& coefficients,
                                 std::span<const double> x) {
    // Clenshaw, all x side by side
    std::vector<double> sum(x.size(), 0), next(x.size(), 0);
    for (std::size_t l = coefficients.size(); l-- > 0;) {
        const double order = static_cast<double>(l), c = coefficients[l];
        const double up = (2 * order + 1) / (order + 1), back = (order + 1) / (order + 2);
        for (std::size_t k = 0; k < x.size(); ++k) {
            const double now = c + up * x[k] * sum[k] - back * next[k];
            next[k] = sum[k];
            sum[k] = now;
        }
    }
    return sum;
}

double sum_legendre(const std::vector<double>& coefficients, double x) {
    return sum_legendre(coefficients, std::span(&x, 1))[0];
}

}  // namespace stratus
