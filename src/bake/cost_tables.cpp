#include "cost_tables.h"

#include <stratus/bake/bake.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/packed_table.h>

#include "axes.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace stratus {

namespace {

constexpr int random_points = 6000;
constexpr unsigned point_seed = 7;  // neither the bake's check nor verify's default

constexpr double max_bytes = 1 << 30;  // of a table

constexpr SweptAxis swept_axes[] = {
    {"mu_samples", &Discretisation::mu_samples, 4},
    {"azimuth_samples", &Discretisation::azimuth_samples, 3},
    {"optical_depth_samples_per_octave", &Discretisation::optical_depth_samples_per_octave, 1},
    {"albedo_samples", &Discretisation::albedo_samples, 2},
};

/// At least one sample more or fewer, but not below the axis' minimum.
void scale(Discretisation& d, const SweptAxis& axis, double factor) {
    int& samples = d.*axis.samples;
    const int before = samples;
    samples = static_cast<int>(std::lround(factor * before));
    if (samples == before) samples += factor > 1 ? 1 : -1;
    samples = std::max(std::min(axis.min, before), samples);
}

}  // namespace

bool keeps_tolerance(double tolerance, const CostPoint& table) {
    return table.error_99_9 <= tolerance && table.error_largest <= largest_over_tolerance * tolerance;
}

TableSweep::TableSweep(const Recipe& recipe, const CostBudget& budget, int nodes_of_points)
    : recipe_(recipe), budget_(budget), nodes_of_points_(nodes_of_points) {}

BakeOptions TableSweep::bake_options() const {
    BakeOptions options;
    options.threads = budget_.threads();
    return options;
}

/// Random points of the recipe's own range: tables may begin below it.
void TableSweep::solve_points(const Discretisation& chosen) {
    budget_.show("solving");
    const Range depth = recipe_.optical_depth;
    Axis tau = optical_depth_axis(depth, 4, chosen.deepest_optical_depth);
    const AxisView sampled = tau.view();
    if (sampled.count > 1)
        tau = make_axis(AxisScale::logarithmic, depth.min, sampled.highest, sampled.count,
                        sampled.ends_at_infinity);
    Recipe resolved = recipe_;
    resolved.discretisation = chosen;
    const DirectionAxes directions = direction_axes(resolved);
    PointRange range{albedo_axis(recipe_.albedo, 100).view(),
                     tau.view(),
                     directions.mu_in.view(),
                     directions.mu_out.view(),
                     recipe_.reflection,
                     recipe_.transmission,
                     recipe_.lower_boundary};
    range.azimuth = directions.azimuth.view();
    SolverOptions solver = solver_of(recipe_);
    solver.nodes = std::max(nodes_of_points_, chosen.nodes + 8);
    solver.mode_tolerance = 1e-4 * recipe_.tolerance;
    VerifyOptions options;
    options.samples = random_points;
    options.seed = point_seed;
    options.threads = budget_.threads();
    options.progress = [&](double) { budget_.show("solving"); };
    expected_ = solve_random_points(recipe_.phase_function, range, solver, options);
    std::mt19937 random(point_seed);
    std::shuffle(expected_.begin(), expected_.end(), random);  // no two in a row share samples
}

/// Mean of all points; of each thousand in a row the best of several rounds, so that time given to
/// other programs does not count.
double TableSweep::time_lookup(const TableView& table) const {
    constexpr std::size_t in_a_row = 1000;
    double all = 0;
    volatile double sink = 0;
    for (std::size_t first = 0; first < expected_.size(); first += in_a_row) {
        const std::size_t last = std::min(expected_.size(), first + in_a_row);
        double best = infinity;
        for (int round = 0; round < budget_.rounds(); ++round) {
            const auto started = Clock::now();
            double sum = 0;
            for (std::size_t n = first; n < last; ++n) {
                const ErrorSample& at = expected_[n];
                const auto look = at.side == Side::reflection ? reflection : transmission;
                sum += look(table, at.albedo, at.optical_depth, at.geometry).total();
            }
            sink = sum;
            best = std::min(best, seconds_since(started));
        }
        all += best;
    }
    static_cast<void>(sink);
    return 1e9 * all / static_cast<double>(expected_.size());
}

