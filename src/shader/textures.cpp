#include <stratus/base/argument.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/layer/diffusion.h>
#include <stratus/table/kernels/packed.h>
#include <stratus/table/packed_block.h>

#include "texture_parts.h"

#include <array>
#include <utility>

namespace stratus {
namespace {

using shader::vec4;

constexpr std::size_t record_texels = 16;

/// An optical depth, which may have no end.
float finite(double depth) { return static_cast<float>(std::min(depth, 1e30)); }

vec4 of_axis(const PackedAxis& axis, float more) {
    return {axis.first, axis.inverse_step, axis.last, more};
}

/// Each sample beside the next: one or two functions.
void append_phase(const PhaseCurveView& curve, std::size_t width, std::vector<vec4>& numbers) {
    for (std::size_t n = 0; n < size(curve.last); ++n) {
        const float* const at = curve.sample + n * width;
        numbers.push_back({at[0], width > 1 ? at[1] : 0, at[width], width > 1 ? at[width + 1] : 0});
    }
}

/// H and dH/ds at each angle beside the next.
void append_path(const PackedSide& side, std::vector<vec4>& numbers) {
    const PathSheetView& sheet = side.path;
    const std::size_t angles = 2 * size(sheet.angles),
                      rows = size(sheet.channel) / (2 * angles) *
                             static_cast<std::size_t>(side.path_steps + 1 - side.path_first);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t a = 0; a < angles; ++a) {
            const float* const at = sheet.sample + 2 * (row * angles + a);
            const float* const next = a + 1 < angles ? at + 2 : at;
            numbers.push_back({at[0], at[1], next[0], next[1]});
        }
}

/// Functions of a side as floats, or as they are.
void append_functions(const PackedSide& side, std::size_t rows, const LayerBlock& block,
                      bool as_halves, std::vector<char>& bytes) {
    const std::size_t count = rows * size(side.functions);
    const auto append = [&](const void* numbers, std::size_t width) {
        const auto* const first = static_cast<const char*>(numbers);
        bytes.insert(bytes.end(), first, first + count * width);
    };
    if (as_halves || !side.halves)
        return append(block.function, side.halves ? sizeof(Half) : sizeof(float));
    const auto* const half = static_cast<const Half*>(block.function);
    std::vector<float> values(count);
    std::transform(half, half + count, values.begin(), to_float);
    append(values.data(), sizeof(float));
}

/// All that lookups in a table read, as texels.
struct Texels {
    std::vector<vec4> numbers = std::vector<vec4>(2 * record_texels);
    std::vector<char> functions;
    bool halves = true;

    std::size_t function_texels() const {
        return functions.size() / (4 * (halves ? sizeof(Half) : sizeof(float)));
    }
};

/// A cell's texel: first texels of its functions and coefficients, depths of a row of these and the
/// first of them. Coefficients are counted from sample (0, 0) of the table.
void append_cells(const PackedSide& side, std::size_t rows, Texels& to) {
    const int words = side.functions / 4, cells = (static_cast<int>(side.albedo.last) + 1) *
                                                  (static_cast<int>(side.optical_depth.last) + 1);
    const std::size_t first_cell = to.numbers.size();
    to.numbers.resize(first_cell + size(cells));
    const auto last =
        static_cast<int>(*std::max_element(side.block_of_cell, side.block_of_cell + cells));
    for (int b = 0; b <= last; ++b) {
        const LayerBlock& block = side.block[b];
        const auto function = exactly(to.function_texels());
        append_functions(side, rows, block, to.halves, to.functions);
        const auto coefficient = exactly(
            static_cast<std::ptrdiff_t>(to.numbers.size()) -
            words * (std::ptrdiff_t{block.first_albedo} * block.depths + block.first_depth));
        for (std::size_t word = 0; word < size(block.albedos * block.depths * words); ++word) {
            const float* const four = block.coefficient + 4 * word;
            to.numbers.push_back({four[0], four[1], four[2], four[3]});
        }
        for (int cell = 0; cell < cells; ++cell)
            if (side.block_of_cell[cell] == exactly(b))
                to.numbers[first_cell + size(cell)] = {function, coefficient, exactly(block.depths),
                                                       exactly(block.first_depth)};
    }
}

/// The three texels that a phase function begins with: polynomial and last sample, two lobes.
std::array<vec4, 3> of_phase(const PhaseCurveView& curve) {
    const auto lobe = [&](int k) {
        const PhaseLobe& of = curve.lobe[k];
        return vec4{of.scale, of.offset, of.forward, of.backward};
    };
    return {{{curve.polynomial[0], curve.polynomial[1], curve.polynomial[2], exactly(curve.last)},
             lobe(0),
             lobe(1)}};
}

/// The layers of a stack, four texels each, and samples of their phase functions: first texel,
/// layers, depth of all.
vec4 append_layers(const TableView& view, std::vector<vec4>& numbers) {
    if (!view.is_stack()) return {0, 0, 0, 0};
    const StackLayers& layers = *view.layers;
    const std::size_t first = numbers.size();
    numbers.resize(first + 4 * layers.size());
    double depth = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const StackLayer& layer = layers[k];
        const PhaseCurve curve(layer.phase_function);
        const std::array<vec4, 3> phase = of_phase(curve.view());
        std::copy_n(phase.data(), phase.size(), &numbers[first + 4 * k]);
        numbers[first + 4 * k + 3] = {static_cast<float>(layer.albedo), finite(layer.optical_depth),
                                      exactly(numbers.size()), 0};
        append_phase(curve.view(), 1, numbers);
        depth += layer.optical_depth;
    }
    return {exactly(first), exactly(layers.size()), finite(depth), 0};
}

