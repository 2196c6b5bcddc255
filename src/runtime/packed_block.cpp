#include "packed_block.h"

#include "mu_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace stratus {
namespace {

// Error that straight lines between cosines may make in all but the worst hundredth of the
// directions, as a share of the tolerance.
constexpr double line_share = 0.25, rare = 0.01;

constexpr float negligible = 1e-16f;  // coefficient

std::size_t size(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// Cosines at which a block is sampled, closer where straight lines need it.
struct MuGrid {
    double v_first, v_step;   // of the segments
    int first[segments + 1];  // place at which a segment begins

    int last() const { return first[segments]; }

    double mu(int place) const {
        if (last() == 0) return mu_at(v_first);
        const int at = std::min(place, last());
        int segment = 0;
        while (segment + 1 < segments && first[segment + 1] <= at) ++segment;
        return mu_at(v_first + v_step * (segment + static_cast<double>(at - first[segment]) /
                                                       (first[segment + 1] - first[segment])));
    }
};

/// The cosines along one of the table's axes of them; pair(along, across) of two samples.
template <class Pair>
MuGrid mu_grid(const AxisView& axis, const AxisView& across, const Pair& pair,
               const BlockLayers& layers, double allowed) {
    constexpr int probed = 16;     // intervals a segment
    constexpr int max_steps = 64;  // a segment
    MuGrid grid{v_at(axis.highest), 0, {}};
    if (axis.count < 2) return grid;
    grid.v_step = (v_at(axis.lowest) - grid.v_first) / segments;
    std::vector<Stencil> stencils;
    for (int i = 0; i <= segments * probed; ++i)
        stencils.push_back(axis.stencil(mu_at(grid.v_first + grid.v_step * i / probed)));
    std::vector<float> errors[segments];
    const int used = std::min(stencil_size, axis.count), azimuths = layers.azimuths;
    const int layer_step = std::max(1, layers.count() / 40),
              azimuth_step = std::max(1, azimuths / 4);
    std::vector<float> along(stencils.size()), importance(stencils.size());
    for (int l = 0; l < layers.count(); l += layer_step)
        for (int j = 0; j < across.count; ++j)
            for (int k = 0; k < azimuths; k += azimuth_step) {
                for (std::size_t i = 0; i < stencils.size(); ++i) {
                    along[i] = importance[i] = 0;
                    for (int s = 0; s < used; ++s) {
                        const float share = stencils[i].weight[s];
                        const auto at = size(pair(stencils[i].first + s, j) * azimuths + k);
                        along[i] += share * (*layers.values[size(l)])[at];
                        importance[i] += std::max(0.0f, share) * (*layers.importance[size(l)])[at];
                    }
                }
                for (std::size_t i = 1; i + 1 < stencils.size(); ++i)
                    errors[i / probed].push_back(
                        std::abs(along[i - 1] - 2 * along[i] + along[i + 1]) * importance[i]);
            }
    for (int segment = 0; segment < segments; ++segment) {
        auto& found = errors[segment];
        const auto common =
            static_cast<std::ptrdiff_t>((1 - rare) * static_cast<double>(found.size()));
        std::nth_element(found.begin(), found.begin() + common, found.end());
        // An eighth of the second difference, of steps `probed` times as long as here.
        const double with_one_step = double{found[size(common)]} * probed * probed / 8;
        const double steps = std::ceil(std::sqrt(with_one_step / allowed));
        grid.first[segment + 1] =
            grid.first[segment] + static_cast<int>(std::clamp(steps, 1.0, double{max_steps}));
    }
    return grid;
}

/// The power of two in units of which halves hold a number up to `largest`.
float unit_of(float largest) {
    return largest > 0 ? std::exp2(std::ceil(std::log2(largest / (largest_half / 2)))) : 1;
}

/// The functions at the table's own directions, all azimuths: over (pair of cosines, azimuth,
/// function).
std::vector<float> functions_at_samples(const LayerShapes& samples, const BlockLayers& layers,
                                        const LayerBasis& basis) {
    std::vector<float> all(size(samples.pairs()) * size(samples.azimuths() * functions));
    for (std::size_t f = 0; f < basis.pivot.size(); ++f) {
        const int pivot = basis.pivot[f], depths = layers.depth_count();
        const std::vector<float> layer = samples.layer(layers.albedos.first + pivot / depths,
                                                       layers.depths.first + pivot % depths, 1);
        for (std::size_t c = 0; c < layer.size(); ++c) {
            float* const here = &all[c * functions];
            double left = double{layer[c]};
            for (std::size_t earlier = 0; earlier < f; ++earlier)
                left -= double{basis.coefficient[size(pivot)][earlier]} * double{here[earlier]};
            here[f] = static_cast<float>(left / basis.norm[f]);
        }
    }
    return all;
}

/// Divides functions by their units.
std::array<float, functions> scale_to_units(std::vector<float>& values) {
    std::array<float, functions> unit{};
    for (std::size_t c = 0; c < values.size(); ++c) {
        float& largest = unit[c % functions];
        largest = std::max(largest, std::abs(values[c]));
    }
    for (float& one : unit) one = unit_of(one);
    for (std::size_t c = 0; c < values.size(); ++c) values[c] /= unit[c % functions];
    return unit;
}

/// The functions over (mu, mu', azimuth), at the cosines of two grids.
std::vector<FunctionRow> refined(const LayerShapes& samples, const std::vector<float>& at_samples,
                                 const MuGrid& in, const MuGrid& out) {
    const AxisView &mu_in = samples.table().mu_in, &mu_out = samples.table().mu_out;
    const bool symmetric = samples.table().is_symmetric();
    const int cosines = mu_in.count, azimuths = samples.azimuths();
    const std::size_t row_size = size(azimuths * functions);
    const int count = in.last() + 2;  // one beyond the last
    const int columns = symmetric ? count + 1 : out.last() + 2;
    const auto stencils_of = [](const AxisView& axis, const MuGrid& grid, int places) {
        std::vector<Stencil> stencils;
        for (int i = 0; i < places; ++i) stencils.push_back(axis.stencil(grid.mu(i)));
        return stencils;
    };
    const std::vector<Stencil> along_in = stencils_of(mu_in, in, count),
                               along_out = stencils_of(mu_out, out, columns);
    const auto add = [&](const float* from, float share, float* to) {
        for (std::size_t k = 0; k < row_size; ++k) to[k] += share * from[k];
    };
    // Finer in mu', then in mu.
    std::vector<float> finer(size(cosines * columns) * row_size);
    for (int i = 0; i < cosines; ++i)
        for (int j = 0; j < columns; ++j)
            for (int s = 0; s < std::min(stencil_size, mu_out.count); ++s)
                add(&at_samples[size(samples.pair(i, along_out[size(j)].first + s)) * row_size],
                    along_out[size(j)].weight[s], &finer[size(i * columns + j) * row_size]);
    const int rows = azimuths > 1 ? azimuths + 2 : 1, inside = azimuths > 1 ? 1 : 0;
    const std::size_t cells =
        symmetric ? size(count) * size(count + 3) / 2 : size(count) * size(columns);
    std::vector<FunctionRow> all(cells * size(rows), FunctionRow{});
    FunctionRow* to = all.data();
    std::vector<float> row(row_size);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < (symmetric ? i + 2 : columns); ++j, to += rows) {
            std::fill(row.begin(), row.end(), 0.0f);
            for (int s = 0; s < std::min(stencil_size, cosines); ++s)
                add(&finer[size((along_in[size(i)].first + s) * columns + j) * row_size],
                    along_in[size(i)].weight[s], row.data());
            for (std::size_t k = 0; k < row_size; ++k)
                to[size(inside) + k / functions].value[k % functions] = to_half(row[k]);
            if (azimuths > 1) {
                to[0] = to[2];
                to[azimuths + 1] = to[azimuths - 1];
            }
        }
    return all;
}

/// Coefficients over (albedo, optical depth), axes no shorter than a cubic, of functions in the
/// units that they are stored in.
std::vector<CoefficientRow> coefficients(const BlockLayers& layers, const LayerBasis& basis,
                                         const std::array<float, functions>& unit) {
    const int finite = layers.depths.count, depths = layers.depth_count();
    const Resampling albedo(layers.albedos.count), depth(std::max(finite, 1));
    const int rows = depth.to + depths - finite;
    std::vector<CoefficientRow> all(size(albedo.to) * size(rows), CoefficientRow{});
    const auto depth_weight = [&](int from, int to) {
        if (from == finite || to == depth.to) return from - finite == to - depth.to ? 1.0 : 0.0;
        return depth.weight(from, to);
    };
    for (int a = 0; a < albedo.to; ++a)
        for (int d = 0; d < rows; ++d)
            for (int l = 0; l < layers.albedos.count; ++l)
                for (int t = 0; t < depths; ++t) {
                    const double share = albedo.weight(l, a) * depth_weight(t, d);
                    if (share == 0) continue;
                    const auto& of_layer = basis.coefficient[size(l * depths + t)];
                    for (std::size_t f = 0; f < of_layer.size(); ++f)
                        all[size(a * rows + d)].value[f] +=
                            static_cast<float>(share * double{of_layer[f]} * double{unit[f]});
                }
    // At albedo 0 little is left: products of it underflow, which takes fifty cycles each.
    for (CoefficientRow& row : all)
        for (float& value : row.value)
            if (std::abs(value) < negligible) value = 0;
    return all;
}

}  // namespace

