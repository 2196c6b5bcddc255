#include <stratus/runtime/textured_table.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffusion.h>

#include "kept_tolerance.h"
#include "kernels/kernels.h"
#include "layer_blend.h"
#include "mu_places.h"
#include "packed_block.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace stratus {

/// One side, with the memory that its view points to.
struct TexturedMemory {
    TexturedSide view{};
    const TexturedKernel* kernel = nullptr;
    PhaseCurve phase;
    PathSheet path;
    std::vector<TexturedBlock> blocks;
    std::vector<std::vector<FunctionRow>> function;
    std::vector<std::vector<CoefficientRow>> coefficient;
    std::vector<float> block_of_cell, place_in, place_out;
    std::vector<float> diffusion_exponent, inverse_deficit, deepest_scale;
};

namespace {

/// Share of the tolerance by which the functions may miss a layer.
constexpr double basis_share = 0.2;

std::size_t size(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// Single scattering, on the lit side with that of the lower boundary.
void set_closed_forms(const TableView& table, Side which, const TexturedKernels& all,
                      TexturedMemory& side) {
    const bool over_layer = which == Side::reflection && table.has_lower_boundary() &&
                            table.lower_boundary->kind == LowerBoundary::Kind::layer;
    side.phase = over_layer ? PhaseCurve::reflected(*table.phase_function, {}, table.lower_boundary)
                            : *table.phase_curve;
    if (which == Side::reflection && table.has_lower_boundary()) {
        const auto albedo = static_cast<float>(table.lower_boundary->albedo);
        side.view.over_surface = !over_layer;
        side.view.surface_albedo = over_layer ? 0 : albedo;
        side.view.boundary_quarter_albedo = over_layer ? albedo / 4 : 0;
    }
    side.view.phase = side.phase.view();
    side.kernel = &(which == Side::reflection ? all.reflected : all.transmitted)
                       .of(side.phase.form(), table.azimuth.count > 1);
}

/// The path law, divided by w^2, over w^2.
void set_path_law(const TableView& table, TexturedMemory& side) {
    constexpr int steps = 11;
    constexpr double min_square = 1e-6;  // in place of 0, where only the ratio is left
    double albedo[steps + 1];
    for (int i = 0; i <= steps; ++i)
        albedo[i] = std::sqrt(std::max(min_square, static_cast<double>(i) / steps));
    side.path = PathSheet(*table.path_law, albedo, steps + 1, table.highest_order, 2);
    side.view.path = side.path.view();
    side.view.path_steps = steps;
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
        const double scale =
            depth.count > 0 ? reflection_scale(depth.highest, exponent, length) : 1;
        side.deepest_scale.push_back(view.divided ? static_cast<float>(scale) : 1);
    }
    view.diffusion_exponent = side.diffusion_exponent.data();
    view.inverse_deficit = side.inverse_deficit.data();
    view.deepest_scale = side.deepest_scale.data();
}

/// Adds a block, whose coefficients start at these samples of the table.
void add_block(TexturedMemory& side, PackedBlock block, int first_albedo, int first_depth) {
    side.blocks.push_back({block.function.data(), block.columns, block.coefficient.data(),
                           first_albedo, first_depth, block.depths});
    for (const int place : block.first_in) side.place_in.push_back(static_cast<float>(place));
    for (const int place : block.first_out) side.place_out.push_back(static_cast<float>(place));
    side.function.push_back(std::move(block.function));
    side.coefficient.push_back(std::move(block.coefficient));
}

/// Orders n >= 2 that a table does not hold.
void set_nothing(TexturedMemory& side, int azimuths) {
    const std::size_t albedos = side.diffusion_exponent.size();
    add_block(side,
              {std::vector<FunctionRow>(size(5 * (azimuths + 2)), FunctionRow{}),
               std::vector<CoefficientRow>(albedos * stencil_size, CoefficientRow{}),
               {},
               {},
               2,
               stencil_size},
              0, 0);
    side.view.optical_depth = {0, 0, stencil_size - 1};
    side.view.ends_at_infinity = false;
    side.block_of_cell.assign(albedos * stencil_size, 0.0f);
}

/// Divides albedos and optical depths into blocks as large as sixteen functions suffice for.
class BlockBuilder {
  public:
    BlockBuilder(const LayerShapes& samples, TexturedMemory& side)
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
    }

  private:
    /// Samples that the cubics of some cells reach.
    static SampleRange reach(const SampleRange& cells, int samples) {
        if (samples <= stencil_size) return {0, samples};
        const int first = std::clamp(cells.first - 1, 0, samples - stencil_size);
        const int last =
            std::clamp(cells.first + cells.count + 1, first + stencil_size - 1, samples - 1);
        return {first, last - first + 1};
    }

