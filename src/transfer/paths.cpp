#include "paths.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "options.h"

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <array>
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
        std::vector<double> series(size(count) + 2);
        for (int n = 0; n < count; ++n)
            for (int i = 0; i < count; ++i)
                series[size(n)] +=
                    2.0 / count * values[size(i)] * std::cos(n * (i + 0.5) * pi / count);
        coefficients_.resize(series.size() - 1);
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
    kept_.resize(std::max(kept_.size(), back_.size()));
    back_.resize(kept_.size());
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
    std::vector<double> sum(back_.size());
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

namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The largest rise whose series growth() sums.
constexpr double most_of_series = 0.1;

/// (e^rise - 1) / rise - 1.
double growth(double rise) {
    return rise * (1. / 2 +
                   rise * (1. / 6 +
                           rise * (1. / 24 + rise * (1. / 120 + rise * (1. / 720 + rise / 5040)))));
}

/// The largest rise of which sum_growth() sums powers: of this one, the series misses 1e-9.
constexpr double most_of_sums = 0.5;
constexpr Index growth_terms = 8;

/// Sums of weight x^j over points x.
using PowerSums = std::array<double, growth_terms + 1>;

/// The sum of weight growth(from + slope x) over these points, for several rises side by side.
ArrayXd sum_growth(const PowerSums& power_sums, const ArrayXd& from, const ArrayXd& slope) {
    ArrayXXd sums(from.size(), growth_terms + 1);
    for (Index j = 0; j <= growth_terms; ++j) sums.col(j).setConstant(power_sums[size(j)]);
    ArrayXd all = ArrayXd::Zero(from.size());
    double share = 1;  // 1 / (k + 1)!
    for (Index k = 1; k <= growth_terms; ++k) {
        // From sums of weight (from + slope x)^(k - 1) x^j to those of the next power of the rise.
        for (Index j = 0; j + k <= growth_terms; ++j)
            sums.col(j) = from * sums.col(j) + slope * sums.col(j + 1);
        share /= static_cast<double>(k + 1);
        all += share * sums.col(0);
    }
    return all;
}

/// (e^(from + rise) - e^from) / rise with at_from = e^from: the mean of an exponential along its rise.
double mean_exponential(double from, double at_from, double rise) {
    if (std::abs(rise) > most_of_series) return (std::exp(from + rise) - at_from) / rise;
    return at_from * (1 + growth(rise));
}

/// How many moments of a peak change light that they scatter twice or more by 1e-12.
std::size_t second_order_length(const std::vector<double>& chi) {
    std::size_t length = chi.size();
    while (length > 0 &&
           static_cast<double>(2 * length - 1) * chi[length - 1] * chi[length - 1] < 1e-12)
        --length;
    return length;
}

/// Six Gauss points in each panel from 0 to `end`, the panels as wide as what lies before them:
/// at(place, weight).
template <class At>
void for_each_node(double end, double first_panel, const At& at) {
    using Gauss = boost::math::quadrature::gauss<double, 6>;
    double begin = 0;
    while (begin < end) {
        const double next = std::min(end, 2 * begin + first_panel);
        const double middle = (begin + next) / 2, half = (next - begin) / 2;
        for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k)
            for (const double side : {-1.0, 1.0})
                at(middle + side * half * Gauss::abscissa()[k], half * Gauss::weights()[k]);
        begin = next;
    }
}

}  // namespace

StackTruncation::StackTruncation(const StackLayers& stack, const SolverOptions& options,
                                 bool has_line_law) {
    for (const StackLayer& layer : stack) {
        layers.push_back(choose_truncation(layer.phase_function, options, false));
        follows_paths |= stratus::follows_paths(layer.phase_function, layers.back(), options);
    }
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const bool stays = layers[k].backward ? has_line_law : follows_paths;
        if (!stays) layers[k] = choose_truncation(stack[k].phase_function, options, true);
    }
}

