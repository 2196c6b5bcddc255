#include "stack_modes.h"

#include <cmath>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

StackModes::StackModes(const std::vector<StackLayer>& layers,
                       const std::vector<Truncation>& truncations, const Directions& directions)
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
    int count = 0;
    for (const LayerModes& layer : layers_) count = std::max(count, layer.count());
    return count;
}

LayerMode StackModes::layer(std::size_t k, int mode) {
    if (mode < layers_[k].count()) return layers_[k].layer(mode);
    const MatrixXd none = MatrixXd::Zero(directions_.size(), directions_.size());
    if (std::isinf(depths_[k])) return {none, {}, {}, {}};
    return {none, none, none, beam_along(directions_, depths_[k])};
}

const PhaseKernels* StackModes::kernels(std::size_t k, int mode) {
    return mode < layers_[k].count() ? &layers_[k].kernels(mode) : nullptr;
}

Beam StackModes::beam(std::size_t end) const {
    double depth = 0, left_out = 0;
    for (std::size_t k = 0; k < end; ++k) {
        depth += depths_[k];
        left_out += left_out_[k];
    }
    const VectorXd unscattered = beam_along(directions_, depth);
    const VectorXd scattered =
        directions_.mu.unaryExpr([left_out](double mu) { return -std::expm1(-left_out / mu); });
    return {unscattered, unscattered.cwiseProduct(scattered)};
}

}  // namespace stratus
