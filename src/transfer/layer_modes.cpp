#include "layer_modes.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "climb.h"
#include "options.h"
#include "simd/doubling_steps.h"

#include <algorithm>
#include <cmath>
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
    const int first = mode / lane_count * lane_count;
    if (first != first_) solve_pack(first);
    return layers_[size(mode - first)];
}

const PhaseKernels& LayerModes::kernels(int mode) {
    layer(mode);
    return kernels_[size(mode - first_)];
}

void LayerModes::solve_pack(int first) {
    first_ = first;
    layers_.clear();
    kernels_.clear();
    const DepthLadder ladder = ladder_to(target_);
    const VectorXd beam = beam_along(directions_.mu, task_.optical_depth);
    double half_transmittance = 0;
    climb_harmonic(
        {directions_, task_.moments, ladder, {{task_.albedo, task_.co_albedo, ladder.first}}},
        modes_between(first, std::min(first + lane_count, count_)),
        [&](int mode, std::size_t, int depth, ModeMatrices layer, const PhaseKernels& kernels) {
            require_finite(layer, mode, directions_);
            if (depth + 1 < ladder.octaves) {
                if (mode == 0) half_transmittance = uniform_mean(directions_, layer.transmission);
                return false;
            }
            layer = reach(target_, mode, half_transmittance, directions_, std::move(layer));
            kernels_.push_back(kernels);
            if (target_.regime == DepthRegime::infinite)
                layers_.push_back({std::move(layer.reflection)});
            else
                layers_.push_back(
                    {layer.reflection, layer.reflection, std::move(layer.transmission), beam});
            if (mode == 0 && task_.co_albedo == 0)
                layers_.back().conserved = directions_.s.head(directions_.nodes);
            return false;
        });
}

// ---- the lower boundary ------------------------------------------------------------------------

BoundaryModes::BoundaryModes(const LowerBoundary& boundary, const Truncation& truncation,
                             const Directions& directions)
    : boundary_(boundary), truncation_(truncation), directions_(directions) {
    if (boundary.is_layer())
        modes_.emplace(directions, LayerTask{truncation.moments, truncation.albedo(boundary.albedo),
                                             truncation.co_albedo(boundary.albedo), infinity});
}

int BoundaryModes::count() const {
    if (modes_) return modes_->count();
    if (boundary_.law) return 2 * directions_.nodes;
    return boundary_.is_surface() ? 1 : 0;
}

LayerMode BoundaryModes::layer(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return {MatrixXd::Zero(n, n)};
    if (modes_) return modes_->layer(mode);
    LayerMode layer{directions_.s.asDiagonal() * once(mode) * directions_.s.asDiagonal()};
    if (!boundary_.law && boundary_.albedo == 1)
        layer.conserved = directions_.s.head(directions_.nodes);
    return layer;
}

MatrixXd BoundaryModes::once(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return MatrixXd::Zero(n, n);
    // The weights of uniform illumination sum to 1 only from three nodes on; dividing by their sum
    // keeps a white surface from absorbing with fewer.
    if (boundary_.law) return ground(mode);
    if (!modes_)
        return MatrixXd::Constant(
            n, n, boundary_.albedo / directions_.s.head(directions_.nodes).squaredNorm());
    const double w = truncation_.albedo(boundary_.albedo);
    MatrixXd once = modes_->kernels(mode).reflection;
    for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index i = 0; i < n; ++i)
            once(i, j) *= single_reflection(1, w, infinity, directions_.mu(i), directions_.mu(j));
    return once;
}

const MatrixXd& BoundaryModes::ground(int mode) {
    constexpr int group = 16;
    if (ground_.empty() || mode < first_ || mode >= first_ + group) {
        first_ = mode / group * group;
        const auto n = directions_.size();
        ground_.assign(group, MatrixXd(n, n));
        const AzimuthalModes modes_at(first_, first_ + group);
        for (Eigen::Index j = 0; j < n; ++j)
            for (Eigen::Index i = 0; i <= j; ++i) {
                const std::vector<double> modes =
                    modes_at(*boundary_.law, directions_.mu(j), directions_.mu(i));
                for (std::size_t m = 0; m < group; ++m)
                    ground_[m](i, j) = ground_[m](j, i) = modes[m];
            }
    }
    return ground_[size(mode - first_)];
}

VectorXd BoundaryModes::entering() {
    const VectorXd& s = directions_.s;
    if (boundary_.is_surface()) return (1 - boundary_.albedo) * s;
    if (boundary_.albedo == 1) return VectorXd::Zero(s.size());
    const int N = directions_.nodes;
    return s - layer(0).reflection.leftCols(N) * s.head(N);
}

// ---- stacks ------------------------------------------------------------------------------------

StackModes::StackModes(const StackLayers& layers, const std::vector<Truncation>& truncations,
                       const Directions& directions)
    : directions_(directions) {
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const StackLayer& layer = layers[k];
        const Truncation& truncation = truncations[k];
        depths_.push_back(truncation.optical_depth(layer.optical_depth, layer.albedo));
        left_out_.push_back(
            truncation.fraction > 0 ? truncation.fraction * layer.albedo * layer.optical_depth : 0);
        layers_.emplace_back(directions_,
                             LayerTask{truncation.moments, truncation.albedo(layer.albedo),
                                       truncation.co_albedo(layer.albedo), depths_.back()});
    }
}

int StackModes::count() const {
    return std::ranges::max_element(layers_, {}, &LayerModes::count)->count();
}

LayerMode StackModes::layer(std::size_t k, int mode) {
    if (mode < layers_[k].count()) return layers_[k].layer(mode);
    const MatrixXd none = MatrixXd::Zero(directions_.size(), directions_.size());
    if (std::isinf(depths_[k])) return {none};
    return {none, none, none, beam_along(directions_.mu, depths_[k])};
}

std::vector<const PhaseKernels*> StackModes::kernels(int mode) {
    std::vector<const PhaseKernels*> all;
    for (LayerModes& layer : layers_)
        all.push_back(mode < layer.count() ? &layer.kernels(mode) : nullptr);
    return all;
}

Beam StackModes::beam(std::size_t end) const {
    double depth = 0, left_out = 0;
    for (std::size_t k = 0; k < end; ++k) {
        depth += depths_[k];
        left_out += left_out_[k];
    }
    const VectorXd unscattered = beam_along(directions_.mu, depth);
    const VectorXd scattered =
        directions_.mu.unaryExpr([left_out](double mu) { return -std::expm1(-left_out / mu); });
    return {unscattered, unscattered.cwiseProduct(scattered)};
}

}  // namespace stratus
