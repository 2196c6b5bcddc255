// Neumann orders one by one: the light scattered exactly n times.
//
// Every matrix of a layer is a power series in the albedo, R = sum_n w^n R_n, and doubling is done
// on the series: products become Cauchy products, and no matrix is ever inverted, for light that is
// not scattered only crosses the layer. From the start on all terms of doubling are positive where
// the kernels are, so every order comes out to rounding, however weak. One run serves all albedos;
// it costs n^2 / 2 products where the sum of all orders costs one.
//
// The orders are those of the layer itself, truncated peaks included: of those w* and tau* are
// series in w as well.
#pragma once

#include <vector>

#include <stratus/transfer/layer.h>

namespace stratus {

/// sum_k w^k (diag(d_k) + K_k) over all directions, products summing over the Gauss nodes. A part
/// that is nothing is left empty; K_0 is always.
struct OrderSeries {
    int nodes;
    std::vector<Eigen::VectorXd> d;
    std::vector<Eigen::MatrixXd> K;

    OrderSeries(int nodes, int highest_order);
};

/// One azimuthal mode of a layer while its depth is doubled, orders 1 to `highest_order`.
class OrderedLayer {
  public:
    /// A layer no deeper than the smallest cosine, `truncated` the share f taken from its peak.
    OrderedLayer(const Directions& directions, const PhaseKernels& kernels, double truncated,
                 int highest_order, double thin_depth);

    void double_depth();

    /// True once no light comes through, so that this depth may stand for infinity.
    bool is_opaque() const;

    /// sum_n weights(n) R_n, and the same for T.
    ModeMatrices matrices(const Eigen::VectorXd& weights) const;

  private:
    void set_beam();

    const Directions& directions_;
    double truncated_;
    double optical_depth_;
    OrderSeries reflection_, transmission_;  // T with the beam on its diagonal
};

}  // namespace stratus
