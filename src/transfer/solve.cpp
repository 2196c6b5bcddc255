#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <stratus/runtime/argument.h>
#include <stratus/transfer/adding.h>
#include <stratus/transfer/layer.h>
#include <stratus/transfer/stack.h>

#include "classic.h"
#include "lane_ladder.h"
#include "options.h"
#include "surface.h"

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One ladder of depths for several albedos: what all modes share, and where their results go.
class LadderRun {
  public:
    LadderRun(const PhaseFunction& phase_function, const std::vector<double>& albedos,
              const DepthLadder& ladder, const std::vector<double>& mu,
              const SolverOptions& options, const Below& below)
        : albedos_(albedos),
          ladder_(ladder),
          options_(options),
          truncation_(truncation_of(phase_function, options)),
          truncation_below_(truncation_of(below, options)),
          directions_(
              gauss_directions(options.nodes,
                               joint_map(choose_node_map(truncation_.moments, options.nodes),
                                         choose_node_map(truncation_below_.moments, options.nodes)),
                               mu)),
          first_asked_(mu.empty() ? 0 : options.nodes),
          below_(below),
          below_modes_(below, truncation_below_, directions_, methods_of(options)) {
        results_.resize(albedos.size());
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
        most = std::max(most, below_modes_.count());
        if (options_.modes) most = std::min(options_.modes, most);
        const auto lanes = static_cast<std::size_t>(lane_count);
        // Enough modes at a time to fill whole packs; two, so that both parities of l - m are seen
        // before stopping.
        const int group = std::max(2, static_cast<int>(lanes / std::min(lanes, albedos_.size())));
        bool first_group = true;
        for (int mode = 0; mode < most; mode += group) {
            std::vector<std::pair<int, std::size_t>> pairs;
            for (int m = mode; m < std::min(mode + group, most); ++m)
                for (std::size_t a = 0; a < albedos_.size(); ++a) pairs.emplace_back(m, a);
            for (auto& of_albedo : results_)
                for (LayerSolution& solution : of_albedo) {
                    solution.reflection_modes.resize(
                        static_cast<std::size_t>(std::min(mode + group, most)));
                    solution.transmission_modes.resize(solution.reflection_modes.size());
                }
            for (std::size_t i = 0; i < pairs.size(); i += lanes)
                run_pack({pairs.begin() + static_cast<std::ptrdiff_t>(i),
                          pairs.begin() +
                              static_cast<std::ptrdiff_t>(std::min(pairs.size(), i + lanes))});
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
        solution.optical_depth =
            depth == ladder_.octaves ? infinity : std::ldexp(ladder_.first, depth);
        solution.mu = directions_.mu.tail(directions_.size() - first_asked_);
        if (first_asked_ == 0) solution.mu = directions_.mu;
        solution.phase_function = phase_function;
        solution.truncation = truncation_;
        solution.below = below_;
        solution.truncation_below = truncation_below_;
        return solution;
    }

    SingleFactors single_factors(const LayerSolution& solution) const {
        const double w = truncation_.albedo(solution.albedo);
        const double tau = truncation_.optical_depth(solution.optical_depth, solution.albedo);
        const auto count = solution.mu.size();
        SingleFactors factors{MatrixXd(count, count), MatrixXd(count, count)};
        for (Eigen::Index j = 0; j < count; ++j)
            for (Eigen::Index i = 0; i <= j; ++i) {
                factors.reflection(i, j) = factors.reflection(j, i) =
                    single_reflection(1, w, tau, solution.mu(i), solution.mu(j));
                factors.transmission(i, j) = factors.transmission(j, i) =
                    single_transmission(1, w, tau, solution.mu(i), solution.mu(j));
            }
        return factors;
    }

    double first_depth(std::size_t a) const {
        return truncation_.optical_depth(
            ladder_.octaves ? ladder_.first : directions_.mu.minCoeff(), albedos_[a]);
    }

    void run_pack(const std::vector<std::pair<int, std::size_t>>& pairs) {
        if (options_.scheme == Scheme::classic) {
            for (const auto& [mode, a] : pairs) run_classic(mode, a);
            return;
        }
        double deepest = 0;
        for (const auto& [mode, a] : pairs) deepest = std::max(deepest, first_depth(a));
        const int doublings = count_doublings(directions_, deepest);
        std::vector<LaneTask> tasks;
        for (const auto& [mode, a] : pairs)
            tasks.push_back({mode, truncation_.albedo(albedos_[a]),
                             truncation_.co_albedo(albedos_[a]),
                             std::ldexp(first_depth(a), -doublings)});
        LaneLadder ladder(directions_, truncation_.moments, tasks, methods_of(options_));
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
        const PhaseKernels kernels = compute_phase_kernels(directions_, truncation_.moments, mode);
        const int doublings = count_classic_doublings(directions_, first_depth(a));
        ClassicLayer layer(directions_, kernels, truncation_.albedo(albedos_[a]),
                           std::ldexp(first_depth(a), -doublings));
        for (int k = 0; k < doublings; ++k) layer.double_depth();
        for (int depth = 0; depth < ladder_.octaves; ++depth) {
            if (depth > 0) layer.double_depth();
            record(mode, a, depth, layer.matrices(), kernels);
        }
        if (!ladder_.to_infinity) return;
        // Conservative layers approach their limit as 1/tau: 2^60 is as far as rounding lets any of
        // them go.
        for (int k = 0; k < 60; ++k) layer.double_depth();
        record(mode, a, ladder_.octaves, layer.matrices(), kernels);
    }

    /// Takes single scattering out of a mode and keeps the rest; fluxes from mode 0.
    void record(int mode, std::size_t a, int depth, ModeMatrices layer,
                const PhaseKernels& kernels) {
        LayerSolution& solution = results_[a][static_cast<std::size_t>(depth)];
        const SingleFactors& single = singles_[a][static_cast<std::size_t>(depth)];
        const bool infinite = std::isinf(solution.optical_depth);
        const bool opaque = infinite || below_.is_something();
        const auto count = solution.mu.size();
        const auto at = static_cast<std::size_t>(mode);
        const VectorXd s = directions_.s.tail(count);
        const VectorXd unscale = s.cwiseInverse();
        if (!layer.reflection.allFinite() || !layer.transmission.allFinite())
            throw std::runtime_error(
                "solve: nodes must be more for this phase function: its series of " +
                std::to_string(2 * options_.nodes) + " moments is too negative in mode " +
                std::to_string(mode) + ", got " + std::to_string(options_.nodes));
        if (infinite)
            layer.reflection += layer.transmission;  // LaneLadder::is_converged
        else if (below_.is_something())
            layer.reflection = over_below(layer, mode, solution);
        solution.reflection_modes[at] = unscale.asDiagonal() *
                                        layer.reflection.bottomRightCorner(count, count) *
                                        unscale.asDiagonal();
        solution.reflection_modes[at] -=
            single.reflection.cwiseProduct(kernels.other.bottomRightCorner(count, count));
        if (!infinite && mode < below_modes_.count()) {
            const VectorXd beam = beam_of(solution).tail(count);
            solution.reflection_modes[at] -=
                beam.asDiagonal() * below_modes_.once(mode).bottomRightCorner(count, count) *
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
    MatrixXd over_below(const ModeMatrices& layer, int mode, const LayerSolution& solution) {
        if (mode >= below_modes_.count()) return layer.reflection;
        const LayerMode above{layer.reflection, layer.reflection, layer.transmission,
                              beam_of(solution)};
        return add(above, below_modes_.layer(mode), directions_.nodes).reflection;
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
        const VectorXd beam = beam_of(solution);
        solution.total_transmittance = (s.dot(layer.transmission.topLeftCorner(N, N) * s) +
                                        s.cwiseProduct(s).dot(beam.head(N))) /
                                       uniform;
        solution.diffuse_transmittance =
            unscale.asDiagonal() * (layer.transmission.bottomLeftCorner(count, N) * s);
        // What truncation took for beam and is not: exp(-tau*/mu) - exp(-tau/mu).
        const double scattered = truncation_.fraction * solution.albedo * solution.optical_depth;
        for (Eigen::Index i = 0; i < count; ++i)
            solution.diffuse_transmittance(i) +=
                beam.tail(count)(i) * -std::expm1(-scattered / solution.mu(i));
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
    const DepthLadder& ladder_;
    const SolverOptions& options_;
    const Truncation truncation_, truncation_below_;
    const Directions directions_;
    const int first_asked_;
    const Below& below_;
    BelowModes below_modes_;
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
    solution.below = stack.below;
    solution.truncation_below = stack.truncation_below;
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

}  // namespace

std::vector<std::vector<LayerSolution>> solve_ladder(const PhaseFunction& phase_function,
                                                     const std::vector<double>& albedos,
                                                     const DepthLadder& ladder,
                                                     const std::vector<double>& mu,
                                                     const SolverOptions& options,
                                                     const Below& below) {
    check(albedos, ladder, options);
    check_below(below);
    return LadderRun(phase_function, albedos, ladder, mu, options, below).run();
}

LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options,
                          const Below& below) {
    require(optical_depth >= 0, "solve", "optical_depth", "in [0, inf]", optical_depth);
    if (std::isinf(optical_depth))
        return solve_ladder(phase_function, {albedo}, {1, 0, true}, mu, options, below)[0][0];
    if (below.is_something() && options.scheme == Scheme::harmonic)
        return as_layer(solve_stack({{phase_function, albedo, optical_depth}}, below, mu, options));
    const double last = conservative_depth / std::max(1e-16, 1 - phase_function.asymmetry());
    if (albedo == 1 && optical_depth > last) {
        // 1/T grows by 3/4 of the reduced depth, and R takes up what T loses. [vdH80]
        LayerSolution solution = solve_layer(phase_function, albedo, last, mu, options);
        const double kept = 1 / (1 + 0.75 * (1 - phase_function.asymmetry()) *
                                         solution.total_transmittance * (optical_depth - last));
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

    // Thinner still, 0 included: light scatters at most once, in proportion to the depth.
    LayerSolution solution =
        solve_ladder(phase_function, {albedo}, {thinnest_depth, 1, false}, mu, options)[0][0];
    const double share = optical_depth / thinnest_depth;
    solution.optical_depth = optical_depth;
    solution.plane_albedo *= share;
    solution.diffuse_transmittance *= share;
    solution.spherical_albedo *= share;
    for (std::size_t m = 0; m < solution.reflection_modes.size(); ++m) {
        solution.reflection_modes[m].setZero();
        solution.transmission_modes[m].setZero();
    }
    return solution;
}

SolvedValue LayerSolution::reflection(int in, int out, double azimuth) const {
    const Geometry geometry{mu(in), mu(out), azimuth};
    const double phase = phase_function(cos_scattering_angle_reflected(geometry));
    const double single = single_reflection(phase, albedo, optical_depth, mu(in), mu(out));
    const double below_once = single_reflection_below(below, optical_depth, geometry);
    const double depth = truncation.optical_depth(optical_depth, albedo);
    const double corrected =
        single_reflection(phase, truncation.single_scattering_albedo(albedo), depth, mu(in),
                          mu(out)) +
        single_reflection_below(truncated(below, truncation_below), depth, geometry);
    return put_together(single + below_once, corrected,
                        sum_modes(reflection_modes, in, out, azimuth));
}

SolvedValue LayerSolution::transmission(int in, int out, double azimuth) const {
    if (below.is_something()) return {0, 0, 0};
    const Geometry geometry{mu(in), mu(out), azimuth};
    const double phase = phase_function(cos_scattering_angle_transmitted(geometry));
    const double single = single_transmission(phase, albedo, optical_depth, mu(in), mu(out));
    const double corrected =
        single_transmission(phase, truncation.single_scattering_albedo(albedo),
                            truncation.optical_depth(optical_depth, albedo), mu(in), mu(out));
    return put_together(single, corrected, sum_modes(transmission_modes, in, out, azimuth));
}

namespace {

template <class Single>
MatrixXd correction(const LayerSolution& layer, Single single) {
    MatrixXd result = MatrixXd::Zero(layer.mu.size(), layer.mu.size());
    if (layer.truncation.fraction == 0) return result;
    const double w = layer.truncation.single_scattering_albedo(layer.albedo);
    const double tau = layer.truncation.optical_depth(layer.optical_depth, layer.albedo);
    for (Eigen::Index i = 0; i < layer.mu.size(); ++i)
        for (Eigen::Index j = 0; j < layer.mu.size(); ++j)
            result(i, j) = single(1, w, tau, layer.mu(i), layer.mu(j)) -
                           single(1, layer.albedo, layer.optical_depth, layer.mu(i), layer.mu(j));
    return result;
}

}  // namespace

MatrixXd LayerSolution::reflection_correction() const {
    return correction(*this, single_reflection);
}

MatrixXd LayerSolution::transmission_correction() const {
    return correction(*this, single_transmission);
}

MatrixXd LayerSolution::below_correction() const {
    MatrixXd result = MatrixXd::Zero(mu.size(), mu.size());
    if (truncation.fraction == 0 && truncation_below.fraction == 0) return result;
    const double depth = truncation.optical_depth(optical_depth, albedo);
    const Below corrected = truncated(below, truncation_below);
    for (Eigen::Index i = 0; i < mu.size(); ++i)
        for (Eigen::Index j = 0; j < mu.size(); ++j)
            result(i, j) = single_reflection_below(corrected, 1, depth, mu(i), mu(j)) -
                           single_reflection_below(below, 1, optical_depth, mu(i), mu(j));
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
    const PhaseKernels kernels = compute_phase_kernels(directions, moments, 0);
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
