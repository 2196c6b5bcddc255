#include "layer_fluxes.h"

#include <stratus/base/size.h>
#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace stratus {
namespace {

constexpr std::size_t exponents = 3;  // their place after the fluxes

Side side_of(LayerFluxes::Flux flux) {
    return flux == LayerFluxes::diffuse_transmittance ? Side::transmission : Side::reflection;
}

/// Goes on by one more sample before some even ones `stride` apart, by the cubic through as many as four.
double sample_before(const double* next, std::size_t stride, std::size_t count) {
    switch (std::min<std::size_t>(count, 4)) {
        case 1: return next[0];
        case 2: return 2 * next[0] - next[stride];
        case 3: return 3 * (next[0] - next[stride]) + next[2 * stride];
        default: return 4 * (next[0] + next[2 * stride]) - 6 * next[stride] - next[3 * stride];
    }
}

/// How far fluxes of thin layers, divided by the light intercepted, are from their limit: in proportion to this,
/// which orders 1 and 2 have in common.
double from_thin_limit(double optical_depth) { return optical_depth * thin_growth(optical_depth); }

/// Fluxes of one of the mixtures over (albedo, optical_depth, mu), or without mu, divided by what scales
/// them; before the first depth of each albedo a row of the limit of thin layers. Where that leaves nothing of
/// a flux, at albedo 0 or in deep layers, order 1 at albedo 1 stands for light transmitted at albedo 0; all
/// else goes on from the next albedos, or from the next depth.
std::vector<double> divided(const std::vector<float>& fluxes, const Table& table,
                            std::size_t mixture, LayerFluxes::Flux flux) {
    if (fluxes.empty()) return {};
    constexpr double least = std::numeric_limits<float>::min(), tiny_albedo = 1e-15;
    const auto &albedo = table.albedo.values, &depth = table.optical_depth.values;
    const std::size_t row = fluxes.size() / (albedo.size() * depth.size()),
                      stride = (depth.size() + 1) * row;
    std::optional<SingleDiffuseTransmittance> order_1;  // of what is transmitted at albedo 0
    if (albedo[0] <= tiny_albedo && flux == LayerFluxes::diffuse_transmittance)
        order_1.emplace(phase_function_of_member(table, mixture));
    const bool of_all_cosines = flux == LayerFluxes::spherical_albedo;
    std::vector<double> all(albedo.size() * stride);
    for (std::size_t a = albedo.size(); a-- > 0;) {
        const auto scale_at = [&](std::size_t d) {
            return diffusion_scale(side_of(flux), depth[d], table.diffusion_exponent[a],
                                   table.extrapolation_lengths[mixture]);
        };
        for (std::size_t d = 0; d < depth.size(); ++d) {
            const double scale = scale_at(d);
            for (std::size_t m = 0; m < row; ++m) {
                const std::size_t i = a * stride + (d + 1) * row + m;
                const double mu = table.mu_in.values[m],
                             flux_here = double{fluxes[(a * depth.size() + d) * row + m]},
                             share = of_all_cosines ? 1 : intercepted_share(depth[d], mu);
                if (flux_here >= least && albedo[a] > tiny_albedo)
                    all[i] = flux_here / (albedo[a] * scale * share);
                else if (a == 0 && order_1 && scale >= least)
                    all[i] = (*order_1)(depth[d], mu) / (scale * share);
                else if (a + 1 < albedo.size())
                    all[i] = sample_before(&all[i + stride], stride, albedo.size() - a - 1);
                else if (d > 0)
                    all[i] = all[i - row];
            }
        }
        // Beyond the two thinnest samples, whose share of the light differs as their depth does without mu.
        double* const limit = &all[a * stride];
        std::copy_n(limit + row, row, limit);
        if (depth.size() < 2 || !std::isfinite(depth[1])) continue;
        const double next = scale_at(1) / scale_at(0) * (of_all_cosines ? depth[0] / depth[1] : 1),
                     beyond = from_thin_limit(depth[0]) /
                              (from_thin_limit(depth[1]) - from_thin_limit(depth[0]));
        for (double* value = limit; value < limit + row; ++value)
            *value += beyond * (value[row] - next * value[2 * row]);
    }
    return all;
}

}  // namespace

LayerFluxes::Decay::Decay(double exponent, double length)
    : exponent_(exponent), length_(length), rest_(-std::expm1(-2 * exponent * length)) {}

LayerFluxes::Scales LayerFluxes::Decay::scales(double optical_depth) const {
    if (std::isinf(optical_depth)) return {0, 0};
    if (exponent_ == 0) {
        const double share = length_ / (optical_depth + length_);
        return {share, share};
    }
    const double lost = -std::expm1(-exponent_ * optical_depth), left = 1 - lost,
                 share = left * rest_ / (rest_ + (1 - rest_) * lost * (1 + left));
    return {share, share * left};
}

