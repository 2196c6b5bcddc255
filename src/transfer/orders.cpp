#include "orders.h"

#include <stratus/base/size.h>

#include "climb.h"
#include "stack_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

using Eigen::VectorXd;

VectorXd weights_of_orders(double albedo, int highest) {
    VectorXd weights(highest + 1);
    double power = 1;
    for (int n = 0; n <= highest; ++n, power *= albedo) weights(n) = power;
    return weights;
}

std::vector<VectorXd> weights_of_each_order(double albedo, int highest) {
    const VectorXd powers = weights_of_orders(albedo, highest);
    std::vector<VectorXd> weights;
    for (int n = 1; n <= highest; ++n)
        weights.push_back(powers(n) * VectorXd::Unit(powers.size(), n));
    return weights;
}

double sum_paths(Side side, const LayerSolution& layer, int lowest, double in, double out) {
    const double f = layer.truncation.fraction;
    const int highest = f > 0 ? int_size(layer.order_weights) - 1 : 1;
    const PathWeights paths = path_weights(side, highest + 1, layer.optical_depth, in, out);
    double sum = 0;
    for (int n = lowest; n < paths.count; ++n)
        sum += layer.order_weights(n) * n * std::pow(f, n - 1) * paths.of_order[n];
    return sum;
}

double truncated_beam(const LayerSolution& layer, double mu) {
    const double f = layer.truncation.fraction, tau = layer.optical_depth;
    if (f == 0 || std::isinf(tau)) return 0;
    const VectorXd& weights = layer.order_weights;
    if (weights.size() == 0)
        return direct_transmittance(layer.truncation.optical_depth(tau, layer.albedo), mu) *
               -std::expm1(-f * layer.albedo * tau / mu);
    double sum = 0, term = direct_transmittance(tau, mu);
    for (Eigen::Index n = 1; n < weights.size(); ++n) {
        term *= f * tau / mu / static_cast<double>(n);
        sum += weights(n) * term;
    }
    return sum;
}

namespace {

using Eigen::MatrixXd;

/// diag(d) + z K_1 + z^2 K_2 + ..., over all directions; an empty part is zero.
struct Series {
    std::vector<MatrixXd> K;  // [0] is empty
    VectorXd d{};
};

void add_to(MatrixXd& sum, const MatrixXd& more) {
    if (more.size() == 0) return;
    if (sum.size() == 0)
        sum = more;
    else
        sum += more;
}

/// Adds F_a G_b at order a + b, without the diagonals.
void add_product(Series& sum, const Series& F, std::size_t a, const Series& G, std::size_t b,
                 int nodes) {
    const MatrixXd &K = F.K[a], &L = G.K[b];
    if (K.size() > 0 && L.size() > 0) add_to(sum.K[a + b], K.leftCols(nodes) * L.topRows(nodes));
}

Series product(const Series& F, const Series& G, int nodes) {
    Series sum{std::vector<MatrixXd>(F.K.size())};
    if (F.d.size() > 0 && G.d.size() > 0) sum.d = F.d.cwiseProduct(G.d);
    for (std::size_t n = 1; n < sum.K.size(); ++n) {
        if (F.d.size() > 0 && G.K[n].size() > 0) add_to(sum.K[n], F.d.asDiagonal() * G.K[n]);
        if (G.d.size() > 0 && F.K[n].size() > 0) add_to(sum.K[n], F.K[n] * G.d.asDiagonal());
        for (std::size_t a = 1; a < n; ++a) add_product(sum, F, a, G, n - a, nodes);
    }
    return sum;
}

/// Interreflection: solves X = F + Q X, where Q begins with the second order.
Series between(const Series& Q, const Series& F, int nodes) {
    Series X = F;
    for (std::size_t n = 2; n < X.K.size(); ++n) {
        if (F.d.size() > 0 && Q.K[n].size() > 0) add_to(X.K[n], Q.K[n] * F.d.asDiagonal());
        for (std::size_t j = 2; j < n; ++j) add_product(X, Q, j, X, n - j, nodes);
    }
    return X;
}

Series add_series(Series F, const Series& G) {
    for (std::size_t n = 1; n < F.K.size(); ++n) add_to(F.K[n], G.K[n]);
    return F;
}

Series transposed(Series F) {
    for (MatrixXd& K : F.K) K.transposeInPlace();
    return F;
}

/// One mode; as LayerMode. T has the beam on its diagonal.
struct OrderedMode {
    Series reflection, reflection_below, transmission;

