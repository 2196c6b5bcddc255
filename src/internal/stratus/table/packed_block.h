// A block of a packed table as its lookups read it (kernels/packed.h): functions of the directions, of which
// its layers are sums, and their coefficients. The functions are a basis chosen greedily from the layers
// themselves, as in reduced-basis methods.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/table/kernels/packed.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace stratus {

struct LayerSums;  // src/table/layer_sums.h

/// Numbers of several layers or functions, each in a vector of its own.
using Vectors = std::vector<std::vector<float>>;

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
    std::size_t room;          // functions in a row of the block
    std::vector<int> pivot;    // layers
    std::vector<double> norm;  // of what was left of a pivot
    Vectors coefficient;       // over layers
    std::vector<double>
        error;  // largest of any layer, relative to R or T, over 0, 1, ... functions

    /// The first `count` functions alone.
    LayerBasis first(std::size_t count) const;
};

/// Adds the layer with the largest error to the basis until all are below `allowed`, or there are
/// as many functions as a row has `room` for.
LayerBasis greedy_basis(const BlockLayers& layers, std::size_t room, double allowed);

/// Samples of an axis, never fewer than a cubic needs: short axes are sampled again on the
/// polynomial through all they have.
struct Resampling {
    int from, to;

    explicit Resampling(int count) : from(count), to(std::max(stencil_size, count)) {}

    /// Resampling along cosines, where a single sample stands for four.
    static Resampling of_directions(int count) {
        Resampling sampling(count);
        if (count == 1) sampling.to = 1;
        return sampling;
    }

    bool is_same() const { return from == to; }
    /// Back to the samples that there were.
    Resampling inverse() const {
        Resampling back(*this);
        std::swap(back.from, back.to);
        return back;
    }

    double weight(int old_sample, int new_sample) const;
    PackedAxis axis(const AxisView& view) const;
};

/// Where the rows of functions of a block lie.
struct FunctionLayout {
    Resampling mu_in, mu_out;
    bool symmetric;
    int azimuth_rows;  // of one (mu, mu')

    explicit FunctionLayout(const TableView& table);

    int row_step() const { return mu_in.to > 1 ? mu_out.to * azimuth_rows : 0; }
    int column_step() const { return mu_out.to > 1 ? azimuth_rows : 0; }
    /// mu' in row i over mu.
    int columns(int i) const { return symmetric ? i + stencil_size : mu_out.to; }
    /// Returns how many rows a whole block has.
    std::size_t rows() const;
};

struct PackedBlock {
    std::vector<float> function;  // over (FunctionLayout::rows(), function)
    Vectors coefficient;          // of each member, over (albedo, depth, function)
    int depths;                   // of the coefficients, infinity included
};

/// The largest error of a layer of a block, relative to R or T at the sketch, by functions that are
/// rounded to halves.
double error_of_halves(const LayerSums& sums, const BlockLayers& layers, const LayerBasis& basis);

PackedBlock packed_block(const LayerSums& sums, const BlockLayers& layers, const LayerBasis& basis);

}  // namespace stratus
