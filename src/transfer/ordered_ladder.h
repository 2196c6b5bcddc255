// Neumann orders one by one: the light scattered exactly n times, up to eight azimuthal modes at
// once. Phase kernels and SIMD products are those of the harmonic scheme; the doubling is not.
//
// Every matrix of a layer is a power series in the albedo, R = sum_n w^n R_n, and the series are
// doubled: products become Cauchy products, and no matrix is inverted, since order 0 is diagonal.
// All terms of doubling are positive where the kernels are, so that every order is accurate to
// rounding, however weak. One run serves all albedos; it costs n^2 / 2 products where the sum of
// all orders costs one.
//
// The orders are those of the layer itself. With a truncated peak, w* and tau* are series in w too.
#pragma once

#include "doubling_ladder.h"

#include <span>
#include <vector>

namespace stratus {

class OrderedLadder {
  public:
    /// Layers of depths up to the smallest cosine, orders 1 to `highest_order` of 1 to 8 `modes`;
    /// `truncated` is the share f taken from the peak.
    OrderedLadder(const Directions& directions, const std::vector<double>& moments,
                  double truncated, std::span<const int> modes, int highest_order,
                  double thin_depth);

    void double_depth();

    /// True once nothing is transmitted.
    bool is_converged() const;

    /// sum_n weights(n) R_n, and the same for T.
    ModeMatrices matrices(int lane, const Eigen::VectorXd& weights) const;
    std::vector<PhaseKernels> kernels() const { return start_.kernels(); }

  private:
    /// sum_k w^k (diag(d_k) + K_k), over all directions; zero parts are empty, K_0 always is.
    struct Series {
        std::vector<Eigen::VectorXd> d;
        std::vector<PackMemory> K;  // as in SimdLayer
    };

    Series nothing() const;
    void add_product(Series& sum, double factor, const Series& F, std::size_t i, const Series& G,
                     std::size_t j) const;
    void add(Series& sum, double factor, const Series& F) const;
    Series sum(double x, const Series& F, double y, const Series& G) const;
    Series product(const Series& F, const Series& G) const;
    Series inverse(const Series& F) const;
    Series parallel_sum(const Series& P, const Series& Q) const;
    Series scattered(double depth, const Pack* kernel) const;
    Pack* kernel(Series& of, std::size_t order) const;
    void set_beam();

    const Directions& directions_;
    const DoublingSteps<Pack>& steps_;
    double truncated_;
    std::size_t highest_order_;
    double optical_depth_;
    DoublingLadder<Pack> start_;        // for its phase kernels
    Series reflection_, transmission_;  // T with the beam on its diagonal
};

}  // namespace stratus
