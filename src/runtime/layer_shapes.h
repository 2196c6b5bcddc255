// The samples of one side of a table divided by all that lookups multiply back (lookup.h): shapes
// that hardly differ from one layer to the next.
#pragma once

#include <stratus/runtime/table.h>

#include <vector>

namespace stratus {

class LayerShapes {
  public:
    LayerShapes(const TableView& table, Side side);

    const TableView& table() const { return table_; }
    int azimuths() const { return table_.azimuth.count; }
    int pairs() const { return table_.mu_in.count * (table_.mu_in.count + 1) / 2; }

    static int pair(int i, int j) { return i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

    /// One layer over (pair of cosines, every `step`-th azimuth).
    std::vector<float> layer(int albedo, int depth, int step) const;

    /// What an error of a layer's values is to be multiplied by to be relative to R or T; over the
    /// same directions.
    std::vector<float> importance(int albedo, int depth, int step) const;

  private:
    Geometry geometry(int i, int j, int k) const;
    double depth_of(int depth) const;

    const TableView& table_;
    const float* samples_;
    const float* weight_;
    Side side_;
    std::vector<double> phase_;  // over (pair, azimuth)
};

}  // namespace stratus
