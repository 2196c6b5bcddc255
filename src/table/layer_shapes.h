// The samples of one side of a table divided by all that lookups multiply back (lookup.h): shapes
// that hardly differ from one layer to the next.
#pragma once

#include <stratus/table/table.h>

#include <vector>

namespace stratus {

class LayerShapes {
  public:
    LayerShapes(const TableView& table, Side side);

    const TableView& table() const { return table_; }
    int azimuths() const { return table_.azimuth.count; }

    // Pairs of the cosines along mu_in and mu_out, either way round where the table is symmetric.
    int pairs() const {
        const int cosines = table_.mu_in.count;
        return table_.is_symmetric() ? cosines * (cosines + 1) / 2 : cosines * table_.mu_out.count;
    }
    int pair(int in, int out) const {
        if (!table_.is_symmetric()) return in * table_.mu_out.count + out;
        return in > out ? in * (in + 1) / 2 + out : out * (out + 1) / 2 + in;
    }

    /// One layer over (pair of cosines, every `step`-th azimuth).
    std::vector<float> layer(int albedo, int depth, int step) const;

    /// What an error of a layer's values is to be multiplied by to be relative to R or T; over the
    /// same directions.
    std::vector<float> importance(int albedo, int depth, int step) const;

  private:
    Geometry geometry(int in, int out, int azimuth) const;
    /// How many of mu_out are paired with a sample of mu_in: the first.
    int partners(int in) const { return table_.is_symmetric() ? in + 1 : table_.mu_out.count; }
    double depth_of(int depth) const;

    const TableView& table_;
    const float* samples_;
    const float* weight_;
    Side side_;
    std::vector<double> phase_;  // over (pair, azimuth)
};

}  // namespace stratus
