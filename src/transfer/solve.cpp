#include <stratus/transfer/solve.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/transfer/adding.h>
#include <stratus/transfer/layer.h>
#include <stratus/transfer/stack.h>

#include "boundary_modes.h"
#include "doubling_ladder.h"
#include "options.h"
#include "ordered_ladder.h"
#include "reference/classic.h"
#include "reference/phase_kernels.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// single_reflection or single_transmission.
using SingleScattering = double (*)(double phase_value, double albedo, double optical_depth,
                                    double mu_in, double mu_out);

/// sum_n weights(n) f^(n-1) path(n) from order `lowest` on: what truncation makes of single
/// scattering, order by order, per unit of phase function.
double sum_paths(OrderPath path, const LayerSolution& layer, Eigen::Index lowest, double in,
                 double out) {
    const double f = layer.truncation.fraction;
    const Eigen::Index highest = f > 0 ? layer.order_weights.size() - 1 : 1;
    double sum = 0;
    for (Eigen::Index n = lowest; n <= highest; ++n)
        if (layer.order_weights(n) != 0)
            sum += layer.order_weights(n) * std::pow(f, static_cast<double>(n - 1)) *
                   path(static_cast<int>(n), layer.optical_depth, in, out);
    return sum;
}

/// One ladder of depths for several albedos: what all modes share, and where their results go.
class LadderRun {
  public:
    /// `order_weights` of each albedo, none: all orders.
    LadderRun(const PhaseFunction& phase_function, const std::vector<double>& albedos,
              const std::vector<VectorXd>& order_weights, const DepthLadder& ladder,
              const std::vector<double>& mu, const SolverOptions& options,
              const LowerBoundary& boundary)
        : albedos_(albedos),
          order_weights_(order_weights),
          ladder_(ladder),
          options_(options),
          truncation_(truncation_of(phase_function, options, boundary.is_present())),
          boundary_truncation_(truncation_of(boundary, options)),
          directions_(gauss_directions(
              options.nodes,
              joint_map(choose_node_map(truncation_.moments, options.nodes),
                        choose_node_map(boundary_truncation_.moments, options.nodes)),
              mu)),
          first_asked_(mu.empty() ? 0 : options.nodes),
          boundary_(boundary),
          boundary_modes_(boundary, boundary_truncation_, directions_, doubling_steps()) {
        results_.resize(albedos.size());
        const std::vector<double> moments =
            truncation_.narrow ? peak_moments(phase_function) : std::vector<double>{};
        for (double albedo : albedos)
            peaks_.push_back(!moments.empty()
                                 ? std::make_shared<const ForwardPeak>(moments, truncation_, albedo)
                                 : nullptr);
        for (std::size_t a = 0; a < albedos.size(); ++a)
            for (int d = 0; d < depth_count(); ++d)
                results_[a].push_back(blank(phase_function, a, d));
        for (const auto& of_albedo : results_) {
            singles_.emplace_back();
            for (const LayerSolution& solution : of_albedo)
                singles_.back().push_back(single_factors(solution));
        }
    }

    std::vector<std::vector<LayerSolution>> run() {
        // Modes beyond the last moment are empty.
        int most = static_cast<int>(truncation_.moments.size());
        while (most > 1 && truncation_.moments[static_cast<std::size_t>(most - 1)] == 0) --most;
        most = std::max(most, boundary_modes_.count());
        if (options_.modes) most = std::min(options_.modes, most);
        const auto lanes = static_cast<std::size_t>(lane_count);
        // Enough modes at a time to fill whole packs; two, so that both parities of l - m are seen
        // before stopping.
        // Orders are worked out for all albedos at once.
        const int group =
            order_weights_.empty()
                ? std::max(2, static_cast<int>(lanes / std::min(lanes, albedos_.size())))
                : lane_count;
        bool first_group = true;
        for (int mode = 0; mode < most; mode += group) {
            for (auto& of_albedo : results_)
                for (LayerSolution& solution : of_albedo) {
                    solution.reflection_modes.resize(
                        static_cast<std::size_t>(std::min(mode + group, most)));
                    solution.transmission_modes.resize(solution.reflection_modes.size());
                }
            solve_modes(mode, std::min(mode + group, most));
            if (!options_.modes && !first_group &&
                is_negligible(mode, std::min(group, most - mode)))
                break;
            first_group = false;
        }
        return std::move(results_);
    }

