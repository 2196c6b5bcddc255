#include "probes.h"

#include <stratus/bake/parallel.h>
#include <stratus/runtime/diffusion.h>

#include "axes.h"
#include "piece_of_work.h"

#include <utility>

namespace stratus {

namespace {

ProbedSide probe_side(const LayerSolution& layer, Side side, const LowerBoundary& boundary,
                      const DirectionGrid& directions, const Eigen::MatrixXd& cosines) {
    const bool reflects = side == Side::reflection;
    const auto& phase = reflects ? directions.reflected_phase : directions.transmitted_phase;
    ProbedSide values;
    values.floor = reflects ? reflection_floor(layer) : transmission_floor(layer);
    values.multiple.resize(phase.size());
    values.total.resize(phase.size());
    visit_multiple_scattering(
        layer, side, directions, cosines,
        [&](std::size_t i, std::size_t j, std::span<const double> multiple) {
            const double in = directions.mu[i], out = directions.mu[j];
            const double once = (reflects ? single_reflection : single_transmission)(
                1, layer.albedo, layer.optical_depth, in, out);
            const double boundary_once =
                reflects ? single_reflection_of_boundary(boundary, 1, layer.optical_depth, in, out)
                         : 0;
            for (std::size_t k = 0; k < multiple.size(); ++k) {
                const std::size_t at = directions.at(i, j, k), mirrored = directions.at(j, i, k);
                values.multiple[at] = values.multiple[mirrored] = multiple[k];
                values.total[at] = values.total[mirrored] =
                    multiple[k] + once * phase[at] + boundary_once * directions.boundary_phase[at];
            }
        });
    return values;
}

std::vector<double> probed_albedos(Range albedo) {
    if (albedo.min == albedo.max) return {albedo.min};
    const double first = std::sqrt(1 - albedo.max), last = std::sqrt(1 - albedo.min);
    std::vector<double> albedos;
    for (const double share : {0.0, 0.04, 0.15, 0.4, 0.75, 1.0}) {
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

ProbedLayers solve_layers_with(const SolverOptions& solver, const Probes& probes,
                               const std::vector<double>& albedos, const DepthLadder& ladder,
                               const DirectionGrid& directions) {
    const Recipe& recipe = probes.recipe;
    // Eight albedos fill the lanes of a pack; few albedos are split so that no thread is idle.
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
                                   ladder, directions.mu, solver, recipe.lower_boundary);
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
    return {recipe,
            max_error,
            options,
            directions_at(recipe, std::move(mu)),
            albedos,
            decay_exponents(recipe, albedos),
            probed_ladder(recipe),
            extrapolation_length(recipe.phase_function, recipe.lower_boundary),
            {}};
}

DirectionGrid directions_at(const Recipe& recipe, std::vector<double> cosines) {
    return {recipe.phase_function,
            recipe.lower_boundary,
            std::move(cosines),
            {0.15, 0.7, 1.3, 1.9, 2.5, 3.1}};
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
                          const DepthLadder& ladder, const DirectionGrid& directions) {
    return solve_layers_with(solver_options(probes.recipe), probes, albedos, ladder, directions);
}

ProbedLayer probe(const Recipe& recipe, LayerSolution solution, const DirectionGrid& directions) {
    ProbedLayer layer;
    const auto modes = static_cast<Eigen::Index>(
        std::max(solution.reflection_modes.size(), solution.transmission_modes.size()));
    const Eigen::MatrixXd cosines = fourier_cosines(directions.azimuth, modes);
    if (recipe.reflection)
        layer.reflection =
            probe_side(solution, Side::reflection, recipe.lower_boundary, directions, cosines);
    if (recipe.transmission)
        layer.transmission =
            probe_side(solution, Side::transmission, recipe.lower_boundary, directions, cosines);
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
    add_errors(recipe, expected, directions, directions.mu.size(), errors,
               [&](Side side, std::size_t i, std::size_t j, std::size_t k) {
                   const double* const weight =
                       side == Side::reflection ? blend.reflection : blend.transmission;
                   double found = 0;
                   for (std::size_t p = 0; p < Blend::size; ++p)
                       if (weight[p] != 0)
                           found += weight[p] *
                                    blend.sample[p]->side(side).multiple[directions.at(i, j, k)];
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