LayerFluxes::LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo)
    : albedo_(tables[0].albedo.view()),
      optical_depth_(tables[0].optical_depth.view()),
      mu_(tables[0].mu_in.view()),
      own_albedo_(albedo) {
    for (std::size_t k = 0; k < tables.size(); ++k) {
        const Table& table = tables[k];
        all_.push_back({divided(table.diffuse_transmittance, table, k, diffuse_transmittance),
                        divided(table.plane_albedo, table, k, plane_albedo),
                        divided(table.spherical_albedo, table, k, spherical_albedo),
                        table.diffusion_exponent});
        extrapolation_length_.push_back(table.extrapolation_lengths[k]);
    }
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
            own_decay_[c].emplace_back(std::max(0.0, own[exponents][0]),
                                       extrapolation_length_[own_[c].size()]);
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

void LayerFluxes::set_optical_depth(Place& place, double optical_depth) const {
    place.intercepted = intercepted_share(optical_depth, place.cosine);
    place.thinness = 1;
    place.depth = optical_depth;
    place.transmitted = {1, {1, 0, 0, 0}};
    if (optical_depth_.count == 0) return;
    place.thinness = std::min(1.0, optical_depth / optical_depth_.lowest);
    place.depth = std::max(optical_depth, optical_depth_.lowest);
    if (place.thinness < 1) {
        const double sampled =
            from_thin_limit(optical_depth) / from_thin_limit(optical_depth_.lowest);
        place.transmitted = {0,
                             {static_cast<float>(1 - sampled), static_cast<float>(sampled), 0, 0}};
        return;
    }
    place.transmitted = optical_depth_.stencil(optical_depth);
    ++place.transmitted.first;  // after the limit of thin layers
}

void LayerFluxes::set_albedo(Place& place, std::size_t channel, double albedo) const {
    const bool own = albedo == own_albedo_[channel];
    place.values = own ? &own_[channel] : &all_;
    place.albedo = own ? Stencil{0, {1, 0, 0, 0}} : albedo_.stencil(albedo);
    place.factor = std::clamp(albedo, albedo_.lowest, albedo_.highest);
    const Decay decay = own && place.table.weight[0] == 1
                            ? own_decay_[channel][size(place.table.first)]
                            : decay_at(place);
    const Scales scales = decay.scales(place.depth);
    place.transmission = scales.transmission;
    place.reflection = scales.reflection();
    place.reflected = place.transmitted;
    if (!optical_depth_.ends_at_infinity || place.depth <= optical_depth_.highest) return;
    // The distance from the limit dies away by the law of diffusion.
    const Scales deepest = decay.scales(optical_depth_.highest);
    const double left = deepest.deficit > 0 ? scales.deficit / deepest.deficit : 0;
    place.reflection = 1;
    place.reflected = {
        optical_depth_.count,
        {static_cast<float>(left * deepest.reflection()), static_cast<float>(1 - left), 0, 0}};
}

LayerFluxes::Decay LayerFluxes::decay_at(const Place& place) const {
    double exponent = 0, length = 0;
    for (std::size_t k = 0; k < stencil_size; ++k) {
        if (place.table.weight[k] == 0) continue;
        const std::size_t table = size(place.table.first) + k;
        const double share{place.table.weight[k]};
        const double* const near = (*place.values)[table][exponents].data() + place.albedo.first;
        for (std::size_t a = 0; a < stencil_size; ++a)
            exponent += share * double{place.albedo.weight[a]} * near[a];
        length += share * extrapolation_length_[table];
    }
    return Decay(std::max(0.0, exponent), length);
}

double LayerFluxes::at(const Place& place, Flux flux) const {
    const bool lit = flux != diffuse_transmittance;
    double sum = 0;
    for (std::size_t k = 0; k < stencil_size; ++k) {
        if (place.table.weight[k] == 0) continue;
        const auto& values = (*place.values)[size(place.table.first) + k][flux];
        if (values.empty()) return 0;
        sum += double{place.table.weight[k]} *
               interpolated(values, place, lit ? place.reflected : place.transmitted, flux);
    }
    return sum * place.factor * (lit ? place.reflection : place.transmission) *
           (flux == spherical_albedo ? place.thinness : place.intercepted);
}

double LayerFluxes::interpolated(const std::vector<double>& values, const Place& place,
                                 const Stencil& depths, Flux flux) const {
    const bool of_all_cosines = flux == spherical_albedo;
    const std::size_t cosines = of_all_cosines ? 1 : size(mu_.count);
    double sum = 0;
    for (std::size_t a = 0; a < stencil_size; ++a) {
        if (place.albedo.weight[a] == 0) continue;
        for (std::size_t d = 0; d < stencil_size; ++d) {
            const double share = double{place.albedo.weight[a]} * double{depths.weight[d]};
            if (share == 0) continue;
            const std::size_t row =
                (size(place.albedo.first) + a) * (size(optical_depth_.size()) + 1) +
                size(depths.first) + d;
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
    return sum;
}

}  // namespace stratus