/// Texels that both sides read: layers of a stack, albedos and the path law.
struct SharedTexels {
    vec4 stack;
    std::size_t of_albedo, first_of_path;
    float path_steps;
};

/// Without what a `bound` layer has no need of, and without the path law where `filtered`, which has it in a
/// texture of its own.
SharedTexels append_shared(const PackedTable& table, bool filtered, bool bound, Texels& to) {
    const PackedSide& side = table.side(Side::reflection);
    const vec4 stack = append_layers(table.view(), to.numbers);
    const std::size_t of_albedo = to.numbers.size();
    for (std::size_t a = 0; !bound && a <= size(static_cast<int>(side.albedo.last)); ++a)
        to.numbers.push_back(
            {side.diffusion_exponent[a], side.inverse_deficit[a], side.deepest_scale[a], 0});
    SharedTexels shared{stack, of_albedo, to.numbers.size(), 0};
    if (side.path.sample == nullptr || filtered) return shared;
    shared.path_steps = side.path_steps;
    append_path(side, to.numbers);
    return shared;
}

/// `max_finite_depth`: that the reflection's factor changes beyond; without functions where `filtered`.
void append_side(const PackedTable& table, Side which, const SharedTexels& shared, bool filtered,
                 float max_finite_depth, Texels& to) {
    const PackedSide& side = table.side(which);
    const TableView view = table.view();
    const bool lit = which == Side::reflection;
    const bool held = lit ? view.has_reflection() : view.has_transmission();
    const bool over_layer = lit && view.has_lower_boundary() && view.lower_boundary->is_layer();
    const PathSheetView& path = table.side(Side::reflection).path;
    const std::size_t phase = to.numbers.size();
    append_phase(side.phase, over_layer ? 2 : 1, to.numbers);
    const std::size_t cells = to.numbers.size();
    if (held && !filtered) append_cells(side, FunctionLayout(view).rows(), to);

    const std::array<vec4, 3> curve = of_phase(side.phase);
    const vec4 record[record_texels] = {
        curve[0],
        curve[1],
        curve[2],
        of_axis(side.albedo, exactly(side.fourth_root_of_albedo)),
        of_axis(side.optical_depth, exactly(side.ends_at_infinity)),
        of_axis(side.mu_in, exactly(side.symmetric)),
        of_axis(side.mu_out, side.divided ? static_cast<float>(side.thin.deeper) : 0),
        {side.azimuth_first, side.azimuth_step_inverse, exactly(side.azimuths),
         exactly(side.square_root_of_azimuth)},
        {side.azimuth_window, side.last_azimuth_window, exactly(side.row_step),
         exactly(side.column_step)},
        {side.min_albedo, side.max_albedo, side.min_depth, max_finite_depth},
        {side.max_depth, exactly(side.divided), exactly(side.over_surface),
         side.extrapolation_length},
        {side.surface_albedo, side.boundary_quarter_albedo, shared.path_steps, path.last_depth},
        {path.offset, exactly(path.first_angle), exactly(path.angles), exactly(path.channel / 2)},
        {exactly(shared.of_albedo), exactly(cells), exactly(phase),
         exactly(shared.first_of_path) - side.path_first * exactly(path.channel / 2)},
        {exactly(held), exactly(view.has_lower_boundary()), side.path_growth,
         exactly(side.functions / 4)},
        shared.stack};
    std::copy_n(record, record_texels, to.numbers.begin() + (lit ? 0 : record_texels));
}

