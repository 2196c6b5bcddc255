#include "layer_fluxes.h"

#include <stratus/base/size.h>
#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

/// Fluxes over (albedo, optical_depth, mu), divided by the share of light that is intercepted.
std::vector<double> per_intercepted(const std::vector<float>& fluxes, const Table& table) {
    std::vector<double> divided(fluxes.begin(), fluxes.end());
    const auto &mu = table.mu_in.values, &depth = table.optical_depth.values;
    for (std::size_t k = 0; k < divided.size(); ++k)
        divided[k] /= intercepted_share(depth[k / mu.size() % depth.size()], mu[k % mu.size()]);
    return divided;
}

}  // namespace

LayerFluxes::LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo)
    : albedo_(tables[0].albedo.view()),
      optical_depth_(tables[0].optical_depth.view()),
      mu_(tables[0].mu_in.view()),
      own_albedo_(albedo) {
    for (const Table& table : tables)
        all_.push_back({per_intercepted(table.diffuse_transmittance, table),
                        per_intercepted(table.plane_albedo, table),
                        {table.spherical_albedo.begin(), table.spherical_albedo.end()}});
    for (std::size_t c = 0; c < own_albedo_.size(); ++c) {
        const Stencil at = albedo_.stencil(own_albedo_[c]);
        for (const Values& all : all_) {
            Values own;
            for (std::size_t flux = 0; flux < own.size(); ++flux) {
                const std::size_t row_size = all[flux].size() / size(albedo_.count);
                own[flux].assign(row_size, 0.0);
                for (std::size_t a = 0; a < stencil_size; ++a) {
                    if (at.weight[a] == 0) continue;
                    const std::size_t row = size(at.first) + a;
                    for (std::size_t i = 0; i < row_size; ++i)
                        own[flux][i] += double{at.weight[a]} * all[flux][row * row_size + i];
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

void LayerFluxes::set_cosine(Place& place, double mu) const {
    place.cosine = mu;
    place.mu = mu_.stencil(mu);
}

void LayerFluxes::set_albedo(Place& place, std::size_t channel, double albedo) const {
    const bool own = albedo == own_albedo_[channel];
    place.values = own ? &own_[channel] : &all_;
    place.albedo = own ? Stencil{0, {1, 0, 0, 0}} : albedo_.stencil(albedo);
}

void LayerFluxes::set_optical_depth(Place& place, double optical_depth) const {
    place.intercepted = intercepted_share(optical_depth, place.cosine);
    place.thinness = 1;
    if (optical_depth_.count == 0 || std::isinf(optical_depth)) {
        place.optical_depth = {optical_depth_.size() - 1, {1, 0, 0, 0}};
        return;
    }
    place.optical_depth = optical_depth_.stencil(optical_depth);
    place.thinness = std::min(1.0, optical_depth / optical_depth_.lowest);
}

double LayerFluxes::at(const Place& place, Flux flux, std::size_t table) const {
    const std::vector<double>& values = (*place.values)[table][flux];
    if (values.empty()) return 0;
    const bool of_all_cosines = flux == spherical_albedo;
    const std::size_t cosines = of_all_cosines ? 1 : size(mu_.count);
    double sum = 0;
    const double factor = of_all_cosines ? place.thinness : place.intercepted;
    for (std::size_t a = 0; a < stencil_size; ++a) {
        if (place.albedo.weight[a] == 0) continue;
        for (std::size_t d = 0; d < stencil_size; ++d) {
            const double share =
                double{place.albedo.weight[a]} * double{place.optical_depth.weight[d]};
            if (share == 0) continue;
            const std::size_t row = (size(place.albedo.first) + a) * size(optical_depth_.size()) +
                                    size(place.optical_depth.first) + d;
            const double* const from = values.data() + row * cosines;
            if (of_all_cosines) {
                sum += share * *from;
                continue;
            }
            const double* const near = from + place.mu.first;
            const auto& weight = place.mu.weight;
            sum += share * (double{weight[0]} * near[0] + double{weight[1]} * near[1] +
                            double{weight[2]} * near[2] + double{weight[3]} * near[3]);
        }
    }
    return factor * sum;
}

}  // namespace stratus
