#include <stratus/transfer/reference/solvers.h>

#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include "../options.h"
#include "classic.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace stratus {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A dense matrix of 512 MiB.
constexpr int max_states = 8192;

/// Modes below this share of mode 0 are left out: far below the error in K.
constexpr double mode_tolerance = 1e-10;

/// Smallest error estimate, as a share of the last step in K. With it, none of 24000 values of R
/// and T at K = 32 (isotropic to g = 0.3, depths 0.01 to 8, cosines from 0.02) was off by more than
/// its estimate; at K = 16, 38 were.
constexpr double min_error = 0.1;

/// 1 - (1 - exp(-z))/z: the share of light emitted uniformly along an optical path z that is
/// extinguished within it.
double extinguished_within(double z) {
    if (z > 0.5) return 1 + std::expm1(-z) / z;
    double term = z / 2, sum = 0;  // z/2! - z^2/3! + ...
    for (int n = 3; n < 20; ++n, term *= -z / (n - 1)) sum += term;
    return sum;
}

/// The layer divided into K sublayers, and the shares of downward light that pass between them.
/// Upward light is the mirror image, k <-> K - 1 - k.
struct Discretisation {
    int K;
    MatrixXd start;   // n x K: share of a beam from above that first collides in a sublayer
    MatrixXd escape;  // n x K: share of light scattered in a sublayer that leaves below
    MatrixXd hit;     // N x K^2: share from sublayer k that collides in l, at column k K + l

    Discretisation(const Directions& directions, double optical_depth, int count)
        : K(count),
          start(directions.size(), K),
          escape(directions.size(), K),
          hit(MatrixXd::Zero(directions.nodes, Index{K} * K)) {
        // Sublayers as thin as K^-3 at both faces, where light varies fastest with depth; edges are
        // a smooth function of k/K, so that the error remains a series in K^-2.
        std::vector<double> edge;
        for (int k = 0; k <= K; ++k) {
            const double x = static_cast<double>(k) / K;
            edge.push_back(optical_depth * x * x * x * (10 - 15 * x + 6 * x * x));
        }
        for (Index i = 0; i < directions.size(); ++i) {
            const double mu = directions.mu(i);
            const auto slant = [&](int from, int to) {
                return (edge[size(to)] - edge[size(from)]) / mu;
            };
            for (int k = 0; k < K; ++k) {
                const double z = slant(k, k + 1), leaving = z > 0 ? -std::expm1(-z) / z : 1;
                start(i, k) = -std::expm1(-z) * std::exp(-slant(0, k));
                escape(i, k) = leaving * std::exp(-slant(k + 1, K));
                if (i >= directions.nodes) continue;
                hit(i, column(k, k)) = extinguished_within(z);
                for (int l = k + 1; l < K; ++l)
                    hit(i, column(k, l)) =
                        leaving * std::exp(-slant(k + 1, l)) * -std::expm1(-slant(l, l + 1));
            }
        }
    }

    Index column(int k, int l) const { return Index{k} * K + l; }
};

/// The chain of light that is symmetric (sign = 1) or antisymmetric (-1) about the mid-plane:
/// downward light of sublayer k stands for the upward light of K - 1 - k as well. Returns T +- R.
std::vector<MatrixXd> run_chain(const Discretisation& discretisation, const Directions& directions,
                                const PhaseKernels& kernels, double albedo, double sign,
                                int orders) {
    const Index N = directions.nodes, n = directions.size();
    const int K = discretisation.K;
    const VectorXd weight = albedo / 2 * directions.weight.head(N);
    const MatrixXd same = kernels.transmission.leftCols(N),
                   other = sign * kernels.reflection.leftCols(N);
    MatrixXd Q(N * K, N * K), B(N * K, n), E(n, N * K);
    for (int k = 0; k < K; ++k) {
        // [EH78]: P into the same hemisphere stays at l, P into the other one is mirrored.
        MatrixXd ahead = MatrixXd::Zero(n, N), back = MatrixXd::Zero(n, N);
        for (int l = 0; l < K; ++l) {
            const VectorXd to = discretisation.hit.col(discretisation.column(k, l));
            const VectorXd to_mirror = discretisation.hit.col(discretisation.column(k, K - 1 - l));
            Q.block(l * N, k * N, N, N) =
                weight.asDiagonal() *
                (same.topRows(N) * to.asDiagonal() + other.topRows(N) * to_mirror.asDiagonal());
            ahead += discretisation.escape.col(l) * to.transpose();
            back += discretisation.escape.col(l) * to_mirror.transpose();
        }
        E.middleCols(k * N, N) = (albedo / 4 * directions.mu.cwiseInverse()).asDiagonal() *
                                 (same.cwiseProduct(ahead) + other.cwiseProduct(back));
        B.middleRows(k * N, N) =
            weight.asDiagonal() *
            (kernels.transmission.topRows(N) * discretisation.start.col(k).asDiagonal() +
             sign * kernels.reflection.topRows(N) *
                 discretisation.start.col(K - 1 - k).asDiagonal());
    }
    std::vector<MatrixXd> result;
    if (orders == 0) {
        Q = MatrixXd::Identity(N * K, N * K) - Q;
        const Eigen::PartialPivLU<Eigen::Ref<MatrixXd>> factors(Q);
        result.push_back(E * factors.solve(B));
    }
    for (int order = 2; order <= orders; ++order) {
        result.push_back(E * B);
        B = Q * B;
    }
    return result;
}

