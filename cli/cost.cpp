// `stratus cost`: what accuracy costs in time and in bytes, as CSV and as a figure.
#include <stratus/bake/cost.h>

#include <stratus/base/number_text.h>
#include <stratus/picture/plots.h>

#include "options.h"
#include "progress.h"

#include <algorithm>

namespace stratus {
namespace {

using Kind = CostPoint::Kind;
using Role = PlotSeries::Role;

struct CostCommand {
    std::string recipe, output, svg;
    CostOptions options;
    bool quiet = false;
};

/// Draws errors below double precision at it.
PlotPoint plotted(const CostPoint& point, std::string label = "") {
    return {point.cost(), std::max(point.error_99_9, 1e-16), std::move(label)};
}

/// Adds every tolerance's choice; equal choices share a mark.
void add_choice(PlotSeries& series, const CostPoint& point) {
    PlotPoint mark = plotted(point, short_number(point.tolerance));
    for (PlotPoint& other : series.points)
        if (other.x == mark.x && other.y == mark.y) {
            other.label += ", " + mark.label;
            return;
        }
    if (point.kind == Kind::table)
        mark.label += " (" + short_number(point.lookup_ns * 1e-3) + " \u00b5s)";
    series.points.push_back(std::move(mark));
}

/// Adds the points of a kind to a panel: those that no tolerance chose in a series for each axis that
/// was varied, then the frontier and what tolerances chose.
void add_points(PlotPanel& panel, const CostStudy& study, Kind kind) {
    PlotSeries frontier{"frontier", Role::frontier, {}};
    PlotSeries chosen{"chosen by this tolerance", Role::chosen, {}};
    std::vector<CostPoint> points;
    for (const CostPoint& point : study.points)
        if (point.kind == kind) points.push_back(point);
    std::ranges::stable_sort(points, {}, &CostPoint::cost);
    for (const CostPoint& point : points) {
        if (point.on_frontier) frontier.points.push_back(plotted(point));
        if (point.tolerance > 0) {
            add_choice(chosen, point);
            continue;
        }
        const std::string name = point.varied.substr(0, point.varied.find("_samples"));
        auto series = std::ranges::find(panel.series, name, &PlotSeries::name);
        if (series == panel.series.end())
            series = panel.series.insert(series, {name, Role::measured, {}});
        series->points.push_back(plotted(point));
    }
    panel.series.push_back(frontier);
    panel.series.push_back(chosen);
}

void draw_study(const CostStudy& study, const fs::path& svg) {
    PlotPanel solvers{"Solver",
                      "time of one solve, one thread (s)",
                      "relative error of R and T, 99.9 % within",
                      {}};
    PlotPanel tables{"Table: samples along its axes; time of a lookup",
                     "samples of the table in memory, or packed file (bytes)",
                     "relative error of lookups, 99.9 % within",
                     {}};
    add_points(solvers, study, Kind::solver);
    add_points(tables, study, Kind::table);
    PlotSeries packed{"packed, by tolerance", Role::measured, {}};
    for (const CostPoint& point : study.points)
        if (point.kind == Kind::packed) packed.points.push_back(plotted(point));
    tables.series.push_back(packed);
    draw_cost_plot({solvers, tables}, svg);
}

void run_cost(const CostCommand& command) {
    require_writable_answer("cost", command.output);
    if (!command.svg.empty()) require_writable("cost", "--svg", command.svg, {".svg"});
    require_different_files("cost", {command.recipe}, {command.output, command.svg});
    std::vector<std::string> notes;
    const Recipe recipe = read_recipe(command.recipe, &notes);

    Progress progress(command.quiet);
    progress.notes(notes);
    CostOptions options = command.options;
    options.note = [&](const std::string& line) { progress.note("  " + line); };
    options.progress = std::ref(progress);
    const CostStudy study = measure_cost(recipe, options);
    write_answer(command.output, [&](std::ostream& out) { write_cost(out, study.points); });
    if (!command.svg.empty()) write_file(command.svg, std::bind_front(draw_study, study));
}

}  // namespace

void add_cost(CLI::App& app) {
    const auto [command, options] = add_command<CostCommand>(
        app, "cost", "Measure what accuracy costs a recipe in time and bytes", run_cost);
    add_file(command, "RECIPE", options.recipe, "Recipe, .toml")->required();
    add_csv_output(command, options.output);
    add_file(command, "--svg", options.svg,
             "Figure of all points and both frontiers to draw, .svg");
    command
        .add_option("--seconds", options.options.seconds,
                    "After which no measurement starts; they go from cheap to expensive")
        ->capture_default_str()
        ->check(number("above 0", [](double seconds) { return seconds > 0; }));
    add_threads(command, options.options.threads, ". What is timed runs alone on one");
    add_quiet(command, options.quiet);
    std::string columns =
        "Columns of the CSV, a row a point; empty where one does not belong to it:\n";
    for (const auto& [name, meaning] : cost_columns())
        columns += "  " + name + ": " + meaning + "\n";
    command.footer(columns +
                   "Notes tell what each tolerance chose, and what that costs.\n"
                   "Of a family, solvers are those of its most peaked member; tables are of all "
                   "members.\n"
                   "Errors are relative to the total R or T, as `stratus verify` has them.\n"
                   "Example:\n  stratus cost tables/saturn_rings.toml -o cost.csv --svg cost.svg");
}

}  // namespace stratus