  private:
    /// Azimuthally averaged phase value 1: single scattering of a mode is its kernel times these.
    struct SingleFactors {
        MatrixXd reflection, transmission;
    };

    int depth_count() const { return ladder_.octaves + (ladder_.to_infinity ? 1 : 0); }

    LayerSolution blank(const PhaseFunction& phase_function, std::size_t a, int depth) const {
        LayerSolution solution;
        solution.albedo = albedos_[a];
        if (!order_weights_.empty()) solution.order_weights = order_weights_[a];
        solution.optical_depth =
            depth == ladder_.octaves ? infinity : std::ldexp(ladder_.first, depth);
        solution.mu = directions_.mu.tail(directions_.size() - first_asked_);
        if (first_asked_ == 0) solution.mu = directions_.mu;
        solution.phase_function = phase_function;
        solution.truncation = truncation_;
        solution.peak = peaks_[a];
        solution.lower_boundary = boundary_;
        solution.boundary_truncation = boundary_truncation_;
        return solution;
    }

    SingleFactors single_factors(const LayerSolution& solution) const {
        const double w = truncation_.albedo(solution.albedo);
        const double tau = truncation_.optical_depth(solution.optical_depth, solution.albedo);
        const auto count = solution.mu.size();
        SingleFactors factors{MatrixXd(count, count), MatrixXd(count, count)};
        const VectorXd& weights = solution.order_weights;
        const auto reflection = [&](double in, double out) {
            if (weights.size() == 0) return single_reflection(1, w, tau, in, out);
            return (1 - truncation_.fraction) * sum_paths(reflected_path, solution, 1, in, out);
        };
        const auto transmission = [&](double in, double out) {
            if (weights.size() == 0) return single_transmission(1, w, tau, in, out);
            return (1 - truncation_.fraction) * sum_paths(transmitted_path, solution, 1, in, out);
        };
        for (Eigen::Index j = 0; j < count; ++j)
            for (Eigen::Index i = 0; i <= j; ++i) {
                factors.reflection(i, j) = factors.reflection(j, i) =
                    reflection(solution.mu(i), solution.mu(j));
                factors.transmission(i, j) = factors.transmission(j, i) =
                    transmission(solution.mu(i), solution.mu(j));
            }
        return factors;
    }

    double first_depth(std::size_t a) const {
        return truncation_.optical_depth(
            ladder_.octaves ? ladder_.first : directions_.mu.minCoeff(), albedos_[a]);
    }

    /// All modes from `first` to before `end`, all albedos.
    void solve_modes(int first, int end) {
        if (!order_weights_.empty()) {
            run_orders(first, end);
            return;
        }
        std::vector<std::pair<int, std::size_t>> pairs;
        for (int mode = first; mode < end; ++mode)
            for (std::size_t a = 0; a < albedos_.size(); ++a) pairs.emplace_back(mode, a);
        for (auto pack = pairs.begin(); pack != pairs.end();) {
            const auto end_of_pack =
                pack + std::min<std::ptrdiff_t>(lane_count, pairs.end() - pack);
            run_pack({pack, end_of_pack});
            pack = end_of_pack;
        }
    }

