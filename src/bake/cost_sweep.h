// The state that sweeps of `measure_cost` share: the seconds they may take, and how errors are summed up.
#pragma once

#include <stratus/bake/clock.h>
#include <stratus/bake/cost.h>

#include <string>
#include <vector>

namespace stratus {

/// Parts of the seconds after which a stage begins nothing new.
constexpr double share_of_reference = 0.1, share_of_solver_errors = 0.2,
                 share_of_solver_times = 0.4, share_of_tolerances = 0.62, share_of_orders = 0.67,
                 share_of_references = 0.71, share_of_droplets = 0.75, share_of_axes = 0.87;

/// Tolerances finer than this share of the recipe's own are not measured.
constexpr double finest_share = 0.25;

/// The seconds asked for, counted from its construction.
class CostBudget {
  public:
    explicit CostBudget(const CostOptions& options) : options_(options) {}

    /// Whether `needed` seconds from now are within that share of the budget.
    bool is_time_left(double share, double needed = 0) const;

    void say(const std::string& line) const;
    void show(const char* stage) const;
    int rounds() const { return options_.rounds; }
    int threads() const { return options_.threads; }

  private:
    const CostOptions& options_;
    const Clock::time_point started_ = Clock::now();
};

/// Returns the recipe's options of the solver.
SolverOptions solver_of(const Recipe& recipe);

void set_errors(CostPoint& point, std::vector<double> errors);

}  // namespace stratus
