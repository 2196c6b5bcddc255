#include <stratus/transfer/solve.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/transfer/stack.h>

#include "climb.h"
#include "doubling_ladder.h"
#include "mode_recorder.h"
#include "options.h"
#include "orders.h"
#include "paths.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <map>
#include <span>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Over (albedo, depth).
using Solutions = std::vector<std::vector<LayerSolution>>;

/// Layers of one phase function: all albedos at all depths of a ladder, mode after mode.
struct LadderProblem {
    const PhaseFunction& phase_function;
    const std::vector<double>& albedos;
    std::vector<Eigen::VectorXd> order_weights;  // of each albedo; empty: all orders
    DepthLadder ladder;
    std::vector<DepthTarget> targets;  // depths that the last ones of the ladder lead to
    std::vector<double> mu;
    SolverOptions options;
    const LowerBoundary& boundary;
    const TakeMode* take = nullptr;  // null: all modes are kept
};

class LadderRun {
  public:
    explicit LadderRun(const LadderProblem& problem)
        : problem_(problem),
          truncation_(choose_truncation(problem.phase_function, problem.options,
                                        problem.boundary.is_present())),
          boundary_truncation_(choose_truncation(problem.boundary, problem.options)),
          directions_(
              stack_directions({truncation_}, boundary_truncation_, problem.mu, problem.options)),
          boundary_modes_(problem.boundary, boundary_truncation_, directions_),
          task_{directions_,
                truncation_.moments,
                problem.ladder,
                {},
                !problem.boundary.is_present()} {
        if (!problem.boundary.is_present() &&
            follows_paths(problem.phase_function, truncation_, problem.options))
            path_ = std::make_shared<const TruncatedPath>(
                PathLaw(path_moments(problem.phase_function)), truncation_);
        if (truncation_.backward)
            backward_path_ = std::make_shared<const BackwardPath>(
                path_moments(problem.phase_function), truncation_.moments);
        const DepthLadder& ladder = problem.ladder;
        const auto first_depth = [&](double albedo) {
            if (ladder.octaves == 0) return first_depth_to_infinity;
            return by_order() ? ladder.first : truncation_.optical_depth(ladder.first, albedo);
        };
        for (std::size_t a = 0; a < problem.albedos.size(); ++a) {
            const double albedo = problem.albedos[a];
            task_.albedos.push_back(
                {truncation_.albedo(albedo), truncation_.co_albedo(albedo), first_depth(albedo)});
            results_.emplace_back();
            for (const DepthTarget& target : problem.targets)
                results_[a].push_back(blank(a, target.optical_depth));
        }
        for (auto& of_albedo : results_) {
            recorders_.emplace_back().reserve(of_albedo.size());
            for (LayerSolution& solution : of_albedo)
                recorders_.back().emplace_back(directions_, solution,
                                               std::vector{single_factors(solution)},
                                               direct_beam(solution), true, problem.take);
        }
    }

    Solutions run() {
        const FlushSubnormals flush(problem_.targets.front().optical_depth);
        // Enough modes at a time to fill the packs; orders are solved for all albedos at once.
        const int albedos = int_size(problem_.albedos);
        const int group =
            by_order() ? lane_count : std::max(2, lane_count / std::min(lane_count, albedos));
        const std::vector<int> modes = modes_to_solve();
        solve_groups(
            int_size(modes), group, problem_.options.modes == 0,
            [&](int first, int end) {
                solve_modes(std::span(modes).subspan(size(first), size(end - first)));
            },
            [this](int count) { return is_negligible(count); });
        if (problem_.options.grazing)
            for (auto& of_albedo : results_)
                for (LayerSolution& solution : of_albedo)
                    for (const Side side : both_sides) fill_modes(modes, solution.modes[side]);
        return std::move(results_);
    }

  private:
    bool by_order() const { return !problem_.order_weights.empty(); }

    LayerSolution blank(std::size_t a, double optical_depth) const {
        LayerSolution solution;
        solution.albedo = problem_.albedos[a];
        if (by_order()) solution.order_weights = problem_.order_weights[a];
        solution.optical_depth = optical_depth;
        solution.mu = solved_cosines(directions_);
        solution.phase_function = problem_.phase_function;
        solution.truncation = truncation_;
        solution.path = path_;
        solution.backward_path = backward_path_;
        solution.lower_boundary = problem_.boundary;
        solution.boundary_truncation = boundary_truncation_;
        return solution;
    }