    void run_pack(const std::vector<std::pair<int, std::size_t>>& pairs) {
        if (options_.scheme == Scheme::classic) {
            for (const auto& [mode, a] : pairs) run_classic(mode, a);
            return;
        }
        double deepest = 0;
        for (const auto& [mode, a] : pairs) deepest = std::max(deepest, first_depth(a));
        const int doublings = count_doublings(directions_, deepest);
        std::vector<DoublingTask> tasks;
        for (const auto& [mode, a] : pairs)
            tasks.push_back({mode, truncation_.albedo(albedos_[a]),
                             truncation_.co_albedo(albedos_[a]),
                             std::ldexp(first_depth(a), -doublings)});
        DoublingLadder ladder(directions_, truncation_.moments, tasks, doubling_steps());
        std::vector<PhaseKernels> kernels;
        for (std::size_t lane = 0; lane < pairs.size(); ++lane)
            kernels.push_back(ladder.kernels(static_cast<int>(lane)));
        auto record_lanes = [&](int depth) {
            ladder.extract();
            for (std::size_t lane = 0; lane < pairs.size(); ++lane)
                record(pairs[lane].first, pairs[lane].second, depth,
                       ladder.matrices(static_cast<int>(lane)), kernels[lane]);
        };
        for (int k = 0; k < doublings; ++k) ladder.double_depth();
        for (int depth = 0; depth < ladder_.octaves; ++depth) {
            if (depth > 0) ladder.double_depth();
            record_lanes(depth);
        }
        if (!ladder_.to_infinity) return;
        ladder.double_to_infinity();
        record_lanes(ladder_.octaves);
    }

    void run_classic(int mode, std::size_t a) {
        const PhaseKernels kernels =
            reference_phase_kernels(directions_, truncation_.moments, mode);
        const int doublings =
            count_classic_doublings(directions_, first_depth(a), options_.start_depth);
        ClassicLayer layer(directions_, kernels, truncation_.albedo(albedos_[a]),
                           std::ldexp(first_depth(a), -doublings), options_.start);
        auto double_depth = [&] {
            layer.double_depth();
            if (layer.is_finite()) return;
            std::ostringstream line;
            line << "solve: classic doubling broke down in mode " << mode << " at optical depth "
                 << layer.optical_depth();
            throw std::runtime_error(line.str());
        };
        for (int k = 0; k < doublings; ++k) double_depth();
        for (int depth = 0; depth < ladder_.octaves; ++depth) {
            if (depth > 0) double_depth();
            record(mode, a, depth, layer.matrices(), kernels);
        }
        if (!ladder_.to_infinity) return;
        // Conservative layers approach their limit as 1/tau: 2^60 is as far as rounding lets any of
        // them go.
        const int doublings_left = 60 + std::max(0, -std::ilogb(first_depth(a)));
        for (int k = 0; k < doublings_left; ++k) double_depth();
        record(mode, a, ladder_.octaves, layer.matrices(), kernels);
    }

    /// Up to eight modes, all albedos.
    void run_orders(int first_mode, int end) {
        std::vector<int> modes;
        for (int mode = first_mode; mode < end; ++mode) modes.push_back(mode);
        const double first = ladder_.octaves ? ladder_.first : directions_.mu.minCoeff();
        const int doublings = count_doublings(directions_, first);
        OrderedLadder ladder(directions_, truncation_.moments, truncation_.fraction, modes,
                             static_cast<int>(order_weights_[0].size()) - 1,
                             std::ldexp(first, -doublings), doubling_steps());
        const auto record_all = [&](int depth) {
            for (std::size_t lane = 0; lane < modes.size(); ++lane) {
                const int at = static_cast<int>(lane);
                const PhaseKernels kernels = ladder.kernels(at);
                for (std::size_t a = 0; a < albedos_.size(); ++a)
                    record(modes[lane], a, depth, ladder.matrices(at, order_weights_[a]), kernels);
            }
        };
        for (int k = 0; k < doublings; ++k) ladder.double_depth();
        for (int depth = 0; depth < ladder_.octaves; ++depth) {
            if (depth > 0) ladder.double_depth();
            record_all(depth);
        }
        if (!ladder_.to_infinity) return;
        const int most = max_doublings_to_infinity(first);
        for (int k = 0; !ladder.is_opaque(); ++k) {
            if (k == most)
                throw std::runtime_error("solve: infinite depth not reached after " +
                                         std::to_string(most) + " doublings");
            ladder.double_depth();
        }
        record_all(ladder_.octaves);
    }

