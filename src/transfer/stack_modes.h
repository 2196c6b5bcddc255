// The layers of a stack, truncated, mode after mode.
#pragma once

#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

#include "adding.h"
#include "layer.h"
#include "layer_modes.h"
#include "mode_recorder.h"
#include "simd/doubling_steps.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stratus {

class StackModes {
  public:
    /// Truncates `layers` as `truncations` say. Directions must outlive this.
    StackModes(const std::vector<StackLayer>& layers, const std::vector<Truncation>& truncations,
               const Directions& directions);

    std::size_t size() const { return layers_.size(); }
    /// Returns the optical depths after truncation.
    const std::vector<double>& depths() const { return depths_; }
    /// Returns how many modes any layer scatters into.
    int count() const;

    /// Returns a layer in a mode; where nothing is scattered into the mode, the beam alone.
    LayerMode layer(std::size_t k, int mode);
    /// Returns null where the layer scatters nothing into the mode. Valid until another mode is asked
    /// for.
    const PhaseKernels* kernels(std::size_t k, int mode);

    /// Returns the beam below the first `end` layers.
    Beam beam(std::size_t end) const;

  private:
    const Directions& directions_;
    std::vector<double> depths_;
    std::vector<double> left_out_;  // the optical depth that truncation takes out of each layer
    std::vector<LayerModes> layers_;
};

/// Calls solve(mode) for `count` modes, or as many as the options ask for; without such, until modes are
/// negligible (mode_recorder.h).
template <class Solve, class IsNegligible>
void solve_modes(const SolverOptions& options, int count, Solve solve, IsNegligible is_negligible) {
    solve_groups(
        options.modes ? std::min(options.modes, count) : count, lane_count, options.modes == 0,
        [&](int first, int end) {
            for (int mode = first; mode < end; ++mode) solve(mode);
        },
        is_negligible);
}

}  // namespace stratus
