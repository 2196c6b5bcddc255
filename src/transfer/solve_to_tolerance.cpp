#include <stratus/transfer/solve_to_tolerance.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/phase/path_law.h>
#include <stratus/transfer/stack.h>

#include "convergence.h"
#include "light_inside.h"
#include "options.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace stratus {

namespace {

constexpr int fewest_nodes = 8, fewest_nodes_of_fluxes = 20, fewest_nodes_of_peaks = 32,
              most_nodes = 512;
constexpr double rough = 1e-2;                   // tolerance of what few nodes are compared with
constexpr double grazing_mode_tolerance = 1e-8;  // far less than their interpolation leaves

std::vector<double> to_list(const Eigen::VectorXd& values) {
    return {values.begin(), values.end()};
}

/// Half as many again, in whole registers.
int more_nodes(int nodes) { return std::min(most_nodes, (3 * nodes / 2 + 3) / 4 * 4); }

constexpr int least_patience = 96;  // nodes before a tolerance can be given up as out of reach

/// Nodes that leave less than `rest` of the moment after the last they hold, from least_patience on;
/// least_patience where that takes so many that they take minutes.
int nodes_that_hold(const PhaseFunction& phase_function, int moments_to_a_node, double rest) {
    constexpr int most = 248;
    const std::vector<double> moments = phase_function.moments(moments_to_a_node * most + 1);
    const auto left = [&](int nodes) { return std::abs(moments[size(moments_to_a_node * nodes)]); };
    if (left(most) > rest) return least_patience;
    int nodes = least_patience;
    while (left(nodes) > rest) nodes = more_nodes(nodes);
    return nodes;
}

/// Backward peaks may begin to converge with as many nodes as hold their series: in stacks nothing
/// truncates them.
int patience_for(const StackLayers& layers) {
    int patience = least_patience;
    for (const StackLayer& layer : layers)
        if (layer.phase_function.asymmetry() <= -0.9)
            patience = std::max(patience, nodes_that_hold(layer.phase_function, 2, 1e-4));
    return patience;
}

int fewer_nodes(int nodes) { return (2 * nodes + 1) / 3; }

/// Values whose errors are alike, and converge alike.
struct Class {
    std::vector<bool> counts;  // which of them have to meet the tolerance
    double least_error = 0;    // that is stated, relative to the value
    Convergence convergence;
    std::vector<double> values, errors;  // last found; absolute errors, once these can be told
    int nodes = 0;
    bool is_done = false;

    void add(std::vector<double> found, int with_nodes) {
        convergence.add(found);
        values = std::move(found);
        nodes = with_nodes;
        if (!convergence.can_tell()) return;
        errors = convergence.errors();
        for (std::size_t i = 0; i < errors.size(); ++i)
            errors[i] += least_error * std::abs(values[i]);
    }

