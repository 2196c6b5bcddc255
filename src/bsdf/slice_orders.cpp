#include "slice_refinement.h"

#include <stratus/layer/diffusion.h>
#include <stratus/table/packed_table.h>

#include "table/layer_coverage.h"

#include <algorithm>

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
    const auto scale = which == Side::reflection ? reflection_scale : transmission_scale;
    const auto at = [&](double depth) {
        return scale(depth, std::max(0.0, exponent), table.extrapolation_length);
    };
    const double deepest = at(table.optical_depth.highest);
    return deepest > 0 ? at(optical_depth) / deepest : 0;
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
        orders.sheet.assign(static_cast<std::size_t>(table.mu_in.count) *
                                static_cast<std::size_t>(table.mu_out.count) *
                                static_cast<std::size_t>(table.azimuth.count),
                            0.0f);
        return orders;
    }
    orders.sheet = table.packed->layer(which, albedo, depth, table.members);
    if (follows) {
        const double factor = beyond_deepest(table, which, albedo, optical_depth);
        for (float& value : orders.sheet) value *= static_cast<float>(factor);
    }
    return orders;
}

}  // namespace

ChannelOrders find_orders(const TableView& table, Side which, double albedo, double optical_depth) {
    if (table.packed != nullptr) return packed_orders(table, which, albedo, optical_depth);
    const bool is_deep = optical_depth > table.optical_depth.highest;
    const BeyondDeepest beyond = is_deep && is_depth_known(table, which, albedo, optical_depth)
                                     ? BeyondDeepest::follows_diffusion
                                     : BeyondDeepest::is_clamped;
    LayerBlend found = layer_blend(table, which, albedo, optical_depth, beyond);
    if (is_scattered_once(table, albedo, optical_depth)) found.count = 0;
    return {found, {}};
}

}  // namespace stratus
