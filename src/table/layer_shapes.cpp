#include "layer_shapes.h"

#include <stratus/base/constants.h>
#include <stratus/layer/diffusion.h>

#include "base/size.h"
#include "kept_tolerance.h"

#include <algorithm>
#include <cstddef>

namespace stratus {
namespace {

constexpr float faintest = 1e-8f;  // below which errors count less

}  // namespace

LayerShapes::LayerShapes(const TableView& table, Side side)
    : table_(table),
      samples_(side == Side::reflection ? table.reflection_multiple : table.transmission_multiple),
      weight_(side == Side::reflection ? table.reflection_weight : table.transmission_weight),
      side_(side) {
    for (int i = 0; i < table.mu_in.count; ++i)
        for (int j = 0; j < partners(i); ++j)
            for (int k = 0; k < table.azimuth.count; ++k) {
                const Geometry at = geometry(i, j, k);
                phase_.push_back((*table.phase_function)(
                    side == Side::reflection ? cos_scattering_angle_reflected(at)
                                             : cos_scattering_angle_transmitted(at)));
            }
}

std::vector<float> LayerShapes::layer(int albedo, int depth, int step) const {
    // For a sample too small to be scaled back up, its neighbour is used as in lookup.h.
    const std::ptrdiff_t depths = table_.optical_depth.size();
    int neighbour = albedo;
    while (neighbour < table_.albedo.count && weight_[neighbour * depths + depth] == 0) ++neighbour;
    if (neighbour == table_.albedo.count)
        return depth > 0 ? layer(albedo, depth - 1, step)
                         : std::vector<float>(size(pairs()) * size((azimuths() - 1) / step + 1));
    const std::ptrdiff_t ins = table_.mu_in.count, outs = table_.mu_out.count, columns = azimuths();
    const std::ptrdiff_t at = neighbour * depths + depth;
    const float* const from = samples_ + at * ins * outs * columns;
    const float* const in = table_.mu_in_weight + depth * ins;
    const float* const out = table_.mu_out_weight + depth * outs;
    const bool symmetric = table_.is_symmetric();
    std::vector<float> values;
    values.reserve(size(pairs()) * size((columns - 1) / step + 1));
    for (int i = 0; i < ins; ++i)
        for (int j = 0; j < partners(i); ++j) {
            const float share = 0.5f * weight_[at] * in[i] * out[j];
            const float* const there = from + (i * outs + j) * columns;
            const float* const back = symmetric ? from + (j * outs + i) * columns : there;
            for (std::ptrdiff_t k = 0; k < columns; k += step)
                values.push_back(share * (there[k] + back[k]));
        }
    return values;
}

std::vector<float> LayerShapes::importance(int albedo, int depth, int step) const {
    const std::ptrdiff_t at = std::ptrdiff_t{albedo} * table_.optical_depth.size() + depth;
    std::vector<float> found = layer(albedo, depth, step);
    const double w = table_.albedo.value(albedo), tau = depth_of(depth);
    if (weight_[at] == 0 || w == 0) {  // below what float resolves
        std::fill(found.begin(), found.end(), 0.0f);
        return found;
    }
    const double exponent = table_.diffusion_exponent[albedo];
    const double scale = side_ == Side::reflection
                             ? reflection_scale(tau, exponent, table_.extrapolation_length)
                             : transmission_scale(tau, exponent, table_.extrapolation_length);
    const auto shares_of = [&](const AxisView& cosines) {
        std::vector<float> shares;
        for (int i = 0; i < cosines.count; ++i)
            shares.push_back(static_cast<float>(intercepted_share(tau, cosines.value(i))));
        return shares;
    };
    const std::vector<float> share_in = shares_of(table_.mu_in),
                             share_out = shares_of(table_.mu_out);
    const auto factor = [&](int i, int j) {  // by which samples were divided
        if (table_.has_lower_boundary()) return 1.0f;
        return static_cast<float>(w * scale) * share_in[size(i)] * share_out[size(j)];
    };
    float largest = 0;
    std::size_t n = 0;
    for (int i = 0; i < table_.mu_in.count; ++i)
        for (int j = 0; j < partners(i); ++j) {
            const double mu = table_.mu_in.value(i), other = table_.mu_out.value(j);
            const double order = side_ == Side::reflection
                                     ? single_reflection(1, w, tau, mu, other)
                                     : single_transmission(1, w, tau, mu, other);
            for (int k = 0; k < azimuths(); k += step, ++n) {
                double single = order * phase_[size(pair(i, j) * azimuths() + k)];
                if (table_.has_lower_boundary())
                    single += single_reflection_of_boundary(*table_.lower_boundary, tau,
                                                            geometry(i, j, k));
                found[n] = factor(i, j) * found[n] + static_cast<float>(single);
                if (std::min(mu, other) >= 0.1) largest = std::max(largest, found[n]);
            }
        }
    const float least = std::max(static_cast<float>(darkest_share) * largest, faintest);
    n = 0;
    for (int i = 0; i < table_.mu_in.count; ++i)
        for (int j = 0; j < partners(i); ++j)
            for (int k = 0; k < azimuths(); k += step, ++n)
                found[n] = factor(i, j) / std::max(found[n], least);
    return found;
}

/// Infinity for the last of an axis that ends there.
double LayerShapes::depth_of(int depth) const {
    return depth < table_.optical_depth.count ? table_.optical_depth.value(depth) : infinity;
}

Geometry LayerShapes::geometry(int in, int out, int azimuth) const {
    return {table_.mu_in.value(in), table_.mu_out.value(out), table_.azimuth.value(azimuth)};
}

}  // namespace stratus