CostPoint TableSweep::make_point(const Table& table, const Discretisation& d, double seconds) {
    CostPoint point;
    point.kind = CostPoint::Kind::table;
    point.discretisation = d;
    point.solver = solver_of(recipe_);
    point.solver.nodes = d.nodes;
    point.solver.modes = d.modes;
    point.solver.scheme = d.scheme;
    point.bake_seconds = seconds;
    point.bytes = static_cast<double>(
        (table.reflection_multiple.size() + table.transmission_multiple.size()) * sizeof(float));
    if (expected_.empty()) solve_points(d);
    judge_lookups(point, table.view());
    return point;
}

void TableSweep::judge_lookups(CostPoint& point, const TableView& table) {
    std::vector<ErrorSample> samples = expected_;
    look_up(table, samples);
    std::vector<double> errors;
    for (const ErrorSample& sample : samples) errors.push_back(sample.error);
    set_errors(point, std::move(errors));
    point.lookup_ns = time_lookup(table);
}

CostPoint TableSweep::make_packed(const Table& table, const CostPoint& from) {
    CostPoint point = from;
    point.kind = CostPoint::Kind::packed;
    const auto started = Clock::now();
    const PackedTable packed(pack(table));
    point.bake_seconds = seconds_since(started);
    point.bytes = static_cast<double>(packed.bytes());
    judge_lookups(point, packed.view());
    return point;
}

/// Round tolerances from the coarsest to one that is finer than the recipe's own, and that.
std::vector<double> TableSweep::tolerances() const {
    const double own = recipe_.tolerance;
    std::vector<double> all;
    for (const double tolerance :
         {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6})
        if (tolerance > finest_share * own && std::abs(tolerance / own - 1) > 0.01)
            all.push_back(tolerance);
    all.insert(std::find_if(all.begin(), all.end(), [&](double other) { return other < own; }),
               own);
    return all;
}

void TableSweep::bake_tolerances() {
    double last = 0;
    for (const double tolerance : tolerances()) {
        constexpr double growth = 4;  // of what a third of a tolerance takes
        const bool must = tolerance == recipe_.tolerance;
        if (!must && !budget_.is_time_left(share_of_tolerances, growth * last)) continue;
        budget_.show("tolerance");
        Recipe recipe = recipe_;
        recipe.tolerance = tolerance;
        const auto started = Clock::now();
        const Table table = bake(recipe, bake_options());
        last = seconds_since(started);
        const Discretisation d =
            parse_recipe(table.attributes.at("resolved_recipe")).discretisation;
        CostPoint point = make_point(table, d, last);
        point.varied = "tolerance";
        point.tolerance = tolerance;
        points_.push_back(point);
        if (budget_.is_time_left(share_of_tolerances)) packed_.push_back(make_packed(table, point));
        if (must) own_ = point;
        finest_nodes_ = std::max(finest_nodes_, d.nodes);
        finest_modes_ = std::max(finest_modes_, d.modes);
    }
}

bool TableSweep::can_vary(const SweptAxis& axis) const {
    if (axis.samples == &Discretisation::azimuth_samples)
        return !recipe_.phase_function.is_isotropic() ||
               (recipe_.lower_boundary.kind == LowerBoundary::Kind::layer &&
                !recipe_.lower_boundary.phase_function.is_isotropic());
    const Range& range =
        axis.samples == &Discretisation::albedo_samples ? recipe_.albedo : recipe_.optical_depth;
    return axis.samples == &Discretisation::mu_samples || range.min < range.max;
}

double TableSweep::bytes_of(const Discretisation& d) const {
    const auto depths =
        optical_depth_axis(recipe_.optical_depth, std::max(1, d.optical_depth_samples_per_octave),
                           d.deepest_optical_depth)
            .values.size();
    const auto albedos =
        albedo_axis(recipe_.albedo, d.albedo_samples, d.albedo_scale).values.size();
    const int sides = (recipe_.reflection ? 1 : 0) + (recipe_.transmission ? 1 : 0);
    Recipe resolved = recipe_;
    resolved.discretisation = d;
    return static_cast<double>(sizeof(float) * depths * albedos *
                               direction_axes(resolved).count()) *
           sides;
}

