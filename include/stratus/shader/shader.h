// Packed tables as shader code: the functions of a lookup in GLSL, HLSL, OSL or C++, one text for all
// tables, and the textures that they read.
//
// The text is src/shader/*.shader, which is C++ as well, after what is each language's own.
// docs/shaders.md has the functions, the layout of the textures, and what is left out.
#pragma once

#include <stratus/bsdf/slice.h>
#include <stratus/table/packed_table.h>

#include <string>
#include <vector>

namespace stratus {

enum class ShaderLanguage { glsl, hlsl, osl, cpp };

/// Names of the languages on the command line, and the endings of their files; in the order of
/// ShaderLanguage.
const std::vector<std::string>& shader_language_names();

/// Texels of the textures to a row: texel n lies in column n % this, row n / this, from the first.
constexpr int shader_texture_width = 2048;

/// RGBA, to be fetched without filtering, but for those of a FilteredLight whose texels are halves.
struct ShaderTexture {
    std::string name;  // of the sampler
    int height;
    bool halves;              // else floats
    std::vector<char> bytes;  // little endian, row by row, zeros beyond the last texel
    int width = shader_texture_width;
    int depth = 0;  // of a 3-D texture
};

/// Texels of a filtered layer's `stratus_layer` that are constants of its text.
constexpr int filtered_layer_constants = 8;

/// Textures that a GPU filters linearly. `stratus_light`, a cubic spline: a 3-D texture over mu_in, mu_out and
/// azimuth, finer than the table's samples, as little as keeps all but one in a thousand of R and T within
/// 2e-3.
///
/// For a bound layer it holds the orders n >= 2 of three colours, reflection before transmission: four fetches,
/// between whose azimuths lines are straight. The path law of narrow peaks takes one more: `stratus_path_law`,
/// a 3-D texture. For layers that are not bound it holds, in each block of optical depths, twelve functions of
/// the directions, four fetched at once; `stratus_weights`, a 2-D texture, has their weights at an albedo and
/// depth: 27 fetches in all. The path law takes four more: eight functions of the scattering angle,
/// `stratus_path_functions`, and their weights, `stratus_path_law`.
struct FilteredLight {
    bool bound;
    /// `stratus_numbers`, whose first `constant_numbers` texels are constants of the text; `stratus_layer`, or
    /// of layers that are not bound `stratus_weights`; `stratus_light`; of a path law its one or two.
    std::vector<ShaderTexture> textures;
    int constant_numbers;
    // Differences to the text without a filter at 5,000 random directions with cosines from 0.02, of
    // layers not bound as many albedos and depths of the table: the median, what all but one in a thousand
    // stay below, the worst. They are relative to R or T, but to no less than 1e-6, of layers not bound 1e-4.
    double median_error, usual_error, worst_error;

    const ShaderTexture& light() const { return textures[2]; }
};

/// The text to include. GLSL: ES 3.00 or 4.50, without a #version. C++17: a header without dependencies
/// that reads the table's own file, in place of textures, and refuses a family. It is the same for all
/// tables, but for the constants of filtered light, which GLSL and HLSL alone can have.
std::string shader_text(ShaderLanguage language, const FilteredLight* filtered = nullptr);

/// The textures of a table: `stratus_numbers`, floats, and `stratus_functions`, halves or floats.
///
/// Errors   std::invalid_argument for a table of a family, of which table_at() (member_and_ground.h) makes
///          one of a member, or of more than 2^24 texels.
std::vector<ShaderTexture> shader_textures(const PackedTable& table);

/// `stratus_layer`, a third texture: one layer, bound, and the density that directions are drawn
/// from (bsdf.h). Of a stack, the stack.
///
/// Errors   those of `shader_textures` and of a Slice; std::invalid_argument for a table that was
///          narrowed to some directions.
ShaderTexture shader_layer(const PackedTable& table, const Medium<3>& medium);

/// Errors   those of `shader_layer`.
FilteredLight filtered_layer(const PackedTable& table, const Medium<3>& medium);

/// Layers of any albedo and optical depth of a table, from pixel to pixel.
///
/// Errors   those of `shader_textures`; std::invalid_argument for a stack, which is one layer.
FilteredLight filtered_layers(const PackedTable& table);

}  // namespace stratus
