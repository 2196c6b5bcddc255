// Choices of what resolves layers: samples of optical depth, of albedo and along the axes of a family.
#include <stratus/bake/axes.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/diffusion.h>

#include "choices.h"
#include "recipe_sections.h"

#include <algorithm>
#include <utility>

namespace stratus {

namespace {

/// A ratio of two exponentially small scales; 0 where the divisor is below what a float holds.
double ratio(double scale, double divisor) { return divisor > 1e-35 ? scale / divisor : 0; }

/// Solves layers half an octave deeper than the probes, for the law of diffusion is measured at both. What
/// few orders transmit falls off like the beam, so that the law misses most much sooner.
ProbedLayers solve_between(const Probes& probes) {
    DepthLadder between = probes.ladder;
    between.first *= std::exp2(probes.recipe.orders > 0 ? 1.0 / 12 : 1.0 / 2);
    between.to_infinity = false;
    return std::move(solve_ladders(probes, probes.albedos, {between}, probes.directions)[0]);
}

/// Adds the errors of a blend of layers of other depths, whose samples are divided by the shares
/// intercepted along both directions (lookup.h).
void add_depth_errors(const Probes& probes, const DirectionGrid& directions,
                      const ProbedLayer& target, const Blend& blend, Errors& errors) {
    std::vector<double> along[Blend::size];  // over mu
    for (std::size_t p = 0; p < Blend::size; ++p) {
        if (blend.sample[p] == nullptr) continue;
        const double depth = blend.sample[p]->solution.optical_depth;
        for (const double cosine : directions.mu())
            along[p].push_back(intercepted(probes.recipe, target.solution.optical_depth, cosine) /
                               intercepted(probes.recipe, depth, cosine));
    }
    add_blend_errors(probes.recipe, target, directions, blend, errors, along);
}

/// Returns the error at the worst depth beyond the finite depth `last`: most depths are at the limit.
double infinity_error(Probes& probes, const ProbedLayers& between, std::size_t last) {
    const ProbedLayers& layers = probed_layers(probes);
    const double length = probes.extrapolation_length;
    std::vector<Errors> at_depths;
    const auto measure = [&](const ProbedLayers& deeper, std::size_t depth) {
        at_depths.push_back(errors_of_layers(
            probes, layers.size(), 1, [&](std::size_t a, std::size_t, Errors& errors) {
                const ProbedLayer& target = deeper[a][depth];
                const double k = probes.exponents[a];
                const double tau = target.solution.optical_depth;
                const double tau_last = layers[a][last].solution.optical_depth;
                const double deficit = reflection_deficit(tau_last, k, length);
                Blend blend;
                blend.sample[0] = &layers[a][last];
                blend.sample[1] = &layers[a].back();
                auto& [reflection, transmission] = blend.weight;
                reflection[0] = deficit > 0 ? reflection_deficit(tau, k, length) / deficit : 0;
                reflection[1] = 1 - reflection[0];
                transmission[0] = ratio(transmission_scale(tau, k, length),
                                        transmission_scale(tau_last, k, length));
                add_depth_errors(probes, probes.directions, target, blend, errors);
            }));
    };
    measure(between, last);
    for (std::size_t depth = last + 1; depth < between[0].size(); ++depth) {
        measure(layers, depth);
        measure(between, depth);
    }
    return std::ranges::max(quantiles_of_all(probes, std::move(at_depths), probed_share));
}

/// Layers at up to `fine` depths an octave, solved when a candidate needs them: its own samples are
/// every (fine / candidate)-th. Their first modes and half of the cosines suffice: errors come
/// out as with all or up to a fifth larger.
struct FineDepths {
    static constexpr int fine = 240, modes = 8;
    DirectionGrid directions;
    int octaves;
    double min, max;
    ProbedLayers of_step[fine];

    FineDepths(const Probes& probes, double least, double max_)
        : directions(directions_at(probes.recipe, some_cosines(probes.recipe), probes.path_law)),
          octaves(std::max(1, static_cast<int>(std::ceil(std::log2(max_ / least))))),
          min(std::ldexp(max_, -octaves)),
          max(max_) {}

    /// The samples of a candidate, `stride` steps apart, and the middles between them.
    void solve(const Probes& probes, int stride) {
        std::vector<int> open;
        std::vector<DepthLadder> ladders;
        for (int sample = 0; sample < fine; sample += stride)
            for (const int step : {sample, sample + stride / 2}) {
                if (!of_step[step].empty()) continue;
                open.push_back(step);
                ladders.push_back({min * std::exp2(static_cast<double>(step) / fine),
                                   octaves + (step == 0 ? 1 : 0), false});
            }
        std::vector<ProbedLayers> solved =
            solve_ladders(probes, probes.albedos, ladders, directions, modes);
        for (std::size_t n = 0; n < open.size(); ++n) of_step[open[n]] = std::move(solved[n]);
    }

