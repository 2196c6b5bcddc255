// Ladders of depths: of layers, then of power series in the albedo.
//
// Up to eight (mode, albedo) pairs of one phase function, doubled together in SIMD lanes, or one by
// itself; owns their memory.
#pragma once

#include "layer.h"
#include "simd/doubling_steps.h"

#include <cstdlib>
#include <memory>
#include <vector>

namespace stratus {

/// One lane: a mode of a layer of one albedo, and the first depth at which it is wanted.
struct DoublingTask {
    int mode;
    double albedo;
    double co_albedo;
    double first_depth;
};

/// Places of the grazing and of the steep directions, Gauss nodes first.
struct DirectionGroups {
    struct Group {
        int gauss = 0;
        std::vector<int> places;
        std::vector<double> mu, s;
    };
    Group grazing, steep;
};

/// Grazing directions are those below the widest gap between cosines of about `limit`; none where
/// a depth takes so few doublings that it does not pay to part them.
DirectionGroups group_directions(const Directions& directions, double optical_depth, double limit);

/// Number: Pack or double (simd/doubling_steps.h).
template <class Number>
class DoublingLadder {
  public:
    /// Phase kernels and layers at the first depth of all tasks, one to as many as there are lanes.
    /// `between_requested`: matrices and kernels are those between requested directions alone,
    /// unless mode 0 is among the tasks.
    DoublingLadder(const Directions& directions, const std::vector<double>& moments,
                   const std::vector<DoublingTask>& tasks, bool between_requested = false,
                   bool completed = false);

    void double_depth();

    /// True once another doubling changes less than rounding in every lane: the depth then counts
    /// as infinite.
    bool is_converged() const;

    /// Doubles until `is_converged`.
    void double_to_infinity();

    /// Computes R and T of all lanes at the current depth, which `matrices` then reads.
    void extract();
    std::vector<ModeMatrices> matrices() const;  // of each task
    std::vector<PhaseKernels> kernels() const;

    const SimdLayer<Number>& layer() const { return layer_; }

  private:
    struct Free {
        void operator()(double* memory) const { std::free(memory); }
    };
    using Memory = std::unique_ptr<double, Free>;

    void allocate(const std::vector<double>& moments, PhaseSeries<Number>& phase);
    void allocate(const DirectionGroups& groups);
    void double_depth(SimdLayer<Number>& layer) const;

    const Directions& directions_;
    const DoublingSteps<Number>& steps_;
    Memory memory_, memory_of_groups_;
    SimdLayer<Number> layer_{};
    DirectionGroups directions_of_groups_;
    SimdGroups<Number> groups_{};
    std::vector<SimdLayer<Number>*> doubled_;  // both groups, or the layer as a whole
    int tasks_;
    int first_ = 0;                         // direction of matrices and kernels
    bool conservative_[lanes_per<Number>];  // mode 0 at w = 1
};

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

class OrderedLadder {
  public:
    /// Layers of depths up to the smallest cosine, orders 1 to `highest_order` of 1 to 8 `modes`;
    /// `truncated` is the share f taken from the peak.
    OrderedLadder(const Directions& directions, const std::vector<double>& moments,
                  double truncated, const std::vector<int>& modes, int highest_order,
                  double thin_depth);

    void double_depth();

    /// Doubles until nothing is transmitted.
    void double_to_infinity();

    /// sum_n weights(n) R_n, and the same for T.
    ModeMatrices matrices(int lane, const Eigen::VectorXd& weights) const;
    std::vector<PhaseKernels> kernels() const { return start_.kernels(); }

  private:
    struct Free {
        void operator()(double* memory) const { std::free(memory); }
    };
    using Kernel = std::unique_ptr<double, Free>;  // Packs, as in SimdLayer

    /// sum_k w^k (diag(d_k) + K_k), over all directions; zero parts are empty, K_0 always is.
    struct Series {
        std::vector<Eigen::VectorXd> d;
        std::vector<Kernel> K;
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
    bool is_opaque() const;

    const Directions& directions_;
    const DoublingSteps<Pack>& steps_;
    double truncated_;
    std::size_t highest_order_;
    double optical_depth_;
    DoublingLadder<Pack> start_;        // for its phase kernels
    Series reflection_, transmission_;  // T with the beam on its diagonal
};

}  // namespace stratus
