#include <stratus/runtime/textured_table.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffusion.h>

#include "kept_tolerance.h"
#include "kernels/kernels.h"
#include "kernels/textured.h"
#include "layer_blend.h"
#include "mu_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace stratus {

/// One side, with the memory that its view points to.
struct TexturedMemory {
    TexturedSide view{};
    const TexturedKernel* kernel = nullptr;
    PhaseCurve phase;
    std::vector<TexturedBlock> blocks;
    std::vector<std::vector<FunctionRow>> function;
    std::vector<std::vector<CoefficientRow>> coefficient;
    std::vector<float> block_of_cell, place;
    std::vector<float> diffusion_exponent, inverse_deficit, deepest_scale;
};

namespace {

// Shares of the tolerance: by which the functions may miss a layer, and straight lines between
// cosines all but the worst hundredth of the directions.
constexpr double basis_share = 0.2, line_share = 0.25, rare = 0.01;

constexpr float faintest = 1e-8f;  // below which errors count less

std::size_t size(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// Samples of an axis of coefficients, never fewer than a cubic needs: short axes are sampled again
/// on the polynomial through all they have.
struct Resampling {
    int from, to;

    explicit Resampling(int count) : from(count), to(std::max(stencil_size, count)) {}

    double weight(int old_sample, int new_sample) const {
        if (from == to) return old_sample == new_sample ? 1 : 0;
        const double at = static_cast<double>(new_sample) * (from - 1) / (to - 1);
        double product = 1;  // Lagrange
        for (int other = 0; other < from; ++other)
            if (other != old_sample) product *= (at - other) / (old_sample - other);
        return product;
    }

    TexturedAxis axis(const AxisView& view) const {
        const double finer = from > 1 ? static_cast<double>(to - 1) / (from - 1) : 0;
        return {static_cast<float>(view.first), static_cast<float>(view.inverse_step * finer),
                static_cast<float>(to - 1)};
    }
};

/// The samples of one side, as lookups interpolate them.
class Shapes {
  public:
    Shapes(const TableView& table, Side which)
        : table_(table),
          samples_(which == Side::reflection ? table.reflection_multiple
                                             : table.transmission_multiple),
          weight_(which == Side::reflection ? table.reflection_weight : table.transmission_weight),
          side_(which) {
        for (int i = 0; i < table.mu_in.count; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k < table.azimuth.count; ++k) {
                    const Geometry at = geometry(i, j, k);
                    phase_.push_back((*table.phase_function)(
                        which == Side::reflection ? cos_scattering_angle_reflected(at)
                                                  : cos_scattering_angle_transmitted(at)));
                }
    }

    const TableView& table() const { return table_; }
    int azimuths() const { return table_.azimuth.count; }
    int pairs() const { return table_.mu_in.count * (table_.mu_in.count + 1) / 2; }

    static int pair(int i, int j) { return i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

    /// One layer over (pair of cosines, every `step`-th azimuth).
    std::vector<float> layer(int albedo, int depth, int step) const {
        // A sample too small to be scaled back up is spoken for as in lookup.h.
        const std::ptrdiff_t depths = table_.optical_depth.size();
        int speaker = albedo;
        while (speaker < table_.albedo.count && weight_[speaker * depths + depth] == 0) ++speaker;
        if (speaker == table_.albedo.count)
            return depth > 0
                       ? layer(albedo, depth - 1, step)
                       : std::vector<float>(size(pairs()) * size((azimuths() - 1) / step + 1));
        const std::ptrdiff_t cosines = table_.mu_in.count, columns = azimuths();
        const std::ptrdiff_t at = speaker * depths + depth;
        const float* const from = samples_ + at * cosines * cosines * columns;
        const float* const in = table_.mu_in_weight + depth * cosines;
        const float* const out = table_.mu_out_weight + depth * cosines;
        std::vector<float> values;
        values.reserve(size(pairs()) * size((columns - 1) / step + 1));
        for (std::ptrdiff_t i = 0; i < cosines; ++i)
            for (std::ptrdiff_t j = 0; j <= i; ++j) {
                const float share = 0.5f * weight_[at] * in[i] * out[j];
                const float* const there = from + (i * cosines + j) * columns;
                const float* const back = from + (j * cosines + i) * columns;
                for (std::ptrdiff_t k = 0; k < columns; k += step)
                    values.push_back(share * (there[k] + back[k]));
            }
        return values;
    }

    /// What an error of a layer's values is to be multiplied by to be relative to R or T; over the
    /// same directions.
    std::vector<float> importance(int albedo, int depth, int step) const {
        const std::ptrdiff_t at = std::ptrdiff_t{albedo} * table_.optical_depth.size() + depth;
        std::vector<float> found = layer(albedo, depth, step);
        const double w = table_.albedo.value(albedo), tau = depth_of(depth);
        if (weight_[at] == 0 || w == 0) {  // fainter than float can tell
            std::fill(found.begin(), found.end(), 0.0f);
            return found;
        }
        const double exponent = table_.diffusion_exponent[albedo];
        const double scale = side_ == Side::reflection
                                 ? reflection_scale(tau, exponent, table_.extrapolation_length)
                                 : transmission_scale(tau, exponent, table_.extrapolation_length);
        std::vector<float> share;
        for (int i = 0; i < table_.mu_in.count; ++i)
            share.push_back(static_cast<float>(intercepted_share(tau, table_.mu_in.value(i))));
        const auto factor = [&](int i, int j) {  // by which samples were divided
            if (table_.has_lower_boundary()) return 1.0f;
            return static_cast<float>(w * scale) * share[size(i)] * share[size(j)];
        };
        float largest = 0;
        std::size_t n = 0;
        for (int i = 0; i < table_.mu_in.count; ++i)
            for (int j = 0; j <= i; ++j) {
                const double mu = table_.mu_in.value(i), other = table_.mu_in.value(j);
                const double order = side_ == Side::reflection
                                         ? single_reflection(1, w, tau, mu, other)
                                         : single_transmission(1, w, tau, mu, other);
                for (int k = 0; k < azimuths(); k += step, ++n) {
                    double single = order * phase_[size(pair(i, j) * azimuths() + k)];
                    if (table_.has_lower_boundary())
                        single += single_reflection_of_boundary(*table_.lower_boundary, tau,
                                                                geometry(i, j, k));
                    found[n] = factor(i, j) * found[n] + static_cast<float>(single);
                    if (other >= 0.1) largest = std::max(largest, found[n]);
                }
            }
        const float least = std::max(static_cast<float>(darkest_share) * largest, faintest);
        n = 0;
        for (int i = 0; i < table_.mu_in.count; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k < azimuths(); k += step, ++n)
                    found[n] = factor(i, j) / std::max(found[n], least);
        return found;
    }

    /// Infinity for the last of an axis that ends there.
    double depth_of(int depth) const {
        return depth < table_.optical_depth.count ? table_.optical_depth.value(depth) : infinity;
    }

  private:
    Geometry geometry(int i, int j, int k) const {
        return {table_.mu_in.value(i), table_.mu_in.value(j), table_.azimuth.value(k)};
    }

    const TableView& table_;
    const float* samples_;
    const float* weight_;
    Side side_;
    std::vector<double> phase_;  // over (pair, azimuth)
};

/// Neighbouring samples of one axis of the layers.
struct Rows {
    int first, count;

    int last() const { return first + count - 1; }
};

/// The layers of a block, thinned out along azimuth.
struct BlockLayers {
    Rows albedos, depths;                                       // depths: finite ones
    bool and_infinity;                                          // after the depths
    std::vector<const std::vector<float>*> values, importance;  // over (albedo, depth)
    int azimuths;

    int count() const { return static_cast<int>(values.size()); }
    int depth_count() const { return depths.count + (and_infinity ? 1 : 0); }
};

/// Functions that are orthogonal over the block's directions, as sums over layers.
struct Basis {
    std::vector<int> pivot;                       // layers
    std::vector<double> norm;                     // of what was left of a pivot
    std::vector<std::vector<float>> coefficient;  // over layers
    double error = 0;                             // largest of any layer, relative to R or T
};

/// Takes the layer that is met worst into the basis until all are met. Of many albedos a few speak
/// for all.
Basis greedy(const BlockLayers& layers, double allowed) {
    constexpr int speaking_albedos = 12;
    const int albedo_step = (layers.albedos.count - 1) / speaking_albedos + 1;
    const std::size_t columns = layers.values[0]->size();
    std::vector<int> speakers, others;
    for (int l = 0; l < layers.count(); ++l) {
        const int from_last = layers.albedos.count - 1 - l / layers.depth_count();
        (from_last % albedo_step == 0 ? speakers : others).push_back(l);
    }
    std::vector<float> weight(columns);
    std::vector<std::vector<float>> rest(size(layers.count()));
    for (const int l : speakers) {
        rest[size(l)] = *layers.values[size(l)];
        for (std::size_t k = 0; k < columns; ++k) {
            const float of_layer = (*layers.importance[size(l)])[k];
            weight[k] += of_layer * of_layer / static_cast<float>(layers.count());
        }
    }
    const auto error_of = [&](int l) {
        const float* const left = rest[size(l)].data();
        const float* const importance = layers.importance[size(l)]->data();
        float most = 0;
        for (std::size_t k = 0; k < columns; ++k)
            most = std::max(most, std::abs(left[k] * importance[k]));
        return double{most};
    };
    Basis basis;
    basis.coefficient.resize(size(layers.count()));
    std::vector<double> error(size(layers.count()));
    std::vector<std::vector<float>> function, weighted;
    const auto take_away = [&](int l, std::size_t f) {
        float* const left = rest[size(l)].data();
        float partial[functions] = {};  // side by side, to be fast
        std::size_t k = 0;
        for (; k + functions <= columns; k += functions)
            for (std::size_t s = 0; s < functions; ++s)
                partial[s] += left[k + s] * weighted[f][k + s];
        float share = 0;
        for (; k < columns; ++k) share += left[k] * weighted[f][k];
        for (const float part : partial) share += part;
        basis.coefficient[size(l)].push_back(share);
        for (k = 0; k < columns; ++k) left[k] -= share * function[f][k];
    };
    for (const int l : speakers) error[size(l)] = error_of(l);
    for (;;) {
        const auto worst = std::max_element(error.begin(), error.end());
        basis.error = *worst;
        if (basis.error <= allowed || basis.pivot.size() == size(functions)) break;
        const auto pivot = size(worst - error.begin());
        const std::vector<float>& left = rest[pivot];
        double square = 0;
        for (std::size_t k = 0; k < columns; ++k)
            square += double{weight[k]} * double{left[k]} * double{left[k]};
        const double norm = std::sqrt(square);
        function.emplace_back(columns);
        weighted.emplace_back(columns);
        for (std::size_t k = 0; k < columns; ++k) {
            function.back()[k] = static_cast<float>(double{left[k]} / norm);
            weighted.back()[k] = weight[k] * function.back()[k];
        }
        basis.pivot.push_back(static_cast<int>(pivot));
        basis.norm.push_back(norm);
        for (const int l : speakers) {
            take_away(l, function.size() - 1);
            error[size(l)] = error_of(l);
        }
    }
    for (const int l : others) {
        rest[size(l)] = *layers.values[size(l)];
        for (std::size_t f = 0; f < function.size(); ++f) take_away(l, f);
        rest[size(l)].clear();
    }
    return basis;
}

/// Where the cosines of a block lie, finer where straight lines need it.
struct Places {
    double v_first, v_step;   // of the segments
    int first[segments + 1];  // place at which a segment begins

    int last() const { return first[segments]; }

    double mu(int place) const {
        const int at = std::min(place, last());
        int segment = 0;
        while (segment + 1 < segments && first[segment + 1] <= at) ++segment;
        return mu_at(v_first + v_step * (segment + static_cast<double>(at - first[segment]) /
                                                       (first[segment + 1] - first[segment])));
    }
};

Places places_for(const AxisView& axis, const BlockLayers& layers, double allowed) {
    constexpr int probed = 16;  // intervals a segment
    constexpr int most = 64;    // steps a segment
    Places places{v_at(axis.highest), 0, {}};
    places.v_step = (v_at(axis.lowest) - places.v_first) / segments;
    std::vector<Stencil> stencils;
    for (int i = 0; i <= segments * probed; ++i)
        stencils.push_back(axis.stencil(mu_at(places.v_first + places.v_step * i / probed)));
    std::vector<float> errors[segments];
    const int used = std::min(stencil_size, axis.count), azimuths = layers.azimuths;
    const int layer_step = std::max(1, layers.count() / 40),
              azimuth_step = std::max(1, azimuths / 4);
    std::vector<float> along(stencils.size()), importance(stencils.size());
    for (int l = 0; l < layers.count(); l += layer_step)
        for (int j = 0; j < axis.count; ++j)
            for (int k = 0; k < azimuths; k += azimuth_step) {
                for (std::size_t i = 0; i < stencils.size(); ++i) {
                    along[i] = importance[i] = 0;
                    for (int s = 0; s < used; ++s) {
                        const float share = stencils[i].weight[s];
                        const auto at = size(Shapes::pair(stencils[i].first + s, j) * azimuths + k);
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
        places.first[segment + 1] =
            places.first[segment] + static_cast<int>(std::clamp(steps, 1.0, double{most}));
    }
    return places;
}

/// Functions as TexturedBlock has them, each in a unit of its own.
struct Functions {
    std::vector<FunctionRow> row;
    std::array<float, functions> unit;
};

/// The power of two in units of which halves hold a number up to `largest`.
float unit_of(float largest) {
    return largest > 0 ? std::exp2(std::ceil(std::log2(largest / (largest_half / 2)))) : 1;
}

/// The functions over (mu, mu', azimuth).
Functions refined(const Shapes& samples, const BlockLayers& layers, const Basis& basis,
                  const Places& places) {
    const AxisView& mu = samples.table().mu_in;
    const int cosines = mu.count, azimuths = samples.azimuths(), used = std::min(stencil_size, cosines);
    const std::size_t row_size = size(azimuths * functions);
    // At the table's own directions, all azimuths.
    std::vector<float> at_samples(size(samples.pairs()) * row_size);
    for (std::size_t f = 0; f < basis.pivot.size(); ++f) {
        const int pivot = basis.pivot[f], depths = layers.depth_count();
        const std::vector<float> whole = samples.layer(layers.albedos.first + pivot / depths,
                                                       layers.depths.first + pivot % depths, 1);
        for (std::size_t c = 0; c < whole.size(); ++c) {
            float* const here = &at_samples[c * functions];
            double left = double{whole[c]};
            for (std::size_t earlier = 0; earlier < f; ++earlier)
                left -= double{basis.coefficient[size(pivot)][earlier]} * double{here[earlier]};
            here[f] = static_cast<float>(left / basis.norm[f]);
        }
    }
    Functions all;
    all.unit.fill(0);
    for (std::size_t c = 0; c < at_samples.size(); ++c) {
        float& largest = all.unit[c % functions];
        largest = std::max(largest, std::abs(at_samples[c]));
    }
    for (float& unit : all.unit) unit = unit_of(unit);
    for (std::size_t c = 0; c < at_samples.size(); ++c) at_samples[c] /= all.unit[c % functions];

    const int count = places.last() + 2;  // one beyond the last
    std::vector<Stencil> stencils;
    for (int i = 0; i <= count; ++i) stencils.push_back(mu.stencil(places.mu(i)));
    const auto add = [&](const float* from, float share, float* to) {
        for (std::size_t k = 0; k < row_size; ++k) to[k] += share * from[k];
    };
    // Finer in mu', then in mu.
    std::vector<float> finer(size(cosines * (count + 1)) * row_size);
    for (int i = 0; i < cosines; ++i)
        for (int j = 0; j <= count; ++j)
            for (int s = 0; s < used; ++s)
                add(&at_samples[size(Shapes::pair(i, stencils[size(j)].first + s)) * row_size],
                    stencils[size(j)].weight[s], &finer[size(i * (count + 1) + j) * row_size]);
    const int rows = azimuths > 1 ? azimuths + 2 : 1, inside = azimuths > 1 ? 1 : 0;
    all.row.resize(size(count) * size(count + 3) / 2 * size(rows), FunctionRow{});
    FunctionRow* to = all.row.data();
    std::vector<float> row(row_size);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j <= i + 1; ++j, to += rows) {
            std::fill(row.begin(), row.end(), 0.0f);
            for (int s = 0; s < used; ++s)
                add(&finer[size((stencils[size(i)].first + s) * (count + 1) + j) * row_size],
                    stencils[size(i)].weight[s], row.data());
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
std::vector<CoefficientRow> coefficients(const BlockLayers& layers, const Basis& basis,
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
    // What is left of albedo 0 would make lookups slow: numbers at the end of float's range.
    for (CoefficientRow& row : all)
        for (float& value : row.value)
            if (std::abs(value) < faintest * faintest) value = 0;
    return all;
}

/// Single scattering, and of what lies beneath on the lit side.
void set_closed_forms(const TableView& table, Side which, const TexturedKernels& all,
                      TexturedMemory& side) {
    const bool composed = which == Side::reflection && table.has_lower_boundary() &&
                          table.lower_boundary->kind == LowerBoundary::Kind::layer;
    side.phase = composed ? PhaseCurve::composed(*table.phase_function, {}, table.lower_boundary)
                          : *table.phase_curve;
    if (which == Side::reflection && table.has_lower_boundary()) {
        const auto albedo = static_cast<float>(table.lower_boundary->albedo);
        side.view.over_surface = !composed;
        side.view.surface_albedo = composed ? 0 : albedo;
        side.view.boundary_quarter_albedo = composed ? albedo / 4 : 0;
    }
    side.view.phase = side.phase.view();
    side.kernel = &(which == Side::reflection ? all.reflected : all.transmitted)
                       .of(side.phase.form(), table.azimuth.count > 1);
}

/// The axes of the coefficients and the scales along them.
void set_axes(const TableView& table, Side which, TexturedMemory& side) {
    TexturedSide& view = side.view;
    const AxisView &albedo = table.albedo, &depth = table.optical_depth;
    const Resampling albedos(albedo.count);
    view.albedo = albedos.axis(albedo);
    view.optical_depth = Resampling(std::max(1, depth.count)).axis(depth);
    view.min_albedo = static_cast<float>(albedo.lowest);
    view.max_albedo = static_cast<float>(albedo.highest);
    view.min_depth = static_cast<float>(depth.lowest);
    view.ends_at_infinity = which == Side::reflection && depth.ends_at_infinity;
    view.max_finite_depth = depth.count > 0 ? static_cast<float>(depth.highest) : -1;
    view.max_depth = depth.ends_at_infinity ? 1e30f : view.max_finite_depth;
    view.divided = !table.has_lower_boundary();
    view.extrapolation_length = static_cast<float>(table.extrapolation_length);
    for (int a = 0; a < albedos.to; ++a) {
        double exponent = 0;
        for (int l = 0; l < albedos.from; ++l)
            exponent += albedos.weight(l, a) * table.diffusion_exponent[l];
        exponent = std::max(0.0, exponent);
        const double length = table.extrapolation_length;
        const double deficit =
            depth.count > 0 ? reflection_deficit(depth.highest, exponent, length) : 0;
        side.diffusion_exponent.push_back(static_cast<float>(exponent));
        side.inverse_deficit.push_back(deficit < min_deficit ? 0 : static_cast<float>(1 / deficit));
        side.deepest_scale.push_back(view.divided ? static_cast<float>(1 / (1 + deficit)) : 1);
    }
    view.diffusion_exponent = side.diffusion_exponent.data();
    view.inverse_deficit = side.inverse_deficit.data();
    view.deepest_scale = side.deepest_scale.data();
}

/// Adds a block and its memory.
void add_block(TexturedMemory& side, TexturedBlock block, std::vector<FunctionRow> function,
               std::vector<CoefficientRow> coefficient, const int (&first_place)[segments + 1]) {
    block.function = function.data();
    block.coefficient = coefficient.data();
    side.blocks.push_back(block);
    side.function.push_back(std::move(function));
    side.coefficient.push_back(std::move(coefficient));
    for (const int place : first_place) side.place.push_back(static_cast<float>(place));
}

/// Orders n >= 2 that a table does not hold.
void set_nothing(TexturedMemory& side, int azimuths) {
    const std::size_t albedos = side.diffusion_exponent.size();
    add_block(side, {nullptr, nullptr, 0, 0, stencil_size},
              std::vector<FunctionRow>(size(5 * (azimuths + 2)), FunctionRow{}),
              std::vector<CoefficientRow>(albedos * stencil_size, CoefficientRow{}), {});
    side.view.optical_depth = {0, 0, stencil_size - 1};
    side.view.ends_at_infinity = false;
    side.block_of_cell.assign(albedos * stencil_size, 0.0f);
}

/// Cuts albedos and optical depths into blocks as large as sixteen functions reach.
class Blocks {
  public:
    Blocks(const Shapes& samples, TexturedMemory& side)
        : samples_(samples),
          side_(side),
          tolerance_(kept_tolerance(samples.table())),
          azimuth_step_(std::max(1, (samples.azimuths() - 1) / 8)) {
        const AxisView &albedo = samples.table().albedo, &depth = samples.table().optical_depth;
        for (int a = 0; a < albedo.count; ++a)
            for (int d = 0; d < depth.size(); ++d) {
                values_.push_back(samples.layer(a, d, azimuth_step_));
                importance_.push_back(samples.importance(a, d, azimuth_step_));
            }
        depth_rows_ = std::max(stencil_size, depth.count);
        side.block_of_cell.assign(size(std::max(stencil_size, albedo.count) * depth_rows_), 0.0f);
        cover({0, std::max(1, albedo.count - 1)}, 0);
        const double first = v_at(samples.table().mu_in.highest);
        const double end = v_at(samples.table().mu_in.lowest);
        side.view.v_first = static_cast<float>(first);
        side.view.segments_per_v = end > first ? static_cast<float>(segments / (end - first)) : 0;
    }

  private:
    /// Samples that the cubics of some cells reach.
    static Rows reach(const Rows& cells, int samples) {
        if (samples <= stencil_size) return {0, samples};
        const int first = std::clamp(cells.first - 1, 0, samples - stencil_size);
        const int last = std::clamp(cells.first + cells.count + 1, first + stencil_size - 1, samples - 1);
        return {first, last - first + 1};
    }

    /// Blocks of some albedos from an optical depth on, each as deep as its basis can hold; once
    /// that is not deep, of half the albedos each.
    void cover(const Rows& albedo_cells, int first_depth) {
        constexpr int shallow = 3, narrow = 8;  // cells
        const double allowed = basis_share * tolerance_;
        const int end = std::max(1, samples_.table().optical_depth.count - 1);
        int guess = 9;
        for (int first = first_depth; first < end;) {
            const Rows depth_cells{first, std::min(guess, end - first)};
            const BlockLayers layers = layers_of(albedo_cells, depth_cells);
            const Basis basis = greedy(layers, allowed);
            const bool met = basis.error <= allowed;
            if (!met && depth_cells.count > shallow) {
                guess = std::max(shallow, depth_cells.count * (basis.error > 8 * allowed ? 1 : 2) /
                                              (basis.error > 8 * allowed ? 2 : 3));
            } else if (!met && albedo_cells.count > narrow) {
                const int half = albedo_cells.count / 2;
                cover({albedo_cells.first, half}, first);
                cover({albedo_cells.first + half, albedo_cells.count - half}, first);
                return;
            } else {
                add(layers, basis, albedo_cells, depth_cells);
                first += depth_cells.count;
                guess = depth_cells.count + 2;
            }
        }
    }

    BlockLayers layers_of(const Rows& albedo_cells, const Rows& depth_cells) const {
        const AxisView& depth = samples_.table().optical_depth;
        const bool deepest = depth_cells.first + depth_cells.count >= depth.count - 1;
        BlockLayers layers{reach(albedo_cells, samples_.table().albedo.count),
                           reach(depth_cells, depth.count),
                           deepest && side_.view.ends_at_infinity,
                           {},
                           {},
                           (samples_.azimuths() - 1) / azimuth_step_ + 1};
        for (int a = layers.albedos.first; a <= layers.albedos.last(); ++a)
            for (int d = 0; d < layers.depth_count(); ++d) {
                const std::size_t at = size(a * depth.size() + layers.depths.first + d);
                layers.values.push_back(&values_[at]);
                layers.importance.push_back(&importance_[at]);
            }
        return layers;
    }

    void add(const BlockLayers& layers, const Basis& basis, const Rows& albedo_cells,
             const Rows& depth_cells) {
        // A place on the last sample belongs to the last cell; short axes are sampled again.
        const auto end_of = [](const Rows& cells, int samples) {
            return samples < stencil_size ? stencil_size : std::min(cells.first + cells.count + 1, samples);
        };
        for (int a = albedo_cells.first; a < end_of(albedo_cells, samples_.table().albedo.count);
             ++a)
            for (int d = depth_cells.first;
                 d < end_of(depth_cells, samples_.table().optical_depth.count); ++d)
                side_.block_of_cell[size(a * depth_rows_ + d)] =
                    static_cast<float>(side_.blocks.size());
        const Places places = places_for(samples_.table().mu_in, layers, line_share * tolerance_);
        const int rows = std::max(stencil_size, layers.depths.count) + (layers.and_infinity ? 1 : 0);
        Functions found = refined(samples_, layers, basis, places);
        std::vector<CoefficientRow> rows_of_layers = coefficients(layers, basis, found.unit);
        add_block(side_, {nullptr, nullptr, layers.albedos.first, layers.depths.first, rows},
                  std::move(found.row), std::move(rows_of_layers), places.first);
    }

    const Shapes& samples_;
    TexturedMemory& side_;
    double tolerance_;
    int azimuth_step_, depth_rows_;
    std::vector<std::vector<float>> values_, importance_;  // over (albedo, depth)
};

std::unique_ptr<const TexturedMemory> textured(const TableView& table, Side which,
                                               const TexturedKernels& all) {
    auto side = std::make_unique<TexturedMemory>();
    set_closed_forms(table, which, all, *side);
    set_axes(table, which, *side);
    side->view.azimuths = table.azimuth.count;
    const bool held = which == Side::reflection
                          ? table.has_reflection()
                          : table.has_transmission() && table.optical_depth.count > 0;
    if (held)
        Blocks(Shapes(table, which), *side);
    else
        set_nothing(*side, table.azimuth.count);
    side->view.block = side->blocks.data();
    side->view.block_of_cell = side->block_of_cell.data();
    side->view.place = side->place.data();
    return side;
}

Scattered at_one(const TexturedMemory& side, double albedo, double optical_depth,
                 const Geometry& geometry) noexcept {
    double azimuth = geometry.azimuth;
    if (!(azimuth >= 0 && azimuth <= pi)) azimuth = std::abs(std::remainder(azimuth, 2 * pi));
    float single_multiple[2];
    side.kernel->one(side.view,
                     {static_cast<float>(albedo), static_cast<float>(1 - albedo),
                      static_cast<float>(optical_depth), static_cast<float>(geometry.mu_in),
                      static_cast<float>(geometry.mu_out), static_cast<float>(azimuth)},
                     single_multiple);
    return {double{single_multiple[0]}, double{single_multiple[1]}};
}

void at_many(const TexturedMemory& side, const TexturedPoints& points, float* total) noexcept {
    const std::size_t rest = points.count % points_at_once, whole = points.count - rest;
    side.kernel->many(side.view, points, whole, total);
    if (rest == 0) return;
    alignas(64) float copy[5][points_at_once], found[points_at_once];
    const float* const from[5] = {points.albedo, points.optical_depth, points.mu_in, points.mu_out,
                                  points.azimuth};
    for (int q = 0; q < 5; ++q) {
        std::fill(copy[q], copy[q] + points_at_once, 0.5f);
        std::copy(from[q] + whole, from[q] + points.count, copy[q]);
    }
    side.kernel->many(side.view, {copy[0], copy[1], copy[2], copy[3], copy[4], points_at_once},
                      points_at_once, found);
    std::copy(found, found + rest, total + whole);
}

}  // namespace

TexturedTable::TexturedTable(const TableView& table) {
    const AxisView &in = table.mu_in, &out = table.mu_out;
    require(in.count == out.count && in.lowest == out.lowest && in.highest == out.highest,
            "TexturedTable", "samples along mu_out", "those along mu_in", out.count);
    require(!table.has_mixture(), "TexturedTable", "mixture of the table", "no axis of it",
            table.mixture.count);
    const TexturedKernels& all = *kernels().textured;
    reflection_ = textured(table, Side::reflection, all);
    if (!table.has_lower_boundary()) transmission_ = textured(table, Side::transmission, all);
}

TexturedTable::TexturedTable(TexturedTable&&) noexcept = default;
TexturedTable& TexturedTable::operator=(TexturedTable&&) noexcept = default;
TexturedTable::~TexturedTable() = default;

Scattered TexturedTable::reflection(double albedo, double optical_depth,
                                    const Geometry& geometry) const noexcept {
    return at_one(*reflection_, albedo, optical_depth, geometry);
}

Scattered TexturedTable::transmission(double albedo, double optical_depth,
                                      const Geometry& geometry) const noexcept {
    if (transmission_ == nullptr) return {};
    return at_one(*transmission_, albedo, optical_depth, geometry);
}

void TexturedTable::reflection(const TexturedPoints& points, float* total) const noexcept {
    at_many(*reflection_, points, total);
}

void TexturedTable::transmission(const TexturedPoints& points, float* total) const noexcept {
    if (transmission_ == nullptr)
        std::fill(total, total + points.count, 0.0f);
    else
        at_many(*transmission_, points, total);
}

std::size_t TexturedTable::bytes() const noexcept {
    std::size_t sum = 0;
    for (const TexturedMemory* side : {reflection_.get(), transmission_.get()}) {
        if (side == nullptr) continue;
        for (const auto& rows : side->function) sum += rows.size() * sizeof(FunctionRow);
        for (const auto& rows : side->coefficient) sum += rows.size() * sizeof(CoefficientRow);
        sum += side->phase.sample_count() * sizeof(float);
    }
    return sum;
}

}  // namespace stratus
