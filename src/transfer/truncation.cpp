#include <stratus/transfer/truncation.h>

#include <stratus/base/size.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Truncated share up to which delta-M's abrupt end does less harm than inexact moments.
constexpr double smooth_share = 1e-4;

/// That share of a backward peak, which is seen beside what is scattered forward, the least of all.
constexpr double smooth_share_backward = 1e-7;

/// True where moments beyond 32 show, and are those of a backward peak, which alternate in sign:
/// Henyey-Greenstein from g = -0.84 on. As has_narrow_peak (path_law.h).
bool has_narrow_backward_peak(const PhaseFunction& phase_function) {
    constexpr int resolved = 32;
    constexpr double least_peak = 0.2;
    const std::vector<double> first = phase_function.moments(resolved + 2);
    return std::abs(first[resolved]) * (2 * resolved + 1) >= least_peak &&
           first[resolved] * first[resolved + 1] < 0;
}

/// 1 up to x = 0, 0 from x = 1 on, smooth to the second derivative.
double smooth_end(double x) {
    const double u = std::clamp(x, 0.0, 1.0);
    return 1 - u * u * u * (10 + u * (6 * u - 15));
}

/// max(x, 0), its corner between -width and width replaced by the quartic that matches both sides
/// to the second derivative: exactly 0 at x = -width.
double rounded_off(double x, double width) {
    if (std::abs(x) >= width) return std::max(x, 0.0);
    const double u = x / width;
    return width * (u + 1) * (u + 1) * (u + 1) * (3 - u) / 16;
}

}  // namespace

Truncation truncate_peak(const PhaseFunction& phase_function, int moment_count, bool delta_m) {
    const auto L = size(moment_count);
    std::vector<double> moments = phase_function.moments(moment_count + 2);
    const double last = moments[L];
    const bool forward = last > 1e-15 && moments[L + 1] > 0;  // a backward peak alternates in sign
    const bool backward = std::abs(last) > smooth_share_backward && last * moments[L + 1] < 0 &&
                          has_narrow_backward_peak(phase_function);
    // A large share is chi_l somewhat below L: 0.8 to 0.9 of it do about equally well.
    const auto knee = size(std::lround(0.85 * moment_count));
    const double f = !delta_m && last > smooth_share ? std::max(moments[knee], last) : last;
    moments.resize(L);
    if (backward)
        for (std::size_t l = 0; l < L; ++l)
            moments[l] *= smooth_end((static_cast<double>(l) / moment_count - 0.4) / 0.6);
    if (!forward) return {0, std::move(moments), false, backward};
    for (std::size_t l = 0; l < L; ++l) {
        const double excess = (moments[l] - f) / (1 - f), blend = (f - last) / (1 - f);
        moments[l] = 2 * l < knee || f == last ? excess : rounded_off(excess, blend);
    }
    return {f, std::move(moments), f > last};
}

Truncation no_truncation(const PhaseFunction& phase_function, int moment_count) {
    return {0, phase_function.moments(moment_count)};
}

TruncatedPath::TruncatedPath(PathLaw law, const Truncation& truncation) : law_(std::move(law)) {
    const double f = truncation.fraction;
    const std::size_t count =
        std::max<std::size_t>(PathLaw::smooth_moments, truncation.moments.size());
    rest_.resize(static_cast<Index>(count), law_.order_count() - 2);
    for (Index l = 0; l < rest_.rows(); ++l) {
        const auto at = size(l);
        const double smooth = law_.smooth_moment(at);
        const double c = at < truncation.moments.size() ? (1 - f) * truncation.moments[at] : 0;
        double smooth_n = smooth, kept_n = f + c, f_n = f;  // to the power of n
        for (Index k = 0; k < rest_.cols(); ++k) {
            const double order = static_cast<double>(k + 2), f_before = f_n;
            smooth_n *= smooth;
            kept_n *= f + c;
            f_n *= f;
            rest_(l, k) =
                static_cast<double>(2 * l + 1) * (smooth_n - kept_n + f_n + order * f_before * c);
        }
    }
}

MatrixXd TruncatedPath::rest(std::span<const PathWeights> weights) const {
    MatrixXd of_order = MatrixXd::Zero(rest_.cols(), std::ssize(weights));
    for (Index k = 0; k < of_order.cols(); ++k) {
        const PathWeights& here = weights[size(k)];
        const Index orders = std::max(0, here.count - 2);
        of_order.col(k).head(orders) = Eigen::Map<const Eigen::VectorXd>(here.of_order + 2, orders);
    }
    return rest_ * of_order;
}

MatrixXd TruncatedPath::rest_of_orders(std::span<const double> cosines) const {
    MatrixXd polynomial(rest_.rows(), std::ssize(cosines));
    for (Index k = 0; k < polynomial.cols(); ++k) {
        const double x = cosines[size(k)];
        double before = 0, here = 1;
        for (Index l = 0; l < polynomial.rows(); ++l) {
            polynomial(l, k) = here;
            const double order = static_cast<double>(l);
            const double next = ((2 * order + 1) * x * here - order * before) / (order + 1);
            before = std::exchange(here, next);
        }
    }
    return rest_.transpose() * polynomial;
}

std::vector<double> sum_legendre(std::span<const double> coefficients, std::span<const double> x) {
    // Clenshaw, a few x side by side in registers
    constexpr std::size_t lanes = 8;
    std::vector<double> sums(x.size());
    for (std::size_t first = 0; first < x.size(); first += lanes) {
        const std::size_t count = std::min(lanes, x.size() - first);
        double at[lanes] = {}, sum[lanes] = {}, next[lanes] = {};
        std::copy_n(x.data() + first, count, at);
        double back = 0;  // (l + 1) / (l + 2); of the first, nothing comes back
        for (std::size_t l = coefficients.size(); l-- > 0;) {
            const double c = coefficients[l], inverse = 1 / static_cast<double>(l + 1);
            const double up = 2 - inverse;  // (2 l + 1) / (l + 1)
            for (std::size_t k = 0; k < lanes; ++k) {
                const double now = c + up * at[k] * sum[k] - back * next[k];
                next[k] = sum[k];
                sum[k] = now;
            }
            back = 1 - inverse;
        }
        std::copy_n(sum, count, sums.data() + first);
    }
    return sums;
}

double sum_legendre(std::span<const double> coefficients, double x) {
    return sum_legendre(coefficients, std::span(&x, 1))[0];
}

}  // namespace stratus
