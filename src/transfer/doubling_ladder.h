// Up to eight (mode, albedo) pairs of one phase function, doubled together in SIMD
// lanes; owns their memory.
#pragma once

#include <stratus/transfer/layer.h>

#include "simd/doubling_steps.h"

#include <cstdlib>
#include <memory>
#include <vector>

namespace stratus {

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

    /// True once another doubling changes less than rounding in every lane: the depth then counts
    /// as infinite.
    bool is_converged() const;

    /// Doubles until `is_converged`.
    void double_to_infinity();

    /// Computes R and T of all lanes at the current depth; `matrices` then reads them lane by lane.
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

}  // namespace stratus