    /// The largest error of the values that count, relative to the value.
    double error() const {
        double largest = 0;
        for (std::size_t i = 0; i < counts.size(); ++i)
            if (counts[i]) largest = std::max(largest, relative_error(values[i], errors[i]));
        return largest;
    }
};

struct Aim {
    double tolerance;
    int first_nodes;
    int patience;  // nodes before the tolerance can be given up
};

/// Values of each class.
using ClassValues = std::vector<std::vector<double>>;

/// Solves with more and more nodes, until what counts of every class is within the tolerance or will
/// not be with the most nodes. `solve` gives the values of each class that is not done.
template <class Solve>
void solve_until(const Aim& aim, std::vector<Class>& classes, const Solve& solve) {
    for (int nodes = aim.first_nodes; !std::ranges::all_of(classes, &Class::is_done);
         nodes = more_nodes(nodes)) {
        ClassValues values;
        try {
            values = solve(nodes);
        } catch (const std::runtime_error&) {  // the phase function's series is too negative
            if (nodes == most_nodes) throw;
            continue;
        }
        const double steps = std::log(most_nodes / static_cast<double>(nodes)) / std::log(1.5);
        for (std::size_t k = 0; k < classes.size(); ++k) {
            Class& of = classes[k];
            if (of.is_done) continue;
            of.add(std::move(values[k]), nodes);
            if (!of.convergence.can_tell()) continue;
            const double error = of.error();
            const bool is_out_of_reach =
                nodes >= aim.patience &&
                error * std::pow(of.convergence.decay(), steps) > aim.tolerance;
            of.is_done = error <= aim.tolerance || nodes == most_nodes || is_out_of_reach;
        }
    }
}

/// Solves with `nodes`, and compares with fewer; or, where these are few, with more.
template <class Solve>
void solve_with(int nodes, int patience, std::vector<Class>& classes, const Solve& solve) {
    const std::vector<Class> blank = classes;
    if (nodes >= fewest_nodes) {
        const int third = fewer_nodes(nodes), second = fewer_nodes(third);
        try {
            for (const int count : {fewer_nodes(second), second, third, nodes}) {
                ClassValues values = solve(count);
                for (std::size_t k = 0; k < classes.size(); ++k)
                    classes[k].add(std::move(values[k]), count);
            }
            return;
        } catch (const std::runtime_error&) {  // perhaps only of the fewer ones
            classes = blank;
        }
    }
    solve_until({rough, fewest_nodes, patience}, classes, solve);
    for (Class& of : classes) of.is_done = false;
    ClassValues values = solve(nodes);
    for (std::size_t k = 0; k < classes.size(); ++k) {
        Class& of = classes[k];
        for (std::size_t i = 0; i < of.values.size(); ++i)
            of.errors[i] += std::abs(values[k][i] - of.values[i]);
        of.values = std::move(values[k]);
        of.nodes = nodes;
    }
}

/// Solves as options say.
template <class Solve>
void solve_as(const SolverOptions& options, const Aim& aim, std::vector<Class>& classes,
              const Solve& solve) {
    if (options.tolerance == 0)
        solve_with(options.nodes, aim.patience, classes, solve);
    else
        solve_until(aim, classes, solve);
}

/// Where to begin when `found` nodes sufficed for the like.
int first_nodes_after(int found) {
    int first = fewest_nodes;
    while (more_nodes(more_nodes(more_nodes(first))) < found) first = more_nodes(first);
    return first;
}

/// Grazing geometries need many more nodes than others, and are no measure of them.
constexpr std::size_t class_count = 3;

std::size_t geometry_class(const Geometry& at) {
    const double least = std::min(at.mu_in, at.mu_out);
    return least >= least_path_cosine ? 0 : least >= 0.05 ? 1 : 2;
}

/// One layer over nothing, all orders of a narrow peak, the nodes left to the tolerance.
bool can_resolve_peaks(const StackLayers& layers, const LowerBoundary& boundary,
                       const SolverOptions& options) {
    return options.tolerance > 0 && options.moments == 0 && options.orders == 0 &&
           options.scheme == Scheme::harmonic && options.truncate == Truncate::smooth &&
           layers.size() == 1 && !boundary.is_present() &&
           has_narrow_peak(layers.front().phase_function);
}

/// Geometries that are solved at once.
class Group {
  public:
    /// Takes geometries in the order of `places`, from `first` on, until their cosines make a list of
    /// reasonable length: extra directions cost as much as nodes do, or, `resolved`, twice as much.
    Group(const std::vector<Geometry>& geometries, const std::vector<std::size_t>& places,
          std::size_t first, bool resolved)
        : classes_(resolved ? 1 : class_count) {
        const std::size_t most_cosines = resolved ? 32 : 64;
        std::set<double> cosines;
        for (std::size_t i = first; i < places.size() && cosines.size() + 2 <= most_cosines; ++i) {
            const Geometry& at = geometries[places[i]];
            cosines.insert({at.mu_in, at.mu_out});
            Pair& pair = pairs_[{at.mu_in, at.mu_out}];
            pair.kind = resolved ? 0 : geometry_class(at);
            asked_.push_back({&pair, pair.azimuths.size()});
            pair.azimuths.push_back(at.azimuth);
        }
        for (auto& [cosine, pair] : pairs_) {
            const std::size_t count = pair.azimuths.size();
            // Few values may agree by chance; others are looked at with them.
            if (count < 4)
                for (const double more : {0.0, 0.25, 0.5, 0.75, 1.0})
                    pair.azimuths.push_back(more * pi);
            std::vector<bool>& counts = classes_[pair.kind].counts;
            pair.first = counts.size();
            for (std::size_t side = 0; side < 2; ++side)
                for (std::size_t k = 0; k < pair.azimuths.size(); ++k) counts.push_back(k < count);
        }
        for (Class& of : classes_) {
            of.is_done = of.counts.empty();
            if (resolved) of.least_error = grazing_mode_tolerance;
        }
    }

    std::size_t size() const { return asked_.size(); }
    std::vector<Class>& classes() { return classes_; }

