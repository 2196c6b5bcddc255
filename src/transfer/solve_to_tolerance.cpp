#include <stratus/transfer/solve_to_tolerance.h>

#include <stratus/base/constants.h>
#include <stratus/phase/path_law.h>
#include <stratus/transfer/stack.h>

#include "convergence.h"
#include "options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace stratus {

namespace {

constexpr int fewest_nodes = 8, fewest_nodes_of_fluxes = 20, most_nodes = 512;
constexpr double rough = 1e-2;                   // tolerance of what few nodes are compared with
constexpr double grazing_mode_tolerance = 1e-8;  // far less than their interpolation leaves

/// Half as many again, in whole registers.
int more_nodes(int nodes) { return std::min(most_nodes, (3 * nodes / 2 + 3) / 4 * 4); }

/// Nodes before a tolerance can be given up as out of reach. Backward peaks may begin to converge
/// with as many as hold their series: in stacks nothing truncates them.
int patience_for(const std::vector<StackLayer>& layers) {
    constexpr double held = 1e-4;  // moment that is left
    constexpr int most = 248;      // more take minutes
    int patience = 96;
    for (const StackLayer& layer : layers) {
        if (layer.phase_function.asymmetry() > -0.9) continue;
        const std::vector<double> moments = layer.phase_function.moments(2 * most + 1);
        if (std::abs(moments.back()) > held) continue;
        while (std::abs(moments[static_cast<std::size_t>(2 * patience)]) > held)
            patience = more_nodes(patience);
    }
    return patience;
}

int fewer_nodes(int nodes) { return (2 * nodes + 1) / 3; }

struct EstimatedValues {
    std::vector<double> values, errors;  // absolute errors
    int nodes = 0;
};

/// The largest error of the values that count, relative to the value.
double largest_relative(const EstimatedValues& found, const std::vector<bool>& counts) {
    double largest = 0;
    for (std::size_t i = 0; i < found.values.size(); ++i)
        if (counts[i])
            largest = std::max(largest, relative_error(found.values[i], found.errors[i]));
    return largest;
}

struct Aim {
    double tolerance;
    int first_nodes;
    int patience;                     // nodes before the tolerance can be given up
    const std::vector<bool>& counts;  // which values have to meet it
};

/// Solves with more and more nodes, until the values that count are within the tolerance or will
/// not be with the most nodes. `solve` gives all values by a number of nodes.
template <class Solve>
EstimatedValues solve_until(const Aim& aim, const Solve& solve) {
    Convergence convergence;
    for (int nodes = aim.first_nodes;; nodes = more_nodes(nodes)) {
        EstimatedValues found{{}, {}, nodes};
        try {
            found.values = solve(nodes);
        } catch (const std::runtime_error&) {  // the phase function's series is too negative
            if (nodes == most_nodes) throw;
            continue;
        }
        convergence.add(found.values);
        if (!convergence.can_tell()) continue;
        found.errors = convergence.errors();
        const double error = largest_relative(found, aim.counts);
        const double steps = std::log(most_nodes / static_cast<double>(nodes)) / std::log(1.5);
        const bool is_out_of_reach =
            nodes >= aim.patience && error * std::pow(convergence.decay(), steps) > aim.tolerance;
        if (error <= aim.tolerance || nodes == most_nodes || is_out_of_reach) return found;
    }
}

/// Solves with `nodes`, and compares with fewer; or, where these are few, with more.
template <class Solve>
EstimatedValues solve_with(int nodes, const Aim& aim, const Solve& solve) {
    if (nodes >= fewest_nodes) {
        const int third = fewer_nodes(nodes), second = fewer_nodes(third);
        Convergence convergence;
        try {
            for (const int fewer : {fewer_nodes(second), second, third})
                convergence.add(solve(fewer));
            const std::vector<double> values = solve(nodes);
            convergence.add(values);
            return {values, convergence.errors(), nodes};
        } catch (const std::runtime_error&) {  // perhaps only of the fewer ones
        }
    }
    const EstimatedValues finer =
        solve_until({rough, fewest_nodes, aim.patience, aim.counts}, solve);
    EstimatedValues found{solve(nodes), finer.errors, nodes};
    for (std::size_t i = 0; i < found.values.size(); ++i)
        found.errors[i] += std::abs(found.values[i] - finer.values[i]);
    return found;
}

/// As options say.
template <class Solve>
EstimatedValues solve_as(const SolverOptions& options, const Aim& aim, const Solve& solve) {
    return options.tolerance == 0 ? solve_with(options.nodes, aim, solve) : solve_until(aim, solve);
}

/// Where to begin when `found` nodes sufficed for the like.
int first_nodes_after(int found) {
    int first = fewest_nodes;
    while (more_nodes(more_nodes(more_nodes(first))) < found) first = more_nodes(first);
    return first;
}

/// Places of geometries whose errors are alike.
struct Alike {
    std::vector<std::size_t> places;
    bool grazing = false;  // SolverOptions::grazing
};

/// Grazing geometries need many more nodes than others, and are no measure of them. Between grazing
/// directions narrow peaks are `resolved`, where they can be.
std::array<Alike, 4> by_cosine(const std::vector<Geometry>& geometries, bool resolved) {
    std::array<Alike, 4> all;
    all[3].grazing = true;
    for (std::size_t i = 0; i < geometries.size(); ++i) {
        const auto [least, most] = std::minmax(geometries[i].mu_in, geometries[i].mu_out);
        const std::size_t kind = resolved && most < least_path_cosine ? 3
                                 : least >= least_path_cosine         ? 0
                                 : least >= 0.05                      ? 1
                                                                      : 2;
        all[kind].places.push_back(i);
    }
    return all;
}

/// One layer over nothing, all orders of a narrow peak, the nodes left to the tolerance.
bool can_resolve_peaks(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                       const SolverOptions& options) {
    return options.tolerance > 0 && options.moments == 0 && options.orders == 0 &&
           options.scheme == Scheme::harmonic && options.truncate == Truncate::smooth &&
           layers.size() == 1 && !boundary.is_present() &&
           has_narrow_peak(layers.front().phase_function);
}

/// Geometries that are solved at once.
class Group {
  public:
    /// As many of `geometries`, from the place `first` of those that are alike on, as share a list of
    /// cosines of reasonable length: extra directions cost as much as nodes do, or twice as much.
    Group(const std::vector<Geometry>& geometries, const Alike& alike, std::size_t first) {
        const std::size_t most_cosines = alike.grazing ? 32 : 64;
        for (std::size_t i = first; i < alike.places.size() && mu_.size() + 2 <= most_cosines;
             ++i) {
            const auto& [mu_in, mu_out, azimuth] = geometries[alike.places[i]];
            Pair& pair = pairs_[{place_of(mu_in), place_of(mu_out)}];
            asked_.push_back({&pair, pair.azimuths.size()});
            pair.azimuths.push_back(azimuth);
        }
        for (auto& [places, pair] : pairs_) {
            const std::size_t count = pair.azimuths.size();
            // Few values may agree by chance; others are looked at with them.
            if (count < 4)
                for (const double more : {0.0, 0.25, 0.5, 0.75, 1.0})
                    pair.azimuths.push_back(more * pi);
            for (std::size_t side = 0; side < 2; ++side)
                for (std::size_t k = 0; k < pair.azimuths.size(); ++k) counts_.push_back(k < count);
        }
    }