ShaderTexture texture(std::string name, bool halves, const void* data, std::size_t bytes) {
    const std::size_t texel = halves ? 4 * sizeof(Half) : 4 * sizeof(float),
                      row = texel * size(shader_texture_width),
                      height = std::max<std::size_t>(1, (bytes + row - 1) / row);
    ShaderTexture made{std::move(name), static_cast<int>(height), halves,
                       std::vector<char>(height * row)};
    if (bytes > 0) std::memcpy(made.bytes.data(), data, bytes);
    return made;
}

ShaderTexture texture(std::string name, const std::vector<vec4>& texels) {
    return texture(std::move(name), false, texels.data(), texels.size() * sizeof(vec4));
}

}  // namespace

FilteredNumbers filtered_numbers(const PackedTable& table, bool bound) {
    Texels texels;
    texels.numbers.resize(texels.numbers.size() + filter_texels);
    const SharedTexels shared = append_shared(table, true, bound, texels);
    const auto layers = static_cast<std::size_t>(shared.stack.y);
    const std::size_t constants =
        bound ? 2 * record_texels + filter_texels + 4 * layers : shared.first_of_path;
    for (const Side side : both_sides)
        append_side(table, side, shared, true, bound ? table.side(side).max_finite_depth : 1e30f,
                    texels);
    return {texture("stratus_numbers", texels.numbers), static_cast<int>(constants)};
}

std::vector<ShaderTexture> shader_textures(const PackedTable& table) {
    constexpr const char* caller = "shader";
    const TableView view = table.view();
    require(!view.has_family(), caller, "TABLE", "of one phase function: table_at(), --at",
            "one of a family");
    Texels texels;
    for (const Side side : both_sides)
        if (view.has(side)) texels.halves = texels.halves && table.side(side).halves;
    const SharedTexels shared = append_shared(table, false, false, texels);
    for (const Side side : both_sides)
        append_side(table, side, shared, false, table.side(side).max_finite_depth, texels);
    constexpr std::size_t most = std::size_t{1} << 24;  // whole numbers that a float holds
    const std::size_t count = std::max(texels.numbers.size(), texels.function_texels());
    require(count <= most, caller, "texels of TABLE", "at most 16777216", count);
    return {texture("stratus_numbers", texels.numbers),
            texture("stratus_functions", texels.halves, texels.functions.data(),
                    texels.functions.size())};
}