double Resampling::weight(int old_sample, int new_sample) const {
    if (from == to) return old_sample == new_sample ? 1 : 0;
    const double at = static_cast<double>(new_sample) * (from - 1) / (to - 1);
    double product = 1;  // Lagrange
    for (int other = 0; other < from; ++other)
        if (other != old_sample) product *= (at - other) / (old_sample - other);
    return product;
}

TexturedAxis Resampling::axis(const AxisView& view) const {
    const double finer = from > 1 ? static_cast<double>(to - 1) / (from - 1) : 0;
    return {static_cast<float>(view.first), static_cast<float>(view.inverse_step * finer),
            static_cast<float>(to - 1)};
}

PackedBlock packed_block(const LayerShapes& samples, const BlockLayers& layers,
                         const LayerBasis& basis, double tolerance) {
    const TableView& table = samples.table();
    const double allowed = line_share * tolerance;
    const MuGrid in = mu_grid(
        table.mu_in, table.mu_out, [&](int i, int j) { return samples.pair(i, j); }, layers,
        allowed);
    const MuGrid out = table.is_symmetric()
                           ? in
                           : mu_grid(
                                 table.mu_out, table.mu_in,
                                 [&](int j, int i) { return samples.pair(i, j); }, layers, allowed);
    std::vector<float> at_samples = functions_at_samples(samples, layers, basis);
    const std::array<float, functions> unit = scale_to_units(at_samples);
    PackedBlock block{refined(samples, at_samples, in, out),
                      coefficients(layers, basis, unit),
                      {},
                      {},
                      out.last() + 2,
                      std::max(stencil_size, layers.depths.count) + (layers.and_infinity ? 1 : 0)};
    std::copy(std::begin(in.first), std::end(in.first), block.first_in);
    std::copy(std::begin(out.first), std::end(out.first), block.first_out);
    return block;
}

}  // namespace stratus
