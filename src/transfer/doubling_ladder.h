// Up to eight (mode, albedo) pairs of one phase function, doubled together in SIMD lanes, or one by
// itself; owns their memory.
#pragma once

#include "layer.h"
#include "simd/doubling_steps.h"

#include <cstddef>
#include <cstdint>
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

/// Doubles, of no value yet, from a pack's boundary on. Room for that is left here: aligned_alloc of
/// glibc before 2.38 asks for more than it frees, and the heap would grow from one ladder to the next.
class PackMemory {
  public:
    PackMemory() = default;
    explicit PackMemory(std::size_t count)
        : all_(new double[count + pack_alignment / sizeof(double)]) {}

    /// Null while there is none.
    double* get() const {
        constexpr std::uintptr_t last = pack_alignment - 1;
        return reinterpret_cast<double*>((reinterpret_cast<std::uintptr_t>(all_.get()) + last) &
                                         ~last);
    }

  private:
    std::unique_ptr<double[]> all_;
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

    /// Computes R and T of all lanes at the current depth, which `matrices` then reads.
    void extract();
    std::vector<ModeMatrices> matrices() const;  // of each task
    std::vector<PhaseKernels> kernels() const;

    const SimdLayer<Number>& layer() const { return layer_; }

  private:
    void allocate(const std::vector<double>& moments, PhaseSeries<Number>& phase);
    void allocate(const DirectionGroups& groups);
    void double_depth(SimdLayer<Number>& layer) const;

    const Directions& directions_;
    const DoublingSteps<Number>& steps_;
    PackMemory memory_, memory_of_groups_;
    SimdLayer<Number> layer_{};
    DirectionGroups directions_of_groups_;
    SimdGroups<Number> groups_{};
    std::vector<SimdLayer<Number>*> doubled_;  // both groups, or the layer as a whole
    int tasks_;
    int first_ = 0;                         // direction of matrices and kernels
    bool conservative_[lanes_per<Number>];  // mode 0 at w = 1
};

}  // namespace stratus
