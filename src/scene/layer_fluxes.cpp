#include "layer_fluxes.h"

#include <cmath>

namespace stratus {
namespace {

constexpr Stencil one_sample{0, {1, 0, 0, 0}};

}  // namespace

LayerFluxes::LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo)
    : albedo_(tables[0].albedo.view()),
      optical_depth_(tables[0].optical_depth.view()),
      mu_(tables[0].mu_in.view()),
      own_albedo_(albedo) {
    for (const Table& table : tables)
        all_.push_back({table.diffuse_transmittance, table.plane_albedo, table.spherical_albedo});
    for (std::size_t c = 0; c < own_albedo_.size(); ++c) {
        const Stencil stencil = albedo_.stencil(own_albedo_[c]);
        for (const Values& all : all_) {
            Values own;
            for (std::size_t flux = 0; flux < own.size(); ++flux) {
                const std::size_t size = all[flux].size() / static_cast<std::size_t>(albedo_.count);
                for (std::size_t i = 0; i < size; ++i) {
                    double sum = 0;
                    for (std::size_t a = 0; a < stencil_size; ++a)
                        if (stencil.weight[a] != 0)
                            sum +=
                                double{stencil.weight[a]} *
                                double{
                                    all[flux]
                                       [(static_cast<std::size_t>(stencil.first) + a) * size + i]};
                    own[flux].push_back(static_cast<float>(sum));
                }
            }
            own_[c].push_back(std::move(own));
        }
    }
    // Stencils of short axes reach beyond their samples, with weights of 0.
    for (auto* const values : {&all_, &own_[0], &own_[1], &own_[2]})
        for (Values& each : *values)
            for (std::vector<float>& flux : each)
                if (!flux.empty()) flux.resize(flux.size() + stencil_size, 0.0f);
}

void LayerFluxes::set_albedo(Place& place, std::size_t channel, double albedo) const noexcept {
    const bool own = albedo == own_albedo_[channel];
    place.values = own ? &own_[channel] : &all_;
    place.albedo = own ? one_sample : albedo_.stencil(albedo);
}

void LayerFluxes::set_optical_depth(Place& place, double optical_depth) const noexcept {
    place.factor = 1;
    if (optical_depth_.count == 0 || std::isinf(optical_depth)) {
        place.optical_depth = one_sample;
        place.optical_depth.first = optical_depth_.size() - 1;
        return;
    }
    place.optical_depth = optical_depth_.stencil(optical_depth);
    if (optical_depth < optical_depth_.lowest) place.factor = optical_depth / optical_depth_.lowest;
}

double LayerFluxes::at(const Place& place, Flux flux, std::size_t table) const noexcept {
    const std::vector<float>& values = (*place.values)[table][flux];
    if (values.empty()) return 0;
    const bool of_all_cosines = flux == spherical_albedo;
    const std::size_t cosines = of_all_cosines ? 1 : static_cast<std::size_t>(mu_.count);
    const Stencil& mu = of_all_cosines ? one_sample : place.mu;
    double sum = 0;
    for (int a = 0; a < stencil_size; ++a) {
        if (place.albedo.weight[a] == 0) continue;
        for (int d = 0; d < stencil_size; ++d) {
            if (place.optical_depth.weight[d] == 0) continue;
            const auto row = static_cast<std::size_t>(
                (place.albedo.first + a) * optical_depth_.size() + place.optical_depth.first + d);
            const float* const from =
                values.data() + row * cosines + static_cast<std::size_t>(mu.first);
            double part = 0;
            for (int i = 0; i < stencil_size; ++i) part += double{mu.weight[i]} * double{from[i]};
            sum += double{place.albedo.weight[a]} * double{place.optical_depth.weight[d]} * part;
        }
    }
    return place.factor * sum;
}

}  // namespace stratus
