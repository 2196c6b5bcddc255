// Choices of what resolves directions: nodes, modes, samples of mu and of azimuth.
#include <stratus/bake/axes.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "choices.h"
#include "piece_of_work.h"
#include "table_units.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace stratus {

namespace {

/// Parts of a choice's limit that the solver itself may use up: nodes, and the modes left out. With
/// a path law, nodes that hold more moments change the law's share of the light by much the same.
constexpr double share_of_nodes = 0.2, share_with_path_law = 0.5, share_of_modes = 0.05;

/// Positions of an axis' samples that a stencil reads; weights beyond a short axis are 0.
int sample_position(const Stencil& stencil, int p, const Axis& axis) {
    return std::min(stencil.first + p, int_size(axis.values) - 1);
}

double change(const Probes& probes, const ProbedLayers& from, const ProbedLayers& to) {
    const DirectionGrid& directions = probes.directions;
    return measure_layers(
        probes, to.size(), to[0].size(), [&](std::size_t a, std::size_t d, Errors& errors) {
            add_errors(probes.recipe, to[a][d], directions, errors,
                       [&](Side side, int i, int j, int k) {
                           return from[a][d].side[side].tabulated[directions.at(i, j, k)];
                       });
        });
}

/// Bounds the sum of all modes from `kept` on.
double tail_of_modes(Probes& probes, int kept) {
    const ProbedLayers& layers = probed_layers(probes);
    const DirectionGrid& directions = probes.directions;
    return measure_layers(
        probes, layers.size(), layers[0].size(), [&](std::size_t a, std::size_t d, Errors& errors) {
            const ProbedLayer& layer = layers[a][d];
            add_errors(probes.recipe, layer, directions, errors,
                       [&](Side side, int i, int j, int k) {
                           const int in = directions.pairs().in[size(i)];
                           const int out = directions.pairs().out[size(j)];
                           const auto& modes = layer.solution.modes[side];
                           double tail = 0;
                           for (auto m = size(kept); m < modes.size(); ++m)
                               tail += 2 * std::abs(modes[m](in, out));
                           return layer.side[side].tabulated[directions.at(i, j, k)] + tail;
                       });
        });
}

/// The samples of an axis of cosines that the probed cosines are found between.
struct SampledCosines {
    std::vector<double> samples;
    std::vector<std::array<int, Blend::size>> places;      // of each probe's, among the samples
    std::vector<std::array<double, Blend::size>> weights;  // of each probe

