#include "flux_lookup.h"

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>

#include "layer_blend.h"
#include "lookup_arguments.h"

#include <algorithm>
#include <cstddef>

namespace stratus {

std::vector<double> diffuse_transmittance(const TableView& table, double albedo,
                                          double optical_depth) {
    if (table.diffuse_transmittance == nullptr) return {};
    albedo = in_range("albedo", 0.0, 1.0, albedo);
    optical_depth = in_range("optical_depth", 0.0, infinity, optical_depth);
    const int cosines = table.mu_in.count;
    if (is_unknown(albedo, optical_depth))
        return std::vector<double>(static_cast<std::size_t>(cosines), double{not_a_number});
    std::vector<double> sum(static_cast<std::size_t>(cosines));
    const double clamped_albedo = std::clamp(albedo, table.albedo.lowest, table.albedo.highest);
    if (clamped_albedo == 0) return sum;
    const LayerBlend blend =
        transmission_blend(table, albedo, optical_depth, BeyondDeepest::follows_diffusion);
    const std::ptrdiff_t term_size =
        std::ptrdiff_t{cosines} * table.mu_out.count * table.azimuth.count;
    for (int n = 0; n < blend.count; ++n) {
        const BlendTerm& term = blend.term[n];
        const std::ptrdiff_t layer = term.first / term_size;
        // A blend is of samples divided by the albedo, which order 1 does not allow at albedo 0.
        const auto sampled_albedo = table.albedo.value(
            static_cast<int>(layer / table.optical_depth.size() % table.albedo.count));
        const double share = double{term.share} * sampled_albedo / clamped_albedo;
        for (int i = 0; i < cosines; ++i)
            sum[static_cast<std::size_t>(i)] +=
                share * double{table.mu_in_weight[term.depth * cosines + i]} *
                double{table.diffuse_transmittance[layer * cosines + i]};
    }
    for (int i = 0; i < cosines; ++i)
        sum[static_cast<std::size_t>(i)] *=
            intercepted_share(blend.optical_depth, table.mu_in.value(i));
    return sum;
}

}  // namespace stratus
