#include <stratus/bake/cost.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/axes.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/solve.h>

#include "recipe_sections.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>
#include <random>
#include <stdexcept>

namespace stratus {

namespace {

using Kind = CostPoint::Kind;

constexpr const char* kind_names[] = {"solver", "table", "packed"};

/// Random points that tables, and solvers, are compared at.
constexpr int table_points = 6000, solver_points = 800;

/// Largest change of a converged solution when nodes are added.
constexpr double converged = 1e-9;

/// The seconds asked for, counted from its construction.
struct Budget {
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
    VerifyOptions points(int count) const {
        VerifyOptions verify;
        verify.samples = count;
        verify.seed = 7;  // neither the bake's check nor verify's default
        verify.threads = options.threads;
        return verify;
    }
};

/// Sorts the samples by error.
void set_errors(CostPoint& point, std::vector<ErrorSample>& samples) {
    point.error_median = error_quantile(samples, 0.5);
    point.error_99_9 = error_quantile(samples, 0.999);
    point.error_largest = error_quantile(samples, 1);
}

// ---- Tables

/// An axis whose sampling is swept.
struct SweptAxis {
    std::string name;
    std::function<int&(Discretisation&)> samples;
    int min;
};

/// Returns the axes of a recipe, resolved as `chosen`, that have a range.
std::vector<SweptAxis> swept_axes(const Recipe& recipe, const Discretisation& chosen) {
    using D = Discretisation;
    std::vector<SweptAxis> axes{{"mu_samples", &D::mu_samples, 4}};
    if (chosen.azimuth_samples > 1) axes.push_back({"azimuth_samples", &D::azimuth_samples, 3});
    if (recipe.optical_depth.min < recipe.optical_depth.max)
        axes.push_back(
            {"optical_depth_samples_per_octave", &D::optical_depth_samples_per_octave, 1});
    if (recipe.albedo.min < recipe.albedo.max)
        axes.push_back({"albedo_samples", &D::albedo_samples, 2});
    for (std::size_t k = 0; k < recipe.family.size(); ++k)
        if (recipe.family[k].values.empty())
            axes.push_back({samples_key(recipe.family[k].parameter),
                            [k](D& d) -> int& { return d.family_samples[k]; }, 2});
    return axes;
}

/// Takes at least one sample more or fewer, but not fewer than the axis' minimum.
void scale(Discretisation& d, const SweptAxis& axis, double factor) {
    int& samples = axis.samples(d);
    const int before = samples;
    samples = static_cast<int>(std::lround(factor * before));
    if (samples == before) samples += factor > 1 ? 1 : -1;
    samples = std::max(std::min(axis.min, before), samples);
}

/// Returns nanoseconds, the mean of all points in random order, so that no two in a row share
/// samples; the best of several rounds.
double time_lookups(const TableView& table, const std::vector<ErrorSample>& points) {
    std::vector<TableView> views;  // of members; points of one lie in a row
    std::vector<std::pair<std::size_t, const ErrorSample*>> order;
    for (const ErrorSample& at : points) {
        if (order.empty() || !(order.back().second->member == at.member))
            views.push_back(table.at(at.member));
        order.push_back({views.size() - 1, &at});
    }
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    double best = infinity;
    for (int round = 0; round < 8; ++round) {
        const auto started = Clock::now();
        double sum = 0;
        for (const auto& [view, at] : order)
            sum += scattering(views[view], at->side, at->albedo, at->optical_depth, at->geometry)
                       .total();
        if (!std::isnan(sum)) best = std::min(best, seconds_since(started));  // which needs the sum
    }
    return 1e9 * best / static_cast<double>(order.size());
}

class TableSweep {
  public:
    TableSweep(const Recipe& recipe, const Budget& budget) : recipe_(recipe), budget_(budget) {
        options_.threads = budget.options.threads;
    }

    /// Bakes the recipe's own tolerance, then round ones from the coarsest to one that is finer.
    void bake_tolerances() {
        const double own = recipe_.tolerance;
        bake_tolerance(own);
        for (const double tolerance :
             {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6}) {
            const double growth = tolerance < own ? 4 : 1;
            if (tolerance > own / 4 && std::abs(tolerance / own - 1) > 0.01 &&
                budget_.is_time_left(0.4, growth * points_[0].bake_seconds))
                bake_tolerance(tolerance);
        }
    }

    /// Varies what the recipe's tolerance chose: one axis at a time, and all of them together.
    void sweep_axes() {
        constexpr double max_bytes = 1 << 30;
        const CostPoint own = points_[0];
        axes_ = swept_axes(recipe_, own.discretisation);
        for (const double factor : {0.5, 0.7, 0.85, 1.2, 1.4}) {
            Discretisation all = own.discretisation;
            for (const SweptAxis& axis : axes_) {
                Discretisation one = own.discretisation;
                scale(one, axis, factor);
                scale(all, axis, factor);
                measure(one, axis.name);
            }
            // The cosine's samples count twice.
            if (own.bytes * std::pow(factor, axes_.size() + 1) < max_bytes) measure(all, "all");
        }
    }

