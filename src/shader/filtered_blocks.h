// Layers of all albedos and depths of a table as sums of twelve functions of the directions, other ones
// in each block of depths: what filtered textures hold of layers that are not bound (multiple.shader).
#pragma once

#include "as_cxx.h"

#include <cstddef>
#include <vector>

namespace stratus {

constexpr std::size_t filtered_words = 3;      // of four functions
constexpr float least_filtered_light = 1e-4f;  // R or T that errors are relative to
constexpr float full_scale =
    2048;  // of weights and functions as halves: small ones keep their digits

inline std::size_t index(int n) { return static_cast<std::size_t>(n); }

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

}  // namespace stratus
