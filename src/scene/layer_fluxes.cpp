#include "layer_fluxes.h"

#include <cmath>

namespace stratus {
namespace {

std::vector<double> widened(const std::vector<float>& values) {
    return {values.begin(), values.end()};
}

LayerFluxes::Weights weights_of(const AxisView& axis, double value) noexcept {
    const Stencil stencil = axis.stencil(value);
    LayerFluxes::Weights wide{stencil.first, {}};
    for (std::size_t i = 0; i < wide.weight.size(); ++i) wide.weight[i] = double{stencil.weight[i]};
    return wide;
}

}  // namespace

LayerFluxes::LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo)
    : albedo_(tables[0].albedo.view()),
      optical_depth_(tables[0].optical_depth.view()),
      mu_(tables[0].mu_in.view()),
      own_albedo_(albedo) {
    for (const Table& table : tables)
        all_.push_back({widened(table.diffuse_transmittance), widened(table.plane_albedo),
                        widened(table.spherical_albedo)});
    for (std::size_t c = 0; c < own_albedo_.size(); ++c) {
        const Weights at = weights_of(albedo_, own_albedo_[c]);
        for (const Values& all : all_) {
            Values own;
            for (std::size_t flux = 0; flux < own.size(); ++flux) {
                const std::size_t size = all[flux].size() / static_cast<std::size_t>(albedo_.count);
                own[flux].assign(size, 0.0);
                for (std::size_t a = 0; a < at.weight.size(); ++a) {
                    if (at.weight[a] == 0) continue;
                    const std::size_t row = static_cast<std::size_t>(at.first) + a;
                    for (std::size_t i = 0; i < size; ++i)
                        own[flux][i] += at.weight[a] * all[flux][row * size + i];
                }
            }
            own_[c].push_back(std::move(own));
        }
    }
    // Stencils of short axes reach beyond their samples, with weights of 0.
    for (auto* const values : {&all_, &own_[0], &own_[1], &own_[2]})
        for (Values& each : *values)
            for (std::vector<double>& flux : each)
                if (!flux.empty()) flux.resize(flux.size() + stencil_size, 0.0);
}

void LayerFluxes::set_cosine(Place& place, double mu) const noexcept {
    place.mu = weights_of(mu_, mu);
}

void LayerFluxes::set_albedo(Place& place, std::size_t channel, double albedo) const noexcept {
    const bool own = albedo == own_albedo_[channel];
    place.values = own ? &own_[channel] : &all_;
    place.albedo = own ? Weights{} : weights_of(albedo_, albedo);
}

void LayerFluxes::set_optical_depth(Place& place, double optical_depth) const noexcept {
    if (optical_depth_.count == 0 || std::isinf(optical_depth)) {
        place.optical_depth = {optical_depth_.size() - 1, {1, 0, 0, 0}};
        return;
    }
    place.optical_depth = weights_of(optical_depth_, optical_depth);
    // Thinner than the table: proportional to the depth.
    if (optical_depth < optical_depth_.lowest)
        for (double& weight : place.optical_depth.weight)
            weight *= optical_depth / optical_depth_.lowest;
}

double LayerFluxes::at(const Place& place, Flux flux, std::size_t table) const noexcept {
    const std::vector<double>& values = (*place.values)[table][flux];
    if (values.empty()) return 0;
    const bool of_all_cosines = flux == spherical_albedo;
    const std::size_t cosines = of_all_cosines ? 1 : static_cast<std::size_t>(mu_.count);
    double sum = 0;
    for (std::size_t a = 0; a < stencil_size; ++a) {
        if (place.albedo.weight[a] == 0) continue;
        for (std::size_t d = 0; d < stencil_size; ++d) {
            const double share = place.albedo.weight[a] * place.optical_depth.weight[d];
            if (share == 0) continue;
            const std::size_t row = (static_cast<std::size_t>(place.albedo.first) + a) *
                                        static_cast<std::size_t>(optical_depth_.size()) +
                                    static_cast<std::size_t>(place.optical_depth.first) + d;
            const double* const from = values.data() + row * cosines;
            if (of_all_cosines) {
                sum += share * *from;
                continue;
            }
            const double* const near = from + place.mu.first;
            const auto& weight = place.mu.weight;
            sum += share * (weight[0] * near[0] + weight[1] * near[1] + weight[2] * near[2] +
                            weight[3] * near[3]);
        }
    }
    return sum;
}

}  // namespace stratus
