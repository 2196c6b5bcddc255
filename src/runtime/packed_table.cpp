#include <stratus/runtime/packed_table.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffusion.h>
#include <stratus/runtime/number_text.h>

#include "kernels/kernels.h"
#include "layer_blend.h"
#include "mapped_file.h"
#include "packed_block.h"
#include "packed_names.h"
#include "tensor_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr const char* caller = "packed table";
constexpr std::size_t alignment = 64;  // of rows, and so of the file

std::size_t size(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// One side, with the memory that its view points to.
struct SideMemory {
    PackedSide view{};
    const PackedKernel* kernel = nullptr;
    PhaseCurve phase;
    std::vector<LayerBlock> blocks;
    std::vector<float> block_of_cell;
    std::vector<float> diffusion_exponent, inverse_deficit, deepest_scale;
    std::vector<CoefficientRow> no_coefficients;  // of a side that is not held
    std::vector<FunctionRowOf<float>> no_functions;
};

/// The sides at one sample of the mixture.
struct MixtureSample {
    double extrapolation_length;
    SideMemory side[2];
};

// ---- header

double number(const TensorFile& file, const char* name) {
    const std::string& text = file.text(name);
    double value = 0;
    require(!text.empty() && read_number(text, value) == text.size(), caller, name, "a number",
            '"' + text.substr(0, 40) + '"');
    return value;
}

int whole_number(const TensorFile& file, const char* name, int most) {
    const double value = number(file, name);
    require(value >= 0 && value <= most && value == std::floor(value), caller, name,
            "a whole number up to " + std::to_string(most), value);
    return static_cast<int>(value);
}

template <class Number>
std::vector<Number> copied(const TensorOf<Number>& numbers) {
    return std::vector<Number>(numbers.begin(), numbers.end());
}

std::string shape_text(const std::vector<std::size_t>& shape) {
    std::vector<std::string> words;
    for (const std::size_t extent : shape) words.push_back(std::to_string(extent));
    return "[" + joined(words) + "]";
}

template <class Number>
void require_shape(const TensorOf<Number>& numbers, const std::string& name,
                   const std::vector<std::size_t>& shape) {
    require(numbers.shape == shape, caller, "shape of " + name, shape_text(shape),
            shape_text(numbers.shape));
}

void check_format(const TensorFile& file) {
    const std::string& format = file.text(format_name);
    require(format == packed_format, caller, format_name, packed_format, format.substr(0, 40));
    const std::string& version = file.text(format_version_name);
    require(version == packed_format_version, caller, format_version_name, packed_format_version,
            version.substr(0, 40));
}

AxisScale scale_of(const TensorFile& file, const std::string& name) {
    const std::string& text = file.text(name + scale_suffix);
    for (const AxisScale scale : {AxisScale::linear, AxisScale::arcsine_of_fourth_root,
                                  AxisScale::logarithmic, AxisScale::square_root_of_complement,
                                  AxisScale::square_root, AxisScale::fourth_root_of_complement})
        if (text == axis_scale_name(scale)) return scale;
    require(false, caller, name + scale_suffix, "the name of a scale", text.substr(0, 40));
    return {};
}

/// Refuses a text that names another file.
PhaseFunction complete_phase_function(const std::string& text, const char* name) {
    require(text.find("file") == std::string::npos, caller, name, "complete",
            "one that names a file");
    return parse_phase_function(text);
}

PhaseFunction phase_function(const TensorFile& file, const char* name) {
    return complete_phase_function(file.text(name), name);
}

LowerBoundary lower_boundary(const TensorFile& file) {
    if (file.strings().count(below_name) == 0) return {};
    const std::string& kind = file.text(below_name);
    const double albedo = number(file, below_albedo_name);
    if (kind == surface_name) return LowerBoundary::surface(albedo);
    require(kind == layer_name, caller, below_name, std::string(surface_name) + " or " + layer_name,
            kind.substr(0, 40));
    return LowerBoundary::layer(phase_function(file, below_phase_function_name), albedo);
}

std::vector<StackLayer> layers_of(const TensorFile& file) {
    std::vector<StackLayer> layers;
    if (!file.has(layers_name)) return layers;
    const TensorOf<double> numbers = file.numbers<double>(layers_name, 2, Infinity::allowed);
    require_shape(numbers, layers_name, {numbers.shape[0], 2});
    std::istringstream lines(file.text(layer_phase_functions_name));
    std::string line;
    while (layers.size() < numbers.shape[0] && std::getline(lines, line)) {
        const double* const of = numbers.data + 2 * layers.size();
        layers.push_back({complete_phase_function(line, layer_phase_functions_name), of[0], of[1]});
    }
    require(layers.size() == numbers.shape[0] && !std::getline(lines, line), caller,
            layer_phase_functions_name, std::to_string(numbers.shape[0]) + " lines",
            "another number");
    return layers;
}

PhaseCurve curve_of(const TensorFile& file, const std::string& name, std::size_t width,
                    const PhaseFunction& phase_function) {
    if (!file.has(name)) {
        PhaseCurve curve(phase_function);
        require(width == 1 && curve.sample_count() == 0, caller, name, "given", "none");
        return curve;
    }
    const TensorOf<float> samples = file.numbers<float>(name, 2);
    require(samples.shape[0] >= 2 && samples.shape[0] <= (1 << 20) && samples.shape[1] == width,
            caller, "shape of " + name, "[2 to 1048576, " + std::to_string(width) + "]",
            shape_text(samples.shape));
    return PhaseCurve::of_samples(copied(samples), static_cast<int>(width));
}

Table header_of(const TensorFile& file) {
    check_format(file);
    Table table;
    table.phase_function = phase_function(file, phase_function_name);
    table.lower_boundary = lower_boundary(file);
    table.layers = layers_of(file);
    if (table.is_stack()) table.spherical_albedo_below = number(file, spherical_albedo_below_name);
    for (const PackedAxisField& field : packed_axis_fields()) {
        if (field.axis == &Table::mixture && !file.has(field.name)) continue;
        const bool may_be_infinite = field.axis == &Table::optical_depth;
        table.*field.axis = {
            scale_of(file, field.name),
            copied(file.numbers<double>(field.name, 1,
                                        may_be_infinite ? Infinity::allowed : Infinity::refused))};
    }
    if (table.has_mixture()) {
        table.second_phase_function = phase_function(file, second_phase_function_name);
        table.second_extrapolation_length = number(file, second_extrapolation_length_name);
    }
    table.extrapolation_length = number(file, extrapolation_length_name);
    table.tolerance = number(file, tolerance_name);
    table.measured_error = number(file, measured_error_name);
    table.highest_order = whole_number(file, highest_order_name, 1 << 20);
    for (const PackedFluxField& field : packed_flux_fields())
        if (file.has(field.name))
            table.*field.flux = copied(file.numbers<float>(field.name, field.over_mu ? 4 : 3));
    table.diffusion_exponent = copied(file.numbers<double>(diffusion_exponent_name, 2));
    for (const auto& [name, text] : file.strings())
        if (!is_reserved(name)) table.attributes[name] = text;
    prepare_header(table);
    if (!table.has_mixture())
        table.phase_curve = curve_of(file, phase_name, 1, table.phase_function);
    if (file.has(path_orders_name)) {
        const TensorOf<float> orders = file.numbers<float>(path_orders_name, 2);
        require(orders.shape[1] < 1 << 16, caller, "orders of path_orders", "below 65536",
                orders.shape[1]);
        table.path_law = std::make_shared<const PathOrders>(
            static_cast<float>(number(file, path_offset_name)), number(file, path_deepest_name),
            static_cast<int>(orders.shape[1]) + 2, copied(orders));
    }
    return table;
}

// ---- sides

/// Single scattering, on the lit side with that of the lower boundary.
void set_closed_forms(const TensorFile& file, const std::string& prefix, const Table& table,
                      const PhaseFunction& phase_function, Side which, SideMemory& side) {
    const LowerBoundary& below = table.lower_boundary;
    const bool lit = which == Side::reflection && below.is_present();
    const bool over_layer = lit && below.kind == LowerBoundary::Kind::layer;
    side.phase = over_layer
                     ? curve_of(file, prefix + side_name(which) + phase_name, 2, phase_function)
                     : curve_of(file, prefix + phase_name, 1, phase_function);
    if (lit) {
        const auto albedo = static_cast<float>(below.albedo);
        side.view.over_surface = !over_layer;
        side.view.surface_albedo = over_layer ? 0 : albedo;
        side.view.boundary_quarter_albedo = over_layer ? albedo / 4 : 0;
    }
    side.view.phase = side.phase.view();
    const PackedKernels& all = *kernels().packed;
    side.kernel = &(which == Side::reflection ? all.reflected : all.transmitted)
                       .of(side.phase.form(), table.azimuth.values.size() > 1);
}

/// The axes of the coefficients and the scales along them.
void set_axes(const TableView& table, const double* exponents, double length, Side which,
              SideMemory& side) {
    PackedSide& view = side.view;
    const AxisView &albedo = table.albedo, &depth = table.optical_depth;
    const Resampling albedos(albedo.count);
    view.albedo = albedos.axis(albedo);
    view.optical_depth = Resampling(std::max(1, depth.count)).axis(depth);
    // Samples of a stack are divided by no albedo.
    view.min_albedo = table.is_stack() ? 1 : static_cast<float>(albedo.lowest);
    view.max_albedo = table.is_stack() ? 1 : static_cast<float>(albedo.highest);
    view.min_depth = static_cast<float>(depth.lowest);
    view.ends_at_infinity = which == Side::reflection && depth.ends_at_infinity;
    view.max_finite_depth = depth.count > 0 ? static_cast<float>(depth.highest) : -1;
    view.max_depth = depth.ends_at_infinity ? 1e30f : view.max_finite_depth;
    view.divided = !table.has_lower_boundary();
    view.extrapolation_length = static_cast<float>(length);
    for (int a = 0; a < albedos.to; ++a) {
        double exponent = 0;
        for (int l = 0; l < albedos.from; ++l) exponent += albedos.weight(l, a) * exponents[l];
        exponent = std::max(0.0, exponent);
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
    view.fourth_root_of_albedo = albedo.scale == AxisScale::fourth_root_of_complement;
}

/// Where lookups find cosines and azimuths.
void set_directions(const TableView& table, SideMemory& side) {
    const FunctionLayout layout(table);
    PackedSide& view = side.view;
    const auto cosines = [](const Resampling& sampling, const AxisView& axis) {
        if (sampling.to == 1) return PackedAxis{0, 0, stencil_size - 1};
        PackedAxis places = sampling.axis(axis);
        places.first = static_cast<float>(axis.first - pi / 2);
        return places;
    };
    view.symmetric = layout.symmetric;
    view.mu_in = cosines(layout.mu_in, table.mu_in);
    view.mu_out = cosines(layout.mu_out, table.mu_out);
    view.row_step = layout.row_step();
    view.column_step = layout.column_step();
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

/// Checks a block, and that the cubics of every cell that it serves lie within it.
class BlockChecks {
  public:
    BlockChecks(const TableView& table, bool needs_infinity, std::string name)
        : albedos_(std::max(stencil_size, table.albedo.count)),
          depths_(std::max(stencil_size, table.optical_depth.count)),
          needs_infinity_(needs_infinity),
          deepest_cell_(table.optical_depth.count > 1 ? depths_ - 1 : 0),
          name_(std::move(name)) {}

    int albedos() const { return albedos_; }
    int depths() const { return depths_; }

    void check_block(const std::int32_t* block, std::size_t rows) const {
        require_field(block[BlockField::ends_at_infinity], 0, 1, "ends_at_infinity");
        require_field(block[BlockField::first_albedo], 0, albedos_ - stencil_size, "first_albedo");
        require_field(block[BlockField::albedos], stencil_size,
                      albedos_ - block[BlockField::first_albedo], "albedos");
        require_field(block[BlockField::first_depth], 0, depths_ - stencil_size, "first_depth");
        const int infinite = block[BlockField::ends_at_infinity];
        require_field(block[BlockField::depths], stencil_size + infinite,
                      depths_ - block[BlockField::first_depth] + infinite, "depths");
        const std::size_t needed =
            size(block[BlockField::albedos]) * size(block[BlockField::depths]);
        require(
            block[BlockField::first_row] >= 0 && needed <= rows &&
                size(block[BlockField::first_row]) <= rows - needed,
            caller, "first_row of " + name_,
            "such that " + std::to_string(needed) + " of " + std::to_string(rows) + " rows follow",
            block[BlockField::first_row]);
    }

    void check_cell(const std::int32_t* block, int albedo, int depth) const {
        const auto within = [](int cell, int samples, int first, int count) {
            const int window = std::clamp(cell - 1, 0, samples - stencil_size);
            return window >= first && window + stencil_size <= first + count;
        };
        const bool inside =
            within(albedo, albedos_, block[BlockField::first_albedo], block[BlockField::albedos]) &&
            within(depth, depths_, block[BlockField::first_depth], finite_depths(block)) &&
            (!needs_infinity_ || depth < deepest_cell_ || block[BlockField::ends_at_infinity] == 1);
        require(inside, caller,
                "block of cell (" + std::to_string(albedo) + ", " + std::to_string(depth) +
                    ") of " + name_,
                "one that holds its samples", "another");
    }

  private:
    static int finite_depths(const std::int32_t* block) {
        return block[BlockField::depths] - block[BlockField::ends_at_infinity];
    }

    void require_field(int value, int least, int most, const char* field) const {
        require(value >= least && value <= most, caller, std::string(field) + " of " + name_,
                "in [" + std::to_string(least) + ", " + std::to_string(most) + "]", value);
    }

    int albedos_, depths_;  // samples, those of short axes four
    bool needs_infinity_;
    int deepest_cell_;  // and those beyond
    std::string name_;
};

template <class Number>
const void* checked_functions(const TensorFile& file, const std::string& name,
                              const std::vector<std::size_t>& shape) {
    const TensorOf<Number> numbers = file.numbers<Number>(name, 3);
    require_shape(numbers, name, shape);
    return numbers.data;
}

void require_aligned(const void* data, const std::string& name) {
    require(reinterpret_cast<std::uintptr_t>(data) % alignment == 0, caller, "address of " + name,
            "a multiple of 64 bytes", "another");
}

/// The blocks that a file holds of a side.
void set_blocks(const TensorFile& file, const std::string& name, const TableView& table,
                SideMemory& side) {
    const std::string of_blocks = name + blocks_name;
    const TensorOf<std::int32_t> blocks = file.numbers<std::int32_t>(of_blocks, 2);
    require_shape(blocks, of_blocks, {blocks.shape[0], size(BlockField::count)});
    const std::size_t count = blocks.shape[0], rows = FunctionLayout(table).rows();
    const std::vector<std::size_t> shape{count, rows, functions};
    side.view.halves = file.tensor(name + functions_name).type == TensorType::f16;
    const void* const function = side.view.halves
                                     ? checked_functions<Half>(file, name + functions_name, shape)
                                     : checked_functions<float>(file, name + functions_name, shape);
    const TensorOf<float> coefficients = file.numbers<float>(name + coefficients_name, 2);
    require_shape(coefficients, name + coefficients_name, {coefficients.shape[0], functions});
    require_aligned(function, name + functions_name);
    require_aligned(coefficients.data, name + coefficients_name);
    const std::size_t block_bytes =
        rows * functions * (side.view.halves ? sizeof(Half) : sizeof(float));
    const BlockChecks checks(table, side.view.ends_at_infinity, of_blocks);
    for (std::size_t b = 0; b < count; ++b) {
        const std::int32_t* const block = blocks.data + b * size(BlockField::count);
        checks.check_block(block, coefficients.shape[0]);
        side.blocks.push_back({static_cast<const char*>(function) + b * block_bytes,
                               reinterpret_cast<const CoefficientRow*>(coefficients.data) +
                                   block[BlockField::first_row],
                               block[BlockField::first_albedo], block[BlockField::first_depth],
                               block[BlockField::albedos], block[BlockField::depths]});
    }
    const std::string of_cells = name + block_of_cell_name;
    const TensorOf<std::int32_t> cells = file.numbers<std::int32_t>(of_cells, 2);
    require_shape(cells, of_cells, {size(checks.albedos()), size(checks.depths())});
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
        const std::int32_t block = cells.data[cell];
        require(block >= 0 && size(block) < count, caller, of_cells,
                "below " + std::to_string(count), block);
        checks.check_cell(blocks.data + size(block) * size(BlockField::count),
                          static_cast<int>(cell) / checks.depths(),
                          static_cast<int>(cell) % checks.depths());
        side.block_of_cell.push_back(static_cast<float>(block));
    }
}

/// Orders n >= 2 that a file does not hold.
void set_nothing(SideMemory& side) {
    PackedSide& view = side.view;
    view.symmetric = view.halves = view.ends_at_infinity = false;
    view.row_step = view.column_step = 0;
    view.optical_depth = {0, 0, stencil_size - 1};
    const std::size_t albedos = side.diffusion_exponent.size();
    side.no_functions.assign(size(view.azimuths + 2), {});
    side.no_coefficients.assign(albedos * stencil_size, {});
    side.blocks.push_back({side.no_functions.data(), side.no_coefficients.data(), 0, 0,
                           static_cast<int>(albedos), stencil_size});
    side.block_of_cell.assign(albedos * stencil_size, 0.0f);
}

void set_path_law(const TensorFile& file, const Table& table, SideMemory& side) {
    if (!table.path_law) return;
    const TensorOf<float> sheet = file.numbers<float>(path_sheet_name, 4);
    const std::size_t angles = 2 * size(table.path_law->angle_count());
    const std::size_t depths = sheet.shape[1];
    require(depths >= 2 && depths <= 64, caller, "depths of path_sheet", "in [2, 64]", depths);
    require_shape(sheet, path_sheet_name, {size(path_sheet_steps + 1), depths, angles, 2});
    side.view.path = PathSheet::view_of(sheet.data, table.path_law->offset(),
                                        table.path_law->angle_count(), static_cast<int>(depths));
    side.view.path_steps = path_sheet_steps;
}

MixtureSample mixture_sample(const TensorFile& file, const Table& table, std::size_t m) {
    const std::string prefix = mixture_prefix(table.has_mixture(), m);
    MixtureSample sample{};
    const double share = table.has_mixture() ? table.mixture.values[m] : 1;
    sample.extrapolation_length =
        table.has_mixture() ? mixed_extrapolation_length(table.extrapolation_length,
                                                         table.second_extrapolation_length, share)
                            : table.extrapolation_length;
    const TableView view = table.view();
    const PhaseFunction phase = view.at_mixture(share).mixed_phase_function();
    for (const Side which : {Side::reflection, Side::transmission}) {
        SideMemory& side = sample.side[which == Side::reflection ? 0 : 1];
        const std::string name = prefix + side_name(which);
        set_closed_forms(file, prefix, table, phase, which, side);
        set_axes(view, table.diffusion_exponent.data() + m * table.albedo.values.size(),
                 sample.extrapolation_length, which, side);
        set_directions(view, side);
        set_path_law(file, table, side);
        if (file.has(name + functions_name))
            set_blocks(file, name, view, side);
        else
            set_nothing(side);
        side.view.block = side.blocks.data();
        side.view.block_of_cell = side.block_of_cell.data();
    }
    return sample;
}

double within_half_turn(double azimuth) noexcept {
    return azimuth >= 0 && azimuth <= pi ? azimuth : std::abs(std::remainder(azimuth, 2 * pi));
}

Scattered at_one(const SideMemory& side, double albedo, double optical_depth,
                 const Geometry& geometry) noexcept {
    float single_multiple[2];
    side.kernel->one(side.view,
                     {static_cast<float>(albedo), static_cast<float>(1 - albedo),
                      static_cast<float>(optical_depth), static_cast<float>(geometry.mu_in),
                      static_cast<float>(geometry.mu_out),
                      static_cast<float>(within_half_turn(geometry.azimuth))},
                     single_multiple);
    return {double{single_multiple[0]}, double{single_multiple[1]}};
}

void at_many(const PackedSide& side, const PackedKernel& kernel, const PackedPoints& points,
             float* total) noexcept {
    const std::size_t rest = points.count % points_at_once, whole = points.count - rest;
    kernel.many(side, points, whole, total);
    if (rest == 0) return;
    alignas(64) float copy[5][points_at_once], found[points_at_once];
    const float* const from[5] = {points.albedo, points.optical_depth, points.mu_in, points.mu_out,
                                  points.azimuth};
    for (int q = 0; q < 5; ++q) {
        std::fill(copy[q], copy[q] + points_at_once, 0.5f);
        std::copy(from[q] + whole, from[q] + points.count, copy[q]);
    }
    kernel.many(side, {copy[0], copy[1], copy[2], copy[3], copy[4], points_at_once}, points_at_once,
                found);
    std::copy(found, found + rest, total + whole);
}

/// Memory aligned as files are.
struct AlignedDelete {
    void operator()(char* memory) const { operator delete (memory, std::align_val_t{alignment}); }
};
using AlignedBytes = std::unique_ptr<char, AlignedDelete>;

AlignedBytes aligned_copy(const std::vector<char>& bytes) {
    AlignedBytes copy(static_cast<char*>(operator new (std::max<std::size_t>(1, bytes.size()),
                                                       std::align_val_t{alignment})));
    std::copy(bytes.begin(), bytes.end(), copy.get());
    return copy;
}

}  // namespace

bool is_reserved(const std::string& name) {
    static const std::vector<std::string> fixed{format_name,
                                                format_version_name,
                                                phase_function_name,
                                                below_name,
                                                below_albedo_name,
                                                second_phase_function_name,
                                                tolerance_name,
                                                measured_error_name,
                                                below_phase_function_name,
                                                highest_order_name,
                                                path_offset_name,
                                                extrapolation_length_name,
                                                path_deepest_name,
                                                second_extrapolation_length_name,
                                                layer_phase_functions_name,
                                                spherical_albedo_below_name};
    if (std::find(fixed.begin(), fixed.end(), name) != fixed.end()) return true;
    const auto& axes = packed_axis_fields();
    return std::any_of(axes.begin(), axes.end(), [&](const PackedAxisField& field) {
        return name == std::string(field.name) + scale_suffix;
    });
}

PathSheet squared_path_sheet(const PathOrders& law, int highest_order) {
    constexpr double min_square = 1e-6;  // in place of 0, where only the ratio is left
    double albedo[path_sheet_steps + 1];
    for (int i = 0; i <= path_sheet_steps; ++i)
        albedo[i] = std::sqrt(std::max(min_square, static_cast<double>(i) / path_sheet_steps));
    return PathSheet(law, albedo, path_sheet_steps + 1, highest_order, 2);
}

struct PackedTable::Contents {
    std::optional<MappedFile> mapped;
    AlignedBytes copy;
    std::size_t bytes;
    Table header;
    std::vector<MixtureSample> mixture;

    Contents(std::optional<MappedFile> mapped_, AlignedBytes copy_, const void* data,
             std::size_t bytes_)
        : mapped(std::move(mapped_)), copy(std::move(copy_)), bytes(bytes_) {
        require_aligned(data, "the file");
        const TensorFile file(data, bytes);
        header = header_of(file);
        for (std::size_t m = 0; m < header.mixture_count(); ++m)
            mixture.push_back(mixture_sample(file, header, m));
        require(holds(Side::reflection) || holds(Side::transmission), caller, "file",
                "one that holds reflection or transmission", "neither");
    }

    bool holds(Side side) const {
        return mixture[0].side[side == Side::reflection ? 0 : 1].no_functions.empty();
    }

    /// add(sample of the mixture, its weight) for those around a mixture.
    template <class Add>
    void each_mixture(double share, const Add& add) const {
        if (!header.has_mixture()) {
            add(mixture[0], 1.0);
            return;
        }
        const AxisView axis = header.mixture.view();
        const Stencil stencil = axis.stencil(share);
        for (int k = 0; k < std::min(stencil_size, axis.count); ++k)
            if (stencil.weight[k] != 0)
                add(mixture[size(stencil.first + k)], double{stencil.weight[k]});
    }

    Scattered one(Side side, double albedo, double optical_depth, const Geometry& geometry,
                  double share) const noexcept {
        Scattered sum{};
        if (side == Side::transmission && header.lower_boundary.is_present()) return sum;
        each_mixture(share, [&](const MixtureSample& sample, double weight) {
            const SideMemory& memory = sample.side[side == Side::reflection ? 0 : 1];
            const Scattered at = at_one(memory, albedo, optical_depth, geometry);
            sum.single += weight * at.single;
            sum.multiple += weight * at.multiple;
        });
        if (!header.is_stack()) return sum;
        sum.single = side == Side::reflection ? single_reflection_of(header.layers, geometry)
                                              : single_transmission_of(header.layers, geometry);
        if (header.lower_boundary.is_present())
            sum.single +=
                single_reflection_of_boundary(header.lower_boundary, optical_depth, geometry);
        return sum;
    }

    void many(Side side, const PackedPoints& points, float* total, double share) const noexcept {
        if (side == Side::transmission && header.lower_boundary.is_present()) {
            std::fill(total, total + points.count, 0.0f);
            return;
        }
        if (header.is_stack()) {
            for (std::size_t n = 0; n < points.count; ++n)
                total[n] = static_cast<float>(
                    one(side, double{points.albedo[n]}, double{points.optical_depth[n]},
                        {double{points.mu_in[n]}, double{points.mu_out[n]},
                         double{points.azimuth[n]}},
                        share)
                        .total());
            return;
        }
        const int index = side == Side::reflection ? 0 : 1;
        if (!header.has_mixture()) {
            const SideMemory& side = mixture[0].side[index];
            at_many(side.view, *side.kernel, points, total);
            return;
        }
        std::fill(total, total + points.count, 0.0f);
        each_mixture(share, [&](const MixtureSample& sample, double weight) {
            constexpr std::size_t block = 256;
            float found[block];
            for (std::size_t first = 0; first < points.count; first += block) {
                const std::size_t count = std::min(block, points.count - first);
                at_many(sample.side[index].view, *sample.side[index].kernel,
                        {points.albedo + first, points.optical_depth + first, points.mu_in + first,
                         points.mu_out + first, points.azimuth + first, count},
                        found);
                for (std::size_t n = 0; n < count; ++n)
                    total[first + n] += static_cast<float>(weight) * found[n];
            }
        });
    }
};

PackedTable::PackedTable(const std::string& path) {
    MappedFile file(path);
    const void* const data = file.data();
    const std::size_t size = file.bytes();
    try {
        contents_ = std::make_unique<const Contents>(std::move(file), nullptr, data, size);
    } catch (const std::invalid_argument& error) {
        throw std::runtime_error(path + ": " + error.what());
    }
}

PackedTable::PackedTable(const void* data, std::size_t bytes)
    : contents_(std::make_unique<const Contents>(std::nullopt, nullptr, data, bytes)) {}

PackedTable::PackedTable(const std::vector<char>& bytes) {
    AlignedBytes copy = aligned_copy(bytes);
    const char* const data = copy.get();
    contents_ = std::make_unique<const Contents>(std::nullopt, std::move(copy), data, bytes.size());
}

PackedTable::PackedTable(PackedTable&&) noexcept = default;
PackedTable& PackedTable::operator=(PackedTable&&) noexcept = default;
PackedTable::~PackedTable() = default;

const Table& PackedTable::header() const noexcept { return contents_->header; }

TableView PackedTable::view() const noexcept {
    TableView view = contents_->header.view();
    view.packed = this;
    view.packed_reflection = has_reflection();
    view.packed_transmission = has_transmission();
    return view;
}

Scattered PackedTable::reflection(double albedo, double optical_depth, const Geometry& geometry,
                                  double mixture) const noexcept {
    return contents_->one(Side::reflection, albedo, optical_depth, geometry, mixture);
}

Scattered PackedTable::transmission(double albedo, double optical_depth, const Geometry& geometry,
                                    double mixture) const noexcept {
    return contents_->one(Side::transmission, albedo, optical_depth, geometry, mixture);
}

void PackedTable::reflection(const PackedPoints& points, float* total,
                             double mixture) const noexcept {
    contents_->many(Side::reflection, points, total, mixture);
}

void PackedTable::transmission(const PackedPoints& points, float* total,
                               double mixture) const noexcept {
    contents_->many(Side::transmission, points, total, mixture);
}

bool PackedTable::has_reflection() const noexcept { return contents_->holds(Side::reflection); }
bool PackedTable::has_transmission() const noexcept { return contents_->holds(Side::transmission); }

std::vector<float> PackedTable::layer(Side which, double albedo, double optical_depth,
                                      double mixture) const {
    const Table& table = contents_->header;
    std::vector<float> values(table.mu_in.values.size() * table.mu_out.values.size() *
                              table.azimuth.values.size());
    // All directions, once of those that are symmetric.
    const std::vector<double>&ins = table.mu_in.values, &outs = table.mu_out.values,
          &azimuths = table.azimuth.values;
    const bool symmetric = table.view().is_symmetric();
    std::vector<float> in, out, azimuth, scale;
    for (std::size_t i = 0; i < ins.size(); ++i)
        for (std::size_t j = 0; j < (symmetric ? i + 1 : outs.size()); ++j)
            for (const double angle : azimuths) {
                const double shares = table.lower_boundary.is_present()
                                          ? 1
                                          : intercepted_share(optical_depth, ins[i]) *
                                                intercepted_share(optical_depth, outs[j]);
                in.push_back(static_cast<float>(ins[i]));
                out.push_back(static_cast<float>(outs[j]));
                azimuth.push_back(static_cast<float>(angle));
                scale.push_back(static_cast<float>(1 / shares));
            }
    const std::vector<float> albedos(in.size(), static_cast<float>(albedo)),
        depths(in.size(), static_cast<float>(optical_depth));
    std::vector<float> found(in.size());
    contents_->each_mixture(mixture, [&](const MixtureSample& sample, double weight) {
        const SideMemory& side = sample.side[which == Side::reflection ? 0 : 1];
        PackedSide orders = side.view;  // without what is known in closed form
        orders.path = {};
        orders.phase = {};
        orders.surface_albedo = orders.boundary_quarter_albedo = 0;
        const PackedKernels& all = *kernels().packed;
        const PackedKernel& kernel = (which == Side::reflection ? all.reflected : all.transmitted)
                                         .of(PhaseForm::constant, azimuths.size() > 1);
        at_many(orders, kernel,
                {albedos.data(), depths.data(), in.data(), out.data(), azimuth.data(), in.size()},
                found.data());
        std::size_t n = 0;
        const auto row = [&](std::size_t i, std::size_t j) {
            return &values[(i * outs.size() + j) * azimuths.size()];
        };
        for (std::size_t i = 0; i < ins.size(); ++i)
            for (std::size_t j = 0; j < (symmetric ? i + 1 : outs.size()); ++j)
                for (std::size_t k = 0; k < azimuths.size(); ++k, ++n) {
                    const float value = static_cast<float>(weight) * scale[n] * found[n];
                    row(i, j)[k] += value;
                    if (symmetric && i != j) row(j, i)[k] += value;
                }
    });
    return values;
}

Table PackedTable::unpacked() const {
    Table table = contents_->header;
    for (const Side side : {Side::reflection, Side::transmission}) {
        if (!contents_->holds(side)) continue;
        std::vector<float>& samples =
            side == Side::reflection ? table.reflection_multiple : table.transmission_multiple;
        samples.reserve(table.sample_count());
        for (std::size_t m = 0; m < table.mixture_count(); ++m)
            for (const double albedo : table.albedo.values)
                for (const double depth : table.optical_depth.values) {
                    const double mixture = table.has_mixture() ? table.mixture.values[m] : 1;
                    const std::vector<float> values = layer(side, albedo, depth, mixture);
                    const float* value = values.data();
                    for (const double in : table.mu_in.values)
                        for (const double out : table.mu_out.values) {
                            const double shares =
                                table.lower_boundary.is_present()
                                    ? 1
                                    : intercepted_share(depth, in) * intercepted_share(depth, out);
                            for (std::size_t k = 0; k < table.azimuth.values.size(); ++k)
                                samples.push_back(static_cast<float>(shares * double{*value++}));
                        }
                }
    }
    prepare(table);
    return table;
}

const PackedSide& PackedTable::side(Side side) const noexcept {
    return contents_->mixture[0].side[side == Side::reflection ? 0 : 1].view;
}

std::size_t PackedTable::bytes() const noexcept { return contents_->bytes; }

}  // namespace stratus