namespace {

constexpr std::size_t layer_record_texels = 8;
constexpr int colours = 3;

/// The orders n >= 2 of a layer that a table knows by law, as a share of those of the nearest sampled one,
/// which the text takes: none where nothing is scattered, and beyond the deepest sample those of diffusion.
double share_by_law(const TableView& table, Side side, double exponent, double albedo,
                    double optical_depth) {
    if (albedo == 0 && !table.keeps_light()) return 0;
    const AxisView& depths = table.optical_depth;
    if (depths.ends_at_infinity || !(optical_depth > depths.highest)) return 1;
    return share_beyond_deepest(side, optical_depth, depths.highest, exponent,
                                table.extrapolation_length);
}

/// The orders n >= 2 of the colours side by side. Returns the first texel.
float append_orders(shader::AsCxx& lookup, const TableView& table, Side side,
                    const Medium<3>& medium, std::vector<vec4>& layer) {
    const std::size_t rows = FunctionLayout(table).rows(), first = layer.size();
    layer.resize(first + rows);
    for (int c = 0; c < colours; ++c) {
        const OrdersOfLayer of =
            orders_of_layer(lookup, rows, side, medium.albedo[c], medium.optical_depth[c]);
        component(layer[size(c)], 2) = of.exponent;
        const auto share = static_cast<float>(share_by_law(
            table, side, double{of.exponent}, medium.albedo[c], medium.optical_depth[c]));
        for (std::size_t row = 0; row < rows; ++row)
            component(layer[first + row], c) = share * of.sum[row];
    }
    return exactly(first);
}

/// Numbers, four to a texel. Returns the first texel.
float append_numbers(const std::vector<float>& numbers, std::vector<vec4>& layer) {
    const std::size_t first = layer.size();
    layer.resize(first + (numbers.size() + 3) / 4);
    for (std::size_t n = 0; n < numbers.size(); ++n)
        component(layer[first + n / 4], static_cast<int>(n % 4)) = numbers[n];
    return exactly(first);
}

void append_density(const DirectionDensity& density, bool one_sided, std::vector<vec4>& layer) {
    // over (row, line, azimuth), and with one more azimuth; over (row, line) with one more line
    const std::size_t lines_in_all = density.along_azimuth().size() - density.samples().size(),
                      azimuths = density.samples().size() / lines_in_all,
                      rows = density.over_lines().size() - lines_in_all,
                      quarter_lines = lines_in_all / rows / 4;
    layer[3].z = append_numbers(density.samples(), layer);
    layer[3].w = append_numbers(density.along_azimuth(), layer);
    const float over_lines = append_numbers(density.over_lines(), layer);
    layer[4] = {over_lines, exactly(density.is_peaked()), exactly(rows), exactly(quarter_lines)};
    layer[5] = {exactly(azimuths), exactly(one_sided), 0, 0};
    for (const Side side : both_sides) {
        const DirectionDensity::Peaks& of = density.peaks(side);
        layer[6 + size(static_cast<int>(side))] = {of.at_same_cosine, of.at_horizon, of.slope,
                                                   of.half_over_bend};
    }
}

}  // namespace

OrdersOfLayer orders_of_layer(shader::AsCxx& lookup, std::size_t rows, Side side, double albedo,
                              double optical_depth) {
    const auto of = lookup.stratus_coefficients(static_cast<int>(side), static_cast<float>(albedo),
                                                finite(optical_depth));
    OrdersOfLayer orders{std::vector<float>(rows), of.exponent};
    const vec4* function = &lookup.functions[size(of.functions)];
    std::vector<vec4> coefficients;
    for (int word = 0; word < of.words; ++word)
        coefficients.push_back(lookup.stratus_coefficients_of_word(of, word));
    for (float& sum : orders.sum)
        for (const vec4& word : coefficients) sum += dot(word, *function++);
    return orders;
}

ShaderTexture shader_layer(const PackedTable& table, const Medium<3>& medium) {
    shader::AsCxx lookup(shader_textures(table));
    return bound_layer(table, medium, lookup);
}

ShaderTexture bound_layer(const PackedTable& table, const Medium<3>& medium,
                          shader::AsCxx& lookup) {
    const TableView view = table.view();
    const RgbSlice slice(view, medium);  // refuses what the table does not know
    require(slice.has_all_directions(), "shader", "TABLE",
            "one of all directions, which are sampled", "one narrowed to some");
    std::vector<vec4> layer(layer_record_texels);
    for (int c = 0; c < colours; ++c)
        layer[size(c)] = {finite(medium.optical_depth[c]), static_cast<float>(medium.albedo[c]), 0,
                          0};
    for (const Side side : both_sides)
        if (view.has(side)) {
            const float first = append_orders(lookup, view, side, medium, layer);
            component(layer[3], static_cast<int>(side)) = first;
        }
    append_density(DirectionDensity(colours, [&](auto... arguments) { slice.eval(arguments...); }),
                   slice.is_one_sided(), layer);
    return texture("stratus_layer", layer);
}

}  // namespace stratus