    SampledCosines(const Axis& axis, const std::vector<int>& probed,
                   const std::vector<double>& mu) {
        std::vector<int> sample_place(axis.values.size(), -1);
        for (const int probe : probed) {
            const Stencil stencil = axis.view().stencil(mu[size(probe)]);
            places.emplace_back();
            weights.emplace_back();
            for (int p = 0; p < Blend::size; ++p) {
                const auto sample = size(sample_position(stencil, p, axis));
                if (sample_place[sample] < 0) {
                    sample_place[sample] = int_size(samples);
                    samples.push_back(axis.values[sample]);
                }
                places.back()[size(p)] = sample_place[sample];
                weights.back()[size(p)] = double{stencil.weight[p]};
            }
        }
    }
};

/// A candidate's samples along both axes.
struct MuSamples {
    SampledCosines in, out;
    DirectionGrid grid;
};

MuSamples mu_samples(const Probes& probes, int samples) {
    const Recipe& recipe = probes.recipe;
    const std::vector<double>& probed = probes.more_directions.mu();
    const CosinePairs& pairs = probes.more_directions.pairs();
    SampledCosines in(mu_axis(recipe.mu_in, samples), pairs.in, probed);
    SampledCosines out(mu_axis(recipe.mu_out, samples), pairs.out, probed);
    ProbedCosines sampled{{}, {{}, {}, pairs.exchangeable}};
    const auto add_samples = [&](const SampledCosines& along) {
        std::vector<int> places;
        for (const double sample : along.samples) {
            places.push_back(int_size(sampled.mu));
            sampled.mu.push_back(sample);
        }
        return places;
    };
    sampled.pairs.in = add_samples(in);
    sampled.pairs.out = pairs.are_symmetric() ? sampled.pairs.in : add_samples(out);
    return {std::move(in), std::move(out),
            directions_at(recipe, std::move(sampled), probes.path_law)};
}

/// Adds the errors of cubics in both cosines, samples divided by the shares intercepted (lookup.h).
void add_mu_errors(const Probes& probes, const ProbedLayer& expected, const LayerSolution& solution,
                   const MuSamples& samples, Errors& errors) {
    const Recipe& recipe = probes.recipe;
    const DirectionGrid& probed = probes.more_directions;
    const SampledCosines &in = samples.in, &out = samples.out;
    const auto divisor = [&](double cosine) {
        return intercepted(recipe, solution.optical_depth, cosine);
    };
    /// Weights of the samples, divided by their shares, for each probed cosine.
    const auto divided = [&](const SampledCosines& along, const auto& cosine) {
        std::vector<double> divisors;
        for (const double sample : along.samples) divisors.push_back(divisor(sample));
        auto weights = along.weights;
        for (std::size_t i = 0; i < weights.size(); ++i)
            for (std::size_t p = 0; p < Blend::size; ++p)
                weights[i][p] *=
                    divisor(cosine(static_cast<int>(i))) / divisors[size(along.places[i][p])];
        return weights;
    };
    const auto weights_in = divided(in, [&](int i) { return probed.mu_in(i); });
    const auto weights_out = divided(out, [&](int j) { return probed.mu_out(j); });
    PerSide<std::vector<double>> sampled;
    for (const Side side : asked_sides(recipe))
        sampled[side] = evaluate_tabulated(solution, side, samples.grid);
    add_errors(recipe, expected, probed, errors, [&](Side side, int i, int j, int k) {
        const std::vector<double>& values = sampled[side];
        const auto at_in = size(i), at_out = size(j);
        double found = 0;
        for (std::size_t p = 0; p < Blend::size; ++p)
            for (std::size_t q = 0; q < Blend::size; ++q)
                found += weights_in[at_in][p] * weights_out[at_out][q] *
                         values[samples.grid.at(in.places[at_in][p], out.places[at_out][q], k)];
        return found;
    });
}

/// Errors of candidates; those of the first half of the albedos alone tell what they are at least.
class MuErrors {
  public:
    explicit MuErrors(Probes& probes)
        : probes_(probes), expected_(probe_again(probes, probes.more_directions)) {}

    /// Were there no errors in the other half, which is no larger.
    double at_least(int samples) {
        const Errors& first = half(samples, false);
        // A share that has none of these does the others meanwhile: they may be asked for.
        if (first.empty()) half(samples, true);
        return quantile_of_all(probes_, first, 1 - 2 * (1 - probed_share));
    }

    double all(int samples) {
        Errors errors = half(samples, true);
        const Errors& others = half(samples, false);
        errors.insert(errors.end(), others.begin(), others.end());
        return quantile_of_all(probes_, std::move(errors), probed_share);
    }

  private:
    /// The errors of the first half of the albedos, or of the second.
    const Errors& half(int samples, bool is_second) {
        const auto [at, is_new] = halves_.try_emplace({samples, is_second});
        // Where this share's of the first half of all shares' albedos end.
        const std::size_t middle = count_of_share(probes_, (probes_.all_albedos + 1) / 2);
        if (is_new)
            at->second = is_second ? measure_errors(samples, middle, probes_.albedos.size())
                                   : measure_errors(samples, 0, middle);
        return at->second;
    }

    /// Takes the albedos from `first` to before `end`.
    Errors measure_errors(int samples, std::size_t first, std::size_t end) const {
        const double* const albedos = probes_.albedos.data();
        const MuSamples sampled = mu_samples(probes_, samples);
        return errors_of_solutions(
            probes_, {albedos + first, albedos + end}, sampled.grid.mu(),
            [&](std::size_t a, std::size_t d, const LayerSolution& solution, Errors& errors) {
                add_mu_errors(probes_, expected_[first + a][d], solution, sampled, errors);
            });
    }