    SingleFactors single_factors(const LayerSolution& solution) const {
        const double w = truncation_.albedo(solution.albedo);
        const double tau = truncation_.optical_depth(solution.optical_depth, solution.albedo);
        const auto count = solution.mu.size();
        SingleFactors factors{MatrixXd(count, count), MatrixXd(count, count)};
        for (const Side side : both_sides)
            for (Eigen::Index j = 0; j < count; ++j)
                for (Eigen::Index i = 0; i <= j; ++i) {
                    const double in = solution.mu(i), out = solution.mu(j);
                    factors[side](i, j) = factors[side](j, i) =
                        by_order()
                            ? (1 - truncation_.fraction) * sum_paths(side, solution, 1, in, out)
                            : single_scattering(side, 1, w, tau, in, out);
                }
        return factors;
    }

    Beam direct_beam(const LayerSolution& solution) const {
        const VectorXd truncated =
            directions_.mu.unaryExpr([&](double mu) { return truncated_beam(solution, mu); });
        if (!by_order())
            return {beam_along(directions_.mu,
                               truncation_.optical_depth(solution.optical_depth, solution.albedo)),
                    truncated};
        return {solution.order_weights(0) * beam_along(directions_.mu, solution.optical_depth) +
                    truncated,
                truncated};
    }

    std::vector<int> modes_to_solve() const {
        const SolverOptions& options = problem_.options;
        int count = std::max(count_modes(truncation_.moments), boundary_modes_.count());
        if (options.modes) count = std::min(options.modes, count);
        constexpr double usual_tolerance = 1e-4;
        if (options.grazing)
            return thinned_modes(count,
                                 options.tolerance > 0 ? options.tolerance : usual_tolerance);
        return modes_between(0, count);
    }

    void solve_modes(std::span<const int> modes) {
        const RecordMode record_mode = [this](int mode, std::size_t albedo, int depth,
                                              ModeMatrices layer, const PhaseKernels& kernels) {
            return record(mode, albedo, depth, std::move(layer), kernels);
        };
        if (by_order())
            climb_orders(task_, truncation_.fraction, problem_.order_weights, modes, record_mode);
        else if (problem_.options.scheme == Scheme::classic)
            climb_classic(task_, problem_.options, modes, record_mode);
        else if (problem_.options.grazing)
            climb_grazing(task_, modes, record_mode);
        else
            climb_harmonic(task_, modes, record_mode);
    }

    /// Returns what RecordMode does.
    bool record(int mode, std::size_t a, int depth, ModeMatrices layer,
                const PhaseKernels& kernels) {
        require_finite(layer, mode, directions_);
        const DepthLadder& ladder = problem_.ladder;
        const int before = ladder.place(ladder.count()) - int_size(problem_.targets);
        const int place = ladder.place(depth) - before;
        if (place < 0) {
            if (mode == 0) half_transmittance_ = uniform_mean(directions_, layer.transmission);
            return false;
        }
        const auto at = size(place);
        const DepthTarget& target = problem_.targets[at];
        const bool is_limit = reaches_limit(mode, a, at, layer.transmission);
        layer = reach(target, mode, half_transmittance_, directions_, std::move(layer));
        ModeRecorder& recorder = recorders_[a][at];
        LayerMode all{std::move(layer.reflection), {}, std::move(layer.transmission)};
        if (problem_.boundary.is_present()) {
            if (!all.is_opaque()) {
                all.reflection_below = all.reflection;
                all.beam = recorder.beam();
            }
            if (mode == 0 && problem_.albedos[a] == 1)
                all.conserved = directions_.s.head(directions_.nodes);
            if (mode == 0) recorder.record_boundary(all, boundary_modes_);
            // The layer and its lower boundary as one opaque layer.
            if (all.is_opaque() || mode >= boundary_modes_.count())
                all = {std::move(all.reflection)};
            else
                all = add(all, boundary_modes_.layer(mode), directions_.nodes);
        }
        recorder.record(all, {&kernels}, &boundary_modes_);
        if (target.regime == DepthRegime::thin && !problem_.boundary.is_present())
            for (const Side side : both_sides)  // rounding
                results_[a][at].modes[side].back().values.setZero();
        return is_limit;
    }

