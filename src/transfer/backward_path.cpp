#include "backward_path.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

/// The integral over a length of an exponential whose logarithm goes straight from `from` to `to`.
double exponential_between(double length, double from, double to) {
    const double fall = std::abs(to - from), mean = fall < 1e-9 ? 1 : -std::expm1(-fall) / fall;
    return length * std::exp(std::max(from, to)) * mean;
}

/// The integrals over depth, functions of b.
struct Lines {
    Side side;
    double tau, slant_in, slant_out;  // tau / mu0, tau / mu

    /// Returns the sum of the orders n >= 2.
    double operator()(double b) const {
        const double k = std::sqrt((1 - b) * (1 + b)), r = b / (1 + k), q = r * r;
        const double in = k * slant_in, out = k * slant_out;
        const auto between = [&](double from, double to) {
            return exponential_between(tau, from, to);
        };
        const double scale = (1 - q * std::exp(-2 * in)) * (1 - q * std::exp(-2 * out));
        if (side == Side::reflection)
            return ((1 + q) * (between(0, -in - out) + q * between(-2 * (in + out), -in - out)) -
                    2 * q * (between(-2 * out, -in - out) + between(-2 * in, -in - out))) /
                       scale -
                   between(0, -slant_in - slant_out);
        return r *
               (2 * between(-out, -in) -
                (1 + q) * (between(-out, -in - 2 * out) + between(-2 * in - out, -in)) +
                2 * q * between(-2 * in - out, -in - 2 * out)) /
               scale;
    }
};

/// The integral of lines(b) from 0 to b, by Chebyshev polynomials in asin b, where k is smooth.
class LinesIntegral {
  public:
    /// `largest`: of |b|, [0, 1].
    LinesIntegral(const Lines& lines, double largest) : end_(std::asin(largest)) {
        // Poles lie beyond pi / 2; the terms fall off by this ratio.
        const double ratio = pi / 2 / end_ + std::sqrt(std::pow(pi / 2 / end_, 2) - 1);
        const int count = std::clamp(static_cast<int>(25 / std::log(ratio)) + 4, 8, 96);
        std::vector<double> values;
        for (int i = 0; i < count; ++i) {
            const double angle = end_ * std::cos((i + 0.5) * pi / count);
            values.push_back(lines(std::sin(angle)) * std::cos(angle));
        }
        std::vector<double> series(size(count) + 2, 0.0);
        for (int n = 0; n < count; ++n)
            for (int i = 0; i < count; ++i)
                series[size(n)] +=
                    2.0 / count * values[size(i)] * std::cos(n * (i + 0.5) * pi / count);
        coefficients_.resize(series.size() - 1, 0.0);
        for (std::size_t n = 1; n < coefficients_.size(); ++n)
            coefficients_[n] =
                end_ * (series[n - 1] - series[n + 1]) / (2 * static_cast<double>(n));
        at_0_ = sum(0);
    }

    double operator()(double b) const { return sum(std::asin(b) / end_) - at_0_; }

  private:
    double sum(double x) const {  // Clenshaw
        double here = 0, next = 0;
        for (std::size_t n = coefficients_.size(); n-- > 1;)
            next = std::exchange(here, coefficients_[n] + 2 * x * here - next);
        return x * here - next;
    }

    double end_, at_0_ = 0;
    std::vector<double> coefficients_;
};

}  // namespace

BackwardPath::BackwardPath(std::vector<double> moments, std::vector<double> kept)
    : back_(std::move(moments)), kept_(std::move(kept)) {
    const auto adds = [&] {  // of order 2
        return back_.back() * back_.back() * 2 * static_cast<double>(back_.size()) > 1e-12;
    };
    while (back_.size() > kept_.size() && !adds()) back_.pop_back();
    kept_.resize(std::max(kept_.size(), back_.size()), 0.0);
    back_.resize(kept_.size(), 0.0);
    while (first_ < back_.size() && back_[first_] == kept_[first_]) ++first_;
    for (std::size_t l = first_; l < back_.size(); ++l) {
        if (l % 2 == 1) {
            back_[l] = -back_[l];
            kept_[l] = -kept_[l];
        }
        largest_ = std::max(largest_, std::abs(back_[l]));
    }
}

std::vector<double> BackwardPath::legendre(Side side, double albedo, double optical_depth,
                                           double mu_in, double mu_out) const {
    std::vector<double> sum(back_.size(), 0.0);
    const double largest = std::min(albedo * largest_, 1 - 1e-9);
    if (largest == 0 || (side == Side::transmission && std::isinf(optical_depth))) return sum;
    // Deeper layers reflect alike, and transmit none of it.
    const double deepest = 100 / std::sqrt((1 - largest) * (1 + largest));
    const double tau = std::min(optical_depth, deepest);
    const LinesIntegral integral({side, tau, tau / mu_in, tau / mu_out}, largest);
    for (std::size_t l = first_; l < sum.size(); ++l) {
        const double sign = side == Side::reflection && l % 2 == 1 ? -1 : 1;
        sum[l] = sign * (2 * static_cast<double>(l) + 1) / (4 * mu_in * mu_out) *
                 (integral(albedo * back_[l]) - integral(albedo * kept_[l]));
    }
    return sum;
}

}  // namespace stratus
