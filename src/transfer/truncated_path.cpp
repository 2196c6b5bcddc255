#include <stratus/transfer/truncated_path.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

TruncatedPath::TruncatedPath(PathLaw law, const Truncation& truncation) : law_(std::move(law)) {
    const double f = truncation.fraction;
    const std::size_t count =
        std::max<std::size_t>(PathLaw::smooth_moments, truncation.moments.size());
    rest_.resize(static_cast<Eigen::Index>(count), law_.order_count() - 2);
    for (Eigen::Index l = 0; l < rest_.rows(); ++l) {
        const auto at = static_cast<std::size_t>(l);
        const double smooth = law_.smooth_moment(at);
        const double c = at < truncation.moments.size() ? (1 - f) * truncation.moments[at] : 0;
        double smooth_n = smooth, kept_n = f + c, f_n = f;  // to the power of n
        for (Eigen::Index k = 0; k < rest_.cols(); ++k) {
            const double order = static_cast<double>(k + 2), f_before = f_n;
            smooth_n *= smooth;
            kept_n *= f + c;
            f_n *= f;
            rest_(l, k) =
                static_cast<double>(2 * l + 1) * (smooth_n - kept_n + f_n + order * f_before * c);
        }
    }
}

Eigen::MatrixXd TruncatedPath::rest(std::span<const PathWeights> weights) const {
    Eigen::MatrixXd of_order =
        Eigen::MatrixXd::Zero(rest_.cols(), static_cast<Eigen::Index>(weights.size()));
    for (Eigen::Index k = 0; k < of_order.cols(); ++k) {
        const PathWeights& here = weights[static_cast<std::size_t>(k)];
        const Eigen::Index orders = std::max(0, here.count - 2);
        of_order.col(k).head(orders) = Eigen::Map<const Eigen::VectorXd>(here.of_order + 2, orders);
    }
    return rest_ * of_order;
}

Eigen::MatrixXd TruncatedPath::rest_of_orders(std::span<const double> cosines) const {
    Eigen::MatrixXd polynomial(rest_.rows(), static_cast<Eigen::Index>(cosines.size()));
    for (Eigen::Index k = 0; k < polynomial.cols(); ++k) {
        const double x = cosines[static_cast<std::size_t>(k)];
        double before = 0, here = 1;
        for (Eigen::Index l = 0; l < polynomial.rows(); ++l) {
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