    const Probes& probes_;
    const ProbedLayers expected_;
    std::map<std::pair<int, bool>, Errors> halves_;  // of each candidate
};

/// Places between samples: no candidate has a sample at one of these. Half of them lie evenly in
/// azimuth, half in its square root, where narrow peaks are.
std::vector<double> azimuth_tests(Range degrees) {
    const bool narrow = is_narrow(degrees, all_azimuths);
    const double first = radians(degrees.min);
    const double width = narrow ? radians(degrees.max - degrees.min) : pi;
    if (width == 0) return {first};
    const int count = narrow ? 8 : 16;
    std::vector<double> tests;
    for (int n = 0; n < count; ++n) {
        const double share = (n + 0.37) / count;
        tests.push_back(first + width * share);
        tests.push_back(first + width * share * share);
    }
    return tests;
}

/// The probed layers at azimuths between samples, which all candidates are compared with.
class AzimuthTests {
  public:
    explicit AzimuthTests(Probes& probes)
        : probes_(probes),
          layers_(probed_layers(probes)),
          azimuths_(azimuth_tests(probes.recipe.azimuth)),
          directions_(grid_at(azimuths_)),
          expected_(probe_again(probes, directions_)) {}

    double error(AxisScale scale, int samples) const {
        const Recipe& recipe = probes_.recipe;
        const Axis axis = azimuth_axis(recipe.azimuth, scale, samples);
        const DirectionGrid at_samples = grid_at(axis.values);
        std::vector<Stencil> stencils;
        for (const double phi : azimuths_) stencils.push_back(axis.view().mirrored_stencil(phi));
        return measure_layers(
            probes_, layers_.size(), layers_[0].size(),
            [&](std::size_t a, std::size_t d, Errors& errors) {
                PerSide<std::vector<double>> sampled;
                for (const Side side : asked_sides(recipe))
                    sampled[side] = evaluate_tabulated(layers_[a][d].solution, side, at_samples);
                add_errors(
                    recipe, expected_[a][d], directions_, errors,
                    [&](Side side, int i, int j, int k) {
                        const Stencil& stencil = stencils[size(k)];
                        const auto& values = sampled[side];
                        double found = 0;
                        for (int p = 0; p < Blend::size; ++p)
                            found += stencil.weight[p] *
                                     values[at_samples.at(i, j, sample_position(stencil, p, axis))];
                        return found;
                    });
            });
    }

  private:
    DirectionGrid grid_at(const std::vector<double>& azimuths) const {
        const Recipe& recipe = probes_.recipe;
        return {recipe.phase_function,           recipe.lower_boundary,
                probes_.directions.mu(),         azimuths,
                2 * recipe.discretisation.nodes, probes_.path_law,
                probes_.directions.pairs()};
    }

    const Probes& probes_;
    const ProbedLayers& layers_;
    std::vector<double> azimuths_;
    DirectionGrid directions_;
    ProbedLayers expected_;
};

/// Candidates that give axes unlike those of the one before, none of more than `most` samples;
/// counts(candidate) are the samples of each axis, fewer along narrow ones.
std::vector<int> distinct_candidates(
    const std::vector<int>& candidates, std::size_t most,
    const std::function<std::vector<std::size_t>(int candidate)>& counts) {
    std::vector<int> distinct;
    std::vector<std::size_t> before;
    for (const int candidate : candidates) {
        std::vector<std::size_t> now = counts(candidate);
        if (now == before || std::ranges::max(now) > most) continue;
        distinct.push_back(candidate);
        before = std::move(now);
    }
    return distinct;
}

/// Extrapolates the choice that brings an error down to `allowed`, by the power law through the errors of the last two
/// candidates; 0 where they fall more slowly than in proportion.
double extrapolated(double before, double error_before, double last, double error_last,
                    double allowed) {
    const double power = std::log(error_before / error_last) / std::log(last / before);
    return power >= 1 ? std::ceil(last * std::pow(error_last / allowed, 1 / power)) : 0;
}

}  // namespace

void note_choice(const Probes& probes, const std::string& what, double error,
                 const std::string& of) {
    if (probes.options.note)
        probes.options.note(what + ": " + of + " " + short_number(error) + " (99.9 % of probes)");
}

