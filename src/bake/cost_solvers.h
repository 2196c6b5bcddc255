// The cost in time of the solver's errors: nodes x modes x scheme x start against a converged
// solution.
#pragma once

#include "cost_layers.h"
#include "cost_sweep.h"

#include <map>
#include <tuple>
#include <vector>

namespace stratus {

class SolverSweep {
  public:
    SolverSweep(const Recipe& recipe, const CostBudget& budget);

    /// Doubles the nodes until that changes nothing.
    void find_reference();
    int reference_nodes() const { return reference_nodes_; }
    double reference_change() const { return reference_change_; }

    /// Measures the errors of all variants, then their times.
    void sweep();

    /// Adds the solvers that tolerances chose for their tables.
    void measure_chosen(const std::vector<CostPoint>& tables);

    /// Takes the nodes that the recipe's tolerance chose, with ever more orders until those left out
    /// are lost in the error of the nodes.
    std::vector<CostPoint> measure_orders(int nodes) const;

    /// Nodes that solve random points well enough for every tolerance.
    int nodes_of_points() const { return nodes_of_points_; }

    const std::vector<CostPoint>& points() const { return points_; }

  private:
    /// Points that are alike share their time.
    using SolverKey = std::tuple<Scheme, ClassicStart, double, int, int>;
    static SolverKey key_of(const CostPoint& point);

    std::vector<CostPoint> measure_solver(SolverOptions solver, int only_modes = 0) const;
    std::vector<CostPoint> try_solver(const SolverOptions& solver, int only_modes = 0) const;
    void sweep_nodes(const std::vector<SolverOptions>& variants);
    void time(std::vector<CostPoint>& points, double share);

    const Recipe& recipe_;
    const CostBudget& budget_;
    const CostLayers layers_;
    CostLayers::Values reference_;
    int reference_nodes_ = 0;
    double reference_change_ = 0;
    std::vector<CostPoint> points_;
    std::map<SolverKey, double> best_seconds_;
    int nodes_of_points_ = 0;
};

}  // namespace stratus
