// The choices of a discretisation, a function an axis: ascending candidates in, the cheapest whose
// error holds out. Every choice builds on those that the probes' recipe holds already; the order is
// that of the declarations.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/base/axis.h>
#include <stratus/transfer/fourier_sum.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <vector>

namespace stratus {

// The probes on which every choice of a discretisation is measured, at one mixture: layers solved once, at
// directions between grazing and normal, a few azimuths, albedos over the range and every octave of
// depth (and infinity). Errors are relative as in accuracy.h; a choice stands when 99.9 % of the
// probed values are within its share of the tolerance.

/// One side of a solved layer at all directions.
struct ProbedSide {
    std::vector<double> tabulated, total;  // over (mu, mu, azimuth)
    double floor = 0;                      // accuracy.h
};

struct ProbedLayer {
    LayerSolution solution;
    PerSide<ProbedSide> side;
};

using ProbedLayers = std::vector<std::vector<ProbedLayer>>;  // [albedo][depth]

/// A share of things that are taken in turn: every so many, from one on.
struct Share {
    int index = 0, count = 1;
};

struct Probes {
    Recipe recipe;  // of one mixture, its discretisation as far as it is chosen
    double max_error;
    BakeOptions options;
    std::shared_ptr<const PathOrders> path_law;  // axes.h
    DirectionGrid directions;
    DirectionGrid more_directions;           // with more of its cosines, for samples of mu
    std::vector<double> albedos, exponents;  // exponents: decay_exponents (axes.h)
    DepthLadder ladder;
    double extrapolation_length;
    ProbedLayers layers;  // of all modes; empty until solved
    // Ranks probe some of the albedos each, as many ranks as there are albedos at most. Those beyond
    // do what others do, too, and are not counted.
    Share share;
    std::size_t all_albedos;  // of all shares
};

/// Probes of a recipe of one mixture, not solved yet; with ranks, this one's.
Probes place_probes(const Recipe& recipe, double max_error, const BakeOptions& options);

/// How many of `count` things that shares take in turn are this one's.
std::size_t count_of_share(const Probes& probes, std::size_t count);

/// Cosines of solutions: those that floors of errors need (accuracy.h), and the pairs along mu_in
/// and mu_out at which a recipe is probed.
struct ProbedCosines {
    std::vector<double> mu;
    CosinePairs pairs;
};

/// The cosines that suffice between depths.
ProbedCosines some_cosines(const Recipe& recipe);

/// The few that suffice between albedos, and between members of a family.
ProbedCosines few_cosines(const Recipe& recipe);

/// Some cosines at the probes' azimuths, for solutions of the recipe's nodes.
DirectionGrid directions_at(const Recipe& recipe, ProbedCosines cosines,
                            std::shared_ptr<const PathOrders> path_law);

/// The probes' own layers, solved when first asked for.
const ProbedLayers& probed_layers(Probes& probes);

/// Layers probed like these, or with their first modes alone, of several ladders:
/// [ladder][albedo][depth]. Solutions keep albedo and depth alone.
std::vector<ProbedLayers> solve_ladders(const Probes& probes, const std::vector<double>& albedos,
                                        const std::vector<DepthLadder>& ladders,
                                        const DirectionGrid& directions, int most_modes = 0);

/// Solves one ladder likewise on all ranks, each albedo on one of them.
ProbedLayers solve_layers_together(const Probes& probes, const std::vector<double>& albedos,
                                   const DepthLadder& ladder, const DirectionGrid& directions,
                                   int most_modes);

/// The sides that a recipe asks for.
std::vector<Side> asked_sides(const Recipe& recipe);

/// The probes' own layers at other directions of their cosines, without the solutions.
ProbedLayers probe_again(Probes& probes, const DirectionGrid& directions);

/// The octaves of depth that the table's samples will have.
DepthLadder ladder_to_deepest(const Probes& probes);

// ---- errors -------------------------------------------------------------------------------------

/// The error at a probed direction, and how many of a table's random points (accuracy.h) it stands for.
struct ProbedError {
    float error, weight;
};

using Errors = std::vector<ProbedError>;

/// The share of the probed values, by their weights, that must be within a choice's limit.
constexpr double probed_share = 0.999;

/// Adds the errors of a layer.
using MeasureLayer = std::function<void(std::size_t albedo, std::size_t depth, Errors& errors)>;

/// The errors of all albedos and depths, this share's.
Errors errors_of_layers(const Probes& probes, std::size_t albedos, std::size_t depths,
                        const MeasureLayer& measure);

/// The errors that measure(albedo, depth, solution, errors) adds for some albedos at the probes' depths,
/// solved with the nodes and modes that are chosen.
Errors errors_of_solutions(
    const Probes& probes, const std::vector<double>& albedos, const std::vector<double>& mu,
    const std::function<void(std::size_t albedo, std::size_t depth, const LayerSolution& solution,
                             Errors& errors)>& measure);

/// Several lists one after the other.
Errors joined(std::vector<Errors> lists);

/// The errors of all shares that a share of the weights does not exceed, list by list; as the largest error of a
/// check may be five times its tolerance, a fifth of what a fifth of the others do not exceed where that is more.
/// Ranks tell each other no more than the largest of theirs.
std::vector<double> quantiles_of_all(const Probes& probes, std::vector<Errors> lists, double share);
double quantile_of_all(const Probes& probes, Errors errors, double share);

/// Same, of one list, for 99.9 %.
double measure_layers(const Probes& probes, std::size_t albedos, std::size_t depths,
                      const MeasureLayer& measure);

/// Calls use(i, j, k) for all directions of a grid, once for those that are the same both ways round.
template <class Use>
void for_each_direction(const DirectionGrid& directions, const Use& use) {
    for (int i = 0; i < directions.in_count(); ++i)
        for (int j = directions.pairs().are_symmetric() ? i : 0; j < directions.out_count(); ++j)
            for (int k = 0; k < int_size(directions.azimuth()); ++k) use(i, j, k);
}

/// The weight of the error at each direction of a grid. It is 1 without a path law, so that 99.9 % of the errors
/// include those at the ends and corners of the ranges, which few random points of a check come near.
///
/// With a path law, errors at corners are so large that tables would grow by them alone: there it is the number of
/// even random points (accuracy.h) that are nearest to the direction, 0 where a cosine is not judged. Directions near
/// forward, 99 % of which are judged by themselves, have a tenth of all weight: 99.9 % of all are as strict.
class DirectionWeights {
  public:
    DirectionWeights(const Recipe& recipe, const DirectionGrid& directions);