    bool is_opaque() const { return transmission.d.size() == 0; }
};

/// Light that falls on the lower of two layers.
Series between(const OrderedMode& above, const OrderedMode& below, int nodes) {
    return between(product(above.reflection_below, below.reflection, nodes), above.transmission,
                   nodes);
}

/// The adding equations [HT74], as add() of layer.h.
OrderedMode add(const OrderedMode& above, const OrderedMode& below, int nodes) {
    const Series D = between(above, below, nodes), U = product(below.reflection, D, nodes),
                 none{std::vector<MatrixXd>(D.K.size())};
    OrderedMode sum{add_series(above.reflection, product(transposed(above.transmission), U, nodes)),
                    none, none};
    if (below.is_opaque()) return sum;
    sum.transmission = product(below.transmission, D, nodes);
    const Series V = between(product(below.reflection, above.reflection_below, nodes),
                             transposed(below.transmission), nodes);
    sum.reflection_below =
        add_series(below.reflection_below,
                   product(below.transmission, product(above.reflection_below, V, nodes), nodes));
    return sum;
}

class OrderedStackRun : StackSolver {
  public:
    OrderedStackRun(const StackLayers& layers, const LowerBoundary& boundary,
                    const std::vector<double>& mu, const SolverOptions& options)
        : StackSolver(layers, boundary, mu, options, false) {
        const VectorXd beam = beam_along(directions_.mu, total_depth(layers)),
                       none = VectorXd::Zero(beam.size());
        orders_.resize(size(options.orders) + 1, blank<StackSolution>());
        const Eigen::Index count = solved_cosines(directions_).size();
        const SingleFactors nothing{MatrixXd::Zero(count, count), MatrixXd::Zero(count, count)};
        for (std::size_t n = 0; n < orders_.size(); ++n) {
            orders_[n].mu = solved_cosines(directions_);
            orders_[n].order = static_cast<int>(n);
            recorders_.emplace_back(directions_, orders_[n], std::vector{nothing},
                                    Beam{n == 0 ? beam : none, none});
        }
    }

    std::vector<StackSolution> run() {
        solve_modes([this](int first, int end) { solve_group(first, end); });
        return std::move(orders_);
    }

  private:
    Series nothing() const { return {std::vector<MatrixXd>(size(options_.orders) + 1)}; }

    /// Modes `first` to before `end` of a layer of one of any depth.
    std::vector<OrderedMode> layer_modes(const StackLayer& layer,
                                         const std::vector<double>& moments, int first,
                                         int end) const {
        std::vector<OrderedMode> all(size(end - first), {nothing(), nothing(), nothing()});
        if (std::isfinite(layer.optical_depth))
            for (OrderedMode& mode : all)
                mode.transmission.d = beam_along(directions_.mu, layer.optical_depth);
        const int count = std::min(end, count_modes(moments));
        if (first >= count) return all;
        const DepthTarget target = choose_target(layer.optical_depth, false, moments[1]);
        const DepthLadder ladder = ladder_to(target);
        const ClimbTask task{
            directions_, moments, ladder, {{layer.albedo, 1 - layer.albedo, ladder.first}}};
        climb_orders(
            task, 0, weights_of_each_order(layer.albedo, options_.orders),
            modes_between(first, count),
            [&](int mode, std::size_t order, int depth, ModeMatrices solved, const PhaseKernels&) {
                if (depth + 1 < ladder.octaves) return false;
                solved = reach(target, mode, 0, directions_, std::move(solved));
                OrderedMode& to = all[size(mode - first)];
                to.reflection.K[order + 1] = solved.reflection;
                to.reflection_below.K[order + 1] = std::move(solved.reflection);
                if (!to.is_opaque()) to.transmission.K[order + 1] = std::move(solved.transmission);
                return false;
            });
        return all;
    }

