#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/transfer/solve.h>

#include "cost_sweeps.h"

#include <cmath>
#include <stdexcept>

namespace stratus {

namespace {

/// Largest change of a converged solution on doubling its nodes.
constexpr double converged = 1e-9;
constexpr int max_reference_nodes = 256;

constexpr int solver_points = 800;

/// Part of the seconds after which the reference is made no finer.
constexpr double share_of_reference = 0.85;

class SolverSweep {
  public:
    SolverSweep(const Recipe& recipe, const CostBudget& budget)
        : recipe_(recipe), budget_(budget) {}

    /// Doubles the nodes until that changes nothing.
    void find_reference() {
        for (int nodes = 24; nodes <= max_reference_nodes; nodes *= 2) {
            constexpr double growth = 16;  // nodes cubed, and as many more modes
            const auto started = Clock::now();
            std::vector<ErrorSample> finer;
            try {
                finer = solve(solver_with(nodes));
            } catch (const std::runtime_error&) {  // too few nodes
                if (2 * nodes > max_reference_nodes) throw;
                continue;
            }
            const bool is_first = reference_.empty();
            reference_.swap(finer);
            study_.reference_nodes = nodes;
            if (is_first) continue;
            compare(finer);
            study_.reference_change = error_quantile(finer, 1);
            if (study_.reference_change <= converged ||
                !budget_.is_time_left(share_of_reference, growth * seconds_since(started)))
                break;
        }
        budget_.say("converged solution: " + std::to_string(study_.reference_nodes) +
                    " nodes; with half of them it is " + short_number(study_.reference_change) +
                    " off");
    }

    void measure_chosen(const std::vector<CostPoint>& tables) {
        for (const CostPoint& table : tables) {
            if (table.tolerance == 0 || table.kind != CostPoint::Kind::table) continue;
            if (5 * table.solver.nodes > 4 * study_.reference_nodes) {
                budget_.say("tolerance " + short_number(table.tolerance) + ": its " +
                            std::to_string(table.solver.nodes) +
                            " nodes are too near the converged " +
                            std::to_string(study_.reference_nodes) + " to be judged by them");
                continue;
            }
            measure(table.solver);
            study_.points.back().varied = table.varied;
            study_.points.back().tolerance = table.tolerance;
        }
    }

    void sweep() {
        double last = 0;  // seconds
        for (const int nodes : {2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128}) {
            constexpr double growth = 2;
            if (2 * nodes > study_.reference_nodes || !budget_.is_time_left(1, growth * last))
                break;
            const auto started = Clock::now();
            if (sweep_modes(solver_with(nodes)) <= converged) break;
            last = seconds_since(started);
        }
    }

    CostStudy study() { return std::move(study_); }

  private:
    SolverOptions solver_with(int nodes) const {
        SolverOptions solver;
        solver.orders = recipe_.orders;
        solver.nodes = nodes;
        return solver;
    }

    std::vector<ErrorSample> solve(const SolverOptions& solver) const {
        budget_.show("solving");
        return solve_cost_points(recipe_, solver, solver_points, budget_);
    }

    /// Sets the errors of solved points against the reference.
    void compare(std::vector<ErrorSample>& found) const {
        for (std::size_t n = 0; n < found.size(); ++n)
            found[n].error = std::abs(found[n].expected - reference_[n].expected) /
                             std::max(reference_[n].expected, reference_[n].floor);
    }

    /// Solves the deepest and brightest layer at 14 cosines.
    LayerSolution solve_deepest(const SolverOptions& solver) const {
        std::vector<double> mu = floor_cosines();
        for (const double x : {0.05, 0.14, 0.22, 0.3, 0.36, 0.5, 0.64, 0.75, 0.82, 0.96})
            mu.push_back(x * x);
        return solve_layer(recipe_.phase_function, recipe_.albedo.max, recipe_.optical_depth.max,
                           mu, solver, recipe_.lower_boundary);
    }

    /// Points that are alike share their time, the best of some.
    double time_solve(const SolverOptions& solver) const {
        for (const CostPoint& point : study_.points)
            if (point.solver.nodes == solver.nodes && point.solver.modes == solver.modes &&
                point.solver.scheme == solver.scheme)
                return point.solve_seconds;
        constexpr double enough = 2e-2;
        double best = infinity;
        for (const auto begun = Clock::now(); seconds_since(begun) < enough;) {
            const double started = processor_seconds();
            solve_deepest(solver);
            best = std::min(best, processor_seconds() - started);
        }
        return best;
    }

    /// Adds a point and returns its largest error.
    double measure(const SolverOptions& solver) {
        CostPoint point;
        point.varied = "nodes and modes";
        point.solver = solver;
        std::vector<ErrorSample> found = solve(solver);
        compare(found);
        set_errors(point, found);
        point.solve_seconds = time_solve(solver);
        study_.points.push_back(point);
        return point.error_largest;
    }

    /// Measures some nodes with each number of modes that makes a difference. Returns the largest
    /// error with all modes, or 1 where the solver fails for want of nodes.
    double sweep_modes(SolverOptions solver) {
        try {
            const auto all = static_cast<int>(solve_deepest(solver).reflection_modes.size());
            solver.modes = std::max(1, all);
            const double least = measure(solver);
            for (int modes = 1; modes < all; modes += std::max(1, modes / 2)) {
                solver.modes = modes;
                if (measure(solver) <= 1.001 * least) break;
            }
            return least;
        } catch (const std::runtime_error& reason) {
            budget_.say(reason.what());
            return 1;
        }
    }

    const Recipe& recipe_;
    const CostBudget& budget_;
    std::vector<ErrorSample> reference_;
    CostStudy study_;
};

}  // namespace

CostStudy measure_solvers(const Recipe& recipe, const std::vector<CostPoint>& tables,
                          const CostBudget& budget) {
    SolverSweep sweep(recipe, budget);
    sweep.find_reference();
    sweep.measure_chosen(tables);
    sweep.sweep();
    return sweep.study();
}

}  // namespace stratus
