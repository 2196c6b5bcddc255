// The layers of a table as sums of a few functions of the directions, found while looking at most
// layers in a few hundred directions: the sketch.
//
// Some layers, the pilots, are seen in full. Of these the one that the functions so far represent
// worst gives the next function, what is left of it, and adds to the sketch the directions where most
// is left; under a narrow peak random directions alone would miss those that decide. Every layer's
// coefficients then follow from its sketch by least squares. One that misses is seen in full as well.
//
// Layers that are too unlike each other for that (R of very narrow peaks) are sketched in directions spread
// evenly, and those that blocks are made of are seen in full afterwards.
#pragma once

#include <stratus/table/layer_samples.h>
#include <stratus/table/packed_block.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

namespace stratus {

/// The samples of one side of one member of a family, or of the only one, divided by all that lookups multiply
/// back (lookup.h): shapes that hardly differ from one layer to the next. Layers are numbered as LayerSamples
/// has them, over all members.
class LayerShapes {
  public:
    LayerShapes(const Table& table, Side side, std::size_t member);

    const Table& table() const { return table_; }
    const DirectionNumbers& numbers() const { return numbers_; }

    /// False where a sample is too near the end of float's range to be scaled back up: lookups use
    /// that of a higher albedo, or of a thinner layer, in its place.
    bool is_resolved(std::size_t layer) const { return weight(layer) != 0; }

    /// Divides samples at some directions by what lookups multiply back.
    void divide(std::size_t layer, const DirectionList& at, std::vector<float>& samples) const;

    /// Returns the factors that make errors of a layer's shape relative to R or T, but to no less than
    /// a share of the largest, at the same directions; 0 where the layer does not count.
    std::vector<float> importance(std::size_t layer, const DirectionList& at,
                                  const std::vector<float>& shape) const;

  private:
    struct Pair {
        int in, out;
    };

    float weight(std::size_t layer) const;
    /// Returns what samples of a layer and a pair of cosines are multiplied by.
    float weight(std::size_t layer, const Pair& pair) const;
    bool is_forward(std::size_t direction) const;
    double lesser_cosine(std::size_t direction) const;
    float share_of_grazing(std::size_t direction) const;
    /// Calls use(n, pair) for every direction at[n].
    template <class Use>
    void for_each(const DirectionList& at, const Use& use) const;
    PathWeights weights_along_path(double w, double tau, double mu, double other) const;

    const Table& table_;
    DirectionNumbers numbers_;
    Side side_;
    std::vector<Pair> pairs_;             // by number
    std::vector<double> cosine_, phase_;  // of the scattering angle, at every direction
    bool is_peaked_;
    std::shared_ptr<const PathOrders> path_law_;  // null: none
};

/// One side of all layers (numbered as LayerSamples has them).
struct LayerSums {
    std::vector<LayerShapes> shapes;  // of each member of the family, or of the only one
    DirectionList sketch;             // directions
    Vectors function;                 // over all directions
    Vectors coefficient;              // of each layer, over functions
    Vectors values;                   // of each layer: the sum at the sketch
    Vectors importance;               // of each layer: of errors there

    const Table& table() const { return shapes[0].table(); }
    const DirectionNumbers& numbers() const { return shapes[0].numbers(); }
    const LayerShapes& shapes_of(std::size_t layer) const {
        return shapes[layer / table().optical_depth.values.size() / table().albedo.values.size()];
    }

    /// False where there are no functions of all layers: values are then the layers themselves.
    bool is_spanned() const { return !function.empty(); }

    /// A layer at all directions: its sum, or the layer itself if it was seen.
    std::vector<float> in_full(int layer) const;
    std::map<int, std::vector<float>> full;  // shapes of layers that were seen
};

/// Both sides that a table has; none of a side that it has not. `sides`: which are asked for.
///
/// Accuracy  sums miss no layer by more than `allowed`, relative to R or T, where it was looked at.
/// Threads   the same bits however many hand over samples.
PerSide<LayerSums> find_layer_sums(const Table& table, const PerSide<bool>& sides, double allowed,
                                   LayerSamples& samples);

/// Asks for the pivots of each side's blocks at all directions, where layers are no sums; on ranks all call
/// it, once.
void see_in_full(const PerSide<std::map<int, int>>& pivots, PerSide<LayerSums>& sums,
                 LayerSamples& samples);

// ---- how albedos and optical depths are divided into blocks, and a family into members that share their
// functions (block_search.cpp)

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
    std::size_t functions;  // in a row of each
    std::vector<Candidate> blocks;

    std::size_t function_count() const { return blocks.size() * functions; }
    bool hold() const {
        return std::all_of(blocks.begin(), blocks.end(),
                           [](const Candidate& block) { return block.holds; });
    }
};

/// Members in groups that share their functions: halves that are a group each are joined where that
/// takes fewer blocks.
std::vector<FoundBlocks> grouped_blocks(const LayerSums& sums, const SampleRange& members);

/// The layers that blocks are made of, and how many blocks are made of each.
std::map<int, int> pivot_layers(const std::vector<FoundBlocks>& groups);

}  // namespace stratus
