// Parts of the textures of bound layers and of filtered light.
#pragma once

#include <stratus/shader/shader.h>

#include "as_cxx.h"

#include <cstddef>
#include <vector>

namespace stratus {

inline float& component(shader::vec4& texel, int i) {
    float* const all[] = {&texel.x, &texel.y, &texel.z, &texel.w};
    return *all[i];
}

/// `shader_layer` by a lookup in the table's textures.
ShaderTexture bound_layer(const PackedTable& table, const Medium<3>& medium, shader::AsCxx& lookup);

/// The sixteen products of a layer's coefficients and the functions, summed: over rows as the functions
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

}  // namespace stratus