    /// Takes single scattering out of a mode and keeps the rest; fluxes from mode 0.
    void record(int mode, std::size_t a, int depth, ModeMatrices layer,
                const PhaseKernels& kernels) {
        LayerSolution& solution = results_[a][static_cast<std::size_t>(depth)];
        const SingleFactors& single = singles_[a][static_cast<std::size_t>(depth)];
        const bool infinite = std::isinf(solution.optical_depth);
        const bool opaque = infinite || boundary_.is_present();
        const auto count = solution.mu.size();
        const auto at = static_cast<std::size_t>(mode);
        const VectorXd s = directions_.s.tail(count);
        const VectorXd unscale = s.cwiseInverse();
        require_finite(layer, mode, directions_);
        if (infinite)
            layer.reflection += layer.transmission;  // DoublingLadder::is_converged
        else if (boundary_.is_present())
            layer.reflection = over_boundary(layer, mode, solution);
        solution.reflection_modes[at] = unscale.asDiagonal() *
                                        layer.reflection.bottomRightCorner(count, count) *
                                        unscale.asDiagonal();
        solution.reflection_modes[at] -=
            single.reflection.cwiseProduct(kernels.other.bottomRightCorner(count, count));
        if (!infinite && mode < boundary_modes_.count()) {
            const VectorXd beam = beam_of(solution).tail(count);
            solution.reflection_modes[at] -=
                beam.asDiagonal() * boundary_modes_.once(mode).bottomRightCorner(count, count) *
                beam.asDiagonal();
        }
        if (opaque) {
            solution.transmission_modes[at] = MatrixXd::Zero(count, count);
        } else {
            solution.transmission_modes[at] = unscale.asDiagonal() *
                                              layer.transmission.bottomRightCorner(count, count) *
                                              unscale.asDiagonal();
            solution.transmission_modes[at] -=
                single.transmission.cwiseProduct(kernels.same.bottomRightCorner(count, count));
        }
        if (mode == 0) record_fluxes(solution, layer, opaque);
    }

    /// exp(-tau / mu) after truncation, along all directions.
    VectorXd beam_of(const LayerSolution& solution) const {
        const double tau = truncation_.optical_depth(solution.optical_depth, solution.albedo);
        return directions_.mu.unaryExpr(  // not Eigen's exp, which stops at 2e-308
            [tau](double mu) { return direct_transmittance(tau, mu); });
    }

    /// R of the layer and what lies beneath it.
    MatrixXd over_boundary(const ModeMatrices& layer, int mode, const LayerSolution& solution) {
        if (mode >= boundary_modes_.count()) return layer.reflection;
        const LayerMode above{layer.reflection, layer.reflection, layer.transmission,
                              beam_of(solution)};
        return add(above, boundary_modes_.layer(mode), directions_.nodes).reflection;
    }

    void record_fluxes(LayerSolution& solution, const ModeMatrices& layer, bool opaque) const {
        const int N = directions_.nodes;
        const auto count = solution.mu.size();
        const VectorXd s = directions_.s.head(N);
        const VectorXd unscale = directions_.s.tail(count).cwiseInverse();
        // The weights of uniform illumination sum to 1 from three nodes on, not with fewer.
        const double uniform = s.squaredNorm();
        solution.spherical_albedo = s.dot(layer.reflection.topLeftCorner(N, N) * s) / uniform;
        solution.plane_albedo =
            unscale.asDiagonal() * (layer.reflection.bottomLeftCorner(count, N) * s);
        solution.total_transmittance = 0;
        solution.diffuse_transmittance = VectorXd::Zero(count);
        if (opaque) return;
        const VectorXd beam =  // not Eigen's exp, which stops at 2e-308
            directions_.mu.unaryExpr(
                [&](double mu) { return direct_transmittance(solution.optical_depth, mu); });
        // What truncation took for beam and is not: exp(-tau*/mu) - exp(-tau/mu).
        const VectorXd truncated =
            directions_.mu.unaryExpr([&](double mu) { return truncated_beam(solution, mu); });
        const double straight = solution.order_weights.size() ? solution.order_weights(0) : 1;
        solution.total_transmittance =
            (s.dot(layer.transmission.topLeftCorner(N, N) * s) +
             s.cwiseProduct(s).dot(straight * beam.head(N) + truncated.head(N))) /
            uniform;
        solution.diffuse_transmittance =
            unscale.asDiagonal() * (layer.transmission.bottomLeftCorner(count, N) * s);
        solution.diffuse_transmittance += truncated.tail(count);
    }

