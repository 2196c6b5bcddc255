#include "cost_growth.h"

#include <stratus/bake/forecast.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include "cost_layers.h"
#include "family_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace stratus {

namespace {

using Kind = CostPoint::Kind;
using Measured = std::vector<std::pair<double, double>>;

/// Adds a law where there are points enough for one.
void add_law(std::vector<GrowthLaw>& laws, const std::string& what, const std::string& of,
             const Measured& measured) {
    Measured usable;
    for (const auto& [x, y] : measured)
        if (x > 0 && y > 0) usable.push_back({x, y});
    const auto all_alike = [&] {
        return std::ranges::all_of(usable,
                                   [&](const auto& at) { return at.first == usable[0].first; });
    };
    if (usable.size() < 3 || all_alike()) return;
    laws.push_back({what, of, fit_power_law(usable)});
}

/// Eight modes, which fill a register, or the one that there is.
SolverOptions timed_solver(const Recipe& recipe, int nodes) {
    SolverOptions solver = solver_of(recipe);
    solver.nodes = nodes;
    solver.modes = recipe.phase_function.is_isotropic() ? 1 : 8;
    return solver;
}

Measured time_nodes(const Recipe& recipe, const CostBudget& budget) {
    const CostLayers layers(recipe, 1);
    Measured measured;
    for (const int nodes : {16, 24, 32, 48, 64, 96}) {
        if (!budget.is_time_left(share_of_orders)) break;
        measured.push_back({nodes, layers.time_solve(timed_solver(recipe, nodes))});
    }
    return measured;
}

/// From where a layer is no longer thin.
Measured time_depths(const Recipe& recipe, const CostBudget& budget) {
    Measured measured;
    for (const double depth : {1.0, 4.0, 16.0, 64.0, 256.0}) {
        if (!budget.is_time_left(share_of_orders)) break;
        Recipe of_depth = recipe;
        of_depth.optical_depth = {depth, depth};
        constexpr int nodes = 32;
        measured.push_back(
            {depth, CostLayers(of_depth, 1).time_solve(timed_solver(recipe, nodes))});
    }
    return measured;
}

/// Predicts a bake on ranks of one thread each, as `stratus bake --dry-run --ranks` predicts it.
Measured predict_ranks(const Recipe& recipe, const CostBudget& budget) {
    if (!budget.is_time_left(share_of_orders)) return {};
    BakeOptions options;
    options.threads = 1;
    const Forecast ahead = forecast(recipe, options);
    Measured predicted;
    for (const int ranks : {1, 2, 4, 8, 16})
        predicted.push_back({ranks, predict_on_ranks(ahead, ranks, 1).total()});
    return predicted;
}

/// Points of a kind for which holds(point).
template <class X, class Y, class Holds>
Measured pairs_of(const std::vector<CostPoint>& points, Kind kind, const X& x, const Y& y,
                  const Holds& holds) {
    Measured measured;
    for (const CostPoint& point : points)
        if (point.kind == kind && holds(point)) measured.push_back({x(point), y(point)});
    return measured;
}

/// Errors over the members along an axis, as far as they are that axis' own: at least twice what is
/// left with the most members, which other axes leave.
Measured errors_along(const std::vector<CostPoint>& points, PhaseParameter parameter) {
    const std::vector<CostPoint> along = points_along(points, parameter);
    Measured own;
    for (const CostPoint& point : along)
        if (point.error_99_9 >= 2 * along.back().error_99_9)
            own.push_back({point.members[static_cast<std::size_t>(parameter)], point.error_99_9});
    return own;
}

}  // namespace

std::vector<CostPoint> points_along(const std::vector<CostPoint>& points,
                                    PhaseParameter parameter) {
    const auto members = [&](const CostPoint& p) {
        return p.members[static_cast<std::size_t>(parameter)];
    };
    // The first that was swept; coarser tables follow, which differ along several axes.
    const auto first = std::ranges::find(points, samples_key(parameter), &CostPoint::varied);
    if (first == points.end()) return {};
    const auto all_else = [&](const CostPoint& p) {
        std::array others = p.members;
        others[static_cast<std::size_t>(parameter)] = 0;
        const Discretisation& d = p.discretisation;
        return std::tuple(p.kind, others, d.mu_samples, d.azimuth_samples,
                          d.optical_depth_samples_per_octave, d.albedo_samples);
    };
    std::vector<CostPoint> along;
    for (const CostPoint& point : points)
        if (all_else(point) == all_else(*first)) along.push_back(point);
    std::ranges::sort(along, {}, members);
    return along;
}

