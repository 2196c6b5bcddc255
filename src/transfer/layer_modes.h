// A homogeneous layer of one depth, mode after mode.
#pragma once

#include "adding.h"
#include "depth_regime.h"
#include "layer.h"

#include <vector>

namespace stratus {

/// The requested layer, after truncation.
struct LayerTask {
    std::vector<double> moments;
    double albedo;
    double co_albedo;
    double optical_depth;  // [0, inf]
};

/// Doubles eight modes at a time, on demand.
class LayerModes {
  public:
    LayerModes(const Directions& directions, LayerTask task);

    /// Higher modes are empty: nothing is scattered into them.
    int count() const { return count_; }

    /// R, T and beam of a mode below count(); opaque at infinite depth. Valid until the next call.
    const LayerMode& layer(int mode);
    /// Phase kernels of a mode below count().
    const PhaseKernels& kernels(int mode);

  private:
    void solve_pack(int first);

    const Directions& directions_;
    const LayerTask task_;
    const DepthTarget target_;
    const int count_;
    int first_ = -1;  // mode of the current pack
    std::vector<LayerMode> layers_;
    std::vector<PhaseKernels> kernels_;
};

}  // namespace stratus