    /// exp(-tau*/mu) - exp(-tau/mu), as far as its orders are in.
    double truncated_beam(const LayerSolution& solution, double mu) const {
        const double tau = solution.optical_depth;
        const double scattered = truncation_.fraction * solution.albedo * tau;
        const VectorXd& weights = solution.order_weights;
        if (weights.size() == 0)
            return direct_transmittance(truncation_.optical_depth(tau, solution.albedo), mu) *
                   -std::expm1(-scattered / mu);
        double sum = 0, term = direct_transmittance(tau, mu);
        for (Eigen::Index n = 1; n < weights.size(); ++n) {
            term *= truncation_.fraction * tau / mu / static_cast<double>(n);
            sum += weights(n) * term;
        }
        return sum;
    }

    /// True when modes first .. first + count - 1 add nothing anywhere, so that all higher ones are
    /// left out.
    bool is_negligible(int first, int count) const {
        for (std::size_t a = 0; a < albedos_.size(); ++a)
            for (std::size_t d = 0; d < results_[a].size(); ++d)
                for (int mode = first; mode < first + count; ++mode) {
                    const LayerSolution& of = results_[a][d];
                    const SingleFactors& single = singles_[a][d];
                    const auto m = static_cast<std::size_t>(mode);
                    const double tolerance = options_.mode_tolerance;
                    auto adds = [&](const MatrixXd& f, const MatrixXd& mean, const MatrixXd& once) {
                        return (2 * f.array().abs() >
                                tolerance * (mean.array().abs() + once.array()))
                            .any();
                    };
                    if (adds(of.reflection_modes[m], of.reflection_modes[0], single.reflection) ||
                        adds(of.transmission_modes[m], of.transmission_modes[0],
                             single.transmission))
                        return false;
                }
        return true;
    }

    const std::vector<double>& albedos_;
    const std::vector<VectorXd>& order_weights_;
    const DepthLadder& ladder_;
    const SolverOptions& options_;
    const Truncation truncation_, boundary_truncation_;
    const Directions directions_;
    const int first_asked_;
    std::vector<std::shared_ptr<const ForwardPeak>> peaks_;  // of each albedo
    const LowerBoundary& boundary_;
    BoundaryModes boundary_modes_;
    std::vector<std::vector<LayerSolution>> results_;
    std::vector<std::vector<SingleFactors>> singles_;
};

void check(const std::vector<double>& albedos, const DepthLadder& ladder,
           const SolverOptions& options) {
    require(!albedos.empty(), "solve", "albedos", "at least one", "none");
    for (double albedo : albedos)
        require(albedo >= 0 && albedo <= 1, "solve", "albedo", "in [0, 1]", albedo);
    require(ladder.octaves >= 0, "solve", "octaves", ">= 0", ladder.octaves);
    if (ladder.octaves > 0)
        require(ladder.first >= thinnest_depth && ladder.first < infinity, "solve",
                "first depth of a ladder", "in [1e-280, inf)", ladder.first);
    check_options(options);
}

/// A stack of one layer over something.
LayerSolution as_layer(StackSolution stack) {
    LayerSolution solution;
    solution.phase_function = stack.layers[0].phase_function;
    solution.albedo = stack.layers[0].albedo;
    solution.optical_depth = stack.layers[0].optical_depth;
    solution.truncation = stack.truncations[0];
    solution.lower_boundary = stack.lower_boundary;
    solution.boundary_truncation = stack.boundary_truncation;
    solution.mu = stack.mu;
    solution.reflection_modes = std::move(stack.reflection_modes);
    solution.transmission_modes.assign(solution.reflection_modes.size(),
                                       MatrixXd::Zero(stack.mu.size(), stack.mu.size()));
    solution.plane_albedo = stack.plane_albedo;
    solution.diffuse_transmittance = stack.diffuse_transmittance;
    solution.spherical_albedo = stack.spherical_albedo;
    solution.total_transmittance = 0;
    return solution;
}