    /// Blocks of some albedos from an optical depth on, each as deep as its basis suffices for;
    /// where that is shallow, of half the albedos each.
    void cover(const SampleRange& albedo_cells, int first_depth) {
        constexpr int shallow = 3, narrow = 8;  // cells
        const double allowed = basis_share * tolerance_;
        const int end = std::max(1, samples_.table().optical_depth.count - 1);
        int guess = 9;
        for (int first = first_depth; first < end;) {
            const SampleRange depth_cells{first, std::min(guess, end - first)};
            const BlockLayers layers = layers_of(albedo_cells, depth_cells);
            const LayerBasis basis = greedy_basis(layers, allowed);
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

    BlockLayers layers_of(const SampleRange& albedo_cells, const SampleRange& depth_cells) const {
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

    void add(const BlockLayers& layers, const LayerBasis& basis, const SampleRange& albedo_cells,
             const SampleRange& depth_cells) {
        // A place on the last sample belongs to the last cell; short axes are sampled again.
        const auto end_of = [](const SampleRange& cells, int samples) {
            return samples < stencil_size ? stencil_size
                                          : std::min(cells.first + cells.count + 1, samples);
        };
        for (int a = albedo_cells.first; a < end_of(albedo_cells, samples_.table().albedo.count);
             ++a)
            for (int d = depth_cells.first;
                 d < end_of(depth_cells, samples_.table().optical_depth.count); ++d)
                side_.block_of_cell[size(a * depth_rows_ + d)] =
                    static_cast<float>(side_.blocks.size());
        add_block(side_, packed_block(samples_, layers, basis, tolerance_), layers.albedos.first,
                  layers.depths.first);
    }

    const LayerShapes& samples_;
    TexturedMemory& side_;
    double tolerance_;
    int azimuth_step_, depth_rows_;
    std::vector<std::vector<float>> values_, importance_;  // over (albedo, depth)
};

/// Where lookups find cosines and azimuths.
void set_directions(const TableView& table, TexturedMemory& side) {
    const auto cosines = [](const AxisView& axis, const std::vector<float>& places) {
        const double first = v_at(axis.highest), end = v_at(axis.lowest);
        return TexturedCosines{places.data(), static_cast<float>(first),
                               end > first ? static_cast<float>(segments / (end - first)) : 0};
    };
    TexturedSide& view = side.view;
    view.symmetric = table.is_symmetric();
    view.mu_in = cosines(table.mu_in, side.place_in);
    view.mu_out = cosines(table.mu_out, side.place_out);
    const AxisView& azimuth = table.azimuth;
    const auto coordinate = [&](double value) {
        return azimuth.scale == AxisScale::square_root ? std::sqrt(value / pi) : value / pi;
    };
    view.azimuths = azimuth.count;
    view.square_root_of_azimuth = azimuth.scale == AxisScale::square_root;
    if (azimuth.count < 2) return;
    const double first = coordinate(azimuth.lowest);
    view.azimuth_first = static_cast<float>(first);
    view.azimuth_step_inverse =
        static_cast<float>((azimuth.count - 1) / (coordinate(azimuth.highest) - first));
    // Beyond 0 and pi lie mirrored samples, beyond other ends none.
    view.azimuth_window = azimuth.lowest == 0 ? -1 : 0;
    const int last = azimuth.count - stencil_size;
    view.last_azimuth_window = static_cast<float>(pi - azimuth.highest <= 1e-9 ? last + 1 : last);
}

std::unique_ptr<const TexturedMemory> textured(const TableView& table, Side which,
                                               const TexturedKernels& all) {
    auto side = std::make_unique<TexturedMemory>();
    set_closed_forms(table, which, all, *side);
    set_axes(table, which, *side);
    if (table.path_law != nullptr) set_path_law(table, *side);
    side->view.fourth_root_of_albedo = table.albedo.scale == AxisScale::fourth_root_of_complement;
    const bool held = which == Side::reflection
                          ? table.has_reflection()
                          : table.has_transmission() && table.optical_depth.count > 0;
    if (held)
        BlockBuilder(LayerShapes(table, which), *side);
    else
        set_nothing(*side, table.azimuth.count);
    side->view.block = side->blocks.data();
    side->view.block_of_cell = side->block_of_cell.data();
    set_directions(table, *side);
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
    require(!table.has_mixture(), "TexturedTable", "mixture of the table", "no axis of it",
            table.mixture.count);
    require(!table.is_stack(), "TexturedTable", "table", "one of layers that vary", "a stack's");
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
        sum += (side->phase.sample_count() + side->path.sample_count()) * sizeof(float);
    }
    return sum;
}

}  // namespace stratus
