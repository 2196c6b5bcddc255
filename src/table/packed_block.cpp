#include <stratus/table/packed_block.h>

#include <stratus/base/size.h>

#include "layer_sums.h"

#include <cmath>
#include <limits>

namespace stratus {
namespace {

constexpr float negligible = 1e-16f;  // coefficient

/// How many functions are stored with what rounding to halves leaves of them.
std::size_t remainders(const LayerBasis& basis) {
    return std::min(basis.pivot.size(), basis.room - basis.pivot.size());
}

/// The power of two in units of which halves hold a number up to `largest`.
float choose_unit(float largest) {
    return largest > 0 ? std::exp2(std::ceil(std::log2(largest / (largest_half / 2)))) : 1;
}

/// The functions at some directions, over (direction, function): pivot(f) gives the values of the
/// layer that function f was made of.
template <class Pivot>
std::vector<float> functions_at(std::size_t directions, const LayerBasis& basis,
                                const Pivot& pivot) {
    std::vector<float> all(directions * basis.room);
    for (std::size_t f = 0; f < basis.pivot.size(); ++f) {
        const std::vector<float> layer = pivot(f);
        const std::vector<float>& shares = basis.coefficient[size(basis.pivot[f])];
        for (std::size_t c = 0; c < directions; ++c) {
            float* const here = &all[c * basis.room];
            double left = double{layer[c]};
            for (std::size_t earlier = 0; earlier < f; ++earlier)
                left -= double{shares[earlier]} * double{here[earlier]};
            here[f] = static_cast<float>(left / basis.norm[f]);
        }
    }
    return all;
}

constexpr float remainder_scale = 1 << 11;  // what rounding to halves leaves of a number

/// Divides functions by their units, which those of remainders follow.
std::vector<float> scale_to_units(const LayerBasis& basis, std::vector<float>& values) {
    std::vector<float> unit(basis.room);
    for (std::size_t c = 0; c < values.size(); ++c) {
        float& largest = unit[c % basis.room];
        largest = std::max(largest, std::abs(values[c]));
    }
    for (float& one : unit) one = choose_unit(one);
    for (std::size_t c = 0; c < values.size(); ++c) values[c] /= unit[c % basis.room];
    for (std::size_t f = 0; f < remainders(basis); ++f)
        unit[basis.pivot.size() + f] = unit[f] / remainder_scale;
    return unit;
}

/// Rounds the first functions to halves and writes what that leaves of them after the last.
void split_remainders(const LayerBasis& basis, std::vector<float>& values) {
    for (std::size_t row = 0; row < values.size(); row += basis.room)
        for (std::size_t f = 0; f < remainders(basis); ++f) {
            float& value = values[row + f];
            const float rounded = to_float(to_half(value));
            values[row + basis.pivot.size() + f] = (value - rounded) * remainder_scale;
            value = rounded;
        }
}

/// Coefficients of all layers, those of remainders after the others.
Vectors stored_coefficients(const LayerBasis& basis) {
    Vectors all = basis.coefficient;
    for (std::vector<float>& of_layer : all)
        for (std::size_t f = 0; f < remainders(basis); ++f) of_layer.push_back(of_layer[f]);
    return all;
}

/// Rows of functions over (mu, mu', azimuth) as lookups read them.
std::vector<float> laid_out(const DirectionNumbers& numbers, const std::vector<float>& at_samples,
                            std::size_t functions, const FunctionLayout& layout) {
    const std::size_t azimuths = size(numbers.azimuths()), inside = azimuths > 1 ? 1 : 0,
                      row_size = azimuths * functions,
                      pair_size = size(layout.azimuth_rows) * functions;
    std::vector<float> all(layout.rows() * functions, 0.0f);
    float* to = all.data();
    for (int i = 0; i < layout.mu_in.to; ++i)
        for (int j = 0; j < layout.columns(i); ++j, to += pair_size) {
            if (j >= layout.mu_out.to) continue;  // never read
            float* const first = to + inside * functions;
            for (int r = 0; r < layout.mu_in.from; ++r)
                for (int c = 0; c < layout.mu_out.from; ++c) {
                    const double share = layout.mu_in.weight(r, i) * layout.mu_out.weight(c, j);
                    if (share == 0) continue;
                    const float* const from = &at_samples[numbers.pair(r, c) * row_size];
                    for (std::size_t k = 0; k < row_size; ++k)
                        first[k] += static_cast<float>(share) * from[k];
                }
            if (azimuths > 1) {  // mirrored
                std::copy_n(first + functions, functions, to);
                std::copy_n(first + (azimuths - 2) * functions, functions,
                            first + azimuths * functions);
            }
        }
    return all;
}

/// A member's coefficients over (albedo, optical depth), axes no shorter than a cubic, of functions
/// in the units that they are stored in.
std::vector<float> coefficients(const BlockLayers& layers, int member, const Vectors& stored,
                                const std::vector<float>& unit) {
    const int first = member * layers.albedos.count;
    const int finite = layers.depths.count, depths = layers.depth_count();
    const Resampling albedo(layers.albedos.count), depth(std::max(finite, 1));
    const int rows = depth.to + depths - finite;
    std::vector<float> all(size(albedo.to) * size(rows) * unit.size());
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
                    const std::vector<float>& of_layer = stored[size((first + l) * depths + t)];
                    for (std::size_t f = 0; f < of_layer.size(); ++f)
                        all[size(a * rows + d) * unit.size() + f] +=
                            static_cast<float>(share * double{of_layer[f]} * double{unit[f]});
                }
    // At albedo 0 little is left: products of it underflow, which takes fifty cycles each.
    for (float& value : all)
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

PackedAxis Resampling::axis(const AxisView& view) const {
    const double finer = from > 1 ? static_cast<double>(to - 1) / (from - 1) : 0;
    PackedAxis axis{static_cast<float>(view.first), static_cast<float>(view.inverse_step * finer),
                    static_cast<float>(to - 1)};
    if (to == 1) return axis;
    // Rounding must not keep the last sample from its place: at albedo 1 a millionth of the one before would end
    // diffusion.
    const auto end = static_cast<float>(view.first + (view.count - 1) / view.inverse_step);
    for (int ulp = 0; ulp < 4 && (end - axis.first) * axis.inverse_step < axis.last; ++ulp)
        axis.inverse_step =
            std::nextafter(axis.inverse_step, std::numeric_limits<float>::infinity());
    return axis;
}

FunctionLayout::FunctionLayout(const TableView& table)
    : mu_in(Resampling::of_directions(table.mu_in.count)),
      mu_out(Resampling::of_directions(table.mu_out.count)),
      symmetric(table.is_symmetric() && table.mu_in.count > 1),
      azimuth_rows(table.azimuth.count > 1 ? table.azimuth.count + 2 : 1) {}

std::size_t FunctionLayout::rows() const {
    const std::size_t mus = size(mu_in.to);
    return (symmetric ? mus * (mus + 7) / 2 : mus * size(mu_out.to)) * size(azimuth_rows);
}

double error_of_halves(const LayerSums& sums, const BlockLayers& layers, const LayerBasis& basis) {
    std::vector<float> rounding = functions_at(sums.sketch.size(), basis, [&](std::size_t f) {
        return *layers.values[size(basis.pivot[f])];
    });
    const std::vector<float> unit = scale_to_units(basis, rounding);
    split_remainders(basis, rounding);
    for (std::size_t n = 0; n < rounding.size(); ++n)
        rounding[n] = (to_float(to_half(rounding[n])) - rounding[n]) * unit[n % basis.room];
    constexpr int searched = 40;
    const int layer_step = std::max(1, layers.count() / searched);
    const Vectors stored = stored_coefficients(basis);
    double largest = 0;
    for (int l = 0; l < layers.count(); l += layer_step) {
        const std::vector<float>& coefficient = stored[size(l)];
        const std::vector<float>& importance = *layers.importance[size(l)];
        for (std::size_t at = 0; at < importance.size(); ++at) {
            float error = 0;
            for (std::size_t f = 0; f < coefficient.size(); ++f)
                error += coefficient[f] * rounding[at * basis.room + f];
            largest = std::max(largest, double{std::abs(error * importance[at])});
        }
    }
    return largest;
}

PackedBlock packed_block(const LayerSums& sums, const BlockLayers& layers,
                         const LayerBasis& basis) {
    std::vector<float> everywhere = functions_at(sums.numbers().count(), basis, [&](std::size_t f) {
        return sums.in_full(layers.number[size(basis.pivot[f])]);
    });
    const std::vector<float> unit = scale_to_units(basis, everywhere);
    std::vector<float> rows =
        laid_out(sums.numbers(), everywhere, basis.room, FunctionLayout(sums.table().view()));
    split_remainders(basis, rows);
    PackedBlock block{std::move(rows),
                      {},
                      std::max(stencil_size, layers.depths.count) + (layers.and_infinity ? 1 : 0)};
    const Vectors stored = stored_coefficients(basis);
    for (int m = 0; m < layers.members.count; ++m)
        block.coefficient.push_back(coefficients(layers, m, stored, unit));
    return block;
}

}  // namespace stratus