    /// At mu_in(i), mu_out(j), azimuth()[k].
    double operator()(Side side, int i, int j, int k) const;

  private:
    bool is_forward(Side side, int i, int j, int k) const;
    double even(int i, int j, int k) const;

    const DirectionGrid& directions_;
    std::vector<double> in_, out_, azimuth_;
    PerSide<double> forward_{1, 1};  // by what weights near forward are multiplied
};

/// Adds the errors of found(side, i, j, k) at all pairs of the cosines and at all azimuths that are judged,
/// for both sides of `expected` that the recipe asks for.
template <class Found>
void add_errors(const Recipe& recipe, const ProbedLayer& expected, const DirectionGrid& directions,
                Errors& errors, const Found& found) {
    const DirectionWeights weight_at(recipe, directions);
    for (const Side side : both_sides) {
        if (side == Side::reflection
                ? !recipe.reflection
                : !recipe.transmission || std::isinf(expected.solution.optical_depth))
            continue;
        const ProbedSide& values = expected.side[side];
        for_each_direction(directions, [&](int i, int j, int k) {
            const double weight = weight_at(side, i, j, k);
            if (weight == 0) return;
            const std::size_t at = directions.at(i, j, k);
            const double error = std::abs(found(side, i, j, k) - values.tabulated[at]) /
                                 std::max(values.total[at], values.floor);
            errors.push_back({static_cast<float>(error), static_cast<float>(weight)});
        });
    }
}

/// Samples that interpolate a layer, and their weights on either side.
struct Blend {
    static constexpr int size = std::extent_v<decltype(Stencil::weight)>;
    const ProbedLayer* sample[size] = {};
    PerSide<std::array<double, size>> weight{};
};

/// Adds the errors of a blend at all directions. `along`, if any: a factor for each sample over mu, of both
/// directions.
void add_blend_errors(const Recipe& recipe, const ProbedLayer& expected,
                      const DirectionGrid& directions, const Blend& blend, Errors& errors,
                      const std::vector<double>* along = nullptr);

// ---- what samples are divided by before they are interpolated (lookup.h); 1 over a boundary -----

double intercepted(const Recipe& recipe, double optical_depth, double mu);
double sample_scale(const Probes& probes, Side side, double optical_depth, double exponent);

struct Choice {
    double value = 0;
    double error_at_cap = 0;  // where even the last candidate misses; 0 elsewhere
    double needed = 0;        // there: what would do, extrapolated; 0 where errors do not fall
};

/// Samples of an axis, and what they lie evenly in.
struct ScaledChoice {
    AxisScale scale;
    Choice samples;
};

Choice choose_nodes(Probes& probes);
Choice choose_modes(Probes& probes);
Choice choose_mu_samples(Probes& probes);

/// On the scale that the recipe fixes, or on the one that takes fewer samples; linear where both
/// take as many.
ScaledChoice choose_azimuth_samples(Probes& probes);

/// First depth of the ladder beyond which the law of diffusion bridges the way to infinity; 0 where
/// the axis does not end there.
Choice choose_deepest_optical_depth(Probes& probes);

Choice choose_optical_depth_samples(Probes& probes);

/// On the scale that the recipe fixes, or on the fourth root where its samples are fewer.
ScaledChoice choose_albedo_samples(Probes& probes);

/// Samples along a range of the family, of a recipe of which all but those is resolved.
Choice choose_family_samples(const Recipe& recipe, std::size_t axis, double max_error,
                             const BakeOptions& options);

// ---- what they share ----------------------------------------------------------------------------

/// Tells what was chosen and the error that is left.
void note_choice(const Probes& probes, const std::string& what, double error,
                 const std::string& of);

/// The error that a candidate leaves.
using CandidateError = std::function<double(int candidate)>;

/// First of the ascending candidates whose error is within the probes' limit, found as if errors
/// fell with the fourth power, a cubic's, or with that between the last two; the last if none is.
/// `at_least`, if given, takes less time and tells no more than the error: that is then worked out
/// for those candidates alone that it does not rule out and that may be the first.
Choice choose_cheapest(const Probes& probes, const char* name, const std::vector<int>& candidates,
                       const CandidateError& error, const CandidateError& at_least = {});

/// The scales that an axis may have, and what to call its samples on either.
struct Scales {
    AxisScale usual, other;
    const char *samples, *samples_on_other;
};

/// The cheapest on the scale that is fixed, or on the usual one, or on the other where fewer samples
/// do there; that is tried where the usual scale takes more than `few`.
ScaledChoice choose_scaled(const Probes& probes, const Scales& scales,
                           std::optional<AxisScale> fixed, std::vector<int> candidates, int few,
                           const std::function<double(AxisScale scale, int candidate)>& error);

}  // namespace stratus