    const ProbedLayer& at(std::size_t albedo, int depth) const {
        return of_step[depth % fine][albedo][size(depth / fine)];
    }
};

double depth_error(const Probes& probes, FineDepths& depths, int candidate) {
    const int stride = FineDepths::fine / candidate, intervals = candidate * depths.octaves;
    depths.solve(probes, stride);
    const AxisView axis =
        make_axis(AxisScale::logarithmic, depths.min, depths.max, intervals + 1).view();
    return measure_layers(
        probes, probes.albedos.size(), size(intervals),
        [&](std::size_t a, std::size_t interval, Errors& errors) {
            const ProbedLayer& target =
                depths.at(a, static_cast<int>(interval) * stride + stride / 2);
            const double tau = target.solution.optical_depth, k = probes.exponents[a];
            const Stencil stencil = axis.stencil(tau);
            Blend blend;
            for (std::size_t p = 0; p < Blend::size; ++p) {
                if (stencil.weight[p] == 0) continue;
                blend.sample[p] = &depths.at(a, (stencil.first + static_cast<int>(p)) * stride);
                for (const Side side : both_sides)
                    blend.weight[side][p] =
                        stencil.weight[p] * sample_scale(probes, side, tau, k) /
                        sample_scale(probes, side, blend.sample[p]->solution.optical_depth, k);
            }
            add_depth_errors(probes, depths.directions, target, blend, errors);
        });
}

/// Layers at `fine` even steps along an axis; a candidate's own samples are every so many of them.
/// Albedo and family alike then compare the middle of every interval with a cubic.
struct Steps {
    std::size_t intervals, stride;

    Steps(int candidate, std::size_t fine)
        : intervals(size(candidate - 1)), stride(fine / intervals) {}

    std::size_t middle(std::size_t interval) const { return interval * stride + stride / 2; }

    std::size_t sample(const Stencil& stencil, std::size_t p) const {
        return std::min(size(stencil.first) + p, intervals) * stride;
    }
};

/// Layers at `fine` + 1 albedos of one scale, at few directions, solved when a candidate needs them.
/// Their first modes suffice: later ones are of light scattered a few times, which is a short
/// polynomial of the albedo. With fewer modes too much of the total is missing, and relative errors come
/// out ten times as large: where a peak is without a path law, half of the modes are needed.
struct FineAlbedos {
    static constexpr std::size_t fine = 720;
    static constexpr double unknown = -1;
    AxisScale scale;
    int modes;
    DirectionGrid directions;
    std::vector<double> albedos, exponents;  // exponents: of samples; elsewhere not computed
    ProbedLayers layers;

    FineAlbedos(const Probes& probes, AxisScale of_axis)
        : scale(of_axis),
          modes(probes.path_law ? 8 : std::max(8, probes.recipe.discretisation.modes / 2)),
          directions(directions_at(probes.recipe, few_cosines(probes.recipe), probes.path_law)),
          albedos(albedo_axis(probes.recipe.albedo, fine + 1, scale).values),
          exponents(albedos.size(), unknown),
          layers(albedos.size()) {}

    /// The samples of a candidate, and the middles between them.
    void solve(const Probes& probes, const Steps& steps) {
        solve_exponents(probes, steps);
        std::vector<std::size_t> open;
        std::vector<double> at;
        for (std::size_t k = 0; k <= steps.intervals; ++k)
            for (const std::size_t step : {k * steps.stride, steps.middle(k)})
                if (step <= steps.intervals * steps.stride && layers[step].empty()) {
                    open.push_back(step);
                    at.push_back(albedos[step]);
                }
        ProbedLayers solved =
            solve_layers_together(probes, at, ladder_to_deepest(probes), directions, modes);
        for (std::size_t k = 0; k < open.size(); ++k) layers[open[k]] = std::move(solved[k]);
    }

