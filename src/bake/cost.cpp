#include <stratus/bake/cost.h>

#include <stratus/bake/axes.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "cost_sweeps.h"
#include "family_section.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <ostream>
#include <span>
#include <utility>

namespace stratus {

namespace {

using Kind = CostPoint::Kind;

void judge(std::span<CostPoint> points) {
    std::vector<Trade> trades;
    for (const CostPoint& point : points) trades.push_back({point.cost(), point.error_99_9});
    for (const std::size_t at : find_frontier(trades)) points[at].on_frontier = true;
    for (CostPoint& point : points) {
        double cheapest = point.cost();
        for (const Trade& other : trades)
            if (other.error <= point.error_99_9) cheapest = std::min(cheapest, other.cost);
        point.times_frontier = point.cost() / cheapest;
    }
}

/// Says what a tolerance chose: its error and its cost beside those of the other points of its kind.
std::string sentence_of(const CostPoint& point, std::span<const CostPoint> others) {
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

enum class Holders { all, solvers, tables };

struct Column {
    std::string name, meaning;
    Holders holders;  // kinds of points that have it; empty for others
    std::function<std::string(const CostPoint& point)> text;
};

std::string field(const std::string& words) { return words; }
std::string field(double number) { return short_number(number, 6); }
std::string field(int count) { return count > 0 ? std::to_string(count) : ""; }

template <class Value>
Column column(std::string name, std::string meaning, Holders holders, Value value) {
    return {std::move(name), std::move(meaning), holders,
            [value](const CostPoint& p) { return field(std::invoke(value, p)); }};
}

std::vector<Column> columns() {
    using P = CostPoint;
    using D = Discretisation;
    using enum Holders;
    const auto sampled = [](int D::*samples) {
        return [samples](const P& p) { return p.discretisation.*samples; };
    };
    const auto kind = [](const P& p) -> std::string {
        return p.kind == Kind::solver ? "solver" : p.kind == Kind::table ? "table" : "packed";
    };
    const auto tolerance = [](const P& p) { return p.tolerance > 0 ? field(p.tolerance) : ""; };
    std::vector<Column> list{
        column("kind", "solver, table or packed", all, kind),
        column("varied", "tolerance: it chose the point; else what the sweep changed", all,
               &P::varied),
        column("tolerance", "that chose the point; empty where none did", all, tolerance),
        column("nodes", "Gauss nodes of the solver", all,
               [](const P& p) { return p.solver.nodes; }),
        column("modes", "azimuthal modes of the solver", all,
               [](const P& p) { return p.solver.modes; }),
        column("mu_samples", "of mu_in and mu_out alike", tables, sampled(&D::mu_samples)),
        column("azimuth_samples", "over 0 to 180 degrees", tables, sampled(&D::azimuth_samples)),
        column("optical_depth_samples_per_octave", "samples in which the depth doubles", tables,
               sampled(&D::optical_depth_samples_per_octave)),
        column("albedo_samples", "over the recipe's range", tables, sampled(&D::albedo_samples))};
    for (const PhaseParameter parameter : all_parameters)
        list.push_back(column(
            samples_key(parameter), "members along that axis of a family", tables,
            [at = static_cast<std::size_t>(parameter)](const P& p) { return p.members[at]; }));
    for (const Column& measured :
         {column("error_median", "relative error of half of the values", all, &P::error_median),
          column("error_99_9", "relative error of 99.9 % of the values; the frontier's", all,
                 &P::error_99_9),
          column("error_largest", "largest relative error", all, &P::error_largest),
          column("solve_seconds", "one layer, deepest and brightest, 14 cosines, one thread",
                 solvers, &P::solve_seconds),
          column("bake_seconds",
                 "all threads; where tolerance chose, with choosing and checking; packed: of "
                 "packing",
                 tables, &P::bake_seconds),
          column("bytes", "of the samples of both sides in memory; packed: of the file", tables,
                 &P::bytes),
          column("lookup_ns", "nanoseconds of a lookup at a random point, one thread", tables,
                 &P::lookup_ns),
          column("on_frontier", "1: no other point undercuts it in error and in cost", all,
                 [](const P& p) { return p.on_frontier ? 1.0 : 0.0; }),
          column("times_frontier", "solve_seconds or bytes over those of the cheapest as accurate",
                 all, &P::times_frontier)})
        list.push_back(measured);
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
        judge(points);
        std::vector<CostPoint> chosen;
        std::ranges::copy_if(points, std::back_inserter(chosen),
                             [](const CostPoint& point) { return point.tolerance > 0; });
        std::ranges::sort(chosen, std::greater(), &CostPoint::tolerance);
        for (const CostPoint& point : chosen) budget.say(sentence_of(point, points));
    }
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

void write_cost(std::ostream& out, const std::vector<CostPoint>& points) {
    const std::vector<Column> all = columns();
    for (const Column& column : all) out << (&column == &all.front() ? "" : ",") << column.name;
    out << '\n';
    for (const CostPoint& point : points) {
        for (const Column& column : all) {
            out << (&column == &all.front() ? "" : ",");
            const auto others = point.kind == Kind::solver ? Holders::tables : Holders::solvers;
            if (column.holders != others) out << column.text(point);
        }
        out << '\n';
    }
}

std::vector<std::pair<std::string, std::string>> cost_columns() {
    std::vector<std::pair<std::string, std::string>> names;
    for (const Column& column : columns()) names.emplace_back(column.name, column.meaning);
    return names;
}

}  // namespace stratus
