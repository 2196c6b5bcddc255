// The cost in bytes of the errors of lookups: how finely each axis of a table is sampled.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>

#include "cost_sweep.h"

#include <functional>
#include <string>
#include <vector>

namespace stratus {

/// Judges as Verification::meets does.
bool keeps_tolerance(double tolerance, const CostPoint& table);

/// An axis whose sampling is swept.
struct SweptAxis {
    std::string name;
    std::function<int&(Discretisation&)> samples;
    int min;
    std::vector<int> counts{};  // of samples to try; none: around those that the tolerance chose
};

class TableSweep {
  public:
    TableSweep(const Recipe& recipe, const CostBudget& budget, int nodes_of_points);

    /// Bakes the recipe's own tolerance, and others around it while time is left.
    void bake_tolerances();

    /// Around what the recipe's tolerance chose: one axis at a time, then all of them together.
    void sweep_axes();

    /// From every tolerance's choice, cheap ones first, as coarse as leaves the table as accurate;
    /// then as coarse as keeps the tolerance. What they end with says which choice was too fine.
    void coarsen_chosen();

    const std::vector<CostPoint>& points() const { return points_; }
    /// The tables that tolerances chose, packed.
    const std::vector<CostPoint>& packed() const { return packed_; }
    /// Nodes that the recipe's tolerance chose.
    int nodes() const { return own_.solver.nodes; }

  private:
    BakeOptions bake_options() const;
    void solve_points(const Discretisation& chosen);
    void find_members(const std::vector<FamilyAxis>& family);
    std::vector<TableView> views_of(const TableView& table) const;
    double time_lookup(const std::vector<TableView>& views) const;
    CostPoint make_point(const Table& table, const Discretisation& d, double seconds);
    CostPoint make_packed(const Table& table, const CostPoint& from);
    void judge_lookups(CostPoint& point, const TableView& table);
    std::vector<double> tolerances() const;
    double bytes_of(const Discretisation& d) const;
    const CostPoint* find_table(Discretisation d) const;
    const CostPoint* measure_table(Discretisation d, const std::string& varied, double share);
    void coarsen(Discretisation now, const std::function<bool(const CostPoint&)>& will_do);

    const Recipe& recipe_;
    const CostBudget& budget_;
    const std::vector<SweptAxis> axes_;
    std::vector<CostPoint> points_, packed_;
    std::vector<ErrorSample> expected_;           // random points; found and error unused
    std::vector<FamilyPoint> members_;            // that they are of
    std::vector<std::size_t> member_of_;          // place of each point's
    std::vector<PhaseFunction> phase_functions_;  // of the members; held: droplets take long
    CostPoint own_;                               // the table that the recipe's tolerance chose
    int nodes_of_points_;                         // that solve the random points
    int finest_nodes_ = 0, finest_modes_ = 0;
    double seconds_per_byte_ = 0;
};

}  // namespace stratus
