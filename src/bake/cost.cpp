#include <stratus/bake/cost.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/clock.h>
#include <stratus/bake/parallel.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/number_text.h>

#include "axes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <random>
#include <stdexcept>
#include <tuple>

namespace stratus {

namespace {

/// Parts of the seconds after which a stage begins nothing new.
constexpr double share_of_reference = 0.1, share_of_solver_errors = 0.2,
                 share_of_solver_times = 0.4, share_of_tolerances = 0.65, share_of_axes = 0.85;

/// A solution is converged, and more nodes say nothing more, when nothing changes by more.
constexpr double converged = 1e-9;
constexpr int max_reference_nodes = 256;

constexpr int random_points = 6000;
constexpr unsigned point_seed = 7;  // neither the bake's check nor verify's default

/// Depths that the classic scheme starts from; 0: its own choice (solve.h).
constexpr double start_depths[] = {0, 1e-3, 1e-6};

constexpr double largest_table = 1 << 30;  // bytes

/// Tolerances finer than this share of the recipe's own are not measured.
constexpr double finest_share = 0.25;

/// What the recipe says of its solver.
SolverOptions solver_of(const Recipe& recipe) {
    SolverOptions solver;
    solver.orders = recipe.orders;
    return solver;
}

/// Solvers that are swept, each over nodes and modes: one for each start of the classic scheme,
/// which counts no orders and takes nothing beneath.
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

/// An axis whose sampling is swept.
struct SweptAxis {
    const char* name;
    int Discretisation::*samples;
    int least;
};

constexpr SweptAxis swept_axes[] = {
    {"mu_samples", &Discretisation::mu_samples, 4},
    {"azimuth_samples", &Discretisation::azimuth_samples, 3},
    {"optical_depth_samples_per_octave", &Discretisation::optical_depth_samples_per_octave, 1},
    {"albedo_samples", &Discretisation::albedo_samples, 2},
};

void set_errors(CostPoint& point, std::vector<double> errors) {
    point.error_median = error_quantile(errors, 0.5);
    point.error_most = error_quantile(errors, 0.999);
    point.error_largest = error_quantile(errors, 1);
}

/// Layers that stand for a recipe, and their values at directions that `resolve` does not look at.
class Probes {
  public:
    Probes(const Recipe& recipe, int threads) : recipe_(recipe), threads_(threads) {
        const double most = std::sqrt(1 - recipe.albedo.min);
        const double least = std::sqrt(1 - recipe.albedo.max);
        for (const double at : {0.0, 0.1, 0.45, 0.95}) {
            const double s = least + at * (most - least);
            albedos_.push_back(std::clamp(1 - s * s, recipe.albedo.min, recipe.albedo.max));
            if (recipe.albedo.min == recipe.albedo.max) break;
        }
        for (const double x : {0.05, 0.14, 0.22, 0.3, 0.36, 0.5, 0.64, 0.75, 0.82, 0.96})
            mu_.push_back(x * x);
        const Range depth = recipe.optical_depth;
        if (std::isinf(depth.min)) {
            ladder_ = {1, 0, true};
            return;
        }
        const double highest = std::isinf(depth.max) ? std::max(depth.min, 64.0) : depth.max;
        const int octaves = static_cast<int>(std::floor(std::log2(highest / depth.min) + 1e-9));
        ladder_ = {std::ldexp(highest, -octaves), octaves + 1, std::isinf(depth.max)};
    }

    using Layers = std::vector<LayerSolution>;

    /// All albedos at some depths of the ladder, the first and the last among them.
    Layers solve(const SolverOptions& solver) const {
        std::vector<Layers> of_albedo(albedos_.size());
        parallel_for(static_cast<int>(albedos_.size()), threads_, [&](int a) {
            const auto at = static_cast<std::size_t>(a);
            auto solved = solve_ladder(recipe_.phase_function, {albedos_[at]}, ladder_, mu_, solver,
                                       recipe_.lower_boundary)[0];
            const std::size_t stride = std::max<std::size_t>(1, solved.size() / 6);
            for (std::size_t d = (solved.size() - 1) % stride; d < solved.size(); d += stride)
                of_albedo[at].push_back(std::move(solved[d]));
        });
        Layers layers;
        for (Layers& some : of_albedo)
            for (LayerSolution& layer : some) layers.push_back(std::move(layer));
        return layers;
    }