  private:
    void solve_exponents(const Probes& probes, const Steps& steps) {
        std::vector<std::size_t> open;
        std::vector<double> at;
        for (std::size_t k = 0; k <= steps.intervals; ++k) {
            const std::size_t step = k * steps.stride;
            if (exponents[step] != unknown) continue;
            open.push_back(step);
            at.push_back(albedos[step]);
        }
        if (open.empty()) return;
        const std::vector<double> solved = decay_exponents(probes.recipe, at);
        for (std::size_t k = 0; k < open.size(); ++k) exponents[open[k]] = solved[k];
    }
};

double albedo_error(const Probes& probes, FineAlbedos& fine, int candidate) {
    const Steps steps(candidate, FineAlbedos::fine);
    fine.solve(probes, steps);
    const ProbedLayers& layers = fine.layers;
    const AxisView axis = albedo_axis(probes.recipe.albedo, candidate, fine.scale).view();
    const bool divides = !probes.recipe.lower_boundary.is_present();
    return measure_layers(
        probes, count_of_share(probes, steps.intervals), layers[0].size(),
        [&](std::size_t n, std::size_t d, Errors& errors) {
            const std::size_t interval = size(probes.share.index) + n * size(probes.share.count);
            const ProbedLayer& target = layers[steps.middle(interval)][d];
            const double albedo = target.solution.albedo, tau = target.solution.optical_depth;
            const Stencil stencil = axis.stencil(albedo);
            double k = 0;
            for (std::size_t p = 0; p < Blend::size; ++p)
                k += stencil.weight[p] * fine.exponents[steps.sample(stencil, p)];
            Blend blend;
            for (std::size_t p = 0; p < Blend::size; ++p) {
                const std::size_t at = steps.sample(stencil, p);
                const ProbedLayer& sample = layers[at][d];
                blend.sample[p] = &sample;
                for (const Side side : both_sides)
                    blend.weight[side][p] =
                        divides ? stencil.weight[p] *
                                      ratio(albedo * sample_scale(probes, side, tau, k),
                                            sample.solution.albedo *
                                                sample_scale(probes, side, tau, fine.exponents[at]))
                                : stencil.weight[p];
            }
            add_blend_errors(probes.recipe, target, fine.directions, blend, errors);
            if (!probes.path_law || fine.scale != AxisScale::fourth_root_of_complement) return;
            // Random albedos lie evenly over the square root of 1 - w, probed ones over its fourth root.
            const auto random_points = static_cast<float>(std::sqrt(std::sqrt(1 - albedo)));
            for (ProbedError& each : errors) each.weight *= random_points;
        });
}

/// The probes and the layers of one mixture, at few directions.
struct FamilyStep {
    Probes probes;
    DirectionGrid directions;
    ProbedLayers layers;
};

FamilyStep solve_family_step(const Recipe& recipe, double max_error, const BakeOptions& options) {
    Probes probes = place_probes(recipe, max_error, options);
    DirectionGrid directions = directions_at(recipe, few_cosines(recipe), probes.path_law);
    ProbedLayers layers = std::move(
        solve_ladders(probes, probes.albedos, {ladder_to_deepest(probes)}, directions)[0]);
    return {std::move(probes), std::move(directions), std::move(layers)};
}

/// Steps along an axis of a family, solved when a candidate needs them.
struct FineMembers {
    const Recipe& recipe;
    double max_error;
    const BakeOptions& options;
    std::size_t axis;
    FamilyAxes along;  // fine steps along the axis, one sample of the other
    std::vector<std::optional<FamilyStep>> steps;

    /// `other` counts the least, the middle and the greatest value of the other axis, where there is one.
    FineMembers(const Recipe& recipe_, std::size_t axis_, double max_error_,
                const BakeOptions& options_, int fine, std::size_t other)
        : recipe(recipe_), max_error(max_error_), options(options_), axis(axis_) {
        for (std::size_t k = 0; k < recipe.family.size(); ++k) {
            along.push_back(ranging_axis(recipe.family[k], k == axis ? fine + 1 : 3));
            std::vector<double>& values = along.back().axis.values;
            if (k != axis) values = {values[other]};
        }
        steps.resize(along[axis].axis.values.size());
    }

    const FamilyStep& at(std::size_t step) const { return *steps[step]; }