    std::size_t size() const { return asked_.size(); }

    /// Of which values the error counts, in the order of `values`.
    const std::vector<bool>& counts() const { return counts_; }

    /// R and T of all pairs at all azimuths, one after the other.
    std::vector<double> values(const StackSolution& solution) {
        std::vector<double> all;
        for (auto& [places, pair] : pairs_) {
            pair.first = all.size();
            for (const Side side : {Side::reflection, Side::transmission}) {
                std::vector<SolvedValue>& values = side == Side::reflection ? pair.R : pair.T;
                values = solution.values(side, places.first, places.second, pair.azimuths);
                for (const SolvedValue& value : values) all.push_back(value.total);
            }
        }
        return all;
    }

    /// The i-th geometry as last solved.
    SolvedGeometry at(std::size_t i, const std::vector<double>& errors) const {
        const auto& [pair, k] = asked_[i];
        const std::size_t reflection = pair->first + k,
                          transmission = reflection + pair->azimuths.size();
        return {pair->R[k], pair->T[k], errors[reflection], errors[transmission]};
    }

    const std::vector<double>& cosines() const { return mu_; }

  private:
    struct Pair {
        std::vector<double> azimuths;   // those asked, and others
        std::vector<SolvedValue> R, T;  // at them
        std::size_t first = 0;          // of R's among all values; T's follow
    };
    struct Asked {
        const Pair* pair;
        std::size_t azimuth;
    };