    /// Returns the tables, the first of which the recipe's tolerance chose.
    const std::vector<CostPoint>& tables() const { return points_; }
    const std::vector<CostPoint>& packed() const { return packed_; }
    const PointRange& range() const { return range_; }

  private:
    void bake_tolerance(double tolerance) {
        budget_.show("tolerance");
        Recipe recipe = recipe_;
        recipe.tolerance = tolerance;
        const auto started = Clock::now();
        const Table table = bake(recipe, options_);
        const double seconds = seconds_since(started);
        const Discretisation d =
            parse_recipe(table.attributes.at("resolved_recipe")).discretisation;
        if (expected_.empty()) solve_points(table, d.nodes);
        add_point(table, d, seconds, "tolerance");
        points_.back().tolerance = tolerance;
        finest_.nodes = std::max(finest_.nodes, d.nodes);
        finest_.modes = std::max(finest_.modes, d.modes);

        CostPoint point = points_.back();
        const auto packing = Clock::now();
        const PackedTable packed(pack(table));
        point.kind = Kind::packed;
        point.bake_seconds = seconds_since(packing);
        point.bytes = static_cast<double>(packed.file().size());
        measure_lookups(point, packed.view());
        packed_.push_back(point);
    }

    /// Solves the points that all tables are looked up at, as `verify` does.
    void solve_points(const Table& table, int nodes) {
        range_ = point_range(table, table.view());
        range_.all_kinds = false;
        SolverOptions solver;
        solver.orders = recipe_.orders;
        solver.nodes = reference_nodes(nodes);
        solver.mode_tolerance = 1e-4 * recipe_.tolerance;
        expected_ = solve_random_points(recipe_.phase_function, range_, solver,
                                        budget_.points(table_points));
        for (std::size_t n = 0; n < expected_.size() && !recipe_.family.empty(); ++n)
            if (n == 0 || expected_[n].member != expected_[n - 1].member)
                held_.push_back(
                    with_parameters(recipe_.phase_function, recipe_.family, expected_[n].member));
    }

    void measure_lookups(CostPoint& point, const TableView& table) const {
        std::vector<ErrorSample> samples = expected_;
        look_up(table, samples);
        set_errors(point, samples);
        point.lookup_ns = time_lookups(table, expected_);
    }

    void add_point(const Table& table, const Discretisation& d, double seconds,
                   const std::string& varied) {
        CostPoint point;
        point.kind = Kind::table;
        point.varied = varied;
        point.discretisation = d;
        point.solver.orders = recipe_.orders;
        point.solver.nodes = d.nodes;
        point.solver.modes = d.modes;
        point.solver.scheme = d.scheme;
        point.bake_seconds = seconds;
        point.bytes = static_cast<double>(
            (table.reflection_multiple.size() + table.transmission_multiple.size()) *
            sizeof(float));
        for (const FamilyAxis& axis : table.family)
            point.members[static_cast<std::size_t>(axis.parameter)] = int_size(axis.axis.values);
        measure_lookups(point, table.view());
        points_.push_back(point);
    }

    /// Solves a table, unless it is known, finely enough for the finest tolerance: what is left is
    /// the sampling's error.
    void measure(Discretisation d, const std::string& varied) {
        const auto is_known = [&](const CostPoint& point) {
            Discretisation other = point.discretisation;
            return std::ranges::all_of(axes_, [&](const SweptAxis& axis) {
                return axis.samples(other) == axis.samples(d);
            });
        };
        if (std::ranges::any_of(points_, is_known) || !budget_.is_time_left(0.8)) return;
        budget_.show("sampling");
        d.nodes = finest_.nodes;
        d.modes = finest_.modes;
        Recipe resolved = recipe_;
        resolved.discretisation = d;
        const auto started = Clock::now();
        const Table table = solve_table(resolved, options_);
        add_point(table, d, seconds_since(started), varied);
    }

