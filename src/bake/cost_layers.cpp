#include "cost_layers.h"

#include <stratus/bake/clock.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

CostLayers::CostLayers(const Recipe& recipe, int threads) : recipe_(recipe), threads_(threads) {
    const double last = std::sqrt(1 - recipe.albedo.min);
    const double first = std::sqrt(1 - recipe.albedo.max);
    for (const double at : {0.0, 0.1, 0.45, 0.95}) {
        const double s = first + at * (last - first);
        albedos_.push_back(std::clamp(1 - s * s, recipe.albedo.min, recipe.albedo.max));
        if (recipe.albedo.min == recipe.albedo.max) break;
    }
    for (const double x : {0.05, 0.14, 0.22, 0.3, 0.36, 0.5, 0.64, 0.75, 0.82, 0.96})
        mu_.push_back(x * x);
    const Range depth = recipe.optical_depth;
    if (std::isinf(depth.min)) {
        ladder_ = {1, 0, true};
        return;
    }
    const double max = std::isinf(depth.max) ? std::max(depth.min, 64.0) : depth.max;
    const int octaves = static_cast<int>(std::floor(std::log2(max / depth.min) + 1e-9));
    ladder_ = {std::ldexp(max, -octaves), octaves + 1, std::isinf(depth.max)};
}

CostLayers::Layers CostLayers::solve(const SolverOptions& solver) const {
    std::vector<Layers> of_albedo(albedos_.size());
    parallel_for(static_cast<int>(albedos_.size()), threads_, [&](int a) {
        const auto at = static_cast<std::size_t>(a);
        auto solved = solve_ladder(recipe_.phase_function, {albedos_[at]}, ladder_, mu_, solver,
                                   recipe_.lower_boundary)[0];
        const std::size_t stride = std::max<std::size_t>(1, solved.size() / 6);
        for (std::size_t d = (solved.size() - 1) % stride; d < solved.size(); d += stride)
            of_albedo[at].push_back(std::move(solved[d]));
    });
    Layers layers;
    for (Layers& some : of_albedo)
        for (LayerSolution& layer : some) layers.push_back(std::move(layer));
    return layers;
}

CostLayers::Values CostLayers::values(const Layers& layers) const {
    std::vector<Values> of_layer(layers.size());
    parallel_for(static_cast<int>(layers.size()), threads_, [&](int n) {
        const auto at = static_cast<std::size_t>(n);
        of_layer[at] = values_of(layers[at]);
    });
    Values all;
    for (const Values& some : of_layer) {
        all.total.insert(all.total.end(), some.total.begin(), some.total.end());
        all.floor.insert(all.floor.end(), some.floor.begin(), some.floor.end());
    }
    return all;
}

double CostLayers::time_solve(const SolverOptions& solver) const {
    constexpr double enough = 5e-3;
    double best = infinity;
    for (const auto begun = Clock::now(); seconds_since(begun) < enough;) {
        const double started = processor_seconds();
        solve_layer(recipe_.phase_function, recipe_.albedo.max, recipe_.optical_depth.max, mu_,
                    solver, recipe_.lower_boundary);
        best = std::min(best, processor_seconds() - started);
    }
    return best;
}

CostLayers::Values CostLayers::values_of(const LayerSolution& layer) const {
    Values values;
    const int count = static_cast<int>(mu_.size());
    const std::vector<double> azimuths{0.1, 0.55, 1.2, 2.0, 2.7, 3.05};
    auto add = [&](double floor, auto side) {
        for (int i = 0; i < count; ++i)
            for (int j = i; j < count; ++j)
                for (const SolvedValue& value : side(i, j)) {
                    values.total.push_back(value.total);
                    values.floor.push_back(floor);
                }
    };
    if (recipe_.reflection)
        add(reflection_floor(layer),
            [&](int i, int j) { return layer.reflection(i, j, azimuths); });
    if (recipe_.transmission && !std::isinf(layer.optical_depth))
        add(transmission_floor(layer),
            [&](int i, int j) { return layer.transmission(i, j, azimuths); });
    return values;
}

std::vector<double> errors_of(const CostLayers::Values& found, const CostLayers::Values& expected) {
    std::vector<double> errors(found.total.size());
    for (std::size_t n = 0; n < errors.size(); ++n)
        errors[n] = std::abs(found.total[n] - expected.total[n]) /
                    std::max(expected.total[n], expected.floor[n]);
    return errors;
}

}  // namespace stratus