    /// Returns R and T, pair after pair at all azimuths, of each class that is not done. `solve` gives
    /// the layers, or the light at a level inside, at a list of cosines.
    template <class Solve>
    ClassValues values(const Solve& solve) {
        std::set<double> cosines;
        for (const auto& [cosine, pair] : pairs_)
            if (!classes_[pair.kind].is_done) cosines.insert({cosine.first, cosine.second});
        const std::vector<double> mu(cosines.begin(), cosines.end());
        const auto node_index = [&](double cosine) {
            return static_cast<int>(std::ranges::lower_bound(mu, cosine) - mu.begin());
        };
        const auto solution = solve(mu);
        ClassValues all(classes_.size());
        for (auto& [cosine, pair] : pairs_) {
            if (classes_[pair.kind].is_done) continue;
            for (const Side side : both_sides) {
                std::vector<SolvedValue>& values = side == Side::reflection ? pair.R : pair.T;
                values = solution.values(side, node_index(cosine.first), node_index(cosine.second),
                                         pair.azimuths);
                for (const SolvedValue& value : values) all[pair.kind].push_back(value.total);
            }
        }
        return all;
    }

    /// The i-th geometry as last solved.
    SolvedGeometry at(std::size_t i) const {
        const auto& [pair, k] = asked_[i];
        const std::vector<double>& errors = classes_[pair->kind].errors;
        const std::size_t reflection = pair->first + k,
                          transmission = reflection + pair->azimuths.size();
        return {pair->R[k], pair->T[k], errors[reflection], errors[transmission]};
    }

  private:
    struct Pair {
        std::size_t kind = 0;           // of class
        std::vector<double> azimuths;   // those asked, and others
        std::vector<SolvedValue> R, T;  // at them
        std::size_t first = 0;          // of R's among the values of its class; T's follow
    };
    struct Asked {
        const Pair* pair;
        std::size_t azimuth;
    };

    std::vector<Class> classes_;
    std::map<std::pair<double, double>, Pair> pairs_;
    std::vector<Asked> asked_;
};

/// Solves the geometries at `places`; `solve` gives the layers at cosines, as options say.
template <class Solve>
void solve_places(const std::vector<Geometry>& geometries, const std::vector<std::size_t>& places,
                  bool resolved, int patience, SolverOptions options, const Solve& solve,
                  SolvedGeometries& all) {
    const NumberRange cosines = "[1e-100, 1]";
    for (const auto& [mu_in, mu_out, azimuth] : geometries) {
        for (const double mu : {mu_in, mu_out}) require_in(cosines, "solve", "mu", mu);
        require(std::isfinite(azimuth), "solve", "azimuth", "finite", azimuth);
    }
    int first_nodes = resolved ? fewest_nodes_of_peaks : fewest_nodes;
    for (std::size_t first = 0; first < places.size();) {
        Group group(geometries, places, first, resolved);
        SolverOptions with = options;
        solve_as(
            options, {options.tolerance, first_nodes, patience}, group.classes(), [&](int nodes) {
                with.nodes = nodes;
                return group.values([&](const std::vector<double>& mu) { return solve(mu, with); });
            });
        for (std::size_t i = 0; i < group.size(); ++i) all.at[places[first + i]] = group.at(i);
        first += group.size();
        int fewest = most_nodes;
        for (const Class& of : group.classes())
            if (!of.counts.empty()) {
                fewest = std::min(fewest, of.nodes);
                all.nodes = std::max(all.nodes, of.nodes);
            }
        first_nodes = std::max(first_nodes, first_nodes_after(fewest));
    }
}

/// Fills in fluxes: `count` values, which solve(options) gives, their errors and the nodes.
template <class Solved, class Solve>
void fill_fluxes(const StackLayers& layers, const SolverOptions& options, std::size_t count,
                 Solved& solved, const Solve& solve) {
    SolverOptions with = options;
    with.modes = 1;  // fluxes are made of the first azimuthal mode alone
    // That is quickly solved with so many nodes that peaks need no other truncation.
    if (options.truncate == Truncate::smooth) with.truncate = Truncate::delta_m;
    std::vector<Class> classes(1);
    classes[0].counts.assign(count, true);
    solve_as(options, {options.tolerance, fewest_nodes_of_fluxes, patience_for(layers)}, classes,
             [&](int nodes) {
                 with.nodes = nodes;
                 return ClassValues{solve(with)};
             });
    solved.error = std::ranges::max(classes[0].errors);
    solved.relative_error = classes[0].error();
    solved.nodes = classes[0].nodes;
}

}  // namespace