/// R_m of orders n >= 2 between all directions, unscaled, stacked on T_m: each order up to the
/// highest requested, or the sum of all.
std::vector<MatrixXd> run_mode(const Discretisation& discretisation, const Directions& directions,
                               const PhaseKernels& kernels, double albedo, int orders) {
    const std::vector<MatrixXd> sum =
        run_chain(discretisation, directions, kernels, albedo, 1, orders);
    const std::vector<MatrixXd> difference =
        run_chain(discretisation, directions, kernels, albedo, -1, orders);
    const Eigen::RowVectorXd share =
        directions.s.head(directions.nodes).cwiseAbs2();  // 2 mu weight
    std::vector<MatrixXd> result;
    for (std::size_t n = 0; n < sum.size(); ++n) {
        const MatrixXd R = (sum[n] - difference[n]) / 2, T = (sum[n] + difference[n]) / 2;
        result.emplace_back(2 * R.rows() + 2, R.cols());
        result.back() << R, T, share * R.topRows(share.size()), share * T.topRows(share.size());
    }
    return result;
}

struct Extrapolated {
    MatrixXd value, error;
};

/// Extrapolates from K/2, K and 2 K sublayers: an error of order K^-2 is a third of the last step.
Extrapolated extrapolate(const MatrixXd& half, const MatrixXd& once, const MatrixXd& twice) {
    const MatrixXd step = twice - once, before = once - half;
    const MatrixXd change = step + (step - before) / 3;
    // The last change may vanish where the true error does not.
    return {twice + step / 3, change.cwiseAbs().cwiseMax(min_error * step.cwiseAbs())};
}

class MarkovRun {
  public:
    MarkovRun(const PhaseFunction& phase_function, double albedo, double optical_depth,
              const std::vector<double>& mu, const MarkovOptions& options)
        : options_(options),
          moments_(phase_function.moments(2 * options.nodes)),
          directions_(
              gauss_directions(options.nodes, choose_node_map(moments_, options.nodes), mu)) {
        LayerSolution& layer = solution_.layer;
        layer.albedo = albedo;
        layer.optical_depth = optical_depth;
        layer.phase_function = phase_function;
        layer.truncation = no_truncation(phase_function, 2 * options.nodes);
        layer.mu = solved_cosines(directions_);
        const auto count = layer.mu.size();
        for (const Side side : both_sides) solution_.error[side] = MatrixXd::Zero(count, count);
        solution_.order.resize(size(std::max(0, options.orders - 1)));
    }

    MarkovSolution run() {
        const LayerSolution& layer = solution_.layer;
        const auto n = directions_.size();
        const Extrapolated none{MatrixXd::Zero(2 * n + 2, n), MatrixXd::Zero(2 * n + 2, n)};
        if (layer.albedo == 0 || layer.optical_depth == 0 || options_.orders == 1) {
            record_fluxes(none);
            return std::move(solution_);
        }
        const int K = options_.sublayers;
        const Discretisation discretisations[] = {{directions_, layer.optical_depth, K / 2},
                                                  {directions_, layer.optical_depth, K},
                                                  {directions_, layer.optical_depth, 2 * K}};
        int most = count_modes(moments_);
        if (options_.modes) most = std::min(options_.modes, most);
        for (int mode = 0; mode < most; ++mode) {
            const PhaseKernels kernels = reference_phase_kernels(directions_, moments_, mode);
            std::vector<std::vector<MatrixXd>> at;
            for (const Discretisation& discretisation : discretisations)
                at.push_back(
                    run_mode(discretisation, directions_, kernels, layer.albedo, options_.orders));
            Extrapolated sum = none;
            for (std::size_t order = 0; order < at[0].size(); ++order) {
                Extrapolated of = extrapolate(at[0][order], at[1][order], at[2][order]);
                if (!options_.extrapolate)
                    of = {at[2][order], (at[2][order] - at[1][order]).cwiseAbs()};
                sum.value += of.value;
                sum.error += of.error;
                if (options_.orders == 0) continue;
                for (const Side side : both_sides)
                    solution_.order[order][side].push_back({asked(side, of.value)});
            }
            record(mode, sum);
            if (!options_.modes && mode > 0 && is_negligible(mode) && is_negligible(mode - 1))
                break;
        }
        return std::move(solution_);
    }