    const Recipe& recipe_;
    const Budget& budget_;
    BakeOptions options_;
    std::vector<SweptAxis> axes_;
    PointRange range_{};
    std::vector<ErrorSample> expected_;  // random points; found and error unused
    std::vector<PhaseFunction> held_;    // of the points' members: droplets take long
    std::vector<CostPoint> points_, packed_;
    SolverOptions finest_{.nodes = 0, .modes = 0};
};

// ---- The solver

/// Sets the errors of solved points against the reference.
void compare(std::vector<ErrorSample>& found, const std::vector<ErrorSample>& reference) {
    for (std::size_t n = 0; n < found.size(); ++n)
        found[n].error = std::abs(found[n].expected - reference[n].expected) /
                         std::max(reference[n].expected, reference[n].floor);
}

/// Solves the deepest and brightest layer at 14 cosines, and sets the modes and the time of a point:
/// the best of some.
void time_solve(CostPoint& point, const Recipe& recipe) {
    std::vector<double> mu = floor_cosines();
    for (const double x : {0.05, 0.14, 0.22, 0.3, 0.36, 0.5, 0.64, 0.75, 0.82, 0.96})
        mu.push_back(x * x);
    constexpr double enough = 2e-2;
    point.solve_seconds = infinity;
    for (const auto begun = Clock::now(); seconds_since(begun) < enough;) {
        const double started = processor_seconds();
        const LayerSolution solution =
            solve_layer(recipe.phase_function, recipe.albedo.max, recipe.optical_depth.max, mu,
                        point.solver, recipe.lower_boundary);
        point.solve_seconds = std::min(point.solve_seconds, processor_seconds() - started);
        point.solver.modes = std::max(1, int_size(solution.modes.reflection));
    }
}

/// Adds the solver's points: more and more nodes until that changes nothing, or until the time is up
/// and what the recipe's tolerance chose for `tables` can be judged; and what other tolerances chose.
void add_solvers(CostStudy& study, const Recipe& recipe, const PointRange& range,
                 const std::vector<CostPoint>& tables, const Budget& budget) {
    const auto solve = [&](const SolverOptions& solver) {
        budget.show("solving");
        return solve_random_points(recipe.phase_function, range, solver,
                                   budget.points(solver_points));
    };
    const auto measured = [&](std::vector<ErrorSample> found, const SolverOptions& solver,
                              const std::vector<ErrorSample>& reference) {
        CostPoint point;
        point.varied = "nodes";
        point.solver = solver;
        compare(found, reference);
        set_errors(point, found);
        time_solve(point, recipe);
        return point;
    };
    std::vector<std::pair<SolverOptions, std::vector<ErrorSample>>> solved;
    constexpr int most = 256;
    for (const int nodes : {2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, most}) {
        SolverOptions solver;
        solver.orders = recipe.orders;
        solver.nodes = nodes;
        try {
            solved.push_back({solver, solve(solver)});
        } catch (const std::runtime_error& reason) {  // too few nodes
            if (nodes == most) throw;
            budget.say(reason.what());
            continue;
        }
        if (solved.size() == 1) continue;
        std::vector<ErrorSample> last = solved[solved.size() - 2].second;
        compare(last, solved.back().second);
        study.reference_nodes = nodes;
        study.reference_change = error_quantile(last, 1);
        if (study.reference_change <= converged ||
            (nodes >= 2 * tables[0].solver.nodes && !budget.is_time_left(1)))
            break;
    }
    budget.say("converged solution: " + std::to_string(study.reference_nodes) +
               " nodes; with fewer it is " + short_number(study.reference_change) + " off");

    const std::vector<ErrorSample>& reference = solved.back().second;
    for (const CostPoint& table : tables) {
        if (table.tolerance == 0) continue;
        if (5 * table.solver.nodes > 4 * study.reference_nodes) {
            budget.say("tolerance " + short_number(table.tolerance) + " takes too many nodes, " +
                       std::to_string(table.solver.nodes) + ", to be judged by these");
            continue;
        }
        const auto alike = std::ranges::find_if(study.points, [&](const CostPoint& point) {
            return point.solver.nodes == table.solver.nodes &&
                   point.solver.modes == table.solver.modes;
        });
        study.points.push_back(alike != study.points.end()
                                   ? *alike
                                   : measured(solve(table.solver), table.solver, reference));
        study.points.back().varied = table.varied;
        study.points.back().tolerance = table.tolerance;
    }
    for (const auto& [solver, found] : solved)
        if (2 * solver.nodes <= study.reference_nodes)
            study.points.push_back(measured(found, solver, reference));
}

/// Says what a tolerance chose: its error and its cost.
std::string describe(const CostPoint& point) {
    const bool is_solver = point.kind == Kind::solver;
    const std::string cost = is_solver ? std::to_string(point.solver.nodes) + " nodes, " +
                                             std::to_string(point.solver.modes) + " modes, " +
                                             short_number(1e3 * point.solve_seconds) + " ms"
                                       : short_number(point.bytes * 1e-6, 3) + " MB, " +
                                             short_number(point.lookup_ns * 1e-3) + " us a lookup";
    return "tolerance " + short_number(point.tolerance) + ": " +
           kind_names[static_cast<int>(point.kind)] + " error " + short_number(point.error_99_9) +
           ", " + cost + ", " + short_number(point.times_frontier) + " times the " +
           (is_solver ? "time" : "bytes") + " of the cheapest that is as accurate";
}

// ---- CSV

std::string field(double number) { return short_number(number, 6); }
std::string field(int count) { return count > 0 ? std::to_string(count) : ""; }

/// Returns what stands in the columns; empty where the point has none.
std::vector<std::string> fields(const CostPoint& point) {
    const bool is_solver = point.kind == Kind::solver;
    const auto tables = [&](auto value) { return is_solver ? "" : field(value); };
    const Discretisation& d = point.discretisation;
    std::vector<std::string> all{kind_names[static_cast<int>(point.kind)], point.varied,
                                 point.tolerance > 0 ? field(point.tolerance) : "",
                                 field(point.solver.nodes), field(point.solver.modes)};
    for (const int samples :
         {d.mu_samples, d.azimuth_samples, d.optical_depth_samples_per_octave, d.albedo_samples})
        all.push_back(tables(samples));
    for (const int members : point.members) all.push_back(tables(members));
    for (const double error : {point.error_median, point.error_99_9, point.error_largest})
        all.push_back(field(error));
    all.push_back(is_solver ? field(point.solve_seconds) : "");
    for (const double cost : {point.bake_seconds, point.bytes, point.lookup_ns})
        all.push_back(tables(cost));
    all.push_back(point.on_frontier ? "1" : "0");
    all.push_back(field(point.times_frontier));
    return all;
}

}  // namespace

CostStudy measure_cost(const Recipe& recipe, const CostOptions& options) {
    require(options.seconds > 0, "measure_cost", "seconds", "above 0", options.seconds);
    require(recipe.layers.empty(), "measure_cost", "layers", "absent: costs are of one layer",
            recipe.layers.size());
    const Budget budget{options};
    TableSweep sweep(recipe, budget);
    sweep.bake_tolerances();
    sweep.sweep_axes();
    PointRange range = sweep.range();
    range.family = {};
    CostStudy study;
    add_solvers(study, at_member(recipe, corners_by_peak(recipe).front()), range, sweep.tables(),
                budget);
    for (const std::vector<CostPoint>* const more : {&sweep.tables(), &sweep.packed()})
        study.points.insert(study.points.end(), more->begin(), more->end());
    for (const Kind kind : {Kind::solver, Kind::table, Kind::packed}) {
        const std::span<CostPoint> points(
            std::ranges::lower_bound(study.points, kind, {}, &CostPoint::kind),
            std::ranges::upper_bound(study.points, kind, {}, &CostPoint::kind));
        compare_with_frontier(points);
        for (const CostPoint& point : points)
            if (point.tolerance > 0) budget.say(describe(point));
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

std::vector<std::pair<std::string, std::string>> cost_columns() {
    constexpr const char* members = "members along that axis of a family";
    return {{"kind", "solver, table or packed"},
            {"varied", "tolerance: it chose the point; else what the sweep changed"},
            {"tolerance", "that chose the point; empty where none did"},
            {"nodes", "Gauss nodes of the solver"},
            {"modes", "azimuthal modes of the solver"},
            {"mu_samples", "of mu_in and mu_out alike"},
            {"azimuth_samples", "over 0 to 180 degrees"},
            {"optical_depth_samples_per_octave", "samples in which the depth doubles"},
            {"albedo_samples", "over the recipe's range"},
            {"mixture_samples", members},
            {"g_samples", members},
            {"radius_samples", members},
            {"wavelength_samples", members},
            {"variance_samples", members},
            {"error_median", "relative error of half of the values"},
            {"error_99_9", "relative error of 99.9 % of the values; the frontier's"},
            {"error_largest", "largest relative error"},
            {"solve_seconds", "one layer, deepest and brightest, 14 cosines, one thread"},
            {"bake_seconds",
             "all threads; where tolerance chose, with choosing and checking; packed: of packing"},
            {"bytes", "of the samples of both sides in memory; packed: of the file"},
            {"lookup_ns", "nanoseconds of a lookup at a random point, one thread"},
            {"on_frontier", "1: no other point undercuts it in error and in cost"},
            {"times_frontier", "solve_seconds or bytes over those of the cheapest as accurate"}};
}

void write_cost(std::ostream& out, const std::vector<CostPoint>& points) {
    const char* before = "";
    for (const auto& [name, meaning] : cost_columns()) out << std::exchange(before, ",") << name;
    for (const CostPoint& point : points) {
        before = "\n";
        for (const std::string& text : fields(point)) out << std::exchange(before, ",") << text;
    }
    out << '\n';
}

}  // namespace stratus
