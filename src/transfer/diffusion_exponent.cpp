#include <stratus/base/argument.h>
#include <stratus/transfer/solve.h>

#include "doubling_ladder.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos,
                                                const SolverOptions& options) {
    for (const double albedo : albedos)
        require(albedo >= 0 && albedo <= 1, "compute_diffusion_exponents", "albedo", "in [0, 1]",
                albedo);
    const std::vector<double> moments = phase_function.moments(2 * options.nodes);
    const Directions directions =
        gauss_directions(options.nodes, choose_node_map(moments, options.nodes));
    const PhaseKernels kernels =
        DoublingLadder<double>(directions, moments, {{0, 1, 0, directions.mu.minCoeff()}})
            .kernels()[0];
    const VectorXd scale = directions.s.cwiseQuotient(directions.mu) / std::sqrt(2.0);
    const MatrixXd same = scale.asDiagonal() * kernels.same * scale.asDiagonal();
    const MatrixXd other = scale.asDiagonal() * kernels.other * scale.asDiagonal();
    const MatrixXd slant = directions.mu.cwiseInverse().asDiagonal();
    std::vector<double> exponents;
    for (const double albedo : albedos) {
        if (albedo == 1) {
            exponents.push_back(0);
            continue;
        }
        const MatrixXd A = slant - albedo / 2 * (same - other);
        const MatrixXd B = slant - albedo / 2 * (same + other);
        // 1/k^2 is the largest eigenvalue of (B A)^-1, similar to the symmetric L^-1 B^-1 L^-T with
        // A = L L^T.
        const Eigen::LLT<MatrixXd> factor(A);
        const MatrixXd half = factor.matrixL().solve(MatrixXd(B.llt().solve(
            MatrixXd(factor.matrixL().transpose().solve(MatrixXd::Identity(A.rows(), A.cols()))))));
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen((half + half.transpose()) / 2,
                                                            Eigen::EigenvaluesOnly);
        exponents.push_back(1 / std::sqrt(eigen.eigenvalues().maxCoeff()));
    }
    return exponents;
}

}  // namespace stratus
