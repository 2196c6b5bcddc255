// The two sweeps of `measure_cost`, and the seconds that they share.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/clock.h>
#include <stratus/bake/cost.h>

#include <algorithm>
#include <vector>

namespace stratus {

/// The seconds asked for, counted from its construction.
struct CostBudget {
    const CostOptions& options;
    Clock::time_point started = Clock::now();

    /// Returns whether `needed` seconds from now are within that share of the budget.
    bool is_time_left(double share, double needed = 0) const {
        return seconds_since(started) + needed < share * options.seconds;
    }
    void say(const std::string& line) const {
        if (options.note) options.note(line);
    }
    void show(const char* stage) const {
        if (options.progress)
            options.progress(std::min(0.999, seconds_since(started) / options.seconds), stage);
    }
};

/// Solves random points of the recipe's own ranges: the same ones with every solver.
std::vector<ErrorSample> solve_cost_points(const Recipe& recipe, const SolverOptions& solver,
                                           int count, const CostBudget& budget);

/// Sorts the samples by error.
void set_errors(CostPoint& point, std::vector<ErrorSample>& samples);

/// Judges as Verification::meets does.
bool keeps_tolerance(double tolerance, const CostPoint& table);

/// Measures how finely each axis of a table is sampled: tables, then those that tolerances chose,
/// packed.
std::vector<CostPoint> measure_tables(const Recipe& recipe, const CostBudget& budget);

/// Measures nodes x modes against a converged solution, and among them what tolerances chose for
/// `tables`. The recipe has no family.
CostStudy measure_solvers(const Recipe& recipe, const std::vector<CostPoint>& tables,
                          const CostBudget& budget);

}  // namespace stratus
