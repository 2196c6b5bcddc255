#include <stratus/bake/bake.h>
#include <stratus/bake/axes.h>
#include <stratus/base/constants.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "cost_sweeps.h"
#include "recipe_sections.h"

#include <cmath>
#include <functional>
#include <random>
#include <utility>

namespace stratus {

namespace {

constexpr int table_points = 6000;
constexpr double max_bytes = 1 << 30;  // of a table

/// Tolerances finer than this share of the recipe's own are not measured.
constexpr double finest_share = 0.25;

/// Parts of the seconds after which no other tolerance, axis or coarser table is begun.
constexpr double share_of_tolerances = 0.35, share_of_axes = 0.5, share_of_coarser = 0.7;

/// An axis whose sampling is swept.
struct SweptAxis {
    std::string name;
    std::function<int&(Discretisation&)> samples;
    int min;
};

/// Returns the axes of a recipe, resolved as `chosen`, that have a range; mu first.
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
        volatile double sum = 0;
        for (const auto& [view, at] : order) {
            const auto look = at->side == Side::reflection ? reflection : transmission;
            sum = sum + look(views[view], at->albedo, at->optical_depth, at->geometry).total();
        }
        best = std::min(best, seconds_since(started));
    }
    return 1e9 * best / static_cast<double>(order.size());
}

class TableSweep {
  public:
    TableSweep(const Recipe& recipe, const CostBudget& budget) : recipe_(recipe), budget_(budget) {
        options_.threads = budget.options.threads;
    }

    /// Bakes the recipe's own tolerance, then round ones from the coarsest to one that is finer,
    /// while time is left.
    void bake_tolerances() {
        const double own = recipe_.tolerance;
        bake_tolerance(own);
        axes_ = swept_axes(recipe_, points_[0].discretisation);
        seconds_per_byte_ = points_[0].bake_seconds / points_[0].bytes;
        for (const double tolerance :
             {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6}) {
            const double growth = tolerance < own ? 4 : 1;
            if (tolerance > finest_share * own && std::abs(tolerance / own - 1) > 0.01 &&
                budget_.is_time_left(share_of_tolerances, growth * points_[0].bake_seconds))
                bake_tolerance(tolerance);
        }
    }

    /// Varies what the recipe's tolerance chose: one axis at a time, and all of them together.
    void sweep_axes() {
        std::vector<std::pair<Discretisation, std::string>> candidates;
        for (const double factor : {0.5, 0.7, 0.85, 1.2, 1.4}) {
            Discretisation all = points_[0].discretisation;
            for (const SweptAxis& axis : axes_) {
                candidates.push_back({points_[0].discretisation, axis.name});
                scale(candidates.back().first, axis, factor);
                scale(all, axis, factor);
            }
            candidates.push_back({all, "all"});
        }
        std::ranges::stable_sort(candidates, {},
                                 [&](const auto& one) { return estimate_bytes(one.first); });
        for (const auto& [discretisation, varied] : candidates)
            measure(discretisation, varied, share_of_axes);
    }

    /// Makes every tolerance's choice, cheap ones first, as coarse as leaves the table as accurate;
    /// then as coarse as keeps the tolerance. What they end with says which choice was too fine.
    void coarsen_chosen() {
        std::vector<CostPoint> chosen;
        std::ranges::copy_if(points_, std::back_inserter(chosen),
                             [](const CostPoint& point) { return point.tolerance > 0; });
        std::ranges::sort(chosen, {}, &CostPoint::bytes);
        for (const bool stays_as_accurate : {true, false})
            for (const CostPoint& from : chosen)
                coarsen(from.discretisation, [&](const CostPoint& coarser) {
                    return stays_as_accurate ? coarser.error_99_9 <= from.error_99_9
                                             : keeps_tolerance(from.tolerance, coarser);
                });
    }

