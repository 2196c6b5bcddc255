#include "choices.h"

#include <stratus/bake/axes.h>
#include <stratus/bake/parallel.h>
#include <stratus/bake/ranks.h>
#include <stratus/base/constants.h>

#include "piece_of_work.h"
#include "table_units.h"

#include <numeric>
#include <utility>

namespace stratus {

namespace {

/// More nodes are not tried.
constexpr int max_nodes = 96;

std::vector<double> probed_albedos(Range albedo) {
    if (albedo.min == albedo.max) return {albedo.min};
    // At darker ones there is little light of the orders n >= 2.
    const double darkest = std::max(albedo.min, 0.3 * albedo.max);
    const double first = std::sqrt(1 - albedo.max), last = std::sqrt(1 - darkest);
    constexpr double narrow = 0.05;  // the ends tell of all between them
    std::vector<double> albedos;
    for (const double share : {0.0, 0.1, 0.4, 1.0}) {
        if (last - first < narrow && share > 0 && share < 1) continue;
        const double s = first + share * (last - first);
        albedos.push_back(std::clamp(1 - s * s, darkest, albedo.max));
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

/// Between the ends of a range, one where they meet.
std::vector<double> at_shares(Range range, const std::vector<double>& shares) {
    if (range.min == range.max) return {range.min};
    std::vector<double> values;
    for (const double share : shares)
        values.push_back(std::min(range.min + share * (range.max - range.min), range.max));
    return values;
}

std::vector<double> probed_azimuths(Range degrees) {
    if (!is_narrow(degrees, all_azimuths)) return {0.15, 0.7, 1.3, 1.9, 2.5, 3.1};
    return at_shares({radians(degrees.min), radians(degrees.max)}, {0.05, 0.37, 0.66, 0.98});
}

double least_cosine_of_choices(const Recipe& recipe) {
    return leaves_path_law(recipe) ? least_judged_cosine : 0;
}

/// `cosines` along an axis of all, if they are judged, shares of the way along a narrow one.
ProbedCosines cosines_to_probe(const Recipe& recipe, const std::vector<double>& cosines,
                               const std::vector<double>& shares) {
    ProbedCosines probed{floor_cosines(), {}};
    const bool narrow_in = is_narrow(recipe.mu_in, all_cosines),
               narrow_out = is_narrow(recipe.mu_out, all_cosines);
    const double least = least_cosine_of_choices(recipe);
    if (!narrow_in || !narrow_out)
        std::ranges::copy_if(cosines, std::back_inserter(probed.mu),
                             [&](double mu) { return mu >= least; });
    // Near the normal odd modes are steep; among all pairs few are there.
    if (narrow_in != narrow_out) probed.mu.push_back(0.99);
    std::vector<int> of_all(probed.mu.size());
    std::iota(of_all.begin(), of_all.end(), 0);
    const auto along = [&](Range range) {
        if (!is_narrow(range, all_cosines)) return of_all;
        std::vector<int> places;
        const Range roots{std::sqrt(std::max(range.min, min_mu)), std::sqrt(range.max)};
        for (const double root : at_shares(roots, shares)) {
            places.push_back(int_size(probed.mu));
            probed.mu.push_back(std::clamp(root * root, range.min, range.max));
        }
        return places;
    };
    probed.pairs.in = along(recipe.mu_in);
    const bool same =
        recipe.mu_in.min == recipe.mu_out.min && recipe.mu_in.max == recipe.mu_out.max;
    probed.pairs.out = same ? probed.pairs.in : along(recipe.mu_out);
    probed.pairs.exchangeable = recipe.layers.empty();
    return probed;
}

ProbedCosines many_cosines(const Recipe& recipe) {
    std::vector<double> cosines;
    // However many samples of mu a table has, most of these lie well between two of them.
    for (const double x : {0.035, 0.11, 0.18, 0.25, 0.39, 0.46, 0.615, 0.665, 0.815, 0.875, 0.95})
        cosines.push_back(x * x);
    // Laws of grounds are steep at grazing angles.
    if (recipe.lower_boundary.law != nullptr) cosines.push_back(0.0003);
    // Thin layers of a stack are steep at cosines about as large as their depths.
    for (const StackLayer& layer : recipe.layers)
        for (const double share : {0.3, 1.0})
            if (const double mu = share * layer.optical_depth; mu > 0.001 && mu < 0.1)
                cosines.push_back(mu);
    return cosines_to_probe(recipe, cosines, {0, 0.12, 0.3, 0.45, 0.7, 0.88, 1});
}

/// Adds cosines, along axes of all, at which cubics between few samples would miss most.
void add_cosines_between(const Recipe& recipe, ProbedCosines& probed) {
    const bool narrow_in = is_narrow(recipe.mu_in, all_cosines),
               narrow_out = is_narrow(recipe.mu_out, all_cosines);
    if (narrow_in && narrow_out) return;
    for (const double x : {0.075, 0.14, 0.32}) {
        if (x * x < least_cosine_of_choices(recipe)) continue;
        const int place = int_size(probed.mu);
        probed.mu.push_back(x * x);
        if (!narrow_in) probed.pairs.in.push_back(place);
        if (!narrow_out) probed.pairs.out.push_back(place);
    }
}

/// Packs of eight (mode, albedo) pairs that the solver fills for `modes` modes of some albedos.
std::size_t count_packs(std::size_t albedos, std::size_t modes) {
    constexpr std::size_t lanes = 8;
    const auto packs = [&](std::size_t of) { return (albedos * of + lanes - 1) / lanes; };
    const std::size_t group = std::max<std::size_t>(2, lanes / std::min(lanes, albedos));
    return modes / group * packs(group) + packs(modes % group);
}

/// Albedos to solve at once, as many as fill packs best, fewer where that costs little: threads then
/// share the work better. One at a time where the solver itself finds when to stop: modes then do
/// not depend on the other albedos. Counted orders cost all albedos as much as one.
std::size_t chunk_size(std::size_t albedos, const SolverOptions& solver) {
    const int modes = solver.modes;
    if (modes == 0) return albedos >= 16 ? 8 : 1;
    if (solver.orders > 0) return 8;
    std::size_t best = 1, fewest = 0;
    for (std::size_t chunk = 1; chunk <= 8; chunk *= 2) {
        const std::size_t whole = albedos / chunk, rest = albedos % chunk;
        const auto of = size(modes);
        const std::size_t packs =
            whole * count_packs(chunk, of) + (rest > 0 ? count_packs(rest, of) : 0);
        if (chunk > 1 && 10 * packs > 9 * fewest) continue;
        best = chunk;
        fewest = packs;
    }
    return best;
}

int chunk_count(std::size_t albedos, std::size_t chunk) {
    return static_cast<int>((albedos + chunk - 1) / chunk);
}

/// Solves this share of the layers of several ladders: take(ladder, albedo, solutions of all depths).
template <class Take>
void solve_ladders_with(SolverOptions solver, const Probes& probes,
                        const std::vector<double>& albedos, const std::vector<DepthLadder>& ladders,
                        const std::vector<double>& mu, Share share, const Take& take) {
    solver.exact_fluxes = false;  // no choice is measured on them
    const Recipe& recipe = probes.recipe;
    const std::size_t chunk = chunk_size(albedos.size(), solver);
    const auto chunks = size(chunk_count(albedos.size(), chunk));
    parallel_for(static_cast<int>(ladders.size() * chunks), probes.options.threads, [&](int n) {
        stop_if_asked(probes.options.log);
        const std::size_t c = size(n) % chunks, ladder = size(n) / chunks;
        if (static_cast<int>(c) % share.count != share.index) return;
        const std::size_t first = c * chunk, last = std::min(albedos.size(), first + chunk);
        auto solved = solve_material(recipe.layers, recipe.phase_function,
                                     {albedos.data() + first, albedos.data() + last},
                                     ladders[ladder], mu, solver, recipe.lower_boundary);
        for (std::size_t a = first; a < last; ++a) take(ladder, a, std::move(solved[a - first]));
    });
}

ProbedSide probe_side(const LayerSolution& solution, Side side, const DirectionGrid& directions,
                      double floor) {
    GridValues values = evaluate(solution, side, directions);
    for (std::size_t n = 0; n < values.closed_form.size(); ++n)
        values.closed_form[n] += values.tabulated[n];
    return {std::move(values.tabulated), std::move(values.closed_form), floor};
}

/// A solved layer at all directions; the solution keeps albedo and depth alone.
ProbedLayer probe(const Recipe& recipe, const LayerSolution& solution,
                  const DirectionGrid& directions) {
    ProbedLayer layer;
    layer.solution.albedo = solution.albedo;
    layer.solution.optical_depth = solution.optical_depth;
    for (const Side side : asked_sides(recipe))
        layer.side[side] = probe_side(solution, side, directions, error_floor(solution, side));
    return layer;
}

std::vector<ProbedLayers> solve_ladders_with(const SolverOptions& solver, const Probes& probes,
                                             const std::vector<double>& albedos,
                                             const std::vector<DepthLadder>& ladders,
                                             const DirectionGrid& directions, Share share = {},
                                             bool keeps_solutions = false) {
    std::vector<ProbedLayers> layers(ladders.size(), ProbedLayers(albedos.size()));
    solve_ladders_with(
        solver, probes, albedos, ladders, directions.mu(), share,
        [&](std::size_t ladder, std::size_t a, std::vector<LayerSolution> solutions) {
            for (LayerSolution& solution : solutions) {
                ProbedLayer& layer =
                    layers[ladder][a].emplace_back(probe(probes.recipe, solution, directions));
                if (keeps_solutions) layer.solution = std::move(solution);
            }
        });
    return layers;
}

/// For the first modes alone, unless 0.
SolverOptions solver_of_first(const Probes& probes, int most_modes) {
    SolverOptions solver = solver_options(probes.recipe);
    if (most_modes > 0 && (solver.modes == 0 || solver.modes > most_modes))
        solver.modes = most_modes;
    return solver;
}

Share rank_share(const WorkLog& log, std::size_t albedos) {
    if (log.ranks == nullptr) return {};
    const int count = std::min(log.ranks->count(), static_cast<int>(albedos));
    return {log.ranks->rank() % count, count};
}

std::vector<double> every(Share share, const std::vector<double>& albedos) {
    std::vector<double> some;
    for (auto a = size(share.index); a < albedos.size(); a += size(share.count))
        some.push_back(albedos[a]);
    return some;
}

/// Lists the numbers of a layer that solve_layers_together has, with room for what list(number) sets.
template <class List>
void list_numbers(ProbedLayer& layer, const List& list) {
    list(layer.solution.albedo);
    list(layer.solution.optical_depth);
    for (const Side side : both_sides) {
        ProbedSide& probed = layer.side[side];
        list(probed.floor);
        for (std::vector<double>* values : {&probed.tabulated, &probed.total}) {
            auto count = static_cast<double>(values->size());
            list(count);
            values->resize(static_cast<std::size_t>(count));
            for (double& value : *values) list(value);
        }
    }
}

}  // namespace

Probes place_probes(const Recipe& recipe, double max_error, const BakeOptions& options) {
    std::vector<double> albedos = probed_albedos(recipe.albedo);
    const std::size_t all_albedos = albedos.size();
    const Share share = rank_share(options.log, all_albedos);
    albedos = every(share, albedos);
    const std::shared_ptr<const PathOrders> path_law = recipe_path_law(recipe);
    ProbedCosines cosines = many_cosines(recipe);
    const CosinePairs usual = cosines.pairs;
    add_cosines_between(recipe, cosines);
    return {recipe,
            max_error,
            options,
            path_law,
            directions_at(recipe, {cosines.mu, usual}, path_law),
            directions_at(recipe, cosines, path_law),
            albedos,
            decay_exponents(recipe, albedos),
            probed_ladder(recipe),
            extrapolation_length(recipe.phase_function, recipe.lower_boundary),
            {},
            share,
            all_albedos};
}

std::size_t count_of_share(const Probes& probes, std::size_t count) {
    const auto& [index, shares] = probes.share;
    return (count + size(shares - 1 - index)) / size(shares);
}

ProbedCosines some_cosines(const Recipe& recipe) {
    return cosines_to_probe(recipe, {0.0012, 0.032, 0.15, 0.37, 0.74},
                            {0, 0.12, 0.3, 0.45, 0.7, 0.88, 1});
}

ProbedCosines few_cosines(const Recipe& recipe) {
    return cosines_to_probe(recipe, {0.0049, 0.03}, {0, 0.45, 1});
}

DirectionGrid directions_at(const Recipe& recipe, ProbedCosines cosines,
                            std::shared_ptr<const PathOrders> path_law) {
    const int nodes = recipe.discretisation.nodes;
    return {recipe.phase_function,
            recipe.lower_boundary,
            std::move(cosines.mu),
            probed_azimuths(recipe.azimuth),
            2 * (nodes > 0 ? nodes : max_nodes),
            std::move(path_law),
            std::move(cosines.pairs)};
}

const ProbedLayers& probed_layers(Probes& probes) {
    if (!probes.layers.empty()) return probes.layers;
    SolverOptions solver = solver_options(probes.recipe);
    solver.modes = 0;
    probes.layers = std::move(solve_ladders_with(solver, probes, probes.albedos, {probes.ladder},
                                                 probes.directions, {}, true)[0]);
    return probes.layers;
}

Errors errors_of_solutions(
    const Probes& probes, const std::vector<double>& albedos, const std::vector<double>& mu,
    const std::function<void(std::size_t albedo, std::size_t depth, const LayerSolution& solution,
                             Errors& errors)>& measure) {
    std::vector<Errors> of_albedo(albedos.size());
    solve_ladders_with(solver_options(probes.recipe), probes, albedos, {probes.ladder}, mu, {},
                       [&](std::size_t, std::size_t a, std::vector<LayerSolution> solutions) {
                           for (std::size_t d = 0; d < solutions.size(); ++d)
                               measure(a, d, solutions[d], of_albedo[a]);
                       });
    return joined(std::move(of_albedo));
}

std::vector<ProbedLayers> solve_ladders(const Probes& probes, const std::vector<double>& albedos,
                                        const std::vector<DepthLadder>& ladders,
                                        const DirectionGrid& directions, int most_modes) {
    return solve_ladders_with(solver_of_first(probes, most_modes), probes, albedos, ladders,
                              directions);
}

ProbedLayers solve_layers_together(const Probes& probes, const std::vector<double>& albedos,
                                   const DepthLadder& ladder, const DirectionGrid& directions,
                                   int most_modes) {
    const WorkLog& log = probes.options.log;
    if (albedos.empty() || log.ranks == nullptr || log.ranks->count() == 1)
        return std::move(solve_ladders(probes, albedos, {ladder}, directions, most_modes)[0]);
    const SolverOptions solver = solver_of_first(probes, most_modes);
    const std::size_t chunk = chunk_size(albedos.size(), solver);
    const Share share{log.ranks->rank(),
                      std::min(log.ranks->count(), chunk_count(albedos.size(), chunk))};
    ProbedLayers layers =
        std::move(solve_ladders_with(solver, probes, albedos, {ladder}, directions, share)[0]);
    std::vector<double> numbers;
    for (auto& of_albedo : layers)
        for (ProbedLayer& layer : of_albedo)
            list_numbers(layer, [&](double& number) { numbers.push_back(number); });
    const std::vector<std::vector<double>> of_rank = gather(log, numbers, share.count);
    std::vector<const double*> next;
    for (const std::vector<double>& of_one : of_rank) next.push_back(of_one.data());
    for (std::size_t a = 0; a < albedos.size(); ++a) {
        layers[a].resize(size(ladder.count()));
        for (ProbedLayer& layer : layers[a]) {
            const double*& from = next[a / chunk % of_rank.size()];
            list_numbers(layer, [&](double& number) { number = *from++; });
        }
    }
    return layers;
}

std::vector<Side> asked_sides(const Recipe& recipe) {
    std::vector<Side> sides;
    if (recipe.reflection) sides.push_back(Side::reflection);
    if (recipe.transmission) sides.push_back(Side::transmission);
    return sides;
}

ProbedLayers probe_again(Probes& probes, const DirectionGrid& directions) {
    const ProbedLayers& layers = probed_layers(probes);
    ProbedLayers again(layers.size(), std::vector<ProbedLayer>(layers[0].size()));
    parallel_for(
        static_cast<int>(layers.size() * layers[0].size()), probes.options.threads, [&](int n) {
            const std::size_t a = size(n) / layers[0].size(), d = size(n) % layers[0].size();
            const ProbedLayer& layer = layers[a][d];
            again[a][d].solution.optical_depth = layer.solution.optical_depth;
            for (const Side side : asked_sides(probes.recipe))
                again[a][d].side[side] =
                    probe_side(layer.solution, side, directions, layer.side[side].floor);
        });
    return again;
}

DepthLadder ladder_to_deepest(const Probes& probes) {
    DepthLadder ladder = probes.ladder;
    const double deepest = probes.recipe.discretisation.deepest_optical_depth;
    if (deepest > 0)
        ladder.octaves = 1 + static_cast<int>(std::lround(std::log2(deepest / ladder.first)));
    return ladder;
}

}  // namespace stratus
