#include "cost_solvers.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace stratus {

namespace {

/// Largest change of a converged solution on doubling its nodes.
constexpr double converged = 1e-9;
constexpr int max_reference_nodes = 256;

/// Depths that the classic scheme starts from; 0: its own choice (solve.h).
constexpr double start_depths[] = {0, 1e-3, 1e-6};

/// Solvers that are swept, each over nodes and modes: one for each start of the classic scheme,
/// which counts no orders and takes no lower boundary.
std::vector<SolverOptions> solver_variants(const Recipe& recipe) {
    std::vector<SolverOptions> variants{solver_of(recipe)};
    if (recipe.orders != 0 || recipe.lower_boundary.is_present()) return variants;
    SolverOptions classic = variants.front();
    classic.scheme = Scheme::classic;
    for (const ClassicStart start : {ClassicStart::diamond, ClassicStart::single})
        for (const double start_depth : start_depths) {
            classic.start = start;
            classic.start_depth = start_depth;
            variants.push_back(classic);
        }
    return variants;
}

}  // namespace

SolverSweep::SolverSweep(const Recipe& recipe, const CostBudget& budget)
    : recipe_(recipe), budget_(budget), layers_(recipe, budget.threads()) {}

void SolverSweep::find_reference() {
    budget_.show("converging");
    SolverOptions solver = solver_of(recipe_);
    solver.nodes = 24;
    while (reference_.total.empty()) {
        try {
            reference_ = layers_.values(layers_.solve(solver));
        } catch (const std::runtime_error&) {  // too few nodes
            if (2 * solver.nodes > max_reference_nodes) throw;
            solver.nodes *= 2;
        }
    }
    for (;;) {
        solver.nodes *= 2;
        const auto started = Clock::now();
        CostLayers::Values finer = layers_.values(layers_.solve(solver));
        const double seconds = seconds_since(started);
        CostPoint change;
        set_errors(change, errors_of(reference_, finer));
        reference_ = std::move(finer);
        reference_nodes_ = solver.nodes;
        reference_change_ = change.error_largest;
        constexpr double growth = 16;  // nodes cubed, and as many more modes
        if (change.error_largest <= converged || 2 * solver.nodes > max_reference_nodes ||
            !budget_.is_time_left(share_of_reference, growth * seconds))
            break;
    }
    budget_.say("converged solution: " + std::to_string(reference_nodes_) +
                " nodes; with half of them it is " + short_number(reference_change_) + " off");
}

/// Errors of some nodes with each number of modes that makes a difference; without a number,
/// the numbers of a sweep.
std::vector<CostPoint> SolverSweep::measure_solver(SolverOptions solver, int only_modes) const {
    std::vector<CostPoint> points;
    const CostLayers::Layers layers = layers_.solve(solver);
    auto measure = [&](int modes) {
        CostLayers::Layers kept = layers;
        for (LayerSolution& layer : kept) {
            const auto count =
                std::min(layer.reflection_modes.size(), static_cast<std::size_t>(modes));
            layer.reflection_modes.resize(count);
            layer.transmission_modes.resize(count);
        }
        CostPoint point;
        point.varied = "nodes and modes";
        point.solver = solver;
        point.solver.modes = modes;
        set_errors(point, errors_of(layers_.values(kept), reference_));
        return point;
    };
    if (only_modes) return {measure(only_modes)};
    std::size_t count = 1;
    for (const LayerSolution& layer : layers)
        count = std::max(count, layer.reflection_modes.size());
    const CostPoint all = measure(static_cast<int>(count));
    for (const int modes : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256}) {
        if (modes >= static_cast<int>(count)) {
            points.push_back(all);
            break;
        }
        points.push_back(measure(modes));
        if (points.back().error_largest <= 1.001 * all.error_largest) break;
    }
    return points;
}

/// No points where the solver fails for want of nodes.
std::vector<CostPoint> SolverSweep::try_solver(const SolverOptions& solver, int only_modes) const {
    try {
        return measure_solver(solver, only_modes);
    } catch (const std::runtime_error& reason) {
        budget_.say(reason.what());
        return {};
    }
}

void SolverSweep::sweep() {
    const std::vector<SolverOptions> variants = solver_variants(recipe_);
    sweep_nodes({variants.begin(), variants.begin() + 1});  // the cheapest by far
    // Random points are solved to a hundredth of the finest tolerance that is measured.
    const double enough = 1e-2 * finest_share * recipe_.tolerance;
    for (const CostPoint& point : points_) {
        nodes_of_points_ = point.solver.nodes;
        if (point.error_99_9 <= enough) break;
    }
    sweep_nodes({variants.begin() + 1, variants.end()});
    time(points_, share_of_solver_times);
}