    /// Totals at all pairs of directions, and the floors of their errors, in one order.
    struct Values {
        std::vector<double> total, floor;
    };

    Values values(const Layers& layers) const {
        std::vector<Values> of_layer(layers.size());
        parallel_for(static_cast<int>(layers.size()), threads_, [&](int n) {
            const auto at = static_cast<std::size_t>(n);
            of_layer[at] = values_of(layers[at]);
        });
        Values all;
        for (const Values& some : of_layer) {
            all.total.insert(all.total.end(), some.total.begin(), some.total.end());
            all.floor.insert(all.floor.end(), some.floor.begin(), some.floor.end());
        }
        return all;
    }

    /// Seconds of one solve of the deepest and brightest layer, the best of some.
    double time_solve(const SolverOptions& solver) const {
        constexpr double enough = 5e-3;
        double best = infinity;
        for (const auto begun = Clock::now(); seconds_since(begun) < enough;) {
            const auto started = Clock::now();
            solve_layer(recipe_.phase_function, recipe_.albedo.max, recipe_.optical_depth.max, mu_,
                        solver, recipe_.lower_boundary);
            best = std::min(best, seconds_since(started));
        }
        return best;
    }

  private:
    Values values_of(const LayerSolution& layer) const {
        Values values;
        const int count = static_cast<int>(mu_.size());
        const std::vector<double> azimuths{0.1, 0.55, 1.2, 2.0, 2.7, 3.05};
        auto add = [&](double floor, auto side) {
            for (int i = 0; i < count; ++i)
                for (int j = i; j < count; ++j)
                    for (const SolvedValue& value : side(i, j)) {
                        values.total.push_back(value.total);
                        values.floor.push_back(floor);
                    }
        };
        if (recipe_.reflection)
            add(reflection_floor(layer),
                [&](int i, int j) { return layer.reflection(i, j, azimuths); });
        if (recipe_.transmission && !std::isinf(layer.optical_depth))
            add(transmission_floor(layer),
                [&](int i, int j) { return layer.transmission(i, j, azimuths); });
        return values;
    }

    const Recipe& recipe_;
    const int threads_;
    std::vector<double> albedos_, mu_ = floor_cosines();
    DepthLadder ladder_;
};

std::vector<double> errors_of(const Probes::Values& found, const Probes::Values& expected) {
    std::vector<double> errors(found.total.size());
    for (std::size_t n = 0; n < errors.size(); ++n)
        errors[n] = std::abs(found.total[n] - expected.total[n]) /
                    std::max(expected.total[n], expected.floor[n]);
    return errors;
}

/// Everything that is measured for one recipe.
class CostMeter {
  public:
    CostMeter(const Recipe& recipe, const CostOptions& options)
        : recipe_(recipe), options_(options), probes_(recipe, options.threads) {}

    CostStudy measure() {
        find_reference();
        sweep_solvers();
        time_solvers(solvers_, share_of_solver_times);
        bake_tolerances();
        measure_chosen_solvers();
        sweep_tables();
        coarsen_chosen_tables();
        judge(solvers_);
        judge(tables_);
        tell_distances();
        study_.points = solvers_;
        study_.points.insert(study_.points.end(), tables_.begin(), tables_.end());
        return std::move(study_);
    }

  private:
    // ---- time left -----------------------------------------------------------------------------

    bool is_time_left(double share, double needed = 0) const {
        return seconds_since(started_) + needed < share * options_.seconds;
    }

    void say(const std::string& line) const {
        if (options_.note) options_.note(line);
    }

    void show(const char* stage) const {
        if (options_.progress)
            options_.progress(std::min(0.999, seconds_since(started_) / options_.seconds), stage);
    }

    // ---- the solver ----------------------------------------------------------------------------

