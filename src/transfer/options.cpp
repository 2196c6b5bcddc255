#include "options.h"

#include <stratus/base/number_text.h>
#include <stratus/phase/path_law.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

namespace stratus {

void check_options(const SolverOptions& options) {
    require_in("[1, 512]", "solve", "nodes", options.nodes);
    require(options.tolerance == 0 || (options.tolerance >= 1e-12 && options.tolerance <= 1),
            "solve", "tolerance", "0 or in [1e-12, 1]", options.tolerance);
    require(options.moments >= 0 && options.moments <= 2 * options.nodes, "solve", "moments",
            "in [0, 2 nodes]", options.moments);
    require(options.modes >= 0, "solve", "modes", ">= 0", options.modes);
    require_in("[0, 200]", "solve", "orders", options.orders);
    require(options.orders == 0 || options.scheme == Scheme::harmonic, "solve", "scheme",
            "harmonic where orders are counted", "classic");
    require(!options.grazing || (options.scheme == Scheme::harmonic && options.orders == 0 &&
                                 options.truncate == Truncate::smooth),
            "solve", "grazing",
            "false unless all orders are solved by harmonic, truncated smoothly", "true");
    require(options.start_depth == 0 || (options.start_depth >= 1e-15 && options.start_depth <= 1),
            "solve", "start_depth", "0 or in [1e-15, 1]", options.start_depth);
}

namespace {

/// Moments of a peak that the nodes integrate well: between the 2/3 of them for which their
/// quadrature is exact and the 2 at which their own resolution ends (docs/accuracy.md).
int moments_integrated(int nodes) { return std::max(2, 3 * nodes / 2); }

/// A share of light below which moments that the nodes integrate inexactly do less harm than the
/// early end: T near forward is off by a tenth of it.
constexpr double inexact_share = 2e-3;

/// With fewer, the smooth end of a backward peak's series would be so wide that the line law takes
/// R and T below zero.
constexpr int fewest_nodes_of_backward_ends = 16;

}  // namespace

Truncation choose_truncation(const PhaseFunction& phase_function, const SolverOptions& options,
                             bool delta_m) {
    const int most = options.moments > 0 ? options.moments : 2 * options.nodes;
    if (options.truncate == Truncate::nothing) return no_truncation(phase_function, most);
    if (options.grazing) return truncate_peak(phase_function, moments_completed * options.nodes);
    const bool abrupt = delta_m || options.truncate == Truncate::delta_m;
    Truncation truncation = truncate_peak(phase_function, most, abrupt);
    const bool has_closed_form =
        !delta_m && options.orders == 0 && options.nodes >= fewest_nodes_of_backward_ends;
    if (truncation.backward && !has_closed_form) return no_truncation(phase_function, most);
    if (options.moments > 0 || !(truncation.narrow || truncation.backward)) return truncation;
    const double last = std::abs(phase_function.moments(most + 1).back());
    return last < inexact_share
               ? truncation
               : truncate_peak(phase_function, moments_integrated(options.nodes), abrupt);
}

bool follows_paths(const PhaseFunction& phase_function, const Truncation& truncation,
                   const SolverOptions& options) {
    return options.truncate == Truncate::smooth &&
           (truncation.narrow || has_narrow_peak(phase_function));
}

std::vector<double> path_moments(const PhaseFunction& phase_function) {
    const bool has_rows = std::ranges::any_of(phase_function.terms(), [](const auto& term) {
        return std::holds_alternative<Tabulated>(term.second);
    });
    const int most = has_rows ? most_table_moments : 1 << 20;
    std::vector<double> moments = significant_moments(phase_function, most);
    require(!moments.empty(), "solve", "forward peak of the phase function",
            "wide enough for " + std::to_string(most) + " Legendre moments",
            phase_function.caption());
    return moments;
}

Truncation choose_truncation(const LowerBoundary& boundary, const SolverOptions& options) {
    return boundary.is_layer() ? choose_truncation(boundary.phase_function, options, true)
                               : Truncation{};
}

LowerBoundary truncated(const LowerBoundary& boundary, const Truncation& truncation) {
    LowerBoundary changed = boundary;
    changed.albedo = truncation.single_scattering_albedo(boundary.albedo);
    return changed;
}

void check_boundary(const LowerBoundary& boundary) {
    require_in("[0, 1]", "solve", "albedo of the lower boundary", boundary.albedo);
}

void require_finite(const ModeMatrices& layer, int mode, const Directions& directions) {
    // 0 times infinity is not a number; the sum fills registers, Eigen's allFinite does not.
    if ((0.0 * layer.reflection).sum() == 0 && (0.0 * layer.transmission).sum() == 0) return;
    throw TooFewNodes("solve: nodes must be more for this phase function: its series of " +
                      std::to_string(2 * directions.nodes) + " moments is too negative in mode " +
                      std::to_string(mode) + ", got " + std::to_string(directions.nodes));
}

int count_modes(const std::vector<double>& moments) {
    int count = int_size(moments);
    while (count > 1 && moments[size(count - 1)] == 0) --count;
    return count;
}

Eigen::VectorXd solved_cosines(const Directions& directions) {
    const int asked = directions.size() - directions.nodes;
    return directions.mu.tail(asked ? asked : directions.nodes);
}

Directions stack_directions(const std::vector<Truncation>& truncations,
                            const Truncation& boundary_truncation, const std::vector<double>& mu,
                            const SolverOptions& options) {
    if (options.grazing) return gauss_directions(options.nodes, NodeMap::square, mu);
    NodeMap map = choose_node_map(boundary_truncation.moments, options.nodes);
    for (const Truncation& truncation : truncations)
        if (map != NodeMap::forward) map = choose_node_map(truncation.moments, options.nodes);
    return gauss_directions(options.nodes, map, mu);
}

}  // namespace stratus