void SolverSweep::sweep_nodes(const std::vector<SolverOptions>& variants) {
    for (const int nodes : {2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128}) {
        if (2 * nodes > reference_nodes_ || !budget_.is_time_left(share_of_solver_errors)) break;
        double min_error = 1;
        for (SolverOptions solver : variants) {
            budget_.show("solving");
            solver.nodes = nodes;
            const std::vector<CostPoint> points = try_solver(solver);
            for (const CostPoint& point : points)
                min_error = std::min(min_error, point.error_largest);
            points_.insert(points_.end(), points.begin(), points.end());
        }
        if (min_error <= converged) break;
    }
}

void SolverSweep::measure_chosen(const std::vector<CostPoint>& tables) {
    std::vector<CostPoint> chosen;
    for (const CostPoint& table : tables) {
        if (table.tolerance == 0) continue;
        if (5 * table.solver.nodes > 4 * reference_nodes_) {
            budget_.say("tolerance " + short_number(table.tolerance) + ": its " +
                        std::to_string(table.solver.nodes) + " nodes are too near the converged " +
                        std::to_string(reference_nodes_) + " to be judged by them");
            continue;
        }
        SolverOptions every_mode = table.solver;
        every_mode.modes = 0;
        for (CostPoint point : try_solver(every_mode, table.solver.modes)) {
            point.varied = table.varied;
            point.tolerance = table.tolerance;
            chosen.push_back(point);
        }
    }
    time(chosen, infinity);
    points_.insert(points_.begin(), chosen.begin(), chosen.end());
    for (CostPoint& point : points_) point.solve_seconds = best_seconds_.at(key_of(point));
}

std::vector<CostPoint> SolverSweep::measure_orders(int nodes) const {
    std::vector<CostPoint> points;
    if (recipe_.orders != 0 || recipe_.lower_boundary.is_present()) return points;
    const auto measure = [&](int orders) {
        CostPoint point;
        point.kind = CostPoint::Kind::orders;
        point.varied = "orders";
        point.solver.nodes = nodes;
        point.solver.orders = orders;
        set_errors(point, errors_of(layers_.values(layers_.solve(point.solver)), reference_));
        return point;
    };
    const double all = measure(0).error_99_9;
    double last = 0;  // seconds
    for (const int orders : {2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 200}) {
        constexpr double growth = 3;  // of a series half as long again
        if (!budget_.is_time_left(share_of_orders, growth * last)) break;
        budget_.show("orders");
        const auto started = Clock::now();
        points.push_back(measure(orders));
        last = seconds_since(started);
        points.back().solve_seconds = layers_.time_solve(points.back().solver);
        if (points.back().error_99_9 <= 1.1 * all) break;
    }
    return points;
}

SolverSweep::SolverKey SolverSweep::key_of(const CostPoint& point) {
    const SolverOptions& of = point.solver;
    return {of.scheme, of.start, of.start_depth, of.nodes, of.modes};
}

/// Several rounds over all points, so that no time is that of one busy moment; drops the points
/// that there is no time for.
void SolverSweep::time(std::vector<CostPoint>& points, double share) {
    auto effort = [](const CostPoint& point) {
        const SolverOptions& of = point.solver;
        return (of.scheme == Scheme::classic ? 10.0 : 1.0) * of.modes * std::pow(of.nodes + 10, 3);
    };
    std::stable_sort(points.begin(), points.end(),
                     [&](const CostPoint& a, const CostPoint& b) { return effort(a) < effort(b); });
    for (int round = 0; round < budget_.rounds(); ++round)
        for (const CostPoint& point : points) {
            if (!budget_.is_time_left(share)) break;
            budget_.show("timing");
            const double seconds = layers_.time_solve(point.solver);
            const auto [entry, is_new] = best_seconds_.try_emplace(key_of(point), seconds);
            entry->second = std::min(entry->second, seconds);
        }
    const auto untimed = std::erase_if(
        points, [&](const CostPoint& point) { return !best_seconds_.count(key_of(point)); });
    if (untimed) budget_.say(std::to_string(untimed) + " solvers left out: no time to time them");
}

}  // namespace stratus