    /// Returns whether a mode crosses the layer by a share x of mode 0 so small that its share in
    /// layers twice as deep, x^2, is rounding: no mode is scattered more than mode 0. The beam, which
    /// is the same in all modes, must be as small.
    bool reaches_limit(int mode, std::size_t a, std::size_t at, const MatrixXd& transmission) {
        constexpr double little = 1e-6;
        if (at + 1 == problem_.targets.size()) return false;
        Uniform& uniform = uniform_[{a, at}];
        if (mode == 0) {
            uniform.transmission = transmission;
            uniform.hides_beam = recorders_[a][at].beam().maxCoeff() <=
                                 little * uniform_mean(directions_, transmission);
            return false;
        }
        return uniform.hides_beam &&
               (2 * transmission.array().abs() <=
                little *
                    uniform.transmission.bottomRightCorner(transmission.rows(), transmission.cols())
                        .array())
                   .all();
    }

    bool is_negligible(int count) const {
        for (const auto& of_albedo : recorders_)
            for (const ModeRecorder& recorder : of_albedo)
                if (!recorder.is_negligible(count, problem_.options.mode_tolerance)) return false;
        return true;
    }

    const LadderProblem& problem_;
    const Truncation truncation_, boundary_truncation_;
    const Directions directions_;
    BoundaryModes boundary_modes_;
    std::shared_ptr<const TruncatedPath> path_;
    std::shared_ptr<const BackwardPath> backward_path_;
    ClimbTask task_;
    Solutions results_;
    std::vector<std::vector<ModeRecorder>> recorders_;
    struct Uniform {
        MatrixXd transmission;
        bool hides_beam = false;
    };
    std::map<std::pair<std::size_t, std::size_t>, Uniform> uniform_;  // mode 0 of each result
    double half_transmittance_ = 0;  // at the depth before the target; one albedo only
};

/// Every depth that a ladder is asked for is its own target.
std::vector<DepthTarget> depth_targets(const DepthLadder& ladder) {
    std::vector<DepthTarget> targets;
    for (int depth = 0; depth < ladder.octaves; ++depth)
        if (ladder.asks_for(depth)) targets.push_back({std::ldexp(ladder.first, depth)});
    if (ladder.to_infinity && ladder.asks_for(ladder.octaves))
        targets.push_back({infinity, DepthRegime::infinite});
    return targets;
}

/// Fluxes come from mode 0 alone, and need more of a peaked phase function's moments than the early
/// end leaves: with 64 nodes those of Henyey-Greenstein 0.95 are right to 1e-6.
constexpr int nodes_for_fluxes = 64;
constexpr double cut_share = 1e-4;  // less harms no flux

void refine_fluxes(const LadderProblem& problem, Solutions& solutions) {
    const LayerSolution& any = solutions[0][0];
    const bool cut_early = any.truncation.backward
                               ? problem.options.nodes < nodes_for_fluxes
                               : any.path != nullptr && any.truncation.fraction > cut_share;
    if (!cut_early || !problem.options.exact_fluxes) return;
    LadderProblem of_fluxes = problem;
    of_fluxes.mu.assign(any.mu.begin(), any.mu.end());
    of_fluxes.take = nullptr;
    SolverOptions& options = of_fluxes.options;
    options.nodes = std::max(nodes_for_fluxes, options.nodes);
    options.moments = 0;
    options.modes = 1;
    options.truncate = Truncate::delta_m;
    const Solutions fluxes = LadderRun(of_fluxes).run();
    for (std::size_t a = 0; a < solutions.size(); ++a)
        for (std::size_t d = 0; d < solutions[a].size(); ++d)
            static_cast<ModeFluxes&>(solutions[a][d]) = fluxes[a][d];
}

/// result[albedo][target].
Solutions solve_problem(const LadderProblem& problem) {
    Solutions solutions = LadderRun(problem).run();
    refine_fluxes(problem, solutions);
    return solutions;
}

void check(const std::vector<double>& albedos, const SolverOptions& options,
           const LowerBoundary& boundary) {
    require(!albedos.empty(), "solve", "albedos", "at least one", "none");
    for (double albedo : albedos) require_in("[0, 1]", "solve", "albedo", albedo);
    check_options(options);
    check_boundary(boundary);
    require(options.orders == 0 || !boundary.is_present(), "solve", "orders",
            "0 (all) over a lower boundary", options.orders);
}

/// Weights of the orders up to options.orders; empty when all are solved.
std::vector<VectorXd> order_weights(const std::vector<double>& albedos,
                                    const SolverOptions& options) {
    std::vector<VectorXd> weights;
    for (std::size_t a = 0; options.orders > 0 && a < albedos.size(); ++a)
        weights.push_back(weights_of_orders(albedos[a], options.orders));
    return weights;
}

}  // namespace

