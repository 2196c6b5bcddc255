// Functions of the directions of which the layers of a block are sums: a basis chosen greedily from
// the layers themselves, as in reduced-basis methods.
#pragma once

#include <cstddef>
#include <vector>

namespace stratus {

/// Neighbouring samples of an axis.
struct SampleRange {
    int first, count;

    int last() const { return first + count - 1; }
};

/// The layers of a block, at the directions of a sketch (layer_sums.h).
struct BlockLayers {
    SampleRange members;                                        // of a family; else one
    SampleRange albedos, depths;                                // depths: finite ones
    bool and_infinity;                                          // after the depths
    std::vector<int> number;                                    // over (member, albedo, depth)
    std::vector<const std::vector<float>*> values, importance;  // over the same

    int count() const { return static_cast<int>(values.size()); }
    int depth_count() const { return depths.count + (and_infinity ? 1 : 0); }
};

/// Functions that are orthogonal over the block's directions, as sums over layers.
struct LayerBasis {
    std::vector<int> pivot;                       // layers
    std::vector<double> norm;                     // of what was left of a pivot
    std::vector<std::vector<float>> coefficient;  // over layers
    std::vector<double>
        error;  // largest of any layer, relative to R or T, over 0, 1, ... functions

    /// The first `count` functions alone.
    LayerBasis first(std::size_t count) const;
};

/// Adds the layer with the largest error to the basis until all are below `allowed`, or there are
/// as many functions as a lookup sums (packed.h).
LayerBasis greedy_basis(const BlockLayers& layers, double allowed);

}  // namespace stratus
