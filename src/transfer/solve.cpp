#include <stratus/transfer/solve.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/stack.h>

#include "depth_regime.h"
#include "ladder.h"
#include "options.h"
#include "orders.h"

#include <cmath>
#include <utility>

namespace stratus {

namespace {

using Eigen::VectorXd;

void check(const std::vector<double>& albedos, const SolverOptions& options,
           const LowerBoundary& boundary) {
    require(!albedos.empty(), "solve", "albedos", "at least one", "none");
    for (double albedo : albedos)
        require(albedo >= 0 && albedo <= 1, "solve", "albedo", "in [0, 1]", albedo);
    check_options(options);
    check_boundary(boundary);
    require(options.orders == 0 || !boundary.is_present(), "solve", "orders",
            "0 (all) over a lower boundary", options.orders);
}

/// Weights of the orders up to options.orders; empty when all are solved.
std::vector<VectorXd> weights_of(const std::vector<double>& albedos, const SolverOptions& options) {
    std::vector<VectorXd> weights;
    for (std::size_t a = 0; options.orders > 0 && a < albedos.size(); ++a)
        weights.push_back(weights_of_orders(albedos[a], options.orders));
    return weights;
}

}  // namespace

std::vector<std::vector<LayerSolution>> solve_ladder(const PhaseFunction& phase_function,
                                                     const std::vector<double>& albedos,
                                                     const DepthLadder& ladder,
                                                     const std::vector<double>& mu,
                                                     const SolverOptions& options,
                                                     const LowerBoundary& boundary) {
    check(albedos, options, boundary);
    require(ladder.octaves >= 0, "solve", "octaves", ">= 0", ladder.octaves);
    if (ladder.octaves > 0)
        require(ladder.first >= thinnest_depth && ladder.first < infinity, "solve",
                "first depth of a ladder", "in [1e-280, inf)", ladder.first);
    return solve_problem({phase_function, albedos, weights_of(albedos, options), ladder,
                          targets_of(ladder), mu, options, boundary});
}

LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options,
                          const LowerBoundary& boundary) {
    require(optical_depth >= 0, "solve", "optical_depth", "in [0, inf]", optical_depth);
    const std::vector<double> albedos{albedo};
    check(albedos, options, boundary);
    const bool can_be_stacked = options.scheme == Scheme::harmonic && options.orders == 0;
    if (boundary.is_present() && std::isfinite(optical_depth) && can_be_stacked) {
        const Truncation truncation = truncation_of(phase_function, options, false);
        if (truncation.backward || follows_paths(phase_function, truncation, options))
            return as_one_layer(
                solve_stack({{phase_function, albedo, optical_depth}}, boundary, mu, options));
    }
    const DepthTarget target = choose_target(optical_depth, albedo == 1 && options.orders == 0,
                                             phase_function.asymmetry());
    return std::move(solve_problem({phase_function,
                                    albedos,
                                    weights_of(albedos, options),
                                    ladder_to(target),
                                    {target},
                                    mu,
                                    options,
                                    boundary})[0][0]);
}

std::vector<LayerSolution> solve_orders(const PhaseFunction& phase_function, double albedo,
                                        double optical_depth, const std::vector<double>& mu,
                                        const SolverOptions& options) {
    require(options.orders >= 1, "solve_orders", "orders", "in [1, 200]", options.orders);
    require(optical_depth >= 0, "solve_orders", "optical_depth", "in [0, inf]", optical_depth);
    const std::vector<double> albedos(static_cast<std::size_t>(options.orders), albedo);
    const LowerBoundary none;
    check(albedos, options, none);
    const DepthTarget target = choose_target(optical_depth, false, phase_function.asymmetry());
    const VectorXd all = weights_of_orders(albedo, options.orders);
    std::vector<VectorXd> weights;
    for (int n = 1; n <= options.orders; ++n) {
        weights.push_back(VectorXd::Zero(options.orders + 1));
        weights.back()(n) = all(n);
    }
    std::vector<LayerSolution> orders;
    for (auto& of_order : solve_problem({phase_function,
                                         albedos,
                                         std::move(weights),
                                         ladder_to(target),
                                         {target},
                                         mu,
                                         options,
                                         none}))
        orders.push_back(std::move(of_order[0]));
    return orders;
}

}  // namespace stratus