    /// Doubles the nodes until that changes nothing.
    void find_reference() {
        show("converging");
        SolverOptions solver = solver_of(recipe_);
        solver.nodes = 24;
        while (reference_.total.empty()) {
            try {
                reference_ = probes_.values(probes_.solve(solver));
            } catch (const std::runtime_error&) {  // so few nodes break the solver down
                if (2 * solver.nodes > max_reference_nodes) throw;
                solver.nodes *= 2;
            }
        }
        for (;;) {
            solver.nodes *= 2;
            const auto started = Clock::now();
            Probes::Values finer = probes_.values(probes_.solve(solver));
            const double seconds = seconds_since(started);
            CostPoint change;
            set_errors(change, errors_of(reference_, finer));
            reference_ = std::move(finer);
            study_.reference_nodes = solver.nodes;
            study_.reference_change = change.error_largest;
            constexpr double growth = 16;  // nodes cubed, and as many more modes
            if (change.error_largest <= converged || 2 * solver.nodes > max_reference_nodes ||
                !is_time_left(share_of_reference, growth * seconds))
                break;
        }
        say("converged solution: " + std::to_string(study_.reference_nodes) +
            " nodes; with half of them it is " + short_number(study_.reference_change) + " off");
    }

    /// Errors of some nodes with each number of modes that makes a difference; without a number,
    /// the numbers of a sweep.
    std::vector<CostPoint> measure_solver(SolverOptions solver, int only_modes = 0) const {
        std::vector<CostPoint> points;
        const Probes::Layers layers = probes_.solve(solver);
        auto measure = [&](int modes) {
            Probes::Layers kept = layers;
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
            set_errors(point, errors_of(probes_.values(kept), reference_));
            return point;
        };
        if (only_modes) return {measure(only_modes)};
        std::size_t most = 1;
        for (const LayerSolution& layer : layers)
            most = std::max(most, layer.reflection_modes.size());
        const CostPoint all = measure(static_cast<int>(most));
        for (const int modes : {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256}) {
            if (modes >= static_cast<int>(most)) {
                points.push_back(all);
                break;
            }
            points.push_back(measure(modes));
            if (points.back().error_largest <= 1.001 * all.error_largest) break;
        }
        return points;
    }

    /// Without points where so few nodes break the solver down.
    std::vector<CostPoint> try_solver(const SolverOptions& solver, int only_modes = 0) const {
        try {
            return measure_solver(solver, only_modes);
        } catch (const std::runtime_error& reason) {
            say(reason.what());
            return {};
        }
    }

    void sweep_solvers() {
        const std::vector<SolverOptions> variants = solver_variants(recipe_);
        sweep_nodes({variants.begin(), variants.begin() + 1});  // the cheapest by far
        // Random points are solved to a hundredth of the finest tolerance that is measured.
        const double enough = 1e-2 * finest_share * recipe_.tolerance;
        for (const CostPoint& point : solvers_) {
            point_nodes_ = point.solver.nodes;
            if (point.error_most <= enough) break;
        }
        sweep_nodes({variants.begin() + 1, variants.end()});
    }

    void sweep_nodes(const std::vector<SolverOptions>& variants) {
        for (const int nodes : {2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128}) {
            if (2 * nodes > study_.reference_nodes || !is_time_left(share_of_solver_errors)) break;
            double least = 1;
            for (SolverOptions solver : variants) {
                show("solving");
                solver.nodes = nodes;
                const std::vector<CostPoint> points = try_solver(solver);
                for (const CostPoint& point : points) least = std::min(least, point.error_largest);
                solvers_.insert(solvers_.end(), points.begin(), points.end());
            }
            if (least <= converged) break;
        }
    }

