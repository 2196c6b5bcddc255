#include "packed_parts.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>
#include <stratus/layer/diffusion.h>
#include <stratus/table/metadata.h>
#include <stratus/table/packed_block.h>

#include "layer_blend.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <variant>

namespace stratus {
namespace {

template <class Number>
std::vector<Number> copied(const TensorOf<Number>& numbers) {
    return std::vector<Number>(numbers.begin(), numbers.end());
}

void check_format(const TensorFile& file) {
    const std::string& format = file.text(format_name);
    require(format == packed_format, packed_caller, format_name, packed_format,
            format.substr(0, 40));
    const std::string& version = file.text(format_version_name);
    require(version == packed_format_version, packed_caller, format_version_name,
            packed_format_version, version.substr(0, 40));
}

AxisScale read_scale(const TensorFile& file, const std::string& name) {
    const std::string& text = file.text(name + scale_suffix);
    const std::optional<AxisScale> scale = axis_scale_named(text);
    require(scale.has_value(), packed_caller, name + scale_suffix, "the name of a scale",
            text.substr(0, 40));
    return *scale;
}

std::shared_ptr<const PathOrders> path_orders(const TensorFile& file) {
    const bool is_rounded = file.tensor(path_orders_name).type == TensorType::f16;
    std::vector<float> samples;
    TensorShape shape;
    const auto take = [&](const auto& orders, const auto& to_number) {
        shape = orders.shape;
        std::transform(orders.begin(), orders.end(), std::back_inserter(samples), to_number);
    };
    if (is_rounded)
        take(file.numbers<Half>(path_orders_name, 2), to_float);
    else
        take(file.numbers<float>(path_orders_name, 2), [](float value) { return value; });
    require(shape[1] < 1 << 16, packed_caller, "orders of path_orders", "below 65536", shape[1]);
    return std::make_shared<const PathOrders>(
        static_cast<float>(to_number(path_offset_name, file.text(path_offset_name))),
        to_number(path_deepest_name, file.text(path_deepest_name)), static_cast<int>(shape[1]) + 2,
        std::move(samples));
}

/// The phase curve `name`, of `width` functions; where there is none, that of a phase function.
PhaseCurve read_phase_curve(const TensorFile& file, const std::string& name, std::size_t width,
                            const PhaseFunction& phase_function) {
    if (!file.has(name)) {
        const auto is_closed = [](const auto& part) {
            return std::visit([](const auto& kind) { return kind.closed_form().has_value(); },
                              part.second);
        };
        const auto& terms = phase_function.terms();  // asked before a curve is sampled for nothing
        require(width == 1 && std::all_of(terms.begin(), terms.end(), is_closed), packed_caller,
                name, "given", "none");
        PhaseCurve curve(phase_function);
        require(curve.sample_count() == 0, packed_caller, name, "given", "none");
        return curve;
    }
    const TensorOf<float> samples = file.numbers<float>(name, 2);
    require(samples.shape[0] >= 2 && samples.shape[0] <= (1 << 20) && samples.shape[1] == width,
            packed_caller, "shape of " + name, "[2 to 1048576, " + std::to_string(width) + "]",
            list_text(samples.shape));
    return PhaseCurve::of_samples(copied(samples), static_cast<int>(width));
}

/// The axes of a family, whose parameters are known.
void read_family_axes(const TensorFile& file, Table& table) {
    for (FamilyAxis& axis : table.family) {
        const std::string name = axis.name();
        axis.is_discrete = file.text(name + scale_suffix) == discrete_scale_name;
        if (!axis.is_discrete) axis.axis.scale = read_scale(file, name);
        axis.axis.values = copied(file.numbers<double>(name, 1));
    }
}

}  // namespace

Table packed_header(const TensorFile& file) {
    check_format(file);
    check_features_known(file.strings());
    Table table = table_of_metadata(file.strings());
    for (const AxisField& field : axis_fields) {
        const bool may_be_infinite = field.axis == &Table::optical_depth;
        table.*field.axis = {
            read_scale(file, field.name),
            copied(file.numbers<double>(field.name, 1,
                                        may_be_infinite ? Infinity::allowed : Infinity::refused))};
    }
    read_family_axes(file, table);
    for (const SampleField& field : sample_fields)
        if (field.is_flux() && file.has(field.name))
            table.*field.samples = copied(file.numbers<float>(field.name, field.rank + 1));
    table.diffusion_exponent = copied(file.numbers<double>(diffusion_exponent_name, 2));
    for (const auto& [name, text] : file.strings())
        if (!is_reserved(name)) table.attributes[name] = text;
    prepare_header(table);
    if (!table.has_family())
        table.phase_curve = read_phase_curve(file, phase_name, 1, table.phase_function);
    if (has_feature(file.strings(), path_law_feature))
        table.path_law =
            table.has_family() ? PathOrders::of_any(table.phase_function) : path_orders(file);
    check_features(file.strings(), table);
    return table;
}

bool is_reserved(const std::string& name) {
    static const std::vector<std::string> own = [] {
        std::vector<std::string> names{checksum_key, format_name, format_version_name,
                                       path_offset_name, path_deepest_name};
        for (const std::string& parameter : parameter_names())
            names.push_back(parameter + scale_suffix);
        for (const AxisField& field : axis_fields)
            names.push_back(std::string(field.name) + scale_suffix);
        return names;
    }();
    return find_entry(shared_entries, name) || is_listed(name, own);
}

namespace {

/// Single scattering, on the lit side with that of the lower boundary.
void set_closed_forms(const TensorFile& file, const Table& table, std::size_t m,
                      const PhaseFunction& phase_function, Side which, SideMemory& side) {
    const LowerBoundary& below = table.lower_boundary;
    const bool lit = which == Side::reflection && below.is_present();
    const bool over_layer = lit && below.is_layer();
    side.phase = read_phase_curve(
        file, (over_layer ? side_prefix(table, m, which) : member_prefix(table, m)) + phase_name,
        over_layer ? 2 : 1, phase_function);
    if (lit) {
        const auto albedo = static_cast<float>(below.albedo);
        side.view.over_surface = below.is_surface();
        side.view.surface_albedo = side.view.over_surface ? albedo : 0;
        side.view.boundary_quarter_albedo = over_layer ? albedo / 4 : 0;
    }
    side.view.phase = side.phase.view();
    const PackedSideKernels& kernels = chosen_functions<PackedKernels>()[which];
    const bool azimuthal = table.azimuth.values.size() > 1;
    side.kernel = &kernels.of(side.phase.form(), azimuthal);
    side.of_multiple = &kernels.of(PhaseForm::polynomial, azimuthal);
}

/// The axes of the coefficients and the scales along them.
void set_axes(const TableView& table, std::size_t m, Side which, SideMemory& side) {
    PackedSide& view = side.view;
    const double length = table.extrapolation_lengths[m];
    const AxisView &albedo = table.albedo, &depth = table.optical_depth;
    const double* const exponents = table.diffusion_exponent + m * size(albedo.count);
    const Resampling albedos(albedo.count);
    view.albedo = albedos.axis(albedo);
    view.optical_depth = Resampling(std::max(1, depth.count)).axis(depth);
    // Samples of a stack are divided by no albedo.
    view.min_albedo = table.is_stack() ? 1 : static_cast<float>(albedo.lowest);
    view.max_albedo = table.is_stack() ? 1 : static_cast<float>(albedo.highest);
    view.min_depth = depth.count > 0 ? static_cast<float>(depth.lowest) : 0;
    view.thin = depth.count > 0 ? thin_layers(depth) : ThinLayers{};
    view.thin_place = (static_cast<float>(std::log2(view.thin.deeper)) - view.optical_depth.first) *
                      view.optical_depth.inverse_step;
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
struct BlockChecks {
    const std::string& name;
    int albedos, depths;  // samples, those of short axes four
    bool needs_infinity;  // in this cell along depth, and those beyond
    int deepest_cell;

    void check_block(const BlockFields& block, std::size_t rows) const {
        const int infinite = block.ends_at_infinity;
        require_field(infinite, 0, 1, "ends_at_infinity");
        require_field(block.first_albedo, 0, albedos - stencil_size, "first_albedo");
        require_field(block.albedos, stencil_size, albedos - block.first_albedo, "albedos");
        require_field(block.first_depth, 0, depths - stencil_size, "first_depth");
        require_field(block.depths, stencil_size + infinite, depths - block.first_depth + infinite,
                      "depths");
        const std::size_t needed = size(block.albedos) * size(block.depths);
        require(
            block.first_row >= 0 && needed <= rows && size(block.first_row) <= rows - needed,
            packed_caller, "first_row of " + name,
            "such that " + std::to_string(needed) + " of " + std::to_string(rows) + " rows follow",
            block.first_row);
    }

    void check_cell(const BlockFields& block, int albedo, int depth) const {
        const auto within = [](int cell, int samples, int first, int count) {
            const int window = std::clamp(cell - 1, 0, samples - stencil_size);
            return window >= first && window + stencil_size <= first + count;
        };
        const int infinite = block.ends_at_infinity;
        const bool inside = within(albedo, albedos, block.first_albedo, block.albedos) &&
                            within(depth, depths, block.first_depth, block.depths - infinite) &&
                            (!needs_infinity || depth < deepest_cell || infinite == 1);
        require(inside, packed_caller,
                "block of cell (" + std::to_string(albedo) + ", " + std::to_string(depth) +
                    ") of " + name,
                "one that holds its samples", "another");
    }

    void require_field(int value, int least, int most, const char* field) const {
        require(value >= least && value <= most, packed_caller, std::string(field) + " of " + name,
                "in [" + std::to_string(least) + ", " + std::to_string(most) + "]", value);
    }
};

template <class Number>
const void* checked_functions(const TensorFile& file, const std::string& name,
                              const TensorShape& shape) {
    const TensorOf<Number> numbers = file.numbers<Number>(name, 3);
    require_shape(numbers, name, shape);
    return numbers.data;
}

/// The prefix of the functions that serve a side of member m: its own, or those of an earlier one.
std::string prefix_of_functions(const TensorFile& file, const Table& table, std::size_t m,
                                Side which) {
    const std::string own = side_prefix(table, m, which), name = own + functions_of_name;
    if (!file.has(name)) return own;
    const TensorOf<std::int32_t> given = file.numbers<std::int32_t>(name, 1);
    require_shape(given, name, {1});
    const std::int32_t owner = given.data[0];
    const std::string prefix = side_prefix(table, size(owner), which);
    require(owner >= 0 && size(owner) < m && file.has(prefix + functions_name), packed_caller, name,
            "an earlier member that has functions of its own", owner);
    return prefix;
}

/// Functions in a row.
std::size_t function_count(const TensorFile& file, const std::string& name) {
    const TensorShape& shape = file.tensor(name).shape;
    const std::size_t count = shape.empty() ? 0 : shape.back();
    require(count == fewest_functions || count == most_functions, packed_caller,
            "the last extent of " + name,
            std::to_string(fewest_functions) + " or " + std::to_string(most_functions), count);
    return count;
}

/// The blocks that a file holds of a side: its coefficients, and the functions of `owner`, which may
/// be of another member.
void set_blocks(const TensorFile& file, const std::string& name, const std::string& owner,
                const TableView& table, SideMemory& side) {
    const std::string of_blocks = owner + blocks_name;
    const TensorOf<std::int32_t> blocks = file.numbers<std::int32_t>(of_blocks, 2);
    const std::size_t count = blocks.shape[0], rows = FunctionLayout(table).rows(),
                      functions = function_count(file, owner + functions_name);
    require_shape(blocks, of_blocks, {count, block_field_count});
    std::vector<BlockFields> fields(count);
    std::memcpy(fields.data(), blocks.data, count * sizeof(BlockFields));
    const TensorShape shape{count, rows, functions};
    side.view.functions = static_cast<int>(functions);
    side.view.halves = file.tensor(owner + functions_name).type == TensorType::f16;
    const void* const function =
        side.view.halves ? checked_functions<Half>(file, owner + functions_name, shape)
                         : checked_functions<float>(file, owner + functions_name, shape);
    const TensorOf<float> coefficients = file.numbers<float>(name + coefficients_name, 2);
    require_shape(coefficients, name + coefficients_name, {coefficients.shape[0], functions});
    require_aligned(function, owner + functions_name);
    require_aligned(coefficients.data, name + coefficients_name);
    const std::size_t block_bytes =
        rows * functions * (side.view.halves ? sizeof(Half) : sizeof(float));
    const int albedos = std::max(stencil_size, table.albedo.count),
              depths = std::max(stencil_size, table.optical_depth.count);
    const BlockChecks checks{of_blocks, albedos, depths, side.view.ends_at_infinity,
                             table.optical_depth.count > 1 ? depths - 1 : 0};
    for (std::size_t b = 0; b < count; ++b) {
        const BlockFields& block = fields[b];
        checks.check_block(block, coefficients.shape[0]);
        side.blocks.push_back({static_cast<const char*>(function) + b * block_bytes,
                               coefficients.data + size(block.first_row) * functions,
                               block.first_albedo, block.first_depth, block.albedos, block.depths});
    }
    const std::string of_cells = owner + block_of_cell_name;
    const TensorOf<std::int32_t> cells = file.numbers<std::int32_t>(of_cells, 2);
    require_shape(cells, of_cells, {size(albedos), size(depths)});
    for (std::size_t cell = 0; cell < cells.count(); ++cell) {
        const std::int32_t block = cells.data[cell];
        require(block >= 0 && size(block) < count, packed_caller, of_cells,
                "below " + std::to_string(count), block);
        checks.check_cell(fields[size(block)], static_cast<int>(cell) / depths,
                          static_cast<int>(cell) % depths);
        side.block_of_cell.push_back(static_cast<float>(block));
    }
}

/// How fast T of the path law grows with (w + w^2) / 2 in deep layers (PackedSide::path_growth).
float path_growth(const PathOrders& law, int highest_order) {
    constexpr double mu = 0.5, near_forward = 0.1, dark = 0.7;
    const double slant = std::min(100.0, law.deepest() / 2);
    const auto over_square = [&](double albedo) {
        return law(Side::transmission, albedo, slant * mu, {mu, mu, near_forward}, highest_order) /
               (albedo * albedo);
    };
    const double most = over_square(1), least = over_square(dark);
    if (!(least > 0 && most > least)) return 0;
    const double rate = std::log(most / least) / (1 - 0.5 * (dark + dark * dark));
    return static_cast<float>(rate * (slant + double{path_onset}) / (slant * slant));
}

/// Orders n >= 2 that a file does not hold.
void set_nothing(SideMemory& side) {
    PackedSide& view = side.view;
    view.symmetric = view.halves = view.ends_at_infinity = false;
    view.row_step = view.column_step = 0;
    view.functions = fewest_functions;
    view.optical_depth = {0, 0, stencil_size - 1};
    const std::size_t albedos = side.diffusion_exponent.size();
    side.no_functions.assign(size(view.azimuths + 2) * fewest_functions, 0);
    side.no_coefficients.assign(albedos * stencil_size * fewest_functions, 0);
    side.blocks.push_back({side.no_functions.data(), side.no_coefficients.data(), 0, 0,
                           static_cast<int>(albedos), stencil_size});
    side.block_of_cell.assign(albedos * stencil_size, 0.0f);
}

}  // namespace

void require_aligned(const void* data, const std::string& name) {
    require(reinterpret_cast<std::uintptr_t>(data) % packed_alignment == 0, packed_caller,
            "address of " + name, "a multiple of 64 bytes", "another");
}

PathSheet squared_path_sheet(const PathOrders& law, int first, int highest_order) {
    const int steps = path_sheet_steps(law);
    std::vector<double> albedo;
    for (int i = first; i <= steps; ++i) albedo.push_back(path_sheet_albedo(i, steps));
    return PathSheet(law, albedo.data(), int_size(albedo), highest_order, 2);
}

PathSheetView path_sheet(const TensorFile& file, const Table& table, PathSheet& own) {
    if (!table.path_law || table.varies_parameters()) return {};
    const PathOrders& law = *table.path_law;
    const int first = first_path_step(law, table.view());
    if (!file.has(path_sheet_name)) {
        const std::size_t orders = size(law.order_count() - 2);
        require(orders <= most_summed_orders, packed_caller, path_sheet_name,
                "given for more than " + std::to_string(most_summed_orders) + " orders", orders);
        own = squared_path_sheet(law, first, table.highest_order);
        return own.view();
    }
    const TensorOf<float> sheet = file.numbers<float>(path_sheet_name, 4);
    const std::size_t depths = sheet.shape[1];
    constexpr std::size_t most_depths = std::size_t{16} << PathSheet::depth_bits;  // 16 octaves
    require(depths >= 2 && depths <= most_depths, packed_caller, "depths of path_sheet",
            "in [2, " + std::to_string(most_depths) + "]", depths);
    require_shape(
        sheet, path_sheet_name,
        {size(path_sheet_steps(law) + 1 - first), depths, 2 * size(law.angle_count()), 2});
    return PathSheet::make_view(sheet.data, law.offset(), law.angle_count(),
                                static_cast<int>(depths));
}

PerSide<SideMemory> packed_member(const TensorFile& file, const Table& table, std::size_t m,
                                  const PathSheetView& sheet) {
    PerSide<SideMemory> sides;
    const TableView view = table.view();
    // Members that vary in parameters need no closed form: none lies at the point itself.
    const PhaseFunction phase = table.varies_parameters()
                                    ? PhaseFunction()
                                    : view.at(member_at(table.family, m)).chosen_phase_function();
    const bool has_sheet = sheet.sample != nullptr;
    const float growth = has_sheet ? path_growth(*table.path_law, table.highest_order) : 0;
    for (const Side which : both_sides) {
        SideMemory& side = sides[which];
        set_closed_forms(file, table, m, phase, which, side);
        set_axes(view, m, which, side);
        set_directions(view, side);
        side.view.path = sheet;
        if (has_sheet) {
            side.view.path_steps = static_cast<float>(path_sheet_steps(*table.path_law));
            side.view.path_first = static_cast<float>(first_path_step(*table.path_law, view));
        }
        side.view.path_growth = growth;
        const std::string owner = prefix_of_functions(file, table, m, which);
        if (file.has(owner + functions_name))
            set_blocks(file, side_prefix(table, m, which), owner, view, side);
        else
            set_nothing(side);
        side.view.block = side.blocks.data();
        side.view.block_of_cell = side.block_of_cell.data();
    }
    return sides;
}

}  // namespace stratus
