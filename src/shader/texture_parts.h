// The shaders' text as C++, then the textures that it reads.
//
// src/shader/*.shader compiled as C++, on textures in memory.
#pragma once

#include <stratus/base/half.h>
#include <stratus/base/size.h>
#include <stratus/shader/shader.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

namespace stratus::shader {

#include "cpp/vectors.h.in"

using std::abs, std::floor, std::max, std::min, std::sqrt;

inline std::vector<vec4> to_texels(const ShaderTexture& texture) {
    const auto& bytes = texture.bytes;
    const bool halves = texture.halves;
    const std::size_t width = halves ? sizeof(Half) : sizeof(float);
    const auto number = [&](std::size_t n) {
        float value = 0;
        Half half{};
        if (halves)
            std::memcpy(&half, bytes.data() + n * width, width);
        else
            std::memcpy(&value, bytes.data() + n * width, width);
        return halves ? to_float(half) : value;
    };
    std::vector<vec4> texels;
    for (std::size_t n = 0; n < bytes.size() / width; n += 4)
        texels.emplace_back(number(n), number(n + 1), number(n + 2), number(n + 3));
    return texels;
}

#define STRATUS_LAYER

/// The textures that the functions read, and what a language has of its own.
struct Language {
    std::vector<vec4> numbers, functions, layer;

    explicit Language(const std::vector<ShaderTexture>& textures)
        : numbers(to_texels(textures[0])), functions(to_texels(textures[1])) {
        if (textures.size() > 2) layer = to_texels(textures[2]);
    }

    vec4 stratus_number(int texel) { return numbers.at(size(texel)); }
    vec4 stratus_function(int texel) { return functions.at(size(texel)); }
    vec4 stratus_layer_texel(int texel) { return layer.at(size(texel)); }
    float stratus_power_of_two(int n) { return std::ldexp(1.0f, n); }
    int stratus_exponent(float x) { return std::ilogb(x); }
};

/// The functions.
struct AsCxx : Language {
    using Language::Language;

    // clang-format off
#include "single.shader"
#include "multiple.shader"
#include "layer.shader"
    // clang-format on
};

}  // namespace stratus::shader

// Parts of the textures of bound layers and of filtered light.

namespace stratus {

/// Numbers below 2^24 are exact.
template <class Integer>
float exactly(Integer n) {
    return static_cast<float>(n);
}

inline float& component(shader::vec4& texel, int i) {
    float* const all[] = {&texel.x, &texel.y, &texel.z, &texel.w};
    return *all[i];
}

/// `shader_layer` by a lookup in the table's textures.
ShaderTexture bound_layer(const PackedTable& table, const Medium<3>& medium, shader::AsCxx& lookup);

/// The products of a layer's coefficients and the functions, summed: over rows as the functions
/// are. Returns the exponent of diffusion, too.
struct OrdersOfLayer {
    std::vector<float> sum;
    float exponent;
};
OrdersOfLayer orders_of_layer(shader::AsCxx& lookup, std::size_t rows, Side side, double albedo,
                              double optical_depth);

/// Texels of a filtered text's `stratus_numbers` that tell of its other textures (multiple.shader).
constexpr int first_filter_texel = 32, most_filtered_blocks = 24,
              filter_texels = 4 + 2 * most_filtered_blocks;

/// `stratus_numbers` of filtered light: records of both sides, texels of the filter, still empty, and samples
/// of phase functions.
struct FilteredNumbers {
    ShaderTexture texture;
    int constants;
};
FilteredNumbers filtered_numbers(const PackedTable& table, bool bound);

// ---- filtered light

// Layers of all albedos and depths of a table as sums of twelve functions of the directions, other ones in each
// block of depths: what filtered textures hold of layers that are not bound (multiple.shader).

constexpr std::size_t filtered_words = 3;      // of four functions
constexpr float least_filtered_light = 1e-4f;  // R or T that errors are relative to
constexpr float full_scale =
    2048;  // of weights and functions as halves: small ones keep their digits

/// One side.
struct SideBlocks {
    std::vector<shader::vec4> rows;     // over (block, word, row of the table's functions)
    std::vector<shader::vec4> weights;  // over (word, albedo, column)
    std::vector<float> albedos;
    int columns = 0;
    // For the text: a depth, rows of weights from one of the table's albedos to the next; what sums are
    // multiplied by; of each block where it ends, the column at 0 and columns per unit. Empty: the table lacks
    // the side.
    float offset = 1, finer_albedos = 0, unit = 0;
    std::vector<shader::vec4> blocks;
};

/// Scales texels such that the largest number is full_scale. Returns what they are to be multiplied by.
float scale_to_halves(std::vector<shader::vec4>& texels);

std::vector<char> as_halves(const std::vector<shader::vec4>& texels);

/// `numbers`: the text on the numbers of filtered light, whose factors the light is divided by.
///
/// Accuracy  there are as few blocks, up to sixteen, as leave 1e-3 of R or T in random directions,
///           relative to no less than least_filtered_light. Where the table itself `may_jump`
///           from one of its blocks to the next, up to eight of these depths part ours, too.
SideBlocks side_blocks(shader::AsCxx& exact, shader::AsCxx& numbers, std::size_t rows, int side,
                       bool may_jump);

// ---- the path law of narrow peaks for filtered textures: of a bound layer as it is, else as sums of functions
// of the scattering angle, four for R and eight for T (multiple.shader)

/// Textures, and what the text is told. `stratus_path_law` has the law itself over slices, even in excess /
/// (excess + 4), reflection's own the last, and over slant depth.
struct FilteredPath {
    std::vector<ShaderTexture> textures;
    float lost_at_albedo_one, deepest;
    shader::vec4 grid;
};

/// `stratus_path_functions` over (word, angle), and the law over (slice, word, slant depth, albedo) at the
/// functions' own angles, those from which the others follow best.
FilteredPath filtered_path(const TableView& table, const std::vector<float>& albedos);

/// The law of three albedos over (slice, slant depth, angle), every `angle_step`-th of the law's own.
FilteredPath bound_path(const TableView& table, const double (&albedo)[3], int angle_step);

}  // namespace stratus
