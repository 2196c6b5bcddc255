// `stratus cost`: what accuracy costs in time and in bytes, as CSV and as a figure.
#include <stratus/bake/cost.h>

#include <stratus/base/number_text.h>
#include <stratus/io/atomic_file.h>
#include <stratus/phase/phase_family.h>
#include <stratus/picture/cost_plot.h>

#include "allowed.h"
#include "commands.h"
#include "progress.h"
#include "query.h"
#include "signals_held.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

struct CostCommand {
    std::string recipe, output, svg;
    CostOptions options;
    bool quiet = false;
};

std::string tolerance_text(double tolerance) {
    const int exponent = static_cast<int>(std::floor(std::log10(tolerance) + 1e-9));
    return shortest_text(std::round(100 * tolerance / std::pow(10, exponent)) / 100) + "e" +
           std::to_string(exponent);
}

std::string lookup_text(const CostPoint& point) {
    if (point.lookup_ns == 0) return "";
    return short_number(point.lookup_ns * 1e-3) + " \u00b5s";
}

/// Errors below double precision are drawn at it.
PlotPoint plotted(const CostPoint& point, std::string label) {
    return {point.cost(), std::max(point.error_99_9, 1e-16), std::move(label)};
}

/// Every tolerance's choice; equal choices share a mark.
PlotSeries chosen_by_tolerance(const std::vector<const CostPoint*>& points) {
    PlotSeries series{"chosen by tolerance (beside it)", PlotSeries::Role::chosen, {}};
    for (const CostPoint* point : points) {
        if (point->tolerance == 0) continue;
        PlotPoint mark = plotted(*point, tolerance_text(point->tolerance));
        const auto same = std::find_if(
            series.points.begin(), series.points.end(),
            [&](const PlotPoint& other) { return other.x == mark.x && other.y == mark.y; });
        if (same != series.points.end()) {
            same->label += ", " + mark.label;
            continue;
        }
        if (point->kind == CostPoint::Kind::table) mark.label += " (" + lookup_text(*point) + ")";
        series.points.push_back(std::move(mark));
    }
    return series;
}

PlotSeries frontier_of(const std::vector<const CostPoint*>& points, const char* name) {
    std::vector<const CostPoint*> on_it;
    for (const CostPoint* point : points)
        if (point->on_frontier) on_it.push_back(point);
    std::sort(on_it.begin(), on_it.end(),
              [](const CostPoint* a, const CostPoint* b) { return a->cost() < b->cost(); });
    PlotSeries series{name, PlotSeries::Role::frontier, {}};
    double labelled = 0;  // bytes; the next label is where they have doubled
    for (const CostPoint* point : on_it) {
        const bool is_due = point->tolerance == 0 && point->cost() >= 2 * labelled;
        if (is_due) labelled = point->cost();
        series.points.push_back(plotted(*point, is_due ? lookup_text(*point) : ""));
    }
    return series;
}

/// Points of another kind beside those of a panel; `label` of each.
PlotSeries series_of(const CostStudy& study, const char* name,
                     bool (*holds)(const CostPoint& point),
                     std::string (*label)(const CostPoint& point)) {
    PlotSeries series{name, PlotSeries::Role::measured, {}};
    for (const CostPoint& point : study.points)
        if (holds(point)) series.points.push_back(plotted(point, label(point)));
    return series;
}

/// A series of a panel: points that no tolerance chose.
struct Group {
    const char* name;
    bool (*holds)(const CostPoint& point);
};

PlotPanel make_panel(const CostStudy& study, CostPoint::Kind kind, const char* frontier,
                     const std::vector<Group>& groups) {
    std::vector<const CostPoint*> points;
    for (const CostPoint& point : study.points)
        if (point.kind == kind) points.push_back(&point);
    PlotPanel panel;
    for (const Group& group : groups) {
        panel.series.push_back({group.name, PlotSeries::Role::measured, {}});
        for (const CostPoint* point : points)
            if (point->tolerance == 0 && group.holds(*point))
                panel.series.back().points.push_back(plotted(*point, ""));
    }
    panel.series.push_back(frontier_of(points, frontier));
    panel.series.push_back(chosen_by_tolerance(points));
    return panel;
}

