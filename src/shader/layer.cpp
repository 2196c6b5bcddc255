#include <stratus/base/argument.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/table/kernels/packed.h>
#include <stratus/table/packed_block.h>

#include "texture_parts.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

namespace stratus {
namespace {

using shader::vec4;

constexpr std::size_t record_texels = 8;
constexpr int colours = 3;

/// The orders n >= 2 of the colours side by side. Returns the first texel.
float append_orders(shader::AsCxx& lookup, std::size_t rows, Side side, const Medium<3>& medium,
                    std::vector<vec4>& layer) {
    const std::size_t first = layer.size();
    layer.resize(first + rows);
    for (int c = 0; c < colours; ++c) {
        const OrdersOfLayer of =
            orders_of_layer(lookup, rows, side, medium.albedo[c], medium.optical_depth[c]);
        component(layer[size(c)], 2) = of.exponent;
        for (std::size_t row = 0; row < rows; ++row) component(layer[first + row], c) = of.sum[row];
    }
    return static_cast<float>(first);
}

/// Numbers, four to a texel. Returns the first texel.
float append_numbers(const std::vector<float>& numbers, std::vector<vec4>& layer) {
    const std::size_t first = layer.size();
    layer.resize(first + (numbers.size() + 3) / 4);
    for (std::size_t n = 0; n < numbers.size(); ++n)
        component(layer[first + n / 4], static_cast<int>(n % 4)) = numbers[n];
    return static_cast<float>(first);
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
    layer[4] = {over_lines, density.is_peaked() ? 1.0f : 0.0f, static_cast<float>(rows),
                static_cast<float>(quarter_lines)};
    layer[5] = {static_cast<float>(azimuths), one_sided ? 1.0f : 0.0f, 0, 0};
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
                                                static_cast<float>(std::min(optical_depth, 1e30)));
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
    std::vector<vec4> layer(record_texels);
    for (int c = 0; c < colours; ++c)
        layer[size(c)] = {static_cast<float>(std::min(medium.optical_depth[c], 1e30)),
                          static_cast<float>(medium.albedo[c]), 0, 0};
    const std::size_t rows = FunctionLayout(view).rows();
    if (view.has_reflection())
        layer[3].x = append_orders(lookup, rows, Side::reflection, medium, layer);
    if (view.has_transmission())
        layer[3].y = append_orders(lookup, rows, Side::transmission, medium, layer);
    append_density(DirectionDensity(colours, [&](auto... arguments) { slice.eval(arguments...); }),
                   slice.is_one_sided(), layer);

    const std::size_t row = sizeof(vec4) * size(shader_texture_width),
                      height = (layer.size() * sizeof(vec4) + row - 1) / row;
    ShaderTexture texture{"stratus_layer", static_cast<int>(height), false,
                          std::vector<char>(height * row)};
    std::memcpy(texture.bytes.data(), layer.data(), layer.size() * sizeof(vec4));
    return texture;
}

}  // namespace stratus
