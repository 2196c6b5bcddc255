#include "layer_modes.h"

#include "climb.h"
#include "options.h"
#include "simd/doubling_steps.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LayerModes::LayerModes(const Directions& directions, LayerTask task)
    : directions_(directions),
      task_(std::move(task)),
      target_(choose_target(task_.optical_depth, task_.co_albedo == 0, task_.moments[1])),
      count_(count_modes(task_.moments)) {}

const LayerMode& LayerModes::layer(int mode) {
    if (first_ < 0 || mode / lane_count * lane_count != first_)
        solve_pack(mode / lane_count * lane_count);
    return layers_[static_cast<std::size_t>(mode - first_)];
}

const PhaseKernels& LayerModes::kernels(int mode) {
    layer(mode);
    return kernels_[static_cast<std::size_t>(mode - first_)];
}

void LayerModes::solve_pack(int first) {
    first_ = first;
    layers_.clear();
    kernels_.clear();
    const DepthLadder ladder = ladder_to(target_);
    const double first_depth = ladder.octaves ? ladder.first : first_depth_to_infinity;
    const VectorXd beam = beam_along(directions_, task_.optical_depth);
    std::vector<int> modes(static_cast<std::size_t>(std::min(lane_count, count_ - first)));
    std::iota(modes.begin(), modes.end(), first);
    double half_transmittance = 0;
    climb_harmonic(
        {directions_, task_.moments, ladder, {{task_.albedo, task_.co_albedo, first_depth}}}, modes,
        [&](int mode, std::size_t, int depth, ModeMatrices layer, const PhaseKernels& kernels) {
            require_finite(layer, mode, directions_);
            if (depth + 1 < ladder.octaves) {
                if (mode == 0)
                    half_transmittance = mean_transmittance(directions_, layer.transmission);
                return;
            }
            layer = reach(target_, mode, half_transmittance, directions_, std::move(layer));
            kernels_.push_back(kernels);
            if (target_.regime == DepthRegime::infinite)
                layers_.push_back({std::move(layer.reflection), {}, {}, {}});
            else
                layers_.push_back(
                    {layer.reflection, layer.reflection, std::move(layer.transmission), beam});
        });
}

}  // namespace stratus
