#include "cost_tables.h"

#include <stratus/bake/bake.h>
#include <stratus/base/constants.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/solve.h>

#include "axes.h"
#include "family_section.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <utility>

namespace stratus {

namespace {

constexpr int random_points = 6000;
constexpr unsigned point_seed = 7;  // neither the bake's check nor verify's default

constexpr double max_bytes = 1 << 30;  // of a table

/// Whether directions in azimuth differ.
bool depends_on_azimuth(const Recipe& recipe) {
    const LowerBoundary& below = recipe.lower_boundary;
    return !recipe.family.empty() || !recipe.phase_function.is_isotropic() ||
           (below.kind == LowerBoundary::Kind::layer && !below.phase_function.is_isotropic());
}

/// The axes of a recipe that have a range.
std::vector<SweptAxis> swept_axes(const Recipe& recipe) {
    std::vector<SweptAxis> axes{
        {"mu_samples", [](Discretisation& d) -> int& { return d.mu_samples; }, 4}};
    if (depends_on_azimuth(recipe))
        axes.push_back(
            {"azimuth_samples", [](Discretisation& d) -> int& { return d.azimuth_samples; }, 3});
    if (recipe.optical_depth.min < recipe.optical_depth.max)
        axes.push_back(
            {"optical_depth_samples_per_octave",
             [](Discretisation& d) -> int& { return d.optical_depth_samples_per_octave; }, 1});
    if (recipe.albedo.min < recipe.albedo.max)
        axes.push_back(
            {"albedo_samples", [](Discretisation& d) -> int& { return d.albedo_samples; }, 2});
    for (std::size_t k = 0; k < recipe.family.size(); ++k)
        if (recipe.family[k].values.empty())
            axes.push_back({samples_key(recipe.family[k].parameter),
                            [k](Discretisation& d) -> int& { return d.family_samples[k]; },
                            2,
                            {2, 3, 4, 5, 7, 9, 13}});
    return axes;
}

/// At least one sample more or fewer, but not below the axis' minimum.
void scale(Discretisation& d, const SweptAxis& axis, double factor) {
    int& samples = axis.samples(d);
    const int before = samples;
    samples = static_cast<int>(std::lround(factor * before));
    if (samples == before) samples += factor > 1 ? 1 : -1;
    samples = std::max(std::min(axis.min, before), samples);
}

}  // namespace

bool keeps_tolerance(double tolerance, const CostPoint& table) {
    return table.error_99_9 <= tolerance &&
           table.error_largest <= largest_over_tolerance * tolerance;
}

TableSweep::TableSweep(const Recipe& recipe, const CostBudget& budget, int nodes_of_points)
    : recipe_(recipe),
      budget_(budget),
      axes_(swept_axes(recipe)),
      nodes_of_points_(nodes_of_points) {}

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
    range.family = family_axes(resolved);
    range.second_phase_function = recipe_.second_phase_function;
    range.has_path_law = leaves_path_law(recipe_);
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
    find_members(range.family);
}

/// Which members of a family the points are of.
void TableSweep::find_members(const std::vector<FamilyAxis>& family) {
    for (const ErrorSample& at : expected_) {
        const auto found = std::ranges::find(members_, at.member);
        member_of_.push_back(static_cast<std::size_t>(found - members_.begin()));
        if (found != members_.end()) continue;
        members_.push_back(at.member);
        phase_functions_.push_back(with_parameters(recipe_.phase_function, family, at.member));
    }
}

/// A table at each member.
std::vector<TableView> TableSweep::views_of(const TableView& table) const {
    std::vector<TableView> views;
    for (const FamilyPoint& member : members_) views.push_back(table.at(member));
    return views;
}

/// Mean of all points; of each thousand in a row the best of several rounds, so that time given to
/// other programs does not count.
double TableSweep::time_lookup(const std::vector<TableView>& views) const {
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
                sum += look(views[member_of_[n]], at.albedo, at.optical_depth, at.geometry).total();
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
    for (const FamilyAxis& axis : table.family)
        point.members[static_cast<std::size_t>(axis.parameter)] =
            static_cast<int>(axis.axis.values.size());
    if (expected_.empty()) solve_points(d);
    judge_lookups(point, table.view());
    return point;
}

void TableSweep::judge_lookups(CostPoint& point, const TableView& table) {
    const std::vector<TableView> views = views_of(table);
    std::vector<ErrorSample> samples = expected_;
    std::vector<double> errors;
    for (std::size_t n = 0; n < samples.size(); ++n) {
        look_up(views[member_of_[n]], std::span(&samples[n], 1));
        errors.push_back(samples[n].error);
    }
    set_errors(point, std::move(errors));
    point.lookup_ns = time_lookup(views);
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
    return static_cast<double>(sizeof(float) * member_count(family_axes(resolved)) * depths *
                               albedos * direction_axes(resolved).count()) *
           sides;
}

/// The table of this sampling; null when none has been measured.
const CostPoint* TableSweep::find_table(Discretisation d) const {
    const auto found = std::ranges::find_if(points_, [&](const CostPoint& point) {
        Discretisation of_point = point.discretisation;
        return std::ranges::all_of(axes_, [&](const SweptAxis& axis) {
            return axis.samples(of_point) == axis.samples(d);
        });
    });
    return found == points_.end() ? nullptr : &*found;
}

/// Solved finely enough for the finest tolerance: what is left is the sampling's error. Null
/// when there is no time for it before that share of the seconds.
const CostPoint* TableSweep::measure_table(Discretisation d, const std::string& varied,
                                           double share) {
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
        std::string varied;
    };
    std::vector<Candidate> candidates;
    const Discretisation& chosen = own_.discretisation;
    for (const double factor : {0.5, 0.7, 0.85, 1.2, 1.4}) {
        Discretisation all = chosen;
        for (const SweptAxis& axis : axes_) {
            Discretisation one = chosen;
            scale(one, axis, factor);
            scale(all, axis, factor);
            if (axis.counts.empty()) candidates.push_back({one, axis.name});
        }
        candidates.push_back({all, "all"});
    }
    for (const SweptAxis& axis : axes_)
        for (const int count : axis.counts) {
            candidates.push_back({chosen, axis.name});
            axis.samples(candidates.back().discretisation) = count;
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
        for (const SweptAxis& axis : axes_) {
            Discretisation next = now;
            scale(next, axis, 0.9);
            if (axis.samples(next) == axis.samples(now)) continue;
            const CostPoint* const coarser = measure_table(next, axis.name, 1);
            if (coarser == nullptr || !will_do(*coarser)) continue;
            now = next;
            changed = true;
        }
    }
}

}  // namespace stratus
