#include <stratus/base/constants.h>
#include <stratus/base/size.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/packed_table.h>

#include "slice_parts.h"
#include "table/layer_blend.h"

#include <algorithm>
#include <cstddef>

namespace stratus {
namespace {

/// Ratio of the light of a layer deeper than the deepest sample to that of the deepest.
double beyond_deepest(const TableView& table, Side which, double albedo, double optical_depth) {
    const Stencil around = table.albedo.stencil(albedo);
    double exponent = 0;
    for (int m = 0; m < table.members.count; ++m)
        for (int l = 0; l < std::min(stencil_size, table.albedo.count); ++l)
            exponent += double{table.members.weight[m]} * double{around.weight[l]} *
                        table.diffusion_exponent[table.members.member[m] * table.albedo.count +
                                                 around.first + l];
    return share_beyond_deepest(which, optical_depth, table.optical_depth.highest,
                                std::max(0.0, exponent), table.extrapolation_length);
}

/// The orders n >= 2 of a layer on one side, from a packed table.
ChannelOrders packed_orders(const TableView& table, Side which, double albedo,
                            double optical_depth) {
    const AxisView& depths = table.optical_depth;
    const bool is_deep = !depths.ends_at_infinity && optical_depth > depths.highest;
    const double depth = is_deep ? depths.highest : optical_depth;
    const bool follows = is_deep && is_depth_known(table, which, albedo, optical_depth);
    ChannelOrders orders;
    orders.blend.optical_depth = follows ? optical_depth : depth;
    if (is_scattered_once(table, albedo, optical_depth)) {
        orders.sheet.assign(size(samples_per_layer(table)), 0.0f);
        return orders;
    }
    orders.sheet = table.packed->layer(which, albedo, depth, table.members);
    if (follows) {
        const double factor = beyond_deepest(table, which, albedo, optical_depth);
        for (float& value : orders.sheet) value *= static_cast<float>(factor);
    }
    return orders;
}

/// Cosines of a background's curve where no table gives them.
AxisView background_axis() {
    static const AxisView axis = make_axis(AxisScale::arcsine_of_fourth_root, 0.01, 1, 24).view();
    return axis;
}

}  // namespace

ChannelOrders find_orders(const TableView& table, Side which, double albedo, double optical_depth) {
    if (optical_depth > 0 && table.optical_depth.count > 0 && !table.knows_thinner_layers())
        optical_depth = std::max(optical_depth, table.optical_depth.lowest);
    if (table.packed != nullptr) return packed_orders(table, which, albedo, optical_depth);
    const bool is_deep = optical_depth > table.optical_depth.highest;
    const BeyondDeepest beyond = is_deep && is_depth_known(table, which, albedo, optical_depth)
                                     ? BeyondDeepest::follows_diffusion
                                     : BeyondDeepest::is_clamped;
    LayerBlend found = layer_blend(table, which, albedo, optical_depth, beyond);
    if (is_scattered_once(table, albedo, optical_depth)) found.count = 0;
    return {found, {}};
}

SliceBackground::SliceBackground(const TableView* table, bool with_order_1,
                                 const PhaseFunction& phase_function, const StackLayers* layers)
    : table_(table),
      phase_function_(phase_function),
      layers_(layers),
      cosines_(table ? table->mu_in : background_axis()),
      times_order_1_((with_order_1 ? 1 : 0) - (table ? 1 : 0)) {}

double SliceBackground::order_1(double albedo, double optical_depth, double mu) {
    if (order_1_.empty() && layers_)
        for (const StackLayer& layer : *layers_) order_1_.emplace_back(layer.phase_function);
    else if (order_1_.empty())
        order_1_.emplace_back(phase_function_);
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

std::vector<double> SliceBackground::diffuse_transmittance(double albedo, double optical_depth) {
    const TableView& table = *table_;
    const int cosines = cosines_.count;
    std::vector<double> sum(size(cosines));
    const LayerBlend blend = layer_blend(table, Side::transmission, albedo, optical_depth,
                                         BeyondDeepest::follows_diffusion, true);
    const float* const sample = table.diffuse_transmittance;
    const int depths = table.optical_depth.size();
    for (int n = 0; n < blend.count; ++n) {
        const BlendTerm& term = blend.term[n];
        const std::ptrdiff_t layer = term.first / samples_per_layer(table);
        const auto sampled =
            table.albedo.value(static_cast<int>(layer / depths % table.albedo.count));
        const double depth = table.optical_depth.value(term.depth);
        const bool is_order_1 = sampled <= tiny_albedo && !layers_;
        for (int i = 0; i < cosines; ++i)
            sum[size(i)] += double{term.share} *
                            double{table.mu_in_weight[term.depth * cosines + i]} *
                            (is_order_1 ? order_1(1, depth, cosines_.value(i))
                                        : double{sample[layer * cosines + i]});
    }
    for (int i = 0; i < cosines; ++i)
        sum[size(i)] *= intercepted_share(blend.optical_depth, cosines_.value(i));
    return sum;
}

std::vector<float> SliceBackground::curve(double albedo, double optical_depth) {
    if (albedo == 0 || optical_depth == 0 || optical_depth == infinity) return {};
    std::vector<double> diffuse(size(cosines_.count));
    if (table_) diffuse = diffuse_transmittance(albedo, optical_depth);
    std::vector<float> shares;
    for (int i = 0; i < cosines_.count; ++i) {
        const double mu = cosines_.value(i);
        double value = diffuse[size(i)];
        if (times_order_1_ != 0) value += times_order_1_ * order_1(albedo, optical_depth, mu);
        shares.push_back(static_cast<float>(value / intercepted_share(optical_depth, mu)));
    }
    return shares;
}

}  // namespace stratus
