// Up to eight (mode, albedo) pairs of one phase function, doubled together: the owner of the lanes'
// memory.
#pragma once

#include <stratus/transfer/layer.h>

#include "simd/doubling_steps.h"

#include <cstdlib>
#include <memory>
#include <vector>

namespace stratus {

/// A layer this thin scatters twice less often than rounding notices, and stays above the smallest
/// normal numbers.
constexpr double thinnest_depth = 1e-280;

/// Reduced depth (1 - g) tau from which a conservative layer transmits by the law of diffusion to
/// rounding, and short of which doubling still resolves the gap between Y and Z, of order 1/tau.
constexpr double conservative_depth = 1048576;  // 2^20

/// T of a conservative layer over T of one of depth `deepest`, given T there and at half of it: 1/T
/// grows in proportion to the depth, by 3/4 (1 - g) [vdH80] or what the nodes make of it. R takes up
/// what T loses.
double transmitted_share_beyond(double deepest, double of_half, double of_deepest,
                                double optical_depth);

/// Doublings after which any layer has reached the limit of infinite depth: those up to depth 1, 56
/// until the rest is rounding, and some for g near 1.
int max_doublings_to_infinity(double optical_depth);

/// One lane: a mode of a layer of one albedo. The depth is that of the thin start.
struct DoublingTask {
    int mode;
    double albedo;
    double co_albedo;
    double thin_depth;
};

class DoublingLadder {
  public:
    /// Phase kernels and thin layers of all tasks, 1 to 8 of them.
    DoublingLadder(const Directions& directions, const std::vector<double>& moments,
                   const std::vector<DoublingTask>& tasks, const DoublingSteps& steps);

    void double_depth();

    /// True once twice this depth differs from it by less than rounding in every lane, so that it
    /// may stand for infinity.
    bool is_converged() const;

    /// Doubles until `is_converged`.
    void double_to_infinity();

    /// Works out R and T of all lanes as they stand; then `matrices` reads them lane by lane.
    void extract();
    ModeMatrices matrices(int lane) const;
    PhaseKernels kernels(int lane) const;

    const SimdLayer& layer() const { return layer_; }

  private:
    const Directions& directions_;
    const DoublingSteps& steps_;
    struct Free {
        void operator()(double* memory) const { std::free(memory); }
    };
    std::unique_ptr<double, Free> memory_;  // all matrices of layer_
    SimdLayer layer_{};
    int tasks_;
    bool conservative_[lane_count];  // mode 0 at w = 1
};

/// One lane of a kernel.
Eigen::MatrixXd lane_matrix(const SimdLayer& layer, const Pack* K, int lane);

/// Doublings from a thin start, exact to rounding, to `optical_depth`.
int count_doublings(const Directions& directions, double optical_depth);

}  // namespace stratus
