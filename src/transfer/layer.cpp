#include "layer.h"

#include <stratus/base/argument.h>
#include <stratus/layer/single_scattering.h>

#include <Eigen/LU>

#include <cmath>
#include <string>
#include <utility>

namespace stratus {

Eigen::VectorXd beam_along(const Directions& directions, double optical_depth) {
    return directions.mu.unaryExpr(  // Eigen's exp underflows at 2e-308
        [optical_depth](double mu) { return direct_transmittance(optical_depth, mu); });
}

double sum_modes(const std::vector<double>& modes, double azimuth) {
    const double c = std::cos(azimuth);
    double previous = c, now = 1, sum = 0;  // cos((m - 1) phi), cos(m phi)
    for (std::size_t m = 0; m < modes.size(); ++m) {
        sum += (m ? 2 : 1) * now * modes[m];
        const double next = 2 * c * now - previous;
        previous = now;
        now = next;
    }
    return sum;
}

double sum_modes(const std::vector<Eigen::MatrixXd>& modes, int i, int j, double azimuth) {
    std::vector<double> here;
    for (const Eigen::MatrixXd& mode : modes) here.push_back(mode(i, j));
    return sum_modes(here, azimuth);
}

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

namespace {

void check(const LayerMode& above, const LayerMode& below, int nodes) {
    const auto n = above.reflection.rows();
    require(!above.is_opaque(), "add", "the layer above", "one that lets light through",
            "an opaque one");
    require(nodes >= 1 && nodes <= n, "add", "nodes", "in [1, " + std::to_string(n) + "]", nodes);
    require(below.reflection.rows() == n, "add", "directions of the layer below", std::to_string(n),
            below.reflection.rows());
}

MatrixXd symmetric(const MatrixXd& K) { return (K + K.transpose()) / 2; }

/// Interreflection between two layers: solves (I - Q) X = F, Q = R* R or R R*.
template <class Factor>
BeamMatrix between(const Factor& I_minus_Q, const MatrixXd& Q, const BeamMatrix& F, int nodes) {
    MatrixXd K = F.K + Q * F.d.asDiagonal();
    K += Q.leftCols(nodes) * MatrixXd(I_minus_Q.solve(K.topRows(nodes)));
    return {F.d, K};
}

/// Light between two layers lit from above. [HT74], the adding equations: D is incident on the lower
/// layer, U leaves it.
struct Interreflection {
    BeamMatrix R, R_star;
    MatrixXd Q;
    Eigen::PartialPivLU<MatrixXd> factor;  // of I - Q
    BeamMatrix D, U;

    Interreflection(const LayerMode& above, const LayerMode& below, int N)
        : R{VectorXd::Zero(above.beam.size()), below.reflection},
          R_star{R.d, above.reflection_below},
          Q(product(R_star, R, N).K),
          factor(MatrixXd::Identity(N, N) - Q.topLeftCorner(N, N)),
          D(between(factor, Q, {above.beam, above.transmission}, N)),
          U(product(R, D, N)) {}
};

}  // namespace

LightBetween light_between(const LayerMode& above, const LayerMode& below, int nodes) {
    check(above, below, nodes);
    Interreflection light(above, below, nodes);
    return {std::move(light.D.K), std::move(light.U.K)};
}

LayerMode add(const LayerMode& above, const LayerMode& below, int nodes) {
    check(above, below, nodes);
    const int N = nodes;
    const auto& [R, R_star, Q, factor, D, U] = Interreflection(above, below, N);
    const BeamMatrix T_up{above.beam, above.transmission.transpose()};
    LayerMode sum;
    sum.reflection = symmetric(above.reflection + product(T_up, U, N).K);
    if (below.is_opaque()) return sum;

    const BeamMatrix S_down{below.beam, below.transmission};
    const BeamMatrix S_up{below.beam, below.transmission.transpose()};
    sum.transmission = product(S_down, D, N).K;
    const BeamMatrix V = between(factor.transpose(), MatrixXd(Q.transpose()), S_up, N);
    sum.reflection_below =
        symmetric(below.reflection_below + product(S_down, product(R_star, V, N), N).K);
    sum.beam = above.beam.cwiseProduct(below.beam);
    return sum;
}

MatrixXd diffuse_flux_between(const LayerMode& above, const LayerMode& below,
                              const MatrixXd& weights, int nodes) {
    check(above, below, nodes);
    const int N = nodes;
    const MatrixXd bounce = below.reflection.leftCols(N) * above.reflection_below.topRows(N);
    // weights^T (I - R* R)^-1 T from the left: a few vectors instead of matrices.
    const MatrixXd inner = MatrixXd(MatrixXd::Identity(N, N) - bounce.topLeftCorner(N, N))
                               .partialPivLu()
                               .solve(weights.topRows(N));
    return above.beam.asDiagonal() * (bounce.leftCols(N) * inner) +
           above.transmission.topRows(N).transpose() * inner;
}

}  // namespace stratus
