#include "layer.h"

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace stratus {

Eigen::VectorXd beam_along(const Eigen::VectorXd& mu, double optical_depth) {
    return mu.unaryExpr(  // Eigen's exp underflows at 2e-308
        [optical_depth](double cosine) { return direct_transmittance(optical_depth, cosine); });
}

double sum_modes(const std::vector<AzimuthalMode>& modes, int i, int j, double azimuth) {
    const double c = std::cos(azimuth);
    double previous = c, now = 1, sum = 0;  // cos((m - 1) phi), cos(m phi)
    for (std::size_t m = 0; m < modes.size(); ++m) {
        sum += (m ? 2 : 1) * now * modes[m](i, j);
        const double next = 2 * c * now - previous;
        previous = now;
        now = next;
    }
    return sum;
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

/// I - Q over the nodes, factored, Q = R* R of two layers.
///
/// Deep layers that absorb nothing keep nearly all light between them, and I - Q is singular to rounding. The
/// light that leaves is known without loss (derived here): with s^T R* = s^T - t_above^T and
/// s^T R = s^T - t_below^T, t the transmitted part of uniform light, s^T (I - Q) = t_below^T + t_above^T R. This
/// equation takes the place of a row.
class InterreflectionFactor {
  public:
    InterreflectionFactor(const LayerMode& above, const LayerMode& below, const MatrixXd& Q) {
        const Eigen::Index N = Q.rows();
        MatrixXd rest = MatrixXd::Identity(N, N) - Q;
        if (above.is_conservative() && below.is_conservative()) {
            s_ = above.conserved;
            const VectorXd leaving =
                transmitted(below, below.transmission.transpose()) +
                below.reflection.topLeftCorner(N, N) * transmitted(above, above.transmission);
            scale_ = leaving.maxCoeff(&row_);
            rest.row(row_) = leaving / scale_;
        }
        factor_.compute(rest);
        // Between a white ground's law and a deep layer, singular to the last bit: Q is then short of a
        // rounding error.
        if ((factor_.matrixLU().diagonal().array() == 0).any())
            factor_.compute(rest + std::numeric_limits<double>::epsilon() * Q);
    }

    /// Solves (I - Q) X = F.
    MatrixXd solve(const MatrixXd& F) const {
        MatrixXd B = F;
        if (s_.size() > 0) B.row(row_) = s_.transpose() * F / scale_;
        return factor_.solve(B);
    }

    /// Solves (I - Q)^T X = F.
    MatrixXd solve_transposed(const MatrixXd& F) const {
        MatrixXd X = factor_.transpose().solve(F);
        if (s_.size() > 0) {
            const Eigen::RowVectorXd uniform = X.row(row_) / scale_;
            X.row(row_).setZero();
            X += s_ * uniform;
        }
        return X;
    }

  private:
    /// Returns the transmitted part of uniform light, by the beam and the diffuse T, out of row, into column.
    VectorXd transmitted(const LayerMode& layer, const MatrixXd& T) const {
        const Eigen::Index N = s_.size();
        if (layer.is_opaque()) return VectorXd::Zero(N);
        return T.topLeftCorner(N, N) * s_ + layer.beam.head(N).cwiseProduct(s_);
    }

    Eigen::PartialPivLU<MatrixXd> factor_;
    VectorXd s_;  // empty unless a row was replaced
    Eigen::Index row_ = 0;
    double scale_ = 1;
};

/// Interreflection between two layers: solves (I - Q) X = F; or with Q^T, by `solve_transposed`.
BeamMatrix between(const InterreflectionFactor& factor,
                   MatrixXd (InterreflectionFactor::*solve)(const MatrixXd&) const,
                   const MatrixXd& Q, const BeamMatrix& F, int nodes) {
    MatrixXd K = F.K + Q * F.d.asDiagonal();
    K += Q.leftCols(nodes) * (factor.*solve)(K.topRows(nodes));
    return {F.d, K};
}

/// Light between two layers lit from above. [HT74], the adding equations: D is incident on the lower
/// layer, U leaves it.
struct Interreflection {
    BeamMatrix R, R_star;
    MatrixXd Q;
    InterreflectionFactor factor;
    BeamMatrix D, U;

    Interreflection(const LayerMode& above, const LayerMode& below, int N)
        : R{VectorXd::Zero(above.beam.size()), below.reflection},
          R_star{R.d, above.reflection_below},
          Q(product(R_star, R, N).K),
          factor(above, below, Q.topLeftCorner(N, N)),
          D(between(factor, &InterreflectionFactor::solve, Q, {above.beam, above.transmission}, N)),
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
    if (below.is_conservative()) sum.conserved = above.conserved;
    if (below.is_opaque()) return sum;

    const BeamMatrix S_down{below.beam, below.transmission};
    const BeamMatrix S_up{below.beam, below.transmission.transpose()};
    sum.transmission = product(S_down, D, N).K;
    const BeamMatrix V =
        between(factor, &InterreflectionFactor::solve_transposed, Q.transpose(), S_up, N);
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
    const InterreflectionFactor factor(above, below, bounce.topLeftCorner(N, N).transpose());
    const MatrixXd inner = factor.solve_transposed(weights.topRows(N));
    return above.beam.asDiagonal() * (bounce.leftCols(N) * inner) +
           above.transmission.topRows(N).transpose() * inner;
}

namespace {

/// Reduced depth (1 - g) tau beyond which a conservative layer transmits by the law of diffusion to
/// rounding, also where scattering keeps to two opposite directions. Doubling resolves the gap between
/// Y and Z, of order 1/tau, the worse the deeper the layer.
constexpr double conservative_depth = 4096;  // 2^12

/// T of a conservative layer over T of one of depth `last_depth`, given T there and at half of it:
/// 1/T grows in proportion to the depth, by 3/4 (1 - g) [vdH80] to the accuracy of the nodes.
double transmitted_share_beyond(double last_depth, double of_half, double of_last_depth,
                                double optical_depth) {
    const double growth = (1 / of_last_depth - 1 / of_half) / (last_depth / 2);
    return 1 / (1 + growth * of_last_depth * (optical_depth - last_depth));
}

}  // namespace

DepthTarget choose_target(double optical_depth, bool conservative, double asymmetry) {
    if (std::isinf(optical_depth)) return {optical_depth, DepthRegime::infinite, infinity};
    if (optical_depth < thinnest_depth) return {optical_depth, DepthRegime::thin, thinnest_depth};
    const double last_depth = conservative_depth / std::max(1e-16, 1 - asymmetry);
    if (conservative && optical_depth > last_depth)
        return {optical_depth, DepthRegime::conservative, last_depth};
    return {optical_depth};
}

DepthLadder ladder_to(const DepthTarget& target) {
    switch (target.regime) {
        case DepthRegime::infinite: return {first_depth_to_infinity, 0, true};
        case DepthRegime::conservative: return {target.doubled_depth / 2, 2, false};
        default: return {target.doubled_depth, 1, false};
    }
}

ModeMatrices reach(const DepthTarget& target, int mode, double half_transmittance,
                   const Directions& directions, ModeMatrices layer) {
    switch (target.regime) {
        case DepthRegime::solved: break;
        case DepthRegime::thin: {
            const double share = target.optical_depth / target.doubled_depth;
            layer.reflection *= share;
            layer.transmission *= share;
            break;
        }
        case DepthRegime::conservative: {  // R gains what T loses; T of higher modes is 0
            if (mode > 0) break;
            const double kept = transmitted_share_beyond(
                target.doubled_depth, half_transmittance,
                uniform_mean(directions, layer.transmission), target.optical_depth);
            layer.reflection += (1 - kept) * layer.transmission;
            layer.transmission *= kept;
            break;
        }
        case DepthRegime::infinite:  // DoublingLadder::is_converged
            layer.reflection += layer.transmission;
            layer.transmission.resize(0, 0);
            break;
    }
    return layer;
}

double uniform_mean(const Directions& directions, const Eigen::MatrixXd& mode) {
    const int N = directions.nodes;
    const Eigen::VectorXd s = directions.s.head(N);
    return s.dot(mode.topLeftCorner(N, N) * s) / s.squaredNorm();
}

int count_doublings(double smallest_cosine, double optical_depth) {
    return optical_depth <= smallest_cosine
               ? 0
               : static_cast<int>(std::ceil(std::log2(optical_depth) - std::log2(smallest_cosine)));
}

}  // namespace stratus
