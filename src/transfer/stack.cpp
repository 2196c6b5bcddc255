#include <stratus/transfer/stack.h>

#include <stratus/base/argument.h>

#include "light_inside.h"
#include "orders.h"
#include "stack_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Neighbours that scatter alike are one layer.
StackLayers merged(const StackLayers& layers) {
    StackLayers all;
    for (const StackLayer& layer : layers) {
        const bool is_alike = !all.empty() && all.back().albedo == layer.albedo &&
                              all.back().phase_function.text() == layer.phase_function.text();
        if (is_alike)
            all.back().optical_depth += layer.optical_depth;
        else
            all.push_back(layer);
    }
    return all;
}

/// A stack of one layer over nothing, which is solved as such.
StackSolution as_stack(const LayerSolution& layer, const StackLayer& of) {
    StackSolution solution;
    static_cast<ModeSolution&>(solution) = layer;
    solution.layers = {of};
    solution.truncations = {layer.truncation};
    if (std::isfinite(of.optical_depth)) solution.spherical_albedo_below = layer.spherical_albedo;
    solution.alone = std::make_shared<const LayerSolution>(layer);
    return solution;
}

class StackRun : StackSolver {
  public:
    StackRun(const StackLayers& layers, const LowerBoundary& boundary,
             const std::vector<double>& mu, const SolverOptions& options)
        : StackSolver(layers, boundary, mu, options, layers.size() == 1),
          solution_(blank<StackSolution>()) {
        solution_.mu = solved_cosines(directions_);
        recorders_.emplace_back(directions_, solution_, single_factors(),
                                layer_modes_.beam(layer_modes_.size()));
        if (truncation_.layers[0].backward)
            solution_.backward_path = std::make_shared<const BackwardPath>(
                path_moments(layers[0].phase_function), truncation_.layers[0].moments);
    }

    StackSolution run() {
        solve_modes([&](int first, int end) {
            for (int mode = first; mode < end; ++mode) solve_mode(mode);
        });
        return std::move(solution_);
    }

  private:
    std::vector<SingleFactors> single_factors() const {
        const SingleLayers single(layers_, truncation_.layers, &Truncation::albedo);
        const std::size_t count = layers_.size();
        std::vector<SingleFactors> all;
        for (std::size_t k = 0; k < count; ++k)
            all.push_back(
                {single.factors(k, 0, solution_.mu), single.factors(k, count, solution_.mu)});
        return all;
    }

    void solve_mode(int mode) {
        LayerMode sum = layer_modes_.layer(0, mode);
        for (std::size_t k = 1; k < layer_modes_.size(); ++k)
            sum = add(sum, layer_modes_.layer(k, mode), directions_.nodes);
        ModeRecorder& recorder = recorders_[0];
        if (boundary_.is_present()) {
            if (mode == 0) recorder.record_boundary(sum, boundary_modes_);
            sum = add(sum, boundary_modes_.layer(mode), directions_.nodes);
        } else if (mode == 0 && !sum.is_opaque()) {
            solution_.spherical_albedo_below =  // rounding is taken off
                std::clamp(uniform_mean(directions_, sum.reflection_below), 0.0, 1.0);
        }
        recorder.record(sum, layer_modes_.kernels(mode), &boundary_modes_);
    }

    StackSolution solution_;
};

/// The layers, neighbours that scatter alike as one.
StackLayers checked(const StackLayers& layers, const LowerBoundary& boundary,
                    const SolverOptions& options) {
    check_options(options);
    require(options.scheme == Scheme::harmonic, "solve_stack", "scheme", "harmonic", "another");
    check_layers(layers, boundary.is_present(), "solve_stack");
    check_boundary(boundary);
    return merged(layers);
}

StackSolution sum_orders(const std::vector<StackSolution>& orders) {
    StackSolution sum = orders.front();
    sum.order = 0;
    for (std::size_t n = 1; n < orders.size(); ++n) {
        const StackSolution& order = orders[n];
        for (const Side side : both_sides)
            for (std::size_t m = 0; m < sum.modes[side].size(); ++m)
                sum.modes[side][m].values += order.modes[side][m].values;
        sum.plane_albedo += order.plane_albedo;
        sum.diffuse_transmittance += order.diffuse_transmittance;
        sum.spherical_albedo += order.spherical_albedo;
        sum.spherical_albedo_below += order.spherical_albedo_below;
        sum.total_transmittance += order.total_transmittance;
        sum.spherical_ground_absorptance += order.spherical_ground_absorptance;
        if (sum.lower_boundary.is_present()) sum.ground_absorptance += order.ground_absorptance;
    }
    return sum;
}

}  // namespace

StackSolution solve_stack(const StackLayers& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options) {
    const StackLayers unlike = checked(layers, boundary, options);
    const bool is_one_layer = unlike.size() == 1 && !boundary.is_present();
    if (is_one_layer) {
        const StackLayer& only = unlike.front();
        return as_stack(
            solve_layer(only.phase_function, only.albedo, only.optical_depth, mu, options), only);
    }
    if (options.orders > 0) return sum_orders(solve_stack_orders(unlike, boundary, mu, options));
    return StackRun(unlike, boundary, mu, options).run();
}

std::vector<StackSolution> solve_orders(const StackLayers& layers, const LowerBoundary& boundary,
                                        const std::vector<double>& mu,
                                        const SolverOptions& options) {
    require(options.orders >= 1, "solve_orders", "orders", "in [1, 200]", options.orders);
    const StackLayers unlike = checked(layers, boundary, options);
    if (unlike.size() > 1 || boundary.is_present()) {
        std::vector<StackSolution> orders = solve_stack_orders(unlike, boundary, mu, options);
        orders.erase(orders.begin());  // the beam
        return orders;
    }
    const StackLayer& only = unlike.front();
    std::vector<StackSolution> orders;
    for (const LayerSolution& order :
         solve_orders(only.phase_function, only.albedo, only.optical_depth, mu, options))
        orders.push_back(as_stack(order, only));
    return orders;
}

LayerSolution as_one_layer(StackSolution solution) {
    const StackLayer mean = mean_layer(solution.layers);
    LayerSolution layer;
    static_cast<ModeSolution&>(layer) = solution;
    layer.phase_function = mean.phase_function;
    layer.albedo = mean.albedo;
    layer.optical_depth = mean.optical_depth;
    layer.stack = std::make_shared<const StackSolution>(std::move(solution));
    return layer;
}

bool StackSolution::is_opaque() const {
    return lower_boundary.is_present() || std::isinf(layers.back().optical_depth);
}

}  // namespace stratus
