#include "beam_matrix.h"

#include <Eigen/LU>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

BeamMatrix product(const BeamMatrix& F, const BeamMatrix& G, int nodes) {
    MatrixXd K = F.d.asDiagonal() * G.K;
    K += F.K * G.d.asDiagonal();
    K += F.K.leftCols(nodes) * G.K.topRows(nodes);
    return {F.d.cwiseProduct(G.d), K};
}

BeamMatrix inverse(const BeamMatrix& F, int nodes) {
    // diag(1/d) - (1/d) (K - K[:, :N] (D + K)_NN^-1 K[:N, :]) (1/d)
    MatrixXd block = F.K.topLeftCorner(nodes, nodes);
    block.diagonal() += F.d.head(nodes);
    const MatrixXd rest =
        F.K - F.K.leftCols(nodes) * block.partialPivLu().solve(F.K.topRows(nodes));
    const VectorXd d = F.d.cwiseInverse();
    return {d, -(d.asDiagonal() * rest * d.asDiagonal())};
}

}  // namespace stratus
