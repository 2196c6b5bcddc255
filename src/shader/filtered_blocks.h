// Layers of all albedos and depths of a table as sums of twelve functions of the directions, other ones
// in each block of depths: what filtered textures hold of layers that are not bound (multiple.shader).
#pragma once

#include "as_cxx.h"

#include <cstddef>
#include <vector>

namespace stratus {

constexpr int filtered_words = 3;  // of four functions
constexpr int most_filtered_blocks = 16, filtered_depth_steps = 96;
constexpr float least_filtered_light = 1e-4f;  // R or T that errors are relative to

/// One side.
struct SideBlocks {
    int blocks = 0;                     // 0: the table lacks the side
    std::vector<shader::vec4> rows;     // over (block, word, row of the table's functions)
    std::vector<shader::vec4> weights;  // over (word, albedo, column)
    int albedos = 0, columns = 0;
    // For the text: a depth, rows of weights from one of the table's albedos to the next; first coordinate
    // of the depth, steps per unit of it, the last step of each block, what sums are multiplied by.
    float offset = 1, finer_albedos = 0, first = 0, steps_per_unit = 0, unit = 0;
    std::vector<float> last_step;
};

/// `numbers`: the text on the numbers of filtered light, whose factors the light is divided by.
///
/// Accuracy  there are as few blocks, up to sixteen, as leave 1e-3 of R or T in random directions,
///           relative to no less than least_filtered_light.
SideBlocks side_blocks(shader::AsCxx& exact, shader::AsCxx& numbers, std::size_t rows, int side);

}  // namespace stratus