    std::vector<CostPoint> points() {
        points_.insert(points_.end(), packed_.begin(), packed_.end());
        return std::move(points_);
    }

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
        if (expected_.empty()) solve_points(d.nodes);
        CostPoint point = add_point(table, d, seconds);
        points_.back().varied = point.varied = "tolerance";
        points_.back().tolerance = point.tolerance = tolerance;
        finest_nodes_ = std::max(finest_nodes_, d.nodes);
        finest_modes_ = std::max(finest_modes_, d.modes);
        const auto packing = Clock::now();
        const PackedTable packed(pack(table));
        point.kind = CostPoint::Kind::packed;
        point.bake_seconds = seconds_since(packing);
        point.bytes = static_cast<double>(packed.bytes());
        measure_lookups(point, packed.view());
        packed_.push_back(point);
    }

    /// Solves the points that all tables are looked up at, as `verify` does.
    void solve_points(int nodes) {
        SolverOptions solver;
        solver.orders = recipe_.orders;
        solver.nodes = reference_nodes(nodes);
        solver.mode_tolerance = 1e-4 * recipe_.tolerance;
        expected_ = solve_cost_points(recipe_, solver, table_points, budget_);
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

    CostPoint add_point(const Table& table, const Discretisation& d, double seconds) {
        CostPoint point;
        point.kind = CostPoint::Kind::table;
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
            point.members[static_cast<std::size_t>(axis.parameter)] =
                static_cast<int>(axis.axis.values.size());
        measure_lookups(point, table.view());
        points_.push_back(point);
        return point;
    }

    /// Estimates them from the bytes of the table that the recipe's tolerance chose.
    double estimate_bytes(Discretisation d) const {
        Discretisation own = points_[0].discretisation;
        const auto growth = [&](const SweptAxis& axis) {
            return static_cast<double>(axis.samples(d)) / axis.samples(own);
        };
        double bytes = points_[0].bytes * growth(axes_[0]);  // mu counts twice
        for (const SweptAxis& axis : axes_) bytes *= growth(axis);
        return bytes;
    }

    /// Solves a table, unless it is known, finely enough for the finest tolerance: what is left is
    /// the sampling's error. Null when there is no time for it before that share of the seconds.
    const CostPoint* measure(Discretisation d, const std::string& varied, double share) {
        const auto known = std::ranges::find_if(points_, [&](const CostPoint& point) {
            Discretisation other = point.discretisation;
            return std::ranges::all_of(axes_, [&](const SweptAxis& axis) {
                return axis.samples(other) == axis.samples(d);
            });
        });
        if (known != points_.end()) return &*known;
        const double bytes = estimate_bytes(d);
        if (bytes > max_bytes || !budget_.is_time_left(share, bytes * seconds_per_byte_))
            return nullptr;
        budget_.show("sampling");
        d.nodes = finest_nodes_;
        d.modes = finest_modes_;
        Recipe resolved = recipe_;
        resolved.discretisation = d;
        const auto started = Clock::now();
        const Table table = solve_table(resolved, options_);
        add_point(table, d, seconds_since(started));
        points_.back().varied = varied;
        seconds_per_byte_ = seconds_since(started) / bytes;
        return &points_.back();
    }

    /// Makes one axis after the other a little coarser, round after round, as long as will_do().
    void coarsen(Discretisation now, const std::function<bool(const CostPoint&)>& will_do) {
        for (bool changed = true; changed;) {
            changed = false;
            for (const SweptAxis& axis : axes_) {
                Discretisation next = now;
                scale(next, axis, 0.9);
                if (axis.samples(next) == axis.samples(now)) continue;
                const CostPoint* const coarser = measure(next, axis.name, share_of_coarser);
                if (coarser == nullptr || !will_do(*coarser)) continue;
                now = next;
                changed = true;
            }
        }
    }

    const Recipe& recipe_;
    const CostBudget& budget_;
    std::vector<SweptAxis> axes_;
    BakeOptions options_;
    std::vector<ErrorSample> expected_;  // random points; found and error unused
    std::vector<PhaseFunction> held_;    // of the points' members: droplets take long
    std::vector<CostPoint> points_;      // the first is what the recipe's tolerance chose
    std::vector<CostPoint> packed_;
    int finest_nodes_ = 0, finest_modes_ = 0;
    double seconds_per_byte_ = 0;
};

}  // namespace

std::vector<ErrorSample> solve_cost_points(const Recipe& recipe, const SolverOptions& solver,
                                           int count, const CostBudget& budget) {
    Recipe sampled = recipe;  // at will: points know the ends of the axes
    sampled.discretisation.mu_samples = sampled.discretisation.azimuth_samples = 8;
    sampled.discretisation.family_samples.fill(8);
    const DirectionAxes directions = direction_axes(sampled);
    const Axis albedo = albedo_axis(recipe.albedo, 100);
    const Range depth = recipe.optical_depth;
    const double deepest = std::max(64.0, 2 * depth.min);  // beyond it points become ever rarer
    Axis tau = optical_depth_axis(depth, 4, deepest);
    if (const AxisView view = tau.view(); view.count > 1)  // which may begin below
        tau = make_axis(AxisScale::logarithmic, depth.min, view.highest, view.count,
                        view.ends_at_infinity);
    PointRange range{albedo.view(),
                     tau.view(),
                     directions.mu_in.view(),
                     directions.mu_out.view(),
                     recipe.reflection,
                     recipe.transmission,
                     recipe.lower_boundary,
                     family_axes(sampled),
                     recipe.second_phase_function,
                     leaves_path_law(recipe)};
    range.azimuth = directions.azimuth.view();
    VerifyOptions options;
    options.samples = count;
    options.seed = 7;  // neither the bake's check nor verify's default
    options.threads = budget.options.threads;
    return solve_random_points(recipe.phase_function, range, solver, options);
}

void set_errors(CostPoint& point, std::vector<ErrorSample>& samples) {
    point.error_median = error_quantile(samples, 0.5);
    point.error_99_9 = error_quantile(samples, 0.999);
    point.error_largest = error_quantile(samples, 1);
}

bool keeps_tolerance(double tolerance, const CostPoint& table) {
    return table.error_99_9 <= tolerance &&
           table.error_largest <= largest_over_tolerance * tolerance;
}

std::vector<CostPoint> measure_tables(const Recipe& recipe, const CostBudget& budget) {
    TableSweep sweep(recipe, budget);
    sweep.bake_tolerances();
    sweep.sweep_axes();
    sweep.coarsen_chosen();
    return sweep.points();
}

}  // namespace stratus
