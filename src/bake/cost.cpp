#include <stratus/bake/cost.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "axes.h"
#include "cost_growth.h"
#include "cost_methods.h"
#include "cost_solvers.h"
#include "cost_sweep.h"
#include "cost_tables.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stratus {

namespace {

/// Times the cost of the cheapest of `others` that is as accurate.
void compare(std::vector<CostPoint>& points, const std::vector<CostPoint>& others) {
    for (CostPoint& point : points) {
        double cheapest = point.cost();
        for (const CostPoint& other : others)
            if (other.error_99_9 <= point.error_99_9) cheapest = std::min(cheapest, other.cost());
        point.times_frontier = point.cost() / cheapest;
    }
}

void judge(std::vector<CostPoint>& points) {
    std::vector<Trade> trades;
    for (const CostPoint& point : points) trades.push_back({point.cost(), point.error_99_9});
    for (const std::size_t at : find_frontier(trades)) points[at].on_frontier = true;
    compare(points, points);
}

void tell_distances(const CostBudget& budget, const std::vector<CostPoint>& solvers,
                    const std::vector<CostPoint>& tables) {
    for (const CostPoint& point : solvers)
        if (point.tolerance > 0)
            budget.say("tolerance " + short_number(point.tolerance) + ": solver error " +
                       short_number(point.error_99_9) + ", " + short_number(point.times_frontier) +
                       " times the time of the cheapest that is as accurate");
    for (const CostPoint& point : tables) {
        if (point.tolerance == 0) continue;
        double min_bytes = infinity;
        for (const CostPoint& other : tables)
            if (keeps_tolerance(point.tolerance, other))
                min_bytes = std::min(min_bytes, other.bytes);
        budget.say("tolerance " + short_number(point.tolerance) + ": table error " +
                   short_number(point.error_99_9) + ", " + short_number(point.times_frontier) +
                   " times the bytes of the cheapest that is as accurate, " +
                   (std::isinf(min_bytes) ? "none keeps it"
                                          : short_number(point.bytes / min_bytes) +
                                                " times those of the cheapest that keeps it"));
    }
}

void append(std::vector<CostPoint>& points, const std::vector<CostPoint>& more) {
    points.insert(points.end(), more.begin(), more.end());
}

}  // namespace

CostStudy measure_cost(const Recipe& recipe, const CostOptions& options) {
    require(options.seconds > 0, "measure_cost", "seconds", "above 0", options.seconds);
    require(options.rounds >= 1, "measure_cost", "rounds", ">= 1", options.rounds);
    require(recipe.layers.empty(), "measure_cost", "layers", "absent: costs are of one layer",
            recipe.layers.size());
    const CostBudget budget(options);
    const Recipe alone = at_member(recipe, corners_by_peak(recipe).front());
    SolverSweep solvers(alone, budget);
    solvers.find_reference();
    solvers.sweep();
    TableSweep tables(recipe, budget, solvers.nodes_of_points());
    tables.bake_tolerances();
    solvers.measure_chosen(tables.points());
    CostStudy study;
    study.growth = time_growth(alone, recipe, budget);
    std::vector<CostPoint> others = solvers.measure_orders(tables.nodes());
    append(others, measure_references(alone, budget, solvers.reference_nodes()));
    append(others, measure_droplets(alone, budget));
    tables.sweep_axes();
    tables.coarsen_chosen();

    study.reference_nodes = solvers.reference_nodes();
    study.reference_change = solvers.reference_change();
    study.points = solvers.points();
    std::vector<CostPoint> of_tables = tables.points(), packed = tables.packed();
    judge(study.points);
    judge(of_tables);
    judge(packed);
    compare(others, study.points);
    tell_distances(budget, study.points, of_tables);
    append(study.points, others);
    append(study.points, of_tables);
    append(study.points, packed);
    const std::vector<GrowthLaw> of_points = find_growth(study.points);
    study.growth.insert(study.growth.end(), of_points.begin(), of_points.end());
    for (const GrowthLaw& law : study.growth) budget.say(sentence_of(law));
    return study;
}

std::vector<std::size_t> find_frontier(const std::vector<Trade>& trades) {
    std::vector<std::size_t> order(trades.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(trades[a].cost, trades[a].error) <
               std::pair(trades[b].cost, trades[b].error);
    });
    std::vector<std::size_t> frontier;
    for (const std::size_t at : order)
        if (frontier.empty() || trades[at].error < trades[frontier.back()].error)
            frontier.push_back(at);
    return frontier;
}

}  // namespace stratus
