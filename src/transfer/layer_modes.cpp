#include "layer_modes.h"

#include <stratus/runtime/single_scattering.h>

#include "options.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LayerModes::LayerModes(const Directions& directions, LayerTask task, const DoublingSteps& steps)
    : directions_(directions), task_(std::move(task)), steps_(steps) {
    count_ = static_cast<int>(task_.moments.size());
    while (count_ > 1 && task_.moments[static_cast<std::size_t>(count_ - 1)] == 0) --count_;
}

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
    const bool infinite = std::isinf(task_.optical_depth);
    const double last = conservative_depth / std::max(1e-16, 1 - task_.moments[1]);
    const bool beyond = !infinite && task_.co_albedo == 0 && task_.optical_depth > last;
    const double solved = infinite ? directions_.mu.minCoeff()
                          : beyond ? last
                                   : std::max(task_.optical_depth, thinnest_depth);
    const int doublings = count_doublings(directions_, solved);
    std::vector<DoublingTask> tasks;
    for (int mode = first; mode < std::min(first + lane_count, count_); ++mode)
        tasks.push_back({mode, task_.albedo, task_.co_albedo, std::ldexp(solved, -doublings)});
    DoublingLadder ladder(directions_, task_.moments, tasks, steps_);
    for (std::size_t lane = 0; lane < tasks.size(); ++lane)
        kernels_.push_back(ladder.kernels(static_cast<int>(lane)));
    const VectorXd s = directions_.s.head(directions_.nodes);
    const auto transmittance = [&](const MatrixXd& T) {
        return s.dot(T.topLeftCorner(directions_.nodes, directions_.nodes) * s) / s.squaredNorm();
    };
    double of_half = 0;  // where conservative: of half the depth that is solved
    for (int k = 0; k < doublings; ++k) {
        if (beyond && first == 0 && k + 1 == doublings) {
            ladder.extract();
            of_half = transmittance(ladder.matrices(0).transmission);
        }
        ladder.double_depth();
    }
    if (infinite) ladder.double_to_infinity();
    ladder.extract();

    const VectorXd beam = directions_.mu.unaryExpr(
        [this](double mu) { return direct_transmittance(task_.optical_depth, mu); });
    for (std::size_t lane = 0; lane < tasks.size(); ++lane) {
        ModeMatrices layer = ladder.matrices(static_cast<int>(lane));
        require_finite(layer, tasks[lane].mode, directions_);
        MatrixXd &R = layer.reflection, &T = layer.transmission;
        if (infinite) {
            layers_.push_back({R + T, {}, {}, {}});  // DoublingLadder::is_converged
            continue;
        }
        if (beyond && tasks[lane].mode == 0) {
            const double kept =
                transmitted_share_beyond(last, of_half, transmittance(T), task_.optical_depth);
            R += (1 - kept) * T;
            T *= kept;
        }
        if (task_.optical_depth < thinnest_depth) {  // light scatters in proportion to the depth
            R *= task_.optical_depth / thinnest_depth;
            T *= task_.optical_depth / thinnest_depth;
        }
        layers_.push_back({R, R, T, beam});
    }
}

}  // namespace stratus