    void solve(std::size_t step) {
        if (!steps[step])
            steps[step] =
                solve_family_step(at_member(recipe, member_at(along, step)), max_error, options);
    }
};

Errors family_errors(FineMembers& all, int candidate) {
    const std::size_t fine = all.steps.size() - 1;
    const Steps steps(candidate, fine);
    for (std::size_t interval = 0; interval <= steps.intervals; ++interval) {
        all.solve(interval * steps.stride);
        if (interval < steps.intervals) all.solve(steps.middle(interval));
    }
    const AxisView axis = make_axis(AxisScale::linear, 0, 1, candidate).view();
    const Probes& any = all.at(0).probes;
    const std::size_t albedos = any.albedos.size();
    return errors_of_layers(
        any, steps.intervals * albedos, all.at(0).layers[0].size(),
        [&](std::size_t n, std::size_t d, Errors& errors) {
            const std::size_t a = n % albedos, middle = steps.middle(n / albedos);
            const Stencil stencil =
                axis.stencil(static_cast<double>(middle) / static_cast<double>(fine));
            const FamilyStep& here = all.at(middle);
            const ProbedLayer& target = here.layers[a][d];
            const auto transmitted = [&](double exponent) {
                return transmission_scale(target.solution.optical_depth, exponent,
                                          any.extrapolation_length);
            };
            double k = 0;
            for (std::size_t p = 0; p < Blend::size; ++p)
                k += double{stencil.weight[p]} *
                     all.at(steps.sample(stencil, p)).probes.exponents[a];
            Blend blend;
            for (std::size_t p = 0; p < Blend::size; ++p) {
                const FamilyStep& sample = all.at(steps.sample(stencil, p));
                blend.sample[p] = &sample.layers[a][d];
                blend.weight.reflection[p] = stencil.weight[p];
                const double sampled = transmitted(sample.probes.exponents[a]);
                blend.weight.transmission[p] =
                    sampled > 0 ? stencil.weight[p] * transmitted(k) / sampled : 0;
            }
            add_blend_errors(here.probes.recipe, target, here.directions, blend, errors);
        });
}

}  // namespace

Choice choose_deepest_optical_depth(Probes& probes) {
    if (!probes.ladder.to_infinity || probes.ladder.octaves == 0) return {};
    const ProbedLayers between = solve_between(probes);
    double left = 0;
    std::size_t last = 0;
    for (; last + 2 < size(probes.ladder.octaves); ++last) {
        left = infinity_error(probes, between, last);
        if (left <= probes.max_error) break;
    }
    const double deepest = std::ldexp(probes.ladder.first, static_cast<int>(last));
    note_choice(probes, "deepest finite optical_depth " + short_number(deepest), left,
                "the law of diffusion beyond misses");
    return {deepest};
}

Choice choose_optical_depth_samples(Probes& probes) {
    if (probes.ladder.octaves == 0) return {};
    const Range range = probes.recipe.optical_depth;
    const double max =
        std::isinf(range.max) ? probes.recipe.discretisation.deepest_optical_depth : range.max;
    // Up to infinity, the samples of a cubic end at the only finite depth that is asked for: close to it.
    if (range.min >= max) return {std::isinf(range.max) ? 12.0 : 1.0};
    FineDepths depths(probes, range.min, max);
    return choose_cheapest(probes, "optical_depth_samples_per_octave",
                           {1, 2, 3, 4, 5, 6, 8, 10, 12},
                           [&](int candidate) { return depth_error(probes, depths, candidate); });
}

ScaledChoice choose_albedo_samples(Probes& probes) {
    const Scales scales{AxisScale::square_root_of_complement, AxisScale::fourth_root_of_complement,
                        "albedo_samples", "fourth_root albedo_samples"};
    const Recipe& recipe = probes.recipe;
    const auto fixed = recipe.discretisation.albedo_scale;
    if (recipe.albedo.min == recipe.albedo.max) return {fixed.value_or(scales.usual), {1}};
    std::optional<FineAlbedos> fine;
    return choose_scaled(probes, scales, fixed,
                         {4, 5, 6, 7, 9, 10, 11, 13, 16, 17, 19, 21, 25, 31, 37, 41, 46, 49, 61},
                         13, [&](AxisScale scale, int candidate) {
                             if (!fine || fine->scale != scale) fine.emplace(probes, scale);
                             return albedo_error(probes, *fine, candidate);
                         });
}

Choice choose_family_samples(const Recipe& recipe, std::size_t axis, double max_error,
                             const BakeOptions& options) {
    std::vector<int> candidates{2, 3, 4, 5, 7, 9, 13};
    int fine = 24;
    if (is_narrow(recipe.mu_in, all_cosines) || is_narrow(recipe.mu_out, all_cosines) ||
        is_narrow(recipe.azimuth, all_azimuths)) {  // where samples are small they may be many
        candidates.push_back(25);
        fine = 48;
    }
    // Errors along one axis may be a hundred times as large at one end of the other as in its middle.
    std::vector<std::size_t> others{1};
    if (recipe.family.size() > 1) {
        const std::size_t other = 1 - axis;
        const Range range = recipe.family[other].range;
        const bool at_max = corners_by_peak(recipe).front()[other] > (range.min + range.max) / 2;
        others = {at_max ? 2u : 0u, 1u, at_max ? 0u : 2u};
    }
    std::vector<FineMembers> lines;  // the most peaked first
    for (const std::size_t other : others)
        lines.emplace_back(recipe, axis, max_error, options, fine, other);
    lines[0].solve(0);
    const Probes& probes = lines[0].at(0).probes;
    const auto error = [&](int candidate) {
        std::vector<Errors> of_lines;
        for (FineMembers& line : lines) of_lines.push_back(family_errors(line, candidate));
        return quantile_of_all(probes, joined(std::move(of_lines)), probed_share);
    };
    // The first line alone may have as many large errors as all lines together.
    const double share = 1 - static_cast<double>(lines.size()) * (1 - probed_share);
    CandidateError at_least;
    if (lines.size() > 1)
        at_least = [&](int candidate) {
            return quantile_of_all(probes, family_errors(lines[0], candidate), share);
        };
    return choose_cheapest(probes, samples_key(recipe.family[axis].parameter).c_str(), candidates,
                           error, at_least);
}

}  // namespace stratus