/// The table of this sampling; null when none has been measured.
const CostPoint* TableSweep::find_table(const Discretisation& d) const {
    const auto found = std::find_if(points_.begin(), points_.end(), [&](const CostPoint& point) {
        return std::all_of(std::begin(swept_axes), std::end(swept_axes),
                           [&](const SweptAxis& axis) {
                               return point.discretisation.*axis.samples == d.*axis.samples;
                           });
    });
    return found == points_.end() ? nullptr : &*found;
}

/// Solved finely enough for the finest tolerance: what is left is the sampling's error. Null
/// when there is no time for it before that share of the seconds.
const CostPoint* TableSweep::measure_table(Discretisation d, const char* varied, double share) {
    if (const CostPoint* known = find_table(d)) return known;
    const double bytes = bytes_of(d);
    if (bytes > max_bytes || !budget_.is_time_left(share, bytes * seconds_per_byte_))
        return nullptr;
    budget_.show("sampling");
    d.nodes = finest_nodes_;
    d.modes = finest_modes_;
    Recipe resolved = recipe_;
    resolved.discretisation = d;
    const auto started = Clock::now();
    const Table table = solve_table(resolved, bake_options());
    CostPoint point = make_point(table, d, seconds_since(started));
    point.varied = varied;
    seconds_per_byte_ = seconds_since(started) / bytes;
    points_.push_back(point);
    return &points_.back();
}

void TableSweep::sweep_axes() {
    struct Candidate {
        Discretisation discretisation;
        const char* varied;
    };
    std::vector<Candidate> candidates;
    const Discretisation& chosen = own_.discretisation;
    for (const double factor : {0.5, 0.7, 0.85, 1.2, 1.4}) {
        Discretisation all = chosen;
        for (const SweptAxis& axis : swept_axes) {
            if (!can_vary(axis)) continue;
            Discretisation one = chosen;
            scale(one, axis, factor);
            scale(all, axis, factor);
            candidates.push_back({one, axis.name});
        }
        candidates.push_back({all, "all"});
    }
    std::stable_sort(candidates.begin(), candidates.end(), [&](const auto& a, const auto& b) {
        return bytes_of(a.discretisation) < bytes_of(b.discretisation);
    });
    seconds_per_byte_ = own_.bake_seconds / own_.bytes;
    for (const Candidate& candidate : candidates)
        measure_table(candidate.discretisation, candidate.varied, share_of_axes);
}

void TableSweep::coarsen_chosen() {
    std::vector<CostPoint> chosen;
    for (const CostPoint& point : points_)
        if (point.tolerance > 0) chosen.push_back(point);
    std::sort(chosen.begin(), chosen.end(),
              [](const CostPoint& a, const CostPoint& b) { return a.bytes < b.bytes; });
    for (const CostPoint& from : chosen)
        coarsen(from.discretisation,
                [&](const CostPoint& table) { return table.error_99_9 <= from.error_99_9; });
    for (const CostPoint& from : chosen)
        coarsen(from.discretisation,
                [&](const CostPoint& table) { return keeps_tolerance(from.tolerance, table); });
}

/// One axis after the other a little coarser, round after round, as long as will_do() holds.
void TableSweep::coarsen(Discretisation now, const std::function<bool(const CostPoint&)>& will_do) {
    for (bool changed = true; changed;) {
        changed = false;
        for (const SweptAxis& axis : swept_axes) {
            Discretisation next = now;
            if (can_vary(axis)) scale(next, axis, 0.9);
            if (next.*axis.samples == now.*axis.samples) continue;
            const CostPoint* const coarser = measure_table(next, axis.name, 1);
            if (coarser == nullptr || !will_do(*coarser)) continue;
            now = next;
            changed = true;
        }
    }
}

}  // namespace stratus
