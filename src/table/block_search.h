// How a packed table's albedos and optical depths are divided into blocks, and its family into members
// that share their functions.
#pragma once

#include <stratus/table/packed_block.h>

#include "layer_sums.h"

#include <algorithm>
#include <vector>

namespace stratus {

// Shares of the tolerance by which the functions of all layers may miss one, those of a block the
// sums of these, and both when they are rounded to halves.
constexpr double sums_share = 0.03, basis_share = 0.28, total_share = 0.5;

/// A block and the cells that it may serve.
struct Candidate {
    SampleRange albedo_cells, depth_cells;
    BlockLayers layers;
    LayerBasis basis;
    double half_error;
    bool holds;  // its errors are within their shares of the tolerance
};

/// Blocks of members that share their functions.
struct FoundBlocks {
    SampleRange members;
    std::vector<Candidate> blocks;

    bool hold() const {
        return std::all_of(blocks.begin(), blocks.end(),
                           [](const Candidate& block) { return block.holds; });
    }
};

/// Members in groups that share their functions: halves that are a group each are joined where that
/// takes fewer blocks.
std::vector<FoundBlocks> grouped_blocks(const LayerSums& sums, const SampleRange& members);

/// The layers that blocks are made of.
std::vector<int> pivot_layers(const std::vector<FoundBlocks>& groups);

}  // namespace stratus