Solutions solve_ladder(const PhaseFunction& phase_function, const std::vector<double>& albedos,
                       const DepthLadder& ladder, const std::vector<double>& mu,
                       const SolverOptions& options, const LowerBoundary& boundary,
                       const TakeMode& take) {
    check(albedos, options, boundary);
    require(!take || (options.modes > 0 && !options.grazing), "solve", "modes that are taken",
            "all solved, their number given", options.modes);
    require(ladder.octaves >= 0, "solve", "octaves", ">= 0", ladder.octaves);
    const auto count = size(ladder.count());
    require(ladder.asked.empty() || ladder.asked.size() == count, "solve", "depths of a ladder",
            "all of them asked for or not, " + std::to_string(count), ladder.asked.size());
    require(ladder.place(ladder.count()) > 0, "solve", "depths of a ladder", "at least one",
            "none");
    if (ladder.octaves > 0)
        require_in("[1e-280, inf)", "solve", "first depth of a ladder", ladder.first);
    return solve_problem({phase_function, albedos, order_weights(albedos, options), ladder,
                          depth_targets(ladder), mu, options, boundary, take ? &take : nullptr});
}

LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options,
                          const LowerBoundary& boundary) {
    require_in("[0, inf]", "solve", "optical_depth", optical_depth);
    const std::vector<double> albedos{albedo};
    check(albedos, options, boundary);
    const bool can_be_stacked = options.scheme == Scheme::harmonic && options.orders == 0;
    if (boundary.is_present() && std::isfinite(optical_depth) && can_be_stacked) {
        const Truncation truncation = choose_truncation(phase_function, options, false);
        if (truncation.backward || follows_paths(phase_function, truncation, options))
            return as_one_layer(
                solve_stack({{phase_function, albedo, optical_depth}}, boundary, mu, options));
    }
    const DepthTarget target = choose_target(optical_depth, albedo == 1 && options.orders == 0,
                                             phase_function.asymmetry());
    return std::move(solve_problem({phase_function,
                                    albedos,
                                    order_weights(albedos, options),
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
    require_in("[0, inf]", "solve_orders", "optical_depth", optical_depth);
    const std::vector<double> albedos(size(options.orders), albedo);
    const LowerBoundary none;
    check(albedos, options, none);
    const DepthTarget target = choose_target(optical_depth, false, phase_function.asymmetry());
    std::vector<LayerSolution> orders;
    for (auto& of_order : solve_problem({phase_function,
                                         albedos,
                                         weights_of_each_order(albedo, options.orders),
                                         ladder_to(target),
                                         {target},
                                         mu,
                                         options,
                                         none}))
        orders.push_back(std::move(of_order[0]));
    return orders;
}

std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos) {
    for (const double albedo : albedos)
        require_in("[0, 1]", "compute_diffusion_exponents", "albedo", albedo);
    const int nodes = SolverOptions().nodes;
    const std::vector<double> moments = phase_function.moments(2 * nodes);
    const Directions directions = gauss_directions(nodes, choose_node_map(moments, nodes));
    const PhaseKernels kernels =
        DoublingLadder<double>(directions, moments, {{0, 1, 0, directions.mu.minCoeff()}})
            .kernels()[0];
    const VectorXd scale = directions.s.cwiseQuotient(directions.mu) / std::sqrt(2.0);
    const MatrixXd same = scale.asDiagonal() * kernels.transmission * scale.asDiagonal();
    const MatrixXd other = scale.asDiagonal() * kernels.reflection * scale.asDiagonal();
    const MatrixXd slant = directions.mu.cwiseInverse().asDiagonal();
    std::vector<double> exponents;
    for (const double albedo : albedos) {
        if (albedo == 1) {
            exponents.push_back(0);
            continue;
        }
        const MatrixXd A = slant - albedo / 2 * (same - other);
        const MatrixXd B = slant - albedo / 2 * (same + other);
        // 1/k^2 is the largest eigenvalue of (B A)^-1, similar to the symmetric L^-1 B^-1 L^-T with
        // A = L L^T.
        const Eigen::LLT<MatrixXd> factor(A);
        const MatrixXd half = factor.matrixL().solve(MatrixXd(B.llt().solve(
            MatrixXd(factor.matrixL().transpose().solve(MatrixXd::Identity(A.rows(), A.cols()))))));
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen((half + half.transpose()) / 2,
                                                            Eigen::EigenvaluesOnly);
        exponents.push_back(1 / std::sqrt(eigen.eigenvalues().maxCoeff()));
    }
    return exponents;
}

}  // namespace stratus
