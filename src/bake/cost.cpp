#include <stratus/bake/cost.h>

#include <stratus/bake/axes.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "cost_sweeps.h"
#include "recipe_sections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <ostream>
#include <span>
#include <utility>

namespace stratus {

namespace {

using Kind = CostPoint::Kind;

/// Says what a tolerance chose: its error and its cost beside those of the other points of its kind.
std::string describe(const CostPoint& point, std::span<const CostPoint> others) {
    const std::string error = " error " + short_number(point.error_99_9) + ", ";
    const std::string times = short_number(point.times_frontier) + " times the ";
    const std::string first = "tolerance " + short_number(point.tolerance) + ": ";
    if (point.kind == Kind::solver)
        return first + "solver" + error + std::to_string(point.solver.nodes) + " nodes, " +
               std::to_string(point.solver.modes) + " modes, " +
               short_number(1e3 * point.solve_seconds) + " ms, " + times +
               "time of the cheapest that is as accurate";
    const std::string text = first + (point.kind == Kind::table ? "table" : "packed") + error +
                             short_number(point.bytes * 1e-6, 3) + " MB, " +
                             short_number(point.lookup_ns * 1e-3) + " us a lookup";
    if (point.kind == Kind::packed) return text;
    double least = infinity;
    for (const CostPoint& other : others)
        if (keeps_tolerance(point.tolerance, other)) least = std::min(least, other.bytes);
    return text + ", " + times + "bytes of the cheapest that is as accurate, " +
           (std::isinf(least)
                ? "none keeps it"
                : short_number(point.bytes / least) + " times those of the cheapest that keeps it");
}

// ---- CSV

struct Column {
    std::string name, meaning;
    std::function<std::string(const CostPoint& point)> text;  // empty where the point has none
};

std::string field(const std::string& words) { return words; }
std::string field(double number) { return short_number(number, 6); }
std::string field(int count) { return count > 0 ? std::to_string(count) : ""; }

std::vector<Column> columns() {
    using P = CostPoint;
    using D = Discretisation;
    const auto all = [](auto value) {
        return [value](const P& p) { return field(std::invoke(value, p)); };
    };
    const auto solvers = [](auto value) {
        return [value](const P& p) { return p.kind == Kind::solver ? field(p.*value) : ""; };
    };
    const auto tables = [](auto value) {
        return [value](const P& p) {
            return p.kind == Kind::solver ? "" : field(std::invoke(value, p));
        };
    };
    const auto sampled = [&](int D::*samples) {
        return tables([samples](const P& p) { return p.discretisation.*samples; });
    };
    std::vector<Column> list{
        {"kind", "solver, table or packed", all([](const P& p) {
             constexpr const char* names[] = {"solver", "table", "packed"};
             return std::string(names[static_cast<int>(p.kind)]);
         })},
        {"varied", "tolerance: it chose the point; else what the sweep changed", all(&P::varied)},
        {"tolerance", "that chose the point; empty where none did",
         [](const P& p) { return p.tolerance > 0 ? field(p.tolerance) : ""; }},
        {"nodes", "Gauss nodes of the solver", all([](const P& p) { return p.solver.nodes; })},
        {"modes", "azimuthal modes of the solver", all([](const P& p) { return p.solver.modes; })},
        {"mu_samples", "of mu_in and mu_out alike", sampled(&D::mu_samples)},
        {"azimuth_samples", "over 0 to 180 degrees", sampled(&D::azimuth_samples)},
        {"optical_depth_samples_per_octave", "samples in which the depth doubles",
         sampled(&D::optical_depth_samples_per_octave)},
        {"albedo_samples", "over the recipe's range", sampled(&D::albedo_samples)}};
    for (const PhaseParameter parameter : all_parameters)
        list.push_back({samples_key(parameter), "members along that axis of a family",
                        tables([at = static_cast<std::size_t>(parameter)](const P& p) {
                            return p.members[at];
                        })});
    const std::vector<Column> measured{
        {"error_median", "relative error of half of the values", all(&P::error_median)},
        {"error_99_9", "relative error of 99.9 % of the values; the frontier's",
         all(&P::error_99_9)},
        {"error_largest", "largest relative error", all(&P::error_largest)},
        {"solve_seconds", "one layer, deepest and brightest, 14 cosines, one thread",
         solvers(&P::solve_seconds)},
        {"bake_seconds",
         "all threads; where tolerance chose, with choosing and checking; packed: of packing",
         tables(&P::bake_seconds)},
        {"bytes", "of the samples of both sides in memory; packed: of the file", tables(&P::bytes)},
        {"lookup_ns", "nanoseconds of a lookup at a random point, one thread",
         tables(&P::lookup_ns)},
        {"on_frontier", "1: no other point undercuts it in error and in cost",
         all([](const P& p) { return p.on_frontier ? 1.0 : 0.0; })},
        {"times_frontier", "solve_seconds or bytes over those of the cheapest as accurate",
         all(&P::times_frontier)}};
    list.insert(list.end(), measured.begin(), measured.end());
    return list;
}

}  // namespace

CostStudy measure_cost(const Recipe& recipe, const CostOptions& options) {
    require(options.seconds > 0, "measure_cost", "seconds", "above 0", options.seconds);
    require(recipe.layers.empty(), "measure_cost", "layers", "absent: costs are of one layer",
            recipe.layers.size());
    const CostBudget budget{options};
    const std::vector<CostPoint> tables = measure_tables(recipe, budget);
    CostStudy study =
        measure_solvers(at_member(recipe, corners_by_peak(recipe).front()), tables, budget);
    study.points.insert(study.points.end(), tables.begin(), tables.end());
    for (const Kind kind : {Kind::solver, Kind::table, Kind::packed}) {
        const std::span<CostPoint> points(
            std::ranges::lower_bound(study.points, kind, {}, &CostPoint::kind),
            std::ranges::upper_bound(study.points, kind, {}, &CostPoint::kind));
        compare_with_frontier(points);
        std::vector<CostPoint> chosen;
        std::ranges::copy_if(points, std::back_inserter(chosen),
                             [](const CostPoint& point) { return point.tolerance > 0; });
        std::ranges::sort(chosen, std::greater(), &CostPoint::tolerance);
        for (const CostPoint& point : chosen) budget.say(describe(point, points));
    }
    return study;
}

void compare_with_frontier(std::span<CostPoint> points) {
    for (CostPoint& point : points) {
        double cheapest = point.cost();
        point.on_frontier = true;
        for (const CostPoint& other : points) {
            if (other.error_99_9 > point.error_99_9) continue;
            cheapest = std::min(cheapest, other.cost());
            if (other.cost() < point.cost() ||
                (other.cost() == point.cost() &&
                 (other.error_99_9 < point.error_99_9 || &other < &point)))
                point.on_frontier = false;
        }
        point.times_frontier = point.cost() / cheapest;
    }
}

void write_cost(std::ostream& out, const std::vector<CostPoint>& points) {
    const std::vector<Column> all = columns();
    const auto write_row = [&](const auto& cell) {
        for (const Column& column : all)
            out << cell(column) << (&column == &all.back() ? '\n' : ',');
    };
    write_row([](const Column& column) { return column.name; });
    for (const CostPoint& point : points)
        write_row([&](const Column& column) { return column.text(point); });
}

std::vector<std::pair<std::string, std::string>> cost_columns() {
    std::vector<std::pair<std::string, std::string>> names;
    for (const Column& column : columns()) names.emplace_back(column.name, column.meaning);
    return names;
}

}  // namespace stratus