Choice choose_cheapest(const Probes& probes, const char* name, const std::vector<int>& candidates,
                       const CandidateError& error, const CandidateError& at_least) {
    constexpr int guesses = 3;  // then bisection, which no error misleads
    std::size_t low = 0, high = candidates.size() - 1;
    // Candidates cost more the finer they are: one that is too coarse tells cheaply where to go on.
    // With bounds the search begins in the middle: from the coarse end it passed over 28 samples of
    // mu, which a stack can do with, for 32.
    std::size_t next = at_least ? high / 2 : high / 6;
    double left = infinity;
    double coarse = 0, too_much = 0;  // the last candidate that missed, and its error
    for (int tried = 1; low < high; ++tried) {
        const double here = (at_least ? at_least : error)(candidates[next]);
        const double tested = candidates[next];
        if (here <= probes.max_error) {
            high = next;
            left = here;
        } else {
            low = next + 1;
            coarse = tested;
            too_much = here;
        }
        const double power = high < candidates.size() - 1 && too_much > 0
                                 ? std::log(too_much / left) / std::log(candidates[high] / coarse)
                                 : 4;
        const double enough = tested * std::pow(here / probes.max_error, 1 / power);
        next = (low + high) / 2;
        if (tried > guesses) continue;
        for (next = low; next + 1 < high && candidates[next] < enough;) ++next;
    }
    // The last candidate was taken for granted: it costs most and is seldom needed.
    if (at_least || high + 1 == candidates.size()) left = error(candidates[high]);
    while (left > probes.max_error && high + 1 < candidates.size())
        left = error(candidates[++high]);
    const bool holds = left <= probes.max_error;
    Choice choice{static_cast<double>(candidates[high])};
    if (!holds) {
        choice.error_at_cap = left;
        // Errors of neighbours may be alike, as the probes happen to lie between their samples.
        std::size_t fewer = high;
        while (fewer > 0 && candidates[fewer] > 0.75 * candidates[high]) --fewer;
        if (fewer < high)
            choice.needed = extrapolated(candidates[fewer], error(candidates[fewer]), choice.value,
                                         left, probes.max_error);
    }
    note_choice(probes, std::string(name) + " " + std::to_string(candidates[high]), left,
                holds ? "interpolation misses" : "at its cap; interpolation misses");
    return choice;
}

ScaledChoice choose_scaled(const Probes& probes, const Scales& scales,
                           std::optional<AxisScale> fixed, std::vector<int> candidates, int few,
                           const std::function<double(AxisScale scale, int candidate)>& error) {
    const auto cheapest = [&](AxisScale scale) {
        const char* const name = scale == scales.usual ? scales.samples : scales.samples_on_other;
        return ScaledChoice{scale, choose_cheapest(probes, name, candidates, [&](int candidate) {
                                return error(scale, candidate);
                            })};
    };
    if (fixed) return cheapest(*fixed);
    const ScaledChoice usual = cheapest(scales.usual);
    const double cap = usual.samples.error_at_cap;
    if (cap == 0)  // the other scale must do with fewer
        std::erase_if(candidates, [&](int candidate) { return candidate >= usual.samples.value; });
    if (candidates.empty() || usual.samples.value <= few) return usual;
    const double to_beat = cap > 0 ? cap : probes.max_error;
    return error(scales.other, candidates.back()) <= to_beat ? cheapest(scales.other) : usual;
}

/// Solves the probes' layers with the nodes that their recipe has. Returns whether these suffice for the phase
/// function's series, which ends at so few moments that it may be negative: all ranks' must, or none has layers.
/// With the most nodes it throws.
bool solve_probes(Probes& probes, bool are_most) {
    bool suffice = true;
    try {
        probed_layers(probes);
    } catch (const TooFewNodes&) {
        if (are_most) throw;
        suffice = false;
    }
    const WorkLog& log = probes.options.log;
    for (const std::vector<double>& of_rank : gather(log, {suffice ? 1.0 : 0.0}, probes.share.count))
        suffice = suffice && of_rank[0] != 0;
    if (!suffice) probes.layers.clear();
    return suffice;
}

