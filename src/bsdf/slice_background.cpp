#include "slice_background.h"

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cstddef>

namespace stratus {
namespace {

/// Cosines of a background's curve where no table gives them.
AxisView background_axis() {
    static const AxisView axis = make_axis(AxisScale::arcsine_of_fourth_root, 0.01, 1, 24).view();
    return axis;
}

}  // namespace

SliceBackground::SliceBackground(const TableView* table, bool with_order_1,
                                 const PhaseFunction& phase_function,
                                 const std::vector<StackLayer>* layers)
    : table_(table), layers_(layers), cosines_(table ? table->mu_in : background_axis()) {
    const bool all_orders = table != nullptr;
    if (all_orders == with_order_1) return;
    if (layers)
        for (const StackLayer& layer : *layers) order_1_.emplace_back(layer.phase_function);
    else
        order_1_.emplace_back(phase_function);
}

double SliceBackground::order_1(double albedo, double optical_depth, double mu) const {
    if (!layers_) return albedo * order_1_[0](optical_depth, mu);
    Surroundings around{0, optical_depth};
    double sum = 0;
    for (std::size_t k = 0; k < layers_->size(); ++k) {
        const StackLayer& layer = (*layers_)[k];
        around.below = std::max(0.0, around.below - layer.optical_depth);
        sum += layer.albedo * direct_transmittance(around.above, mu) *
               order_1_[k](layer.optical_depth, mu, around.below);
        around.above += layer.optical_depth;
    }
    return sum;
}

std::vector<float> SliceBackground::curve(double albedo, double optical_depth) const {
    if (albedo == 0 || optical_depth == 0 || optical_depth == infinity) return {};
    std::vector<double> diffuse(static_cast<std::size_t>(cosines_.count));
    if (table_) diffuse = diffuse_transmittance(*table_, albedo, optical_depth);
    std::vector<float> shares;
    for (int i = 0; i < cosines_.count; ++i) {
        const double mu = cosines_.value(i);
        double value = diffuse[static_cast<std::size_t>(i)];
        if (!order_1_.empty()) value += (table_ ? -1 : 1) * order_1(albedo, optical_depth, mu);
        shares.push_back(static_cast<float>(value / intercepted_share(optical_depth, mu)));
    }
    return shares;
}

float background_share(const AxisView& cosines, const std::vector<float>& curve,
                       double optical_depth, double mu) noexcept {
    double share = direct_transmittance(optical_depth, mu);
    if (!curve.empty()) {
        const Stencil stencil = cosines.stencil(mu);
        float ratio = 0;
        for (int i = 0; i < std::min(stencil_size, cosines.count); ++i)
            ratio += stencil.weight[i] * curve[static_cast<std::size_t>(stencil.first + i)];
        share += intercepted_share(optical_depth, mu) * double{std::max(ratio, 0.0f)};
    }
    return static_cast<float>(std::min(share, 1.0));
}

}  // namespace stratus
