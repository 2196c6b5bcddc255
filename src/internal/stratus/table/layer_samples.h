// The samples of a table's layers, as packing asks for them (packed_table.h): of every layer at a few
// directions, of a few layers at all. A bake solves them when they are asked for; a table that holds
// them all hands them over. Whoever asks never needs all samples at once.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/base/size.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

namespace stratus {

/// Directions of a side, by their numbers.
using DirectionList = std::vector<std::size_t>;

/// The directions of one side of a table, numbered: pairs of cosines, azimuths fastest. Where both
/// ways have the same values (TableView::is_symmetric) a pair stands for both, and mu_in is the
/// cosine whose sample comes later.
class DirectionNumbers {
  public:
    explicit DirectionNumbers(const TableView& table)
        : ins_(table.mu_in.count),
          outs_(table.mu_out.count),
          azimuths_(table.azimuth.count),
          symmetric_(table.is_symmetric()) {}

    bool is_symmetric() const { return symmetric_; }
    int ins() const { return ins_; }
    int azimuths() const { return azimuths_; }
    /// How many samples of mu_out are paired with one of mu_in: the first.
    int partners(int in) const { return symmetric_ ? in + 1 : outs_; }
    std::size_t pair(int in, int out) const {
        if (!symmetric_) return size(in) * size(outs_) + size(out);
        const auto [sooner, later] = std::minmax({size(in), size(out)});
        return later * (later + 1) / 2 + sooner;
    }
    std::size_t pairs() const { return pair(ins_ - 1, symmetric_ ? ins_ - 1 : outs_ - 1) + 1; }
    std::size_t count() const { return pairs() * size(azimuths_); }
    DirectionList all() const {
        DirectionList directions(count());
        std::iota(directions.begin(), directions.end(), std::size_t{0});
        return directions;
    }

    /// Returns where ascending directions lie among the samples of a layer, over (mu_in, mu_out,
    /// azimuth).
    std::vector<std::size_t> positions(const DirectionList& directions) const {
        const auto outs = size(outs_);
        const auto azimuths = size(azimuths_);
        std::vector<std::size_t> found;
        found.reserve(directions.size());
        int in = 0, out = 0;
        for (const std::size_t direction : directions) {
            while (pair(in, out) < direction / azimuths)
                if (++out == partners(in)) {
                    ++in;
                    out = 0;
                }
            const std::size_t row = size(in) * outs;
            found.push_back((row + size(out)) * azimuths + direction % azimuths);
        }
        return found;
    }

  private:
    int ins_, outs_, azimuths_;
    bool symmetric_;
};

/// Layers are numbered like the samples of a table: member of the family, albedo, optical depth.
class LayerSamples {
  public:
    /// Receives the samples of a layer's side, the orders n >= 2 that the table holds.
    ///
    /// Threads  called by several at once, for each layer and side once.
    using Use = std::function<void(int layer, Side side, std::vector<float> samples)>;

    virtual ~LayerSamples() = default;

    /// False where another rank (bake/ranks.h) asks, receives the samples and packs them: this one
    /// only solves.
    virtual bool is_first_rank() const { return true; }

    /// Some layers at all directions of the sides that the table has. Returns how many layers these
    /// are: on ranks, those that the first asks for.
    virtual int in_full(std::vector<int> layers, const Use& use) = 0;

    /// All layers at some directions of either side, ascending; none of a side hands over nothing.
    virtual void at(const PerSide<DirectionList>& directions, const Use& use) = 0;

    /// Called where packing has freed much memory: a baker hands it back to the system.
    virtual void trim_memory() {}
};

}  // namespace stratus