/// 1, w, w^2, ...
VectorXd powers(double albedo, int highest) {
    VectorXd weights(highest + 1);
    for (int n = 0; n <= highest; ++n) weights(n) = std::pow(albedo, n);
    return weights;
}

/// Makes a layer of the thinnest depth thinner still: light scatters at most once, in proportion to
/// the depth.
void thin_out(LayerSolution& solution, double optical_depth) {
    const double share = optical_depth / thinnest_depth;
    solution.optical_depth = optical_depth;
    solution.plane_albedo *= share;
    solution.diffuse_transmittance *= share;
    solution.spherical_albedo *= share;
    for (std::size_t m = 0; m < solution.reflection_modes.size(); ++m) {
        solution.reflection_modes[m].setZero();
        solution.transmission_modes[m].setZero();
    }
}

/// TMS less the closed form of the layer itself, per unit of phase function.
double single_correction(const LayerSolution& layer, SingleScattering single_scattering,
                         OrderPath path, double in, double out) {
    if (layer.order_weights.size()) return sum_paths(path, layer, 2, in, out);
    const Truncation& truncation = layer.truncation;
    return single_scattering(1, truncation.single_scattering_albedo(layer.albedo),
                             truncation.optical_depth(layer.optical_depth, layer.albedo), in, out) -
           single_scattering(1, layer.albedo, layer.optical_depth, in, out);
}

}  // namespace

std::vector<std::vector<LayerSolution>> solve_ladder(const PhaseFunction& phase_function,
                                                     const std::vector<double>& albedos,
                                                     const DepthLadder& ladder,
                                                     const std::vector<double>& mu,
                                                     const SolverOptions& options,
                                                     const LowerBoundary& boundary) {
    check(albedos, ladder, options);
    check_boundary(boundary);
    require(options.orders == 0 || !boundary.is_present(), "solve", "orders",
            "0 (all) over something", options.orders);
    std::vector<VectorXd> weights;
    for (std::size_t a = 0; options.orders > 0 && a < albedos.size(); ++a)
        weights.push_back(powers(albedos[a], options.orders));
    return LadderRun(phase_function, albedos, weights, ladder, mu, options, boundary).run();
}

std::vector<LayerSolution> solve_orders(const PhaseFunction& phase_function, double albedo,
                                        double optical_depth, const std::vector<double>& mu,
                                        const SolverOptions& options) {
    require(options.orders >= 1, "solve_orders", "orders", "in [1, 200]", options.orders);
    require(optical_depth >= 0, "solve_orders", "optical_depth", "in [0, inf]", optical_depth);
    const bool infinite = std::isinf(optical_depth);
    const DepthLadder ladder{std::max(optical_depth, thinnest_depth), infinite ? 0 : 1, infinite};
    const std::vector<double> albedos(static_cast<std::size_t>(options.orders), albedo);
    check(albedos, infinite ? DepthLadder{1, 0, true} : ladder, options);
    std::vector<VectorXd> weights;
    for (int n = 1; n <= options.orders; ++n) {
        weights.push_back(VectorXd::Zero(options.orders + 1));
        weights.back()(n) = powers(albedo, options.orders)(n);
    }
    const LowerBoundary nothing;
    std::vector<LayerSolution> orders;
    for (const auto& of_order :
         LadderRun(phase_function, albedos, weights, ladder, mu, options, nothing).run())
        orders.push_back(of_order[0]);
    if (optical_depth < thinnest_depth)
        for (LayerSolution& order : orders) thin_out(order, optical_depth);
    return orders;
}

LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options,
                          const LowerBoundary& boundary) {
    require(optical_depth >= 0, "solve", "optical_depth", "in [0, inf]", optical_depth);
    if (std::isinf(optical_depth))
        return solve_ladder(phase_function, {albedo}, {1, 0, true}, mu, options, boundary)[0][0];
    if (boundary.is_present() && options.scheme == Scheme::harmonic)
        return as_layer(
            solve_stack({{phase_function, albedo, optical_depth}}, boundary, mu, options));
    const double last = conservative_depth / std::max(1e-16, 1 - phase_function.asymmetry());
    if (albedo == 1 && options.orders == 0 && optical_depth > last) {
        std::vector<LayerSolution> octave =
            solve_ladder(phase_function, {albedo}, {last / 2, 2, false}, mu, options)[0];
        LayerSolution& solution = octave[1];
        const double kept = transmitted_share_beyond(last, octave[0].total_transmittance,
                                                     solution.total_transmittance, optical_depth);
        solution.optical_depth = optical_depth;
        for (std::size_t m = 0; m < solution.reflection_modes.size(); ++m) {
            solution.reflection_modes[m] += (1 - kept) * solution.transmission_modes[m];
            solution.transmission_modes[m] *= kept;
        }
        solution.plane_albedo += (1 - kept) * solution.diffuse_transmittance;
        solution.diffuse_transmittance *= kept;
        solution.spherical_albedo += (1 - kept) * solution.total_transmittance;
        solution.total_transmittance *= kept;
        return solution;
    }
    if (optical_depth >= thinnest_depth)
        return solve_ladder(phase_function, {albedo}, {optical_depth, 1, false}, mu, options)[0][0];

    LayerSolution solution =
        solve_ladder(phase_function, {albedo}, {thinnest_depth, 1, false}, mu, options)[0][0];
    thin_out(solution, optical_depth);
    return solution;
}

PeakCorrection LayerSolution::reflection_correction(int in, int out) const {
    if (truncation.fraction == 0) return {};
    const double x = mu(in), y = mu(out);
    return {single_correction(*this, single_reflection, reflected_path, x, y),
            peak ? peak->reflection(optical_depth, x, y, order_weights) : std::vector<double>{}};
}

PeakCorrection LayerSolution::transmission_correction(int in, int out) const {
    if (truncation.fraction == 0) return {};
    const double x = mu(in), y = mu(out);
    return {single_correction(*this, single_transmission, transmitted_path, x, y),
            peak ? peak->transmission(optical_depth, x, y, order_weights) : std::vector<double>{}};
}

double LayerSolution::boundary_correction(int in, int out) const {
    if (truncation.fraction == 0 && boundary_truncation.fraction == 0) return 0;
    const double depth = truncation.optical_depth(optical_depth, albedo);
    return single_reflection_of_boundary(truncated(lower_boundary, boundary_truncation), 1, depth,
                                         mu(in), mu(out)) -
           single_reflection_of_boundary(lower_boundary, 1, optical_depth, mu(in), mu(out));
}

MatrixXd LayerSolution::boundary_correction() const {
    MatrixXd result(mu.size(), mu.size());
    for (int i = 0; i < mu.size(); ++i)
        for (int j = 0; j < mu.size(); ++j) result(i, j) = boundary_correction(i, j);
    return result;
}

std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos,
                                                const SolverOptions& options) {
    for (const double albedo : albedos)
        require(albedo >= 0 && albedo <= 1, "compute_diffusion_exponents", "albedo", "in [0, 1]",
                albedo);
    const std::vector<double> moments = phase_function.moments(2 * options.nodes);
    const Directions directions =
        gauss_directions(options.nodes, choose_node_map(moments, options.nodes));
    const PhaseKernels kernels = reference_phase_kernels(directions, moments, 0);
    const VectorXd scale = directions.s.cwiseQuotient(directions.mu) / std::sqrt(2.0);
    const MatrixXd same = scale.asDiagonal() * kernels.same * scale.asDiagonal();
    const MatrixXd other = scale.asDiagonal() * kernels.other * scale.asDiagonal();
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

double compute_diffusion_exponent(const PhaseFunction& phase_function, double albedo,
                                  const SolverOptions& options) {
    return compute_diffusion_exponents(phase_function, {albedo}, options)[0];
}

}  // namespace stratus