  private:
    MatrixXd asked(Side side, const MatrixXd& all) const {
        const Index n = directions_.size(), count = solution_.layer.mu.size();
        return all.block((side == Side::reflection ? n : 2 * n) - count, n - count, count, count);
    }

    void record(int mode, const Extrapolated& multiple) {
        for (const Side side : both_sides) {
            solution_.layer.modes[side].push_back({asked(side, multiple.value)});
            solution_.error[side] += (mode == 0 ? 1.0 : 2.0) * asked(side, multiple.error);
        }
        if (mode == 0) record_fluxes(multiple);
    }

    /// Fluxes of all orders, order 1 in closed form.
    void record_fluxes(const Extrapolated& multiple) {
        LayerSolution& layer = solution_.layer;
        const double w = layer.albedo, tau = layer.optical_depth;
        const Index N = options_.nodes, n = directions_.size(), count = layer.mu.size();
        const PhaseKernels kernels = reference_phase_kernels(directions_, moments_, 0);
        const VectorXd share = directions_.s.head(N).cwiseAbs2();
        MatrixXd fluxes = multiple.value.bottomRows(2);
        for (Index j = 0; j < n; ++j)
            for (Index i = 0; i < N; ++i) {
                const double out = directions_.mu(i), in = directions_.mu(j);
                for (const Side side : both_sides)
                    fluxes(static_cast<int>(side), j) +=
                        share(i) * single_scattering(side, kernels[side](i, j), w, tau, in, out);
            }
        layer.plane_albedo = fluxes.row(0).tail(count);
        layer.diffuse_transmittance = fluxes.row(1).tail(count);
        fluxes.row(1).head(N) += beam_along(directions_.mu.head(N), tau).transpose();
        const MatrixXd uniform = fluxes.leftCols(N) * share / share.sum();
        layer.spherical_albedo = uniform(0);
        layer.total_transmittance = uniform(1);
        const MatrixXd error = multiple.error.bottomRows(2);
        solution_.flux_error = std::max(error.rightCols(count).maxCoeff(),
                                        (error.leftCols(N) * share / share.sum()).maxCoeff());
    }

    bool is_negligible(int mode) const {
        const auto adds = [&](Side side) {
            const std::vector<AzimuthalMode>& modes = solution_.layer.modes[side];
            return (2 * modes[size(mode)].values.array().abs() >
                    mode_tolerance * modes[0].values.array().abs())
                .any();
        };
        return std::ranges::none_of(both_sides, adds);
    }

    const MarkovOptions options_;
    const std::vector<double> moments_;
    const Directions directions_;
    MarkovSolution solution_;
};

}  // namespace

MarkovValue MarkovSolution::reflection(int in, int out, double azimuth) const {
    return {layer.reflection(in, out, azimuth), error.reflection(in, out)};
}

MarkovValue MarkovSolution::transmission(int in, int out, double azimuth) const {
    return {layer.transmission(in, out, azimuth), error.transmission(in, out)};
}

double MarkovSolution::of_order(Side side, int n, int in, int out, double azimuth) const {
    if (n == 1) return layer.values(side, in, out, {azimuth})[0].single;
    return sum_modes(order.at(size(n - 2))[side], in, out, azimuth);
}

MarkovSolution solve_markov(const PhaseFunction& phase_function, double albedo,
                            double optical_depth, const std::vector<double>& mu,
                            const MarkovOptions& options) {
    const char* const caller = "markov";
    require_in("[0, 1]", caller, "albedo", albedo);
    require_in("[0, inf) (a semi-infinite layer cannot be divided into sublayers)", caller,
               "optical_depth", optical_depth);
    require(options.sublayers >= 4 && options.sublayers <= max_states && options.sublayers % 2 == 0,
            caller, "sublayers", "even and in [4, 8192]", options.sublayers);
    require(options.modes >= 0, caller, "modes", ">= 0", options.modes);
    require(options.orders >= 0, caller, "orders", ">= 0", options.orders);
    require_in("[1, 512]", caller, "nodes", options.nodes);
    require(2 * options.sublayers * options.nodes <= max_states, caller, "2 sublayers x nodes",
            "at most 8192 (a dense matrix of 512 MiB)", 2 * options.sublayers * options.nodes);
    return MarkovRun(phase_function, albedo, optical_depth, mu, options).run();
}

}  // namespace stratus