    int place_of(double mu) {
        const auto [found, is_new] = places_.try_emplace(mu, static_cast<int>(mu_.size()));
        if (is_new) mu_.push_back(mu);
        return found->second;
    }

    std::vector<double> mu_;
    std::map<double, int> places_;
    std::map<std::pair<int, int>, Pair> pairs_;
    std::vector<Asked> asked_;
    std::vector<bool> counts_;
};

}  // namespace

SolvedGeometries solve_geometries(const std::vector<StackLayer>& layers,
                                  const LowerBoundary& boundary,
                                  const std::vector<Geometry>& geometries,
                                  const SolverOptions& options) {
    check_options(options);
    const int patience = patience_for(layers);
    SolvedGeometries all;
    all.at.resize(geometries.size());
    for (const Alike& alike : by_cosine(geometries, can_resolve_peaks(layers, boundary, options))) {
        int nodes_of_others = 0;
        for (std::size_t first = 0; first < alike.places.size();) {
            Group group(geometries, alike, first);
            SolverOptions with = options;
            with.exact_fluxes = false;
            if (alike.grazing) {
                with.grazing = true;
                with.mode_tolerance = std::max(options.mode_tolerance, grazing_mode_tolerance);
            }
            const EstimatedValues found = solve_as(
                options,
                {options.tolerance, first_nodes_after(nodes_of_others), patience, group.counts()},
                [&](int nodes) {
                    with.nodes = nodes;
                    return group.values(solve_stack(layers, boundary, group.cosines(), with));
                });
            for (std::size_t i = 0; i < group.size(); ++i)
                all.at[alike.places[first + i]] = group.at(i, found.errors);
            nodes_of_others = std::max(nodes_of_others, found.nodes);
            first += group.size();
        }
        all.nodes = std::max(all.nodes, nodes_of_others);
    }
    return all;
}

double relative_error(double value, double error) noexcept {
    constexpr double least_value = 1e-8;
    return error / std::max(std::abs(value), least_value);
}

ChosenNodes choose_nodes(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
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

SolvedFluxes solve_fluxes(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options) {
    check_options(options);
    SolverOptions with = options;
    with.modes = 1;  // fluxes are made of the first azimuthal mode alone
    // That is quickly solved with so many nodes that peaks need no other truncation.
    if (options.truncate == Truncate::smooth) with.truncate = Truncate::delta_m;
    SolvedFluxes solved;
    const std::vector<bool> counts(3 * mu.size() + 3, true);
    const EstimatedValues found = solve_as(
        options, {options.tolerance, fewest_nodes_of_fluxes, patience_for(layers), counts},
        [&](int nodes) {
            with.nodes = nodes;
            solved.fluxes = solve_stack(layers, boundary, mu, with);
            const ModeSolution& fluxes = solved.fluxes;
            std::vector<double> values{fluxes.spherical_albedo, fluxes.total_transmittance,
                                       fluxes.spherical_ground_absorptance};
            if (mu.empty()) return values;  // those at the nodes differ
            for (const Eigen::VectorXd* const list :
                 {&fluxes.plane_albedo, &fluxes.diffuse_transmittance, &fluxes.ground_absorptance})
                for (Eigen::Index i = 0; i < std::ssize(mu); ++i)
                    values.push_back(list->size() > 0 ? (*list)(i) : 0);
            return values;
        });
    for (const double error : found.errors) solved.error = std::max(solved.error, error);
    solved.relative_error = largest_relative(found, counts);
    solved.nodes = found.nodes;
    return solved;
}

}  // namespace stratus
