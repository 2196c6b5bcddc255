#include "phase_kernels.h"

#include <algorithm>
#include <cmath>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

PhaseKernels reference_phase_kernels(const Directions& directions,
                                     const std::vector<double>& moments, int mode) {
    const auto n = directions.size();
    const auto L = static_cast<int>(moments.size());
    // Rows l - m = k of sqrt((l-m)!/(l+m)!) P_l^m at all directions.
    MatrixXd legendre = MatrixXd::Zero(std::max(1, L - mode), n);
    for (int k = 0; k < L - mode; ++k) {
        const double l = mode + k, m = mode;
        if (k == 0) {
            legendre.row(0).setOnes();
            for (int j = 1; j <= mode; ++j)
                legendre.row(0).array() *=
                    ((2.0 * j - 1) / (2.0 * j) * (1 - directions.mu.array().square()))
                        .sqrt()
                        .transpose();
            continue;
        }
        legendre.row(k) = (2 * l - 1) * directions.mu.transpose().cwiseProduct(legendre.row(k - 1));
        if (k > 1) legendre.row(k) -= std::sqrt((l - 1) * (l - 1) - m * m) * legendre.row(k - 2);
        legendre.row(k) /= std::sqrt(l * l - m * m);
    }
    MatrixXd even = MatrixXd::Zero(n, n), odd = MatrixXd::Zero(n, n);
    for (int k = 0; k < L - mode; ++k) {
        const double c = (2 * (mode + k) + 1) * moments[static_cast<std::size_t>(mode + k)];
        (k % 2 ? odd : even) += c * legendre.row(k).transpose() * legendre.row(k);
    }
    if (mode == 0) {  // scale symmetrically until every row integrates to 1 (Sinkhorn)
        VectorXd d = VectorXd::Ones(n);
        for (int round = 0; round < 2000; ++round) {
            const VectorXd sum = d.asDiagonal() * (even * (directions.weight.cwiseProduct(d)));
            if ((sum.array() - 1).abs().maxCoeff() < 5e-16) break;
            d.head(directions.nodes).array() /= sum.head(directions.nodes).array().sqrt();
            d.tail(n - directions.nodes).array() /= sum.tail(n - directions.nodes).array();
        }
        even = MatrixXd(d.asDiagonal() * even * d.asDiagonal());
        odd = MatrixXd(d.asDiagonal() * odd * d.asDiagonal());
    }
    return {even + odd, even - odd};
}

}  // namespace stratus