StackPath::StackPath(const StackLayers& layers, const std::vector<Truncation>& truncations)
    : depth_(std::ssize(layers)), truncated_(depth_.size()) {
    std::vector<std::vector<double>> chi;
    std::size_t moments = 0, kept = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        chi.push_back(path_moments(layers[k].phase_function));
        kept = std::max(kept, truncations[k].moments.size());
        moments = std::max({moments, kept, second_order_length(chi.back())});
    }
    peak_.setZero(static_cast<Index>(moments), depth_.size());
    kept_.setZero(static_cast<Index>(kept), depth_.size());
    double most_kept_to_path = 0.5;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double w = layers[k].albedo, f = truncations[k].fraction;
        const std::vector<double>& truncated = truncations[k].moments;
        const Index column = static_cast<Index>(k);
        depth_(column) = layers[k].optical_depth;
        truncated_(column) = w * f;
        for (std::size_t l = 0; l < truncated.size(); ++l)
            kept_(static_cast<Index>(l), column) = w * (1 - f) * truncated[l];
        for (std::size_t l = 0; l < std::min(moments, chi[k].size()); ++l)
            peak_(static_cast<Index>(l), column) = w * chi[k][l];
        most_kept_to_path = std::max(most_kept_to_path, w * chi[k][1]);
    }
    peak_.topRows(kept_.rows()) -= kept_;
    constexpr double rounding = 1e-14;
    while (alike_ < kept_.rows() &&
           (peak_.row(alike_).transpose() - truncated_).cwiseAbs().maxCoeff() <= rounding)
        ++alike_;
    steepest_ = peak_.cwiseAbs().rowwise().maxCoeff();
    for (Index l = steepest_.size() - 1; l-- > 0;)
        steepest_(l) = std::max(steepest_(l), steepest_(l + 1));
    deepest_ = 24 / (1 - most_kept_to_path);
}

void StackPath::add_turns(Index layer, const VectorXd& before, double rate, VectorXd& sum) const {
    const double slant_before = before.sum(), truncated_before = truncated_.dot(before);
    const MatrixXd::ConstColXpr peak_here = peak_.col(layer), kept_here = kept_.col(layer);
    const VectorXd peak_before = peak_ * before, kept_before = kept_ * before;
    const double end = std::min(depth_(layer), deepest_ / rate);
    Index first_of_series = sum.size();
    while (first_of_series > std::max(alike_, kept_.rows()) &&
           steepest_(first_of_series - 1) * (slant_before + rate * end) <= most_of_sums)
        --first_of_series;
    double alike_peak = 0, alike_kept = 0;
    PowerSums slant_sums{};
    for_each_node(end, 1 / rate, [&](double depth, double weight) {
        const double slant = rate * depth, S = slant_before + slant,
                     F = truncated_before + truncated_(layer) * slant;
        const double unscattered = std::exp(-S), passing = std::exp(F - S);
        // Where all peaks are f, the truncated problem's widening is the path's own.
        alike_peak += weight * (mean_exponential(-S, unscattered, F) - unscattered);
        alike_kept += weight * (passing - unscattered);
        for (Index l = alike_; l < first_of_series; ++l) {
            const double p = peak_here(l), P = peak_before(l) + slant * p;
            double added = p * (mean_exponential(-S, unscattered, P) - unscattered);
            if (l < kept_.rows() && kept_here(l) != 0) {
                const double c = kept_here(l), C = kept_before(l) + slant * c;
                added += c * (mean_exponential(P - S, std::exp(P - S), C) -
                              mean_exponential(F - S, passing, C) + passing - unscattered);
            }
            sum(l) += weight * added;
        }
        double power = weight * unscattered;
        for (double& of_power : slant_sums) {
            of_power += power;
            power *= slant;
        }
    });
    sum.head(alike_) += alike_peak * peak_here.head(alike_) + alike_kept * kept_here.head(alike_);
    const Index in_series = sum.size() - first_of_series;
    sum.tail(in_series).array() +=
        peak_here.tail(in_series).array() *
        sum_growth(slant_sums, peak_before.tail(in_series), peak_here.tail(in_series));
}

std::vector<double> StackPath::legendre(Side side, std::size_t above, double mu_in,
                                        double mu_out) const {
    const bool upward = side == Side::reflection;
    const Index level = static_cast<Index>(above), end = upward ? depth_.size() : level;
    VectorXd sum = VectorXd::Zero(peak_.rows());
    double top = depth_.head(upward ? level : 0).sum();  // optical depth above layer j
    for (Index j = upward ? level : 0; j < end && top / mu_in < deepest_; top += depth_(j++)) {
        VectorXd before = VectorXd::Zero(depth_.size());
        before.head(j) = depth_.head(j) / mu_in;
        if (upward) {
            before.segment(level, j - level) += depth_.segment(level, j - level) / mu_out;
            add_turns(j, before, 1 / mu_in + 1 / mu_out, sum);
        } else {
            // The depth counts from where T has less slant depth: from below where mu_in is larger.
            before(j) = depth_(j) / std::max(mu_in, mu_out);
            before.segment(j + 1, level - j - 1) = depth_.segment(j + 1, level - j - 1) / mu_out;
            add_turns(j, before, std::abs(1 / mu_in - 1 / mu_out), sum);
        }
    }
    std::vector<double> coefficients;
    for (Index l = 0; l < sum.size(); ++l)
        coefficients.push_back(static_cast<double>(2 * l + 1) * sum(l) / (4 * mu_in * mu_out));
    return coefficients;
}

}  // namespace stratus
