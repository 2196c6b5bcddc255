// The samples of one side of a table divided by all that lookups multiply back (lookup.h): shapes
// that hardly differ from one layer to the next.
#pragma once

#include <stratus/table/layer_samples.h>
#include <stratus/table/table.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace stratus {

/// DirectionList of a side, by their numbers, ascending.
using DirectionList = std::vector<std::size_t>;

/// The layers of one member of a family, or of the only one.
class LayerShapes {
  public:
    LayerShapes(const Table& table, Side side, int member);

    const Table& table() const { return table_; }
    const DirectionNumbers& numbers() const { return numbers_; }

    /// False where a sample is too near the end of float's range to be scaled back up: lookups use
    /// that of a higher albedo, or of a thinner layer, in its place.
    bool is_resolved(int albedo, int depth) const { return weight(albedo, depth) != 0; }

    /// Divides samples at some directions by what lookups multiply back.
    void divide(int albedo, int depth, const DirectionList& at, std::vector<float>& samples) const;

    /// Returns the factors that make errors of a layer's shape relative to R or T, but to no less than
    /// a share of the largest, at the same directions; 0 where the layer does not count.
    std::vector<float> importance(int albedo, int depth, const DirectionList& at,
                                  const std::vector<float>& shape) const;

  private:
    struct Pair {
        int in, out;
    };

    float weight(int albedo, int depth) const;
    /// Returns what samples of a layer and a pair of cosines are multiplied by.
    float weight(int albedo, int depth, const Pair& pair) const;
    bool is_forward(std::size_t direction) const;
    double lesser_cosine(std::size_t direction) const;
    float share_of_grazing(std::size_t direction) const;
    /// Calls use(n, pair) for every direction at[n].
    template <class Use>
    void for_each(const DirectionList& at, const Use& use) const;
    PathWeights weights_along_path(double w, double tau, double mu, double other) const;
    /// Calls use(n, factor, total) for every direction at[n]: what its sample was divided by, and R or
    /// T.
    template <class Use>
    void for_each_total(int albedo, int depth, const DirectionList& at,
                        const std::vector<float>& shape, const Use& use) const;

    const Table& table_;
    DirectionNumbers numbers_;
    Side side_;
    int member_;
    std::vector<Pair> pairs_;                     // by number
    std::vector<double> cosine_, phase_;          // of the scattering angle, at every direction
    std::shared_ptr<const PathOrders> path_law_;  // null: none
};

}  // namespace stratus