    void measure_chosen_solvers() {
        std::vector<CostPoint> chosen;
        for (const CostPoint& table : tables_) {
            if (table.tolerance == 0) continue;
            if (5 * table.solver.nodes > 4 * study_.reference_nodes) {
                say("tolerance " + short_number(table.tolerance) + ": its " +
                    std::to_string(table.solver.nodes) + " nodes are too near the converged " +
                    std::to_string(study_.reference_nodes) + " to be judged by them");
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
        time_solvers(chosen, infinity);
        solvers_.insert(solvers_.begin(), chosen.begin(), chosen.end());
        for (CostPoint& point : solvers_) point.solve_seconds = best_seconds_.at(key_of(point));
    }

    /// Points that are alike share their time.
    using SolverKey = std::tuple<Scheme, ClassicStart, double, int, int>;
    static SolverKey key_of(const CostPoint& point) {
        const SolverOptions& of = point.solver;
        return {of.scheme, of.start, of.start_depth, of.nodes, of.modes};
    }

    /// Several rounds over all points, so that no point's time is that of one busy moment; leaves
    /// out those that there is no time for.
    void time_solvers(std::vector<CostPoint>& points, double share) {
        auto effort = [](const CostPoint& point) {
            const SolverOptions& of = point.solver;
            return (of.scheme == Scheme::classic ? 10.0 : 1.0) * of.modes *
                   std::pow(of.nodes + 10, 3);
        };
        std::stable_sort(points.begin(), points.end(), [&](const CostPoint& a, const CostPoint& b) {
            return effort(a) < effort(b);
        });
        for (int round = 0; round < options_.rounds; ++round)
            for (const CostPoint& point : points) {
                if (!is_time_left(share)) break;
                show("timing");
                const double seconds = probes_.time_solve(point.solver);
                const auto [entry, is_new] = best_seconds_.try_emplace(key_of(point), seconds);
                entry->second = std::min(entry->second, seconds);
            }
        const auto untimed = std::erase_if(
            points, [&](const CostPoint& point) { return !best_seconds_.count(key_of(point)); });
        if (untimed) say(std::to_string(untimed) + " solvers left out: no time to time them");
    }

    // ---- tables --------------------------------------------------------------------------------

    BakeOptions bake_options() const {
        BakeOptions options;
        options.threads = options_.threads;
        return options;
    }

    /// Random points of the recipe's own range: tables may begin below it.
    void solve_points(const Discretisation& chosen) {
        show("solving");
        const Range depth = recipe_.optical_depth;
        Axis tau = optical_depth_axis(depth, 4, chosen.deepest_optical_depth);
        const AxisView sampled = tau.view();
        if (sampled.count > 1)
            tau = make_axis(AxisScale::logarithmic, depth.min, sampled.highest, sampled.count,
                            sampled.ends_at_infinity);
        const AxisView mu = mu_axis(chosen.mu_samples).view();
        const PointRange range{albedo_axis(recipe_.albedo, 2).view(),
                               tau.view(),
                               mu,
                               mu,
                               recipe_.reflection,
                               recipe_.transmission,
                               recipe_.lower_boundary};
        SolverOptions solver = solver_of(recipe_);
        solver.nodes = std::max(point_nodes_, chosen.nodes + 8);
        solver.mode_tolerance = 1e-4 * recipe_.tolerance;
        VerifyOptions options;
        options.samples = random_points;
        options.seed = point_seed;
        options.threads = options_.threads;
        options.progress = [&](double) { show("solving"); };
        expected_ = solve_random_points(recipe_.phase_function, range, solver, options);
        std::mt19937 random(point_seed);
        std::shuffle(expected_.begin(), expected_.end(), random);  // no two in a row share samples
    }

    /// Mean of all points; of each thousand in a row the best of several rounds, so that no other
    /// program's turn is counted.
    double time_lookup(const TableView& table) const {
        constexpr std::size_t in_a_row = 1000;
        double all = 0;
        volatile double sink = 0;
        for (std::size_t first = 0; first < expected_.size(); first += in_a_row) {
            const std::size_t last = std::min(expected_.size(), first + in_a_row);
            double best = infinity;
            for (int round = 0; round < options_.rounds; ++round) {
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

    CostPoint make_point(const Table& table, const Discretisation& d, double seconds) {
        CostPoint point;
        point.kind = CostPoint::Kind::table;
        point.discretisation = d;
        point.solver = solver_of(recipe_);
        point.solver.nodes = d.nodes;
        point.solver.modes = d.modes;
        point.solver.scheme = d.scheme;
        point.bake_seconds = seconds;
        point.bytes = static_cast<double>(
            (table.reflection_multiple.size() + table.transmission_multiple.size()) *
            sizeof(float));
        if (expected_.empty()) solve_points(d);
        std::vector<ErrorSample> samples = expected_;
        look_up(table.view(), samples);
        std::vector<double> errors;
        for (const ErrorSample& sample : samples) errors.push_back(sample.error);
        set_errors(point, std::move(errors));
        point.lookup_ns = time_lookup(table.view());
        return point;
    }

    /// Round tolerances from the coarsest to one that is finer than the recipe's own, and that.
    std::vector<double> tolerances() const {
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

    void bake_tolerances() {
        double last = 0;
        for (const double tolerance : tolerances()) {
            constexpr double growth = 4;  // of what a third of a tolerance takes
            const bool must = tolerance == recipe_.tolerance;
            if (!must && !is_time_left(share_of_tolerances, growth * last)) continue;
            show("tolerance");
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
            tables_.push_back(point);
            if (must) own_ = point;
            finest_nodes_ = std::max(finest_nodes_, d.nodes);
            finest_modes_ = std::max(finest_modes_, d.modes);
        }
    }

    bool can_vary(const SweptAxis& axis) const {
        if (axis.samples == &Discretisation::azimuth_samples)
            return !recipe_.phase_function.is_isotropic() ||
                   (recipe_.lower_boundary.kind == LowerBoundary::Kind::layer &&
                    !recipe_.lower_boundary.phase_function.is_isotropic());
        const Range& range = axis.samples == &Discretisation::albedo_samples
                                 ? recipe_.albedo
                                 : recipe_.optical_depth;
        return axis.samples == &Discretisation::mu_samples || range.min < range.max;
    }

    double bytes_of(const Discretisation& d) const {
        const auto depths = optical_depth_axis(recipe_.optical_depth,
                                               std::max(1, d.optical_depth_samples_per_octave),
                                               d.deepest_optical_depth)
                                .values.size();
        const auto albedos = albedo_axis(recipe_.albedo, d.albedo_samples).values.size();
        const int sides = (recipe_.reflection ? 1 : 0) + (recipe_.transmission ? 1 : 0);
        return static_cast<double>(sizeof(float) * depths * albedos) * sides * d.mu_samples *
               d.mu_samples * d.azimuth_samples;
    }

    /// At least one sample more or fewer, unless there is none to lose.
    static void scale(Discretisation& d, const SweptAxis& axis, double factor) {
        int& samples = d.*axis.samples;
        const int before = samples;
        samples = static_cast<int>(std::lround(factor * before));
        if (samples == before) samples += factor > 1 ? 1 : -1;
        samples = std::max(std::min(axis.least, before), samples);
    }

    /// The table that samples its axes so; null when none has been measured.
    const CostPoint* find_table(const Discretisation& d) const {
        const auto found =
            std::find_if(tables_.begin(), tables_.end(), [&](const CostPoint& point) {
                return std::all_of(std::begin(swept_axes), std::end(swept_axes),
                                   [&](const SweptAxis& axis) {
                                       return point.discretisation.*axis.samples == d.*axis.samples;
                                   });
            });
        return found == tables_.end() ? nullptr : &*found;
    }

    /// Solved finely enough for the finest tolerance: what is left is the sampling's error. Null
    /// when there is no time for it before that share of the seconds.
    const CostPoint* measure_table(Discretisation d, const char* varied, double share) {
        if (const CostPoint* known = find_table(d)) return known;
        const double bytes = bytes_of(d);
        if (bytes > largest_table || !is_time_left(share, bytes * seconds_per_byte_))
            return nullptr;
        show("sampling");
        d.nodes = finest_nodes_;
        d.modes = finest_modes_;
        Recipe resolved = recipe_;
        resolved.discretisation = d;
        const auto started = Clock::now();
        const Table table = solve_table(resolved, bake_options());
        CostPoint point = make_point(table, d, seconds_since(started));
        point.varied = varied;
        seconds_per_byte_ = seconds_since(started) / bytes;
        tables_.push_back(point);
        return &tables_.back();
    }

    /// Around what the recipe's tolerance chose: one axis at a time, then all of them together.
    void sweep_tables() {
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

    static bool keeps(double tolerance, const CostPoint& table) {
        return table.error_most <= tolerance && table.error_largest <= 5 * tolerance;
    }

    /// From every tolerance's choice, cheap ones first, as coarse as leaves the table as accurate;
    /// then as coarse as keeps the tolerance. What they end with says which choice was too fine.
    void coarsen_chosen_tables() {
        std::vector<CostPoint> chosen;
        for (const CostPoint& point : tables_)
            if (point.tolerance > 0) chosen.push_back(point);
        std::sort(chosen.begin(), chosen.end(),
                  [](const CostPoint& a, const CostPoint& b) { return a.bytes < b.bytes; });
        for (const CostPoint& from : chosen)
            coarsen(from.discretisation,
                    [&](const CostPoint& table) { return table.error_most <= from.error_most; });
        for (const CostPoint& from : chosen)
            coarsen(from.discretisation,
                    [&](const CostPoint& table) { return keeps(from.tolerance, table); });
    }

    /// One axis after the other a little coarser, round after round, as long as that will do.
    template <class WillDo>
    void coarsen(Discretisation now, WillDo will_do) {
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

    // ---- the frontier --------------------------------------------------------------------------

    static void judge(std::vector<CostPoint>& points) {
        std::vector<Trade> trades;
        for (const CostPoint& point : points) trades.push_back({point.cost(), point.error_most});
        for (const std::size_t at : find_frontier(trades)) points[at].on_frontier = true;
        for (CostPoint& point : points) {
            double cheapest = point.cost();
            for (const CostPoint& other : points)
                if (other.error_most <= point.error_most)
                    cheapest = std::min(cheapest, other.cost());
            point.times_frontier = point.cost() / cheapest;
        }
    }

    void tell_distances() const {
        for (const CostPoint& point : solvers_)
            if (point.tolerance > 0)
                say("tolerance " + short_number(point.tolerance) + ": solver error " +
                    short_number(point.error_most) + ", " + short_number(point.times_frontier) +
                    " times the time of the cheapest that is as accurate");
        for (const CostPoint& point : tables_) {
            if (point.tolerance == 0) continue;
            double least = infinity;
            for (const CostPoint& other : tables_)
                if (keeps(point.tolerance, other)) least = std::min(least, other.bytes);
            say("tolerance " + short_number(point.tolerance) + ": table error " +
                short_number(point.error_most) + ", " + short_number(point.times_frontier) +
                " times the bytes of the cheapest that is as accurate, " +
                (std::isinf(least) ? "none keeps it"
                                   : short_number(point.bytes / least) +
                                         " times those of the cheapest that keeps it"));
        }
    }

    const Recipe& recipe_;
    const CostOptions& options_;
    const Clock::time_point started_ = Clock::now();
    const Probes probes_;
    Probes::Values reference_;
    CostStudy study_;
    std::vector<CostPoint> solvers_, tables_;
    std::vector<ErrorSample> expected_;  // random points; found and error unused
    CostPoint own_;                      // the table that the recipe's tolerance chose
    std::map<SolverKey, double> best_seconds_;
    int point_nodes_ = 0;  // that solve the random points
    int finest_nodes_ = 0, finest_modes_ = 0;
    double seconds_per_byte_ = 0;
};

constexpr int digits = 6;  // of numbers

struct CostColumn {
    const char* name;
    const char* meaning;
    enum class Of { both, solver, table } of;
    std::string (*text)(const CostPoint& point);
};

using Of = CostColumn::Of;

constexpr CostColumn columns[] = {
    {"kind", "solver or table", Of::both,
     [](const CostPoint& p) {
         return std::string(p.kind == CostPoint::Kind::solver ? "solver" : "table");
     }},
    {"varied", "tolerance: it chose the point; else what the sweep changed", Of::both,
     [](const CostPoint& p) { return p.varied; }},
    {"tolerance", "that chose the point; empty where none did", Of::both,
     [](const CostPoint& p) { return p.tolerance > 0 ? short_number(p.tolerance, digits) : ""; }},
    {"scheme", "of the solver: harmonic or classic", Of::both,
     [](const CostPoint& p) {
         return std::string(p.solver.scheme == Scheme::classic ? "classic" : "harmonic");
     }},
    {"start", "of the classic scheme: diamond or single", Of::both,
     [](const CostPoint& p) {
         if (p.solver.scheme != Scheme::classic) return std::string();
         return std::string(p.solver.start == ClassicStart::single ? "single" : "diamond");
     }},
    {"start_depth", "of the classic scheme, at most; 0: 1e-3 of the smallest cosine", Of::both,
     [](const CostPoint& p) {
         return p.solver.scheme == Scheme::classic ? short_number(p.solver.start_depth, digits)
                                                   : "";
     }},
    {"nodes", "Gauss nodes of the solver", Of::both,
     [](const CostPoint& p) { return std::to_string(p.solver.nodes); }},
    {"modes", "azimuthal modes of the solver", Of::both,
     [](const CostPoint& p) { return std::to_string(p.solver.modes); }},
    {"mu_samples", "of mu_in and mu_out alike", Of::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.mu_samples); }},
    {"azimuth_samples", "over 0 to 180 degrees", Of::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.azimuth_samples); }},
    {"optical_depth_samples_per_octave", "samples in which the depth doubles", Of::table,
     [](const CostPoint& p) {
         return std::to_string(p.discretisation.optical_depth_samples_per_octave);
     }},
    {"albedo_samples", "over the recipe's range", Of::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.albedo_samples); }},
    {"error_median", "relative error of half of the values", Of::both,
     [](const CostPoint& p) { return short_number(p.error_median, digits); }},
    {"error_99_9", "relative error of 99.9 % of the values; the frontier's", Of::both,
     [](const CostPoint& p) { return short_number(p.error_most, digits); }},
    {"error_largest", "largest relative error", Of::both,
     [](const CostPoint& p) { return short_number(p.error_largest, digits); }},
    {"solve_seconds", "one layer, deepest and brightest, 14 cosines, one thread", Of::solver,
     [](const CostPoint& p) { return short_number(p.solve_seconds, digits); }},
    {"bake_seconds", "all threads; where tolerance chose, with choosing and checking", Of::table,
     [](const CostPoint& p) { return short_number(p.bake_seconds, digits); }},
    {"bytes", "of the samples of both sides in memory", Of::table,
     [](const CostPoint& p) { return short_number(p.bytes, digits); }},
    {"lookup_ns", "nanoseconds of a lookup at a random point, one thread", Of::table,
     [](const CostPoint& p) { return short_number(p.lookup_ns, digits); }},
    {"on_frontier", "1: no other point undercuts it in error and in solve_seconds or bytes",
     Of::both, [](const CostPoint& p) { return std::string(p.on_frontier ? "1" : "0"); }},
    {"times_frontier", "solve_seconds or bytes over those of the cheapest as accurate", Of::both,
     [](const CostPoint& p) { return short_number(p.times_frontier, digits); }},
};

}  // namespace

CostStudy measure_cost(const Recipe& recipe, const CostOptions& options) {
    require(options.seconds > 0, "measure_cost", "seconds", "above 0", options.seconds);
    require(options.rounds >= 1, "measure_cost", "rounds", ">= 1", options.rounds);
    require(!recipe.mixture, "measure_cost", "second_phase_function",
            "absent: costs are of one mixture", recipe.second_phase_function.text());
    return CostMeter(recipe, options).measure();
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
    const char* between = "";
    for (const CostColumn& column : columns) {
        out << between << column.name;
        between = ",";
    }
    out << '\n';
    for (const CostPoint& point : points) {
        between = "";
        const Of own = point.kind == CostPoint::Kind::solver ? Of::solver : Of::table;
        for (const CostColumn& column : columns) {
            out << between;
            if (column.of == Of::both || column.of == own) out << column.text(point);
            between = ",";
        }
        out << '\n';
    }
}

const std::vector<std::pair<const char*, const char*>>& cost_columns() {
    static const auto list = [] {
        std::vector<std::pair<const char*, const char*>> names;
        for (const CostColumn& column : columns) names.emplace_back(column.name, column.meaning);
        return names;
    }();
    return list;
}

}  // namespace stratus