SolvedGeometries solve_geometries(const StackLayers& layers, const LowerBoundary& boundary,
                                  const std::vector<Geometry>& geometries,
                                  const SolverOptions& options) {
    check_options(options);
    SolvedGeometries all;
    all.at.resize(geometries.size());
    const bool can_resolve = can_resolve_peaks(layers, boundary, options);
    std::vector<std::size_t> plain, resolved;
    for (std::size_t i = 0; i < geometries.size(); ++i)
        (can_resolve && geometry_class(geometries[i]) > 0 ? resolved : plain).push_back(i);
    const auto solve = [&](const std::vector<double>& mu, const SolverOptions& with) {
        return solve_stack(layers, boundary, mu, with);
    };
    SolverOptions with = options;
    with.exact_fluxes = false;
    if (!plain.empty())
        solve_places(geometries, plain, false, patience_for(layers), with, solve, all);
    with.grazing = true;
    with.mode_tolerance = std::max(options.mode_tolerance, grazing_mode_tolerance);
    // Resolved peaks, too, may begin to converge with as many nodes as hold their series.
    if (!resolved.empty())
        solve_places(geometries, resolved, true,
                     nodes_that_hold(layers.front().phase_function, moments_completed, 1e-2), with,
                     solve, all);
    return all;
}

SolvedGeometries solve_geometries_inside(const StackLayers& layers, const LowerBoundary& boundary,
                                         double level, const std::vector<Geometry>& geometries,
                                         const SolverOptions& options) {
    check_options(options);
    SolvedGeometries all;
    all.at.resize(geometries.size());
    std::vector<std::size_t> places(geometries.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    solve_places(
        geometries, places, false, patience_for(layers), options,
        [&](const std::vector<double>& mu, const SolverOptions& with) {
            return solve_inside(layers, boundary, {level}, mu, with);
        },
        all);
    return all;
}

double relative_error(double value, double error) noexcept {
    constexpr double least_value = 1e-8;
    return error / std::max(std::abs(value), least_value);
}

ChosenNodes choose_nodes(const StackLayers& layers, const LowerBoundary& boundary,
                         const SolverOptions& options) {
    const std::vector<double> cosines{0.15, 0.35, 0.6, 0.85, 1};
    std::vector<Geometry> geometries;
    for (const double in : cosines)
        for (const double out : cosines)
            for (const double azimuth : {0.0, pi / 3, 2 * pi / 3, pi})
                geometries.push_back({in, out, azimuth});
    const SolvedGeometries solved = solve_geometries(layers, boundary, geometries, options);
    ChosenNodes chosen{solved.nodes, 0};
    for (const SolvedGeometry& at : solved.at)
        for (const auto& [value, error] : {std::pair{at.reflection.total, at.reflection_error},
                                           std::pair{at.transmission.total, at.transmission_error}})
            chosen.error = std::max(chosen.error, relative_error(value, error));
    return chosen;
}

SolvedFluxes solve_fluxes(const StackLayers& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options) {
    check_options(options);
    // Without `mu` a solution has the fluxes at its nodes.
    const auto at_cosines = [&](const Eigen::VectorXd& all) {
        return mu.empty() ? std::vector<double>() : to_list(all);
    };
    SolvedFluxes solved;
    fill_fluxes(layers, options, 3 * mu.size() + 3, solved, [&](const SolverOptions& with) {
        const StackSolution fluxes = solve_stack(layers, boundary, mu, with);
        solved = {at_cosines(fluxes.plane_albedo),
                  at_cosines(fluxes.diffuse_transmittance),
                  at_cosines(fluxes.ground_absorptance),
                  fluxes.spherical_albedo,
                  fluxes.total_transmittance,
                  fluxes.spherical_ground_absorptance};
        std::vector<double> values{solved.spherical_albedo, solved.total_transmittance,
                                   solved.spherical_ground_absorptance};
        for (const std::vector<double>* const list :
             {&solved.plane_albedo, &solved.diffuse_transmittance, &solved.ground_absorptance}) {
            values.insert(values.end(), list->begin(), list->end());
            if (list->empty()) values.resize(values.size() + mu.size());
        }
        return values;
    });
    return solved;
}

SolvedInside solve_fluxes_inside(const StackLayers& layers, const LowerBoundary& boundary,
                                 const std::vector<double>& levels, const std::vector<double>& mu,
                                 const SolverOptions& options) {
    check_options(options);
    require(!mu.empty(), "solve_inside", "mu", "one or more", "none");
    SolvedInside solved;
    const std::size_t count = 3 * mu.size() * levels.size();
    fill_fluxes(layers, options, count, solved, [&](const SolverOptions& with) {
        solved.levels.clear();
        std::vector<double> values;
        for (const LightAtLevel& at : solve_inside(layers, boundary, levels, mu, with).levels) {
            solved.levels.push_back({at.optical_depth, to_list(at.direct_flux),
                                     to_list(at.diffuse_transmittance), to_list(at.plane_albedo),
                                     to_list(at.actinic_flux), to_list(at.heating_rate)});
            for (const Eigen::VectorXd* const list :
                 {&at.plane_albedo, &at.diffuse_transmittance, &at.actinic_flux})
                values.insert(values.end(), list->begin(), list->end());
        }
        return values;
    });
    return solved;
}

}  // namespace stratus
