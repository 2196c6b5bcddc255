#include "probes.h"

#include <stratus/bake/parallel.h>
#include <stratus/runtime/diffusion.h>

#include "axes.h"
#include "piece_of_work.h"

#include <utility>

namespace stratus {

namespace {

/// More nodes are not tried.
constexpr int max_nodes = 96;

ProbedSide probe_side(const LayerSolution& layer, Side side, const DirectionGrid& directions) {
    GridValues values = evaluate(layer, side, directions);
    for (std::size_t n = 0; n < values.closed_form.size(); ++n)
        values.closed_form[n] += values.tabulated[n];
    return {std::move(values.tabulated), std::move(values.closed_form),
            side == Side::reflection ? reflection_floor(layer) : transmission_floor(layer)};
}

std::vector<double> probed_albedos(Range albedo) {
    if (albedo.min == albedo.max) return {albedo.min};
    const double first = std::sqrt(1 - albedo.max), last = std::sqrt(1 - albedo.min);
    std::vector<double> albedos;
    for (const double share : {0.0, 0.1, 0.4, 1.0}) {
        const double s = first + share * (last - first);
        albedos.push_back(std::clamp(1 - s * s, albedo.min, albedo.max));
    }
    return albedos;
}

DepthLadder probed_ladder(const Recipe& recipe) {
    const Range range = recipe.optical_depth;
    if (std::isinf(range.min)) return {1, 0, true};
    // Infinite tables are probed to where the law of diffusion has long taken over.
    const double reduced = 1 - recipe.phase_function.asymmetry();
    const double max = std::isinf(range.max) ? std::max(range.min, 200 / reduced) : range.max;
    const int octaves = static_cast<int>(std::floor(std::log2(max / range.min) + 1e-9));
    return {std::isinf(range.max) ? range.min : std::ldexp(range.max, -octaves), octaves + 1,
            std::isinf(range.max)};
}

ProbedLayers solve_layers_with(SolverOptions solver, const Probes& probes,
                               const std::vector<double>& albedos, const DepthLadder& ladder,
                               const DirectionGrid& directions) {
    solver.exact_fluxes = false;  // no choice is measured on them
    const Recipe& recipe = probes.recipe;
    // Eight albedos fill a SIMD register; few albedos are split so that no thread is idle.
    const std::size_t chunk = albedos.size() >= 16 ? 8 : 1;
    const auto chunks = static_cast<int>((albedos.size() + chunk - 1) / chunk);
    ProbedLayers layers(albedos.size());
    parallel_for(chunks, probes.options.threads, [&](int c) {
        stop_if_asked(probes.options.log);
        const std::size_t first = static_cast<std::size_t>(c) * chunk;
        const std::size_t last = std::min(albedos.size(), first + chunk);
        auto solved = solve_ladder(recipe.phase_function,
                                   {albedos.begin() + static_cast<std::ptrdiff_t>(first),
                                    albedos.begin() + static_cast<std::ptrdiff_t>(last)},
                                   ladder, directions.mu(), solver, recipe.lower_boundary);
        for (std::size_t a = first; a < last; ++a)
            for (LayerSolution& solution : solved[a - first])
                layers[a].push_back(probe(recipe, std::move(solution), directions));
    });
    return layers;
}

}  // namespace

Probes place_probes(const Recipe& recipe, double max_error, const BakeOptions& options) {
    std::vector<double> mu = floor_cosines();
    for (const double x : {0.035, 0.11, 0.18, 0.25, 0.39, 0.46, 0.61, 0.68, 0.86, 0.93})
        mu.push_back(x * x);
    const std::vector<double> albedos = probed_albedos(recipe.albedo);
    const std::shared_ptr<const PathOrders> path_law = path_law_of(recipe);
    return {recipe,
            max_error,
            options,
            path_law,
            directions_at(recipe, std::move(mu), path_law),
            albedos,
            decay_exponents(recipe, albedos),
            probed_ladder(recipe),
            extrapolation_length(recipe.phase_function, recipe.lower_boundary),
            {}};
}

DirectionGrid directions_at(const Recipe& recipe, std::vector<double> cosines,
                            std::shared_ptr<const PathOrders> path_law) {
    const int nodes = recipe.discretisation.nodes;
    return {recipe.phase_function,
            recipe.lower_boundary,
            std::move(cosines),
            {0.15, 0.7, 1.3, 1.9, 2.5, 3.1},
            2 * (nodes > 0 ? nodes : max_nodes),
            std::move(path_law)};
}

std::vector<double> few_cosines() {
    std::vector<double> mu = floor_cosines();
    mu.insert(mu.end(), {0.0049, 0.03});
    return mu;
}

const ProbedLayers& probed_layers(Probes& probes) {
    if (!probes.layers.empty()) return probes.layers;
    SolverOptions solver = solver_options(probes.recipe);
    solver.modes = 0;
    probes.layers =
        solve_layers_with(solver, probes, probes.albedos, probes.ladder, probes.directions);
    return probes.layers;
}

ProbedLayers solve_layers(const Probes& probes, const std::vector<double>& albedos,
                          const DepthLadder& ladder, const DirectionGrid& directions,
                          int most_modes) {
    SolverOptions solver = solver_options(probes.recipe);
    if (most_modes > 0 && (solver.modes == 0 || solver.modes > most_modes))
        solver.modes = most_modes;
    return solve_layers_with(solver, probes, albedos, ladder, directions);
}

ProbedLayer probe(const Recipe& recipe, LayerSolution solution, const DirectionGrid& directions) {
    ProbedLayer layer;
    if (recipe.reflection) layer.reflection = probe_side(solution, Side::reflection, directions);
    if (recipe.transmission)
        layer.transmission = probe_side(solution, Side::transmission, directions);
    layer.solution = std::move(solution);
    return layer;
}

DepthLadder ladder_to_deepest(const Probes& probes) {
    DepthLadder ladder = probes.ladder;
    const double deepest = probes.recipe.discretisation.deepest_optical_depth;
    if (deepest > 0)
        ladder.octaves = 1 + static_cast<int>(std::lround(std::log2(deepest / ladder.first)));
    return ladder;
}

double measure_layers(
    const Probes& probes, std::size_t albedos, std::size_t depths,
    const std::function<void(std::size_t albedo, std::size_t depth, Errors& errors)>& measure) {
    std::vector<Errors> of_layer(albedos * depths);
    parallel_for(static_cast<int>(of_layer.size()), probes.options.threads, [&](int n) {
        stop_if_asked(probes.options.log);
        const auto at = static_cast<std::size_t>(n);
        measure(at / depths, at % depths, of_layer[at]);
    });
    Errors all;
    for (const Errors& errors : of_layer) all.insert(all.end(), errors.begin(), errors.end());
    return error_quantile(all, 0.999);
}

void add_blend_errors(const Recipe& recipe, const ProbedLayer& expected,
                      const DirectionGrid& directions, const Blend& blend, Errors& errors) {
    add_errors(recipe, expected, directions, static_cast<int>(directions.mu().size()), errors,
               [&](Side side, int i, int j, int k) {
                   const double* const weight =
                       side == Side::reflection ? blend.reflection : blend.transmission;
                   double found = 0;
                   for (int p = 0; p < Blend::size; ++p)
                       if (weight[p] != 0)
                           found += weight[p] *
                                    blend.sample[p]->side(side).tabulated[directions.at(i, j, k)];
                   return found;
               });
}

double intercepted(const Recipe& recipe, double optical_depth, double mu) {
    return recipe.lower_boundary.is_present() ? 1 : intercepted_share(optical_depth, mu);
}

double sample_scale(const Probes& probes, Side side, double optical_depth, double exponent) {
    if (probes.recipe.lower_boundary.is_present()) return 1;
    return side == Side::reflection
               ? reflection_scale(optical_depth, exponent, probes.extrapolation_length)
               : transmission_scale(optical_depth, exponent, probes.extrapolation_length);
}

}  // namespace stratus