bool starts(const CostPoint& point, ClassicStart start) {
    return point.solver.scheme == Scheme::classic && point.solver.start == start;
}

PlotPanel panel_of_solvers(const CostStudy& study) {
    PlotPanel panel =
        make_panel(study, CostPoint::Kind::solver, "frontier",
                   {{"harmonic doubling",
                     [](const CostPoint& p) { return p.solver.scheme == Scheme::harmonic; }},
                    {"classic, diamond start",
                     [](const CostPoint& p) { return starts(p, ClassicStart::diamond); }},
                    {"classic, single start",
                     [](const CostPoint& p) { return starts(p, ClassicStart::single); }}});
    panel.title = "Solver: nodes, modes, scheme and start; orders; reference methods";
    const auto no_label = [](const CostPoint&) { return std::string(); };
    panel.series.push_back(series_of(
        study, "first n orders (n beside it)",
        [](const CostPoint& p) { return p.kind == CostPoint::Kind::orders; },
        [](const CostPoint& p) { return std::to_string(p.solver.orders); }));
    panel.series.push_back(series_of(
        study, "Markov chains", [](const CostPoint& p) { return p.sublayers > 0; }, no_label));
    panel.series.push_back(series_of(
        study, "photons", [](const CostPoint& p) { return p.photons > 0; }, no_label));
    panel.x_title = "time of one solve, one thread (s)";
    panel.y_title = "relative error of R and T, 99.9 % within";
    return panel;
}

PlotPanel panel_of_tables(const CostStudy& study) {
    PlotPanel panel = make_panel(
        study, CostPoint::Kind::table, "frontier (time of a lookup)",
        {{"all axes", [](const CostPoint& p) { return p.varied == "all"; }},
         {"mu", [](const CostPoint& p) { return p.varied == "mu_samples"; }},
         {"azimuth", [](const CostPoint& p) { return p.varied == "azimuth_samples"; }},
         {"optical depth",
          [](const CostPoint& p) { return p.varied == "optical_depth_samples_per_octave"; }},
         {"albedo", [](const CostPoint& p) { return p.varied == "albedo_samples"; }}});
    panel.title = "Table: sampling of its axes; packed";
    panel.series.push_back(series_of(
        study, "packed, by tolerance",
        [](const CostPoint& p) { return p.kind == CostPoint::Kind::packed; },
        [](const CostPoint& p) { return lookup_text(p); }));
    panel.x_title = "samples of the table in memory (bytes)";
    panel.y_title = "relative error of lookups, 99.9 % within";
    return panel;
}

/// Error over the size of droplets, a series for each number of nodes.
PlotPanel panel_of_droplets(const CostStudy& study) {
    PlotPanel panel;
    for (const CostPoint& point : study.points) {
        if (point.kind != CostPoint::Kind::droplets) continue;
        const std::string name = std::to_string(point.solver.nodes) + " nodes";
        auto series = std::ranges::find(panel.series, name, &PlotSeries::name);
        if (series == panel.series.end()) {
            panel.series.push_back({name, PlotSeries::Role::measured, {}});
            series = panel.series.end() - 1;
        }
        series->points.push_back(
            {point.size_parameter, std::max(point.error_99_9, 1e-16),
             point.solver.nodes == 32 ? short_number(1e3 * point.solve_seconds) + " ms" : ""});
    }
    panel.title = "Droplets: the solver over their size (time of a solve with 32 nodes beside it)";
    panel.x_title = "size parameter 2\u03c0 radius / wavelength";
    panel.y_title = "relative error of R and T, 99.9 % within";
    return panel;
}

