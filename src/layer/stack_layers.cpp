#include <stratus/layer/stack_layers.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

namespace stratus {

double total_depth(const StackLayers& layers) noexcept {
    double depth = 0;
    for (const StackLayer& layer : layers) depth += layer.optical_depth;
    return depth;
}

void check_layers(const StackLayers& layers, bool over_boundary, const char* caller) {
    require(!layers.empty(), caller, "layers", "at least one", "none");
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const std::string of = layers.size() > 1 ? " of layer " + std::to_string(k + 1) : "";
        const double depth = layers[k].optical_depth;
        require_in("[0, 1]", caller, "albedo" + of, layers[k].albedo);
        require_in("[0, inf]", caller, "optical_depth" + of, depth);
        const bool may_be_infinite = k + 1 == layers.size() && !over_boundary;
        require(depth < infinity || may_be_infinite, caller, "optical_depth" + of,
                "finite above another layer or a lower boundary", depth);
    }
}

StackLayer mean_layer(const StackLayers& layers) {
    require(!layers.empty(), "mean_layer", "layers", "at least one", "none");
    const double depth = total_depth(layers);
    if (depth == infinity) return layers.back();
    std::vector<std::pair<double, PhaseFunction>> terms;
    double scattered = 0;
    for (const StackLayer& layer : layers) {
        const double part = layer.albedo * layer.optical_depth;
        if (part > 0) terms.emplace_back(part, layer.phase_function);
        scattered += part;
    }
    if (terms.empty()) return {layers.front().phase_function, 0, depth};
    return {PhaseFunction::sum(terms), std::min(1.0, scattered / depth), depth};
}

double single_scattering_through(Side side, const Surroundings& around, double phase_value,
                                 double albedo, double optical_depth, double mu_in,
                                 double mu_out) noexcept {
    const double way_out = side == Side::reflection ? around.above : around.below;
    return direct_transmittance(around.above, mu_in) * direct_transmittance(way_out, mu_out) *
           single_scattering(side, phase_value, albedo, optical_depth, mu_in, mu_out);
}

double stack_single_scattering(Side side, const StackLayers& layers,
                               const Geometry& geometry) noexcept {
    const double cosine = cos_scattering_angle(side, geometry);
    Surroundings around{0, total_depth(layers)};
    if (side == Side::transmission && around.below == infinity) return 0;
    double sum = 0;
    for (const StackLayer& layer : layers) {
        around.below = std::max(0.0, around.below - layer.optical_depth);
        sum += single_scattering_through(side, around, layer.phase_function(cosine), layer.albedo,
                                         layer.optical_depth, geometry.mu_in, geometry.mu_out);
        around.above += layer.optical_depth;
    }
    return sum;
}

}  // namespace stratus
