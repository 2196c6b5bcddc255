#include "ordered_layer.h"

#include <cmath>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

using Series = OrderSeries;

/// Adds factor (diag(diagonal) + kernel) at one order.
void add(Series& F, std::size_t order, double factor, const VectorXd& diagonal,
         const MatrixXd& kernel) {
    VectorXd& d = F.d[order];
    MatrixXd& K = F.K[order];
    if (diagonal.size()) d = d.size() ? VectorXd(d + factor * diagonal) : factor * diagonal;
    if (kernel.size()) K = K.size() ? MatrixXd(K + factor * kernel) : factor * kernel;
}

/// Adds factor F_i G_j at order i + j.
void add_product(Series& sum, double factor, const Series& F, std::size_t i, const Series& G,
                 std::size_t j) {
    const VectorXd &d = F.d[i], &e = G.d[j];
    const MatrixXd &K = F.K[i], &L = G.K[j];
    if (d.size() && e.size()) add(sum, i + j, factor, d.cwiseProduct(e), {});
    if (d.size() && L.size()) add(sum, i + j, factor, {}, d.asDiagonal() * L);
    if (K.size() && e.size()) add(sum, i + j, factor, {}, K * e.asDiagonal());
    if (K.size() && L.size()) add(sum, i + j, factor, {}, K.leftCols(F.nodes) * L.topRows(F.nodes));
}

Series sum(double x, const Series& F, double y, const Series& G) {
    Series result(F.nodes, static_cast<int>(F.d.size()) - 1);
    for (std::size_t k = 0; k < F.d.size(); ++k) {
        add(result, k, x, F.d[k], F.K[k]);
        add(result, k, y, G.d[k], G.K[k]);
    }
    return result;
}

Series product(const Series& F, const Series& G) {
    Series result(F.nodes, static_cast<int>(F.d.size()) - 1);
    for (std::size_t k = 0; k < F.d.size(); ++k)
        for (std::size_t i = 0; i <= k; ++i) add_product(result, 1, F, i, G, k - i);
    return result;
}

/// F^-1 where F_0 is diagonal: G_0 = 1/F_0, G_k = -G_0 sum_{j=1..k} F_j G_{k-j}.
Series inverse(const Series& F) {
    Series G(F.nodes, static_cast<int>(F.d.size()) - 1);
    G.d[0] = F.d[0].cwiseInverse();
    for (std::size_t k = 1; k < F.d.size(); ++k) {
        for (std::size_t j = 1; j <= k; ++j) add_product(G, -1, F, j, G, k - j);
        if (G.d[k].size()) G.d[k] = G.d[k].cwiseProduct(G.d[0]).eval();
        if (G.K[k].size()) G.K[k] = (G.d[0].asDiagonal() * G.K[k]).eval();
    }
    return G;
}

/// P : Q = P - P (P + Q)^-1 P.
Series parallel(const Series& P, const Series& Q) {
    return sum(1, P, -1, product(P, product(inverse(sum(1, P, 1, Q)), P)));
}

}  // namespace

OrderSeries::OrderSeries(int of_nodes, int highest_order)
    : nodes(of_nodes),
      d(static_cast<std::size_t>(highest_order) + 1),
      K(static_cast<std::size_t>(highest_order) + 1) {}

OrderedLayer::OrderedLayer(const Directions& directions, const PhaseKernels& kernels,
                           double truncated, int highest_order, double thin_depth)
    : directions_(directions),
      truncated_(truncated),
      optical_depth_(thin_depth),
      reflection_(directions.nodes, highest_order),
      transmission_(directions.nodes, highest_order) {
    // The thin start of lanes/thin_layer.cpp, b = h B and W = (h A)^-1.
    const double h = thin_depth / 2;
    const VectorXd scale = directions.s.cwiseQuotient(directions.mu) / std::sqrt(2.0);
    const VectorXd slant = h * directions.mu.cwiseInverse();
    const auto start = [&](const MatrixXd& scattered) {
        Series F(directions.nodes, highest_order);
        F.d[0] = slant;
        if (truncated > 0) F.d[1] = -truncated * slant;
        F.K[1] = -h * (1 - truncated) / 2 * (scale.asDiagonal() * scattered * scale.asDiagonal());
        return F;
    };
    const auto times = [](double x, const Series& F) { return sum(x, F, 0, F); };
    const Series b = start(kernels.same + kernels.other);
    const Series W = inverse(start(kernels.same - kernels.other));
    Series Y = parallel(times(1.0 / 9, b), times(11, W));
    Y = parallel(times(1.0 / 5, b), sum(7, W, 1, Y));
    Y = parallel(b, sum(3, W, 1, Y));
    Series Z = parallel(times(1.0 / 7, b), sum(9, W, 1.0 / 11, b));
    Z = sum(1, W, 1, parallel(times(1.0 / 3, b), sum(5, W, 1, Z)));
    Y.d[0].array() += 1;
    Z.d[0].array() += 1;
    const Series even = inverse(Y), odd = inverse(Z);  // R + T = 2 (I + Y)^-1 - I, R - T with Z
    for (std::size_t k = 1; k < even.K.size(); ++k) {
        reflection_.K[k] = even.K[k] + odd.K[k];
        transmission_.K[k] = even.K[k] - odd.K[k];
    }
    set_beam();
}

void OrderedLayer::double_depth() {
    // R' = R + T (I - R R)^-1 R T,  T' = T (I - R R)^-1 T.  [HT74]
    const Series bounce = product(reflection_, reflection_);
    Series down = transmission_;  // between the halves: D = T + R R D
    for (std::size_t k = 2; k < down.d.size(); ++k)
        for (std::size_t j = 2; j <= k; ++j) add_product(down, 1, bounce, j, down, k - j);
    reflection_ = sum(1, reflection_, 1, product(transmission_, product(reflection_, down)));
    transmission_ = product(transmission_, down);
    optical_depth_ *= 2;
    set_beam();
}

bool OrderedLayer::is_opaque() const {
    const MatrixXd nothing = 1e-17 * directions_.s * directions_.s.transpose();
    for (std::size_t k = 1; k < transmission_.K.size(); ++k)
        if ((transmission_.K[k].array().abs() > nothing.array()).any()) return false;
    return true;
}

ModeMatrices OrderedLayer::matrices(const VectorXd& weights) const {
    const int n = directions_.size();
    ModeMatrices sums{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
    for (std::size_t k = 1; k < reflection_.K.size(); ++k) {
        const double weight = weights(static_cast<Eigen::Index>(k));
        if (reflection_.K[k].size()) sums.reflection += weight * reflection_.K[k];
        if (transmission_.K[k].size()) sums.transmission += weight * transmission_.K[k];
    }
    return sums;
}

/// exp(-(1 - w f) tau / mu), order by order.
void OrderedLayer::set_beam() {
    const VectorXd slant = optical_depth_ * directions_.mu.cwiseInverse();
    VectorXd term = slant.unaryExpr([](double x) { return std::exp(-x); });
    for (std::size_t k = 0; k < transmission_.d.size(); ++k) {
        transmission_.d[k] = truncated_ > 0 || k == 0 ? term : VectorXd();
        term = (term.cwiseProduct(slant) * (truncated_ / static_cast<double>(k + 1))).eval();
    }
}

}  // namespace stratus