    /// The lower boundary; its first order alone unless it is a layer.
    std::vector<OrderedMode> boundary_modes(int first, int end) {
        if (boundary_.is_layer())
            return layer_modes({boundary_.phase_function, boundary_.albedo, infinity},
                               boundary_truncation_.moments, first, end);
        std::vector<OrderedMode> all(size(end - first), {nothing(), nothing(), nothing()});
        for (int m = first; m < std::min(end, boundary_modes_.count()); ++m)
            all[size(m - first)].reflection.K[1] = boundary_modes_.layer(m).reflection;
        return all;
    }

    void solve_group(int first, int end) {
        std::vector<OrderedMode> sums =
            layer_modes(layers_[0], truncation_.layers[0].moments, first, end);
        const auto add_below = [&](const std::vector<OrderedMode>& below) {
            for (std::size_t m = 0; m < sums.size(); ++m)
                sums[m] = add(sums[m], below[m], directions_.nodes);
        };
        for (std::size_t k = 1; k < layers_.size(); ++k)
            add_below(layer_modes(layers_[k], truncation_.layers[k].moments, first, end));
        if (boundary_.is_present()) {
            const std::vector<OrderedMode> below = boundary_modes(first, end);
            if (first == 0) record_boundary(between(sums[0], below[0], directions_.nodes));
            add_below(below);
        }
        for (const OrderedMode& sum : sums) record(sum);
    }

    void record(const OrderedMode& sum) {
        const MatrixXd none = MatrixXd::Zero(directions_.size(), directions_.size());
        const auto part = [&](const Series& of, std::size_t n) {
            return of.K[n].size() > 0 ? of.K[n] : none;
        };
        for (std::size_t n = 0; n < orders_.size(); ++n) {
            LayerMode mode{part(sum.reflection, n)};
            if (!sum.is_opaque()) mode.transmission = part(sum.transmission, n);
            if (orders_[n].modes.reflection.empty() && !sum.is_opaque())
                orders_[n].spherical_albedo_below =
                    uniform_mean(directions_, part(sum.reflection_below, n));
            recorders_[n].record(mode, {nullptr}, nullptr);
            if (n > 1) continue;
            // Single scattering has its closed form.
            for (const Side side : both_sides) orders_[n].modes[side].back().values.setZero();
        }
    }

    /// `falling`: light of mode 0 that falls on the boundary.
    void record_boundary(const Series& falling) {
        const int N = directions_.nodes;
        MatrixXd weights(directions_.size(), 2);
        weights << boundary_modes_.entering(), directions_.s;
        for (std::size_t n = 0; n < orders_.size(); ++n) {
            const MatrixXd& K = falling.K[n];
            const MatrixXd diffuse = K.size() > 0
                                         ? MatrixXd(K.topRows(N).transpose() * weights.topRows(N))
                                         : MatrixXd::Zero(directions_.size(), 2);
            recorders_[n].record_fluxes_below(diffuse, weights);
        }
    }

    std::vector<StackSolution> orders_;
};

}  // namespace

std::vector<StackSolution> solve_stack_orders(const StackLayers& layers,
                                              const LowerBoundary& boundary,
                                              const std::vector<double>& mu,
                                              const SolverOptions& options) {
    SolverOptions with = options;
    with.truncate = Truncate::nothing;
    return OrderedStackRun(layers, boundary, mu, with).run();
}

}  // namespace stratus