/// Error over the members along an axis of a family, with the bytes that they take.
PlotPanel panel_along(const CostStudy& study, PhaseParameter parameter) {
    PlotPanel panel;
    const std::string name = parameter_name(parameter);
    PlotSeries series{"all else as tolerance chose (bytes)", PlotSeries::Role::measured, {}};
    PlotSeries chosen{"chosen by tolerance", PlotSeries::Role::chosen, {}};
    for (const CostPoint& point : points_along(study.points, parameter)) {
        const PlotPoint mark{double(point.members[static_cast<std::size_t>(parameter)]),
                             std::max(point.error_99_9, 1e-16), short_number(point.bytes)};
        series.points.push_back(mark);
        if (point.tolerance > 0)
            chosen.points.push_back({mark.x, mark.y, tolerance_text(point.tolerance)});
    }
    if (series.points.empty()) return panel;
    panel.series = {series, chosen};
    panel.title = "Family: members along " + name;
    panel.x_title = "members along " + name;
    panel.y_title = "relative error of lookups, 99.9 % within";
    return panel;
}

void run_cost(const CostCommand& command) {
    require_writable_answer("cost", command.output);
    if (!command.svg.empty()) require_writable("cost", "--svg", command.svg, {".svg"});
    for (const std::string& written : {command.output, command.svg})
        require_different_files("cost", command.recipe, written);
    if (!command.svg.empty() && command.svg == command.output)
        throw std::invalid_argument("cost: --svg must be another file than --output, got " +
                                    command.svg);
    std::vector<std::string> notes;
    const Recipe recipe = read_recipe(command.recipe, &notes);

    Progress progress(command.quiet);
    for (const std::string& note : notes) progress.note("note: " + note);
    CostOptions options = command.options;
    options.note = [&](const std::string& line) { progress.note("  " + line); };
    options.progress = [&](double done, const std::string& stage) { progress.show(done, stage); };
    const CostStudy study = measure_cost(recipe, options);
    write_answer(command.output, [&](std::ostream& out) { write_cost(out, study.points); });
    if (command.svg.empty()) return;
    const SignalsHeld held;
    write_atomically(command.svg, [&](const std::filesystem::path& temporary) {
        std::vector<PlotPanel> panels{panel_of_solvers(study), panel_of_tables(study)};
        if (PlotPanel droplets = panel_of_droplets(study); !droplets.series.empty())
            panels.push_back(std::move(droplets));
        for (const PhaseParameter parameter : all_parameters)
            if (PlotPanel along = panel_along(study, parameter); !along.series.empty())
                panels.push_back(std::move(along));
        draw_cost_plot(panels, temporary);
    });
}

std::string help_of_columns() {
    std::string text =
        "Columns of the CSV, a row a point; empty where one does not belong to it:\n";
    for (const auto& [name, meaning] : cost_columns())
        text += "  " + std::string(name) + ": " + meaning + "\n";
    return text;
}

}  // namespace

void add_cost(CLI::App& app) {
    auto command = std::make_shared<CostCommand>();
    CLI::App* cost =
        app.add_subcommand("cost", "Measure what accuracy costs a recipe in time and bytes");
    cost->add_option("RECIPE", command->recipe, "Recipe, .toml")->required()->check(file_name());
    cost->add_option("-o,--output", command->output, "CSV to write. Default or -: standard output")
        ->check(file_name());
    cost->add_option("--svg", command->svg, "Figure of all points and both frontiers to draw, .svg")
        ->check(file_name());
    cost->add_option("--seconds", command->options.seconds,
                     "After which no measurement starts; they go from cheap to expensive")
        ->capture_default_str()
        ->check(number("above 0", [](double seconds) { return seconds > 0; }));
    add_threads(*cost, command->options.threads, ". What is timed runs alone on one");
    cost->add_flag("--quiet", command->quiet, "No progress, no notes");
    cost->footer(help_of_columns() +
                 "Notes tell what grows as which power of what, fitted by least squares in "
                 "logarithms: time of a solve over nodes and depth, of a bake over ranks (by "
                 "the model of `stratus bake --dry-run --ranks`), times and sizes over "
                 "tolerance, errors of reference methods over time, and of tables over the members "
                 "along an axis of a family.\n"
                 "Of a family, solvers, orders and references are those of its most peaked member; "
                 "tables are of all members.\n"
                 "Errors are relative to the total R or T, as `stratus verify` has them.\n"
                 "Example:\n  stratus cost tables/saturn_rings.toml -o cost.csv --svg cost.svg");
    cost->callback([command] { run_cost(*command); });
}

}  // namespace stratus