PowerLaw fit_power_law(const std::vector<std::pair<double, double>>& points) {
    constexpr const char* caller = "fit_power_law";
    require(points.size() >= 3, caller, "points", "at least three", points.size());
    const auto count = static_cast<double>(points.size());
    double mean_x = 0, mean_y = 0;
    for (const auto& [x, y] : points) {
        require(x > 0 && std::isfinite(x), caller, "x", "above 0 and finite", x);
        require(y > 0 && std::isfinite(y), caller, "y", "above 0 and finite", y);
        mean_x += std::log(x) / count;
        mean_y += std::log(y) / count;
    }
    const auto [from, to] = std::ranges::minmax(
        points, {}, [](const std::pair<double, double>& point) { return point.first; });
    require(from.first < to.first, caller, "x", "of more than one value", from.first);
    double xx = 0, xy = 0;
    for (const auto& [x, y] : points) {
        xx += (std::log(x) - mean_x) * (std::log(x) - mean_x);
        xy += (std::log(x) - mean_x) * (std::log(y) - mean_y);
    }
    const double exponent = xy / xx;
    double scatter = 0;
    for (const auto& [x, y] : points) {
        const double off = std::log(y) - mean_y - exponent * (std::log(x) - mean_x);
        scatter += off * off;
    }
    return {exponent, std::sqrt(scatter / (count - 2) / xx), points.size(), from.first, to.first};
}

std::string sentence_of(const GrowthLaw& growth) {
    const PowerLaw& law = growth.law;
    return growth.what + " grows as " + growth.of + "^" + short_number(law.exponent, 3) + " +- " +
           short_number(law.standard_error, 2) + " (" + std::to_string(law.points) + " points, " +
           short_number(law.from) + " to " + short_number(law.to) + ")";
}

std::vector<GrowthLaw> time_growth(const Recipe& alone, const Recipe& recipe,
                                   const CostBudget& budget) {
    std::vector<GrowthLaw> laws;
    budget.show("growth");
    add_law(laws, "time of a solve with eight modes", "nodes", time_nodes(alone, budget));
    add_law(laws, "time of a solve with 32 nodes", "optical depth", time_depths(alone, budget));
    add_law(laws, "predicted time of a bake", "ranks", predict_ranks(recipe, budget));
    return laws;
}

std::vector<GrowthLaw> find_growth(const std::vector<CostPoint>& points) {
    std::vector<GrowthLaw> laws;
    const auto tolerance = [](const CostPoint& p) { return p.tolerance; };
    const auto seconds = [](const CostPoint& p) { return p.solve_seconds; };
    const auto error = [](const CostPoint& p) { return p.error_99_9; };
    const auto bytes = [](const CostPoint& p) { return p.bytes; };
    const auto chosen = [](const CostPoint& p) { return p.tolerance > 0; };
    add_law(laws, "time of a solve", "tolerance",
            pairs_of(points, Kind::solver, tolerance, seconds, chosen));
    add_law(laws, "time of a bake", "tolerance",
            pairs_of(
                points, Kind::table, tolerance, [](const CostPoint& p) { return p.bake_seconds; },
                chosen));
    add_law(laws, "size of a table", "tolerance",
            pairs_of(points, Kind::table, tolerance, bytes, chosen));
    add_law(laws, "size of a packed table", "tolerance",
            pairs_of(points, Kind::packed, tolerance, bytes, chosen));
    for (const PhaseParameter parameter : all_parameters)
        add_law(laws, "error of a table", "members along " + std::string(parameter_name(parameter)),
                errors_along(points, parameter));
    add_law(laws, "error of Markov chains", "time",
            pairs_of(points, Kind::reference, seconds, error,
                     [](const CostPoint& p) { return p.sublayers > 0; }));
    add_law(laws, "error of photons", "time",
            pairs_of(points, Kind::reference, seconds, error,
                     [](const CostPoint& p) { return p.photons > 0; }));
    add_law(laws, "error with 32 nodes", "size of droplets",
            pairs_of(
                points, Kind::droplets, [](const CostPoint& p) { return p.size_parameter; }, error,
                [](const CostPoint& p) { return p.solver.nodes == 32; }));
    return laws;
}

}  // namespace stratus
