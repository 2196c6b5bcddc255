// Doubling of all modes of layers of one phase function, recorded at every depth of a ladder.
#pragma once

#include <stratus/transfer/solver_options.h>

#include "layer.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace stratus {

/// Layers after truncation.
struct ClimbTask {
    struct Albedo {
        double albedo;
        double co_albedo;
        double first_depth;  // of the first octave
    };
    const Directions& directions;
    const std::vector<double>& moments;
    DepthLadder ladder;  // its first depth is that of each albedo
    std::vector<Albedo> albedos;
    bool between_requested = false;  // modes above 0 of climb_harmonic: R, T and kernels are those
                                     // between requested directions alone
    bool completed = false;  // peaks between nodes stay in their direction (simd/phase_kernels.cpp)
};

/// Called for each mode of each albedo at each depth of the ladder that is asked for, infinity last,
/// where R + T is the limit of R. Modes ascend. Returns whether deeper layers reflect the same and
/// transmit nothing, as climb_harmonic then has it.
using RecordMode = std::function<bool(int mode, std::size_t albedo, int depth, ModeMatrices layer,
                                      const PhaseKernels& kernels)>;

/// (mode, albedo) pairs eight at a time or one by one.
void climb_harmonic(const ClimbTask& task, std::span<const int> modes, const RecordMode& record);

/// Modes `first` to before `end`, by textbook doubling (reference/classic.h).
void climb_classic(const ClimbTask& task, const SolverOptions& options, int first, int end,
                   const RecordMode& record);

/// The sum of orders with the weights of each albedo; up to eight modes. All albedos share a first
/// depth, that of the layers before the share `fraction` was truncated.
void climb_orders(const ClimbTask& task, double fraction,
                  const std::vector<Eigen::VectorXd>& order_weights, int first, int end,
                  const RecordMode& record);

}  // namespace stratus