Choice choose_nodes(Probes& probes) {
    constexpr int candidates[] = {8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96};
    constexpr int fewest_with_path_law = 16;
    constexpr int fewest_refined = 24;  // below, a try takes more than fewer nodes save
    const double max_change =
        (probes.path_law ? share_with_path_law : share_of_nodes) * probes.max_error;
    int& nodes = probes.recipe.discretisation.nodes;
    double left = infinity, left_before = infinity;
    int finest = 0, finer_before = 0;
    for (const int candidate : candidates) {
        if (probes.path_law && candidate < fewest_with_path_law) continue;
        const int coarser = std::exchange(nodes, candidate);
        ProbedLayers layers = std::exchange(probes.layers, {});
        const bool suffice = solve_probes(probes, candidate == std::end(candidates)[-1]);
        if (!suffice || layers.empty()) continue;
        left_before = std::exchange(left, change(probes, layers, probes.layers));
        finer_before = std::exchange(finest, coarser);
        if (left > max_change) continue;
        nodes = coarser;
        const ProbedLayers finer = std::exchange(probes.layers, std::move(layers));
        // Each further node divides errors by much the same: halfway they are about the geometric mean.
        if (nodes >= fewest_refined && std::sqrt(left * left_before) <= max_change) {
            nodes = (finer_before + nodes) / 2;
            layers = std::exchange(probes.layers, {});
            const double halfway = change(probes, probed_layers(probes), finer);
            if (halfway <= max_change) {
                left = halfway;
            } else {
                nodes = coarser;
                probes.layers = std::move(layers);
            }
        }
        note_choice(probes, "nodes " + std::to_string(nodes), left, "more nodes change");
        return {static_cast<double>(nodes)};
    }
    note_choice(probes, "nodes " + std::to_string(nodes), left, "at its cap; fewer nodes change");
    return {static_cast<double>(nodes), left,
            extrapolated(finer_before, left_before, finest, left, max_change)};
}

/// Modes beyond which all others together stay below their share.
Choice choose_modes(Probes& probes) {
    int low = 1;
    const auto& solved = probed_layers(probes)[0][0].solution.modes.reflection;
    // Layers may have more or fewer; all ranks begin with those of the first.
    const std::vector<char> first = shared(probes.options.log, std::vector<char>(solved.size()));
    auto high = int_size(first);
    double left = 0;
    while (low < high) {
        const int middle = (low + high) / 2;
        const double tail = tail_of_modes(probes, middle);
        if (tail <= share_of_modes * probes.max_error) {
            high = middle;
            left = tail;
        } else {
            low = middle + 1;
        }
    }
    note_choice(probes, "modes " + std::to_string(high), left, "all higher ones add");
    return {static_cast<double>(high)};
}

Choice choose_mu_samples(Probes& probes) {
    const Recipe& recipe = probes.recipe;
    const bool one_layer = recipe.optical_depth.min == recipe.optical_depth.max &&
                           recipe.albedo.min == recipe.albedo.max && recipe.family.empty();
    const std::size_t most = one_layer ? 128 : 56;  // tables of more layers would grow large
    const auto counts = [&](int candidate) {
        return std::vector{mu_axis(recipe.mu_in, candidate).values.size(),
                           mu_axis(recipe.mu_out, candidate).values.size()};
    };
    MuErrors errors(probes);
    // Without 34, which has samples at most of the probed cosines and would pass for better than it is.
    return choose_cheapest(
        probes, "mu_samples",
        distinct_candidates({8,  10, 12, 14, 16, 18, 20, 22, 24, 26,  28,  30,  32,  36, 38,
                             40, 42, 44, 46, 48, 52, 56, 72, 96, 128, 192, 256, 384, 512},
                            most, counts),
        [&](int candidate) { return errors.all(candidate); },
        [&](int candidate) { return errors.at_least(candidate); });
}

ScaledChoice choose_azimuth_samples(Probes& probes) {
    const Recipe& recipe = probes.recipe;
    if (recipe.lower_boundary.law == nullptr &&
        std::ranges::all_of(
            list_phase_functions(recipe.layers, recipe.phase_function, recipe.lower_boundary),
            [](const PhaseFunction& each) { return each.is_isotropic(); }))
        return {AxisScale::linear, {1}};
    const Scales scales{AxisScale::linear, AxisScale::square_root, "azimuth_samples",
                        "square_root azimuth_samples"};
    constexpr int most = 97;
    const std::vector<int> candidates = distinct_candidates(
        {5,  7,  9,  11, 13,  15,  17,  19,  21,  25,  29,  33,  37,  41,  49,
         57, 65, 81, 97, 129, 161, 193, 257, 321, 385, 513, 641, 769, 1024},
        most, [&](int candidate) {
            return std::vector{
                azimuth_axis(probes.recipe.azimuth, AxisScale::linear, candidate).values.size(),
                azimuth_axis(probes.recipe.azimuth, AxisScale::square_root, candidate)
                    .values.size()};
        });
    const AzimuthTests tests(probes);
    return choose_scaled(
        probes, scales, probes.recipe.discretisation.azimuth_scale, candidates, 0,
        [&](AxisScale scale, int candidate) { return tests.error(scale, candidate); });
}

}  // namespace stratus
