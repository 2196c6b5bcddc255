#include <stratus/bake/axes.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/forecast.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "choices.h"
#include "all_near.h"
#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

TEST(Resolve, FillsInEveryChoice) {
    const Discretisation d = resolve(rayleigh_recipe()).discretisation;
    EXPECT_GE(d.nodes, 1);
    EXPECT_EQ(d.modes, 3);  // Rayleigh scattering has no more
    EXPECT_GE(d.mu_samples, 4);
    EXPECT_GE(d.azimuth_samples, 3);
    EXPECT_GE(d.optical_depth_samples_per_octave, 1);
    EXPECT_GE(d.albedo_samples, 2);
    EXPECT_EQ(d.deepest_optical_depth, 0);  // no infinity, no last sample before it
}

TEST(Resolve, ChoosesTheDeepestFiniteDepth) {
    const Discretisation d = resolve(deep_recipe()).discretisation;
    EXPECT_GE(d.deepest_optical_depth, 0.5);
    EXPECT_LE(d.deepest_optical_depth, 1e4);
    EXPECT_EQ(d.modes, 1);  // isotropic
    EXPECT_EQ(d.azimuth_samples, 1);
}

TEST(Resolve, KeepsTheRestOfTheRecipe) {
    const Recipe recipe = rayleigh_recipe(), resolved = resolve(recipe);
    EXPECT_EQ(resolved.title, recipe.title);
    EXPECT_EQ(resolved.tolerance, recipe.tolerance);
    EXPECT_EQ(resolved.optical_depth.min, recipe.optical_depth.min);
    EXPECT_EQ(resolved.optical_depth.max, recipe.optical_depth.max);
    EXPECT_EQ(resolved.phase_function.text(), recipe.phase_function.text());
}

TEST(Resolve, KeepsAnExplicitDiscretisation) {
    Recipe recipe = explicit_recipe("classic");
    const Discretisation resolved = resolve(recipe).discretisation;
    recipe.discretisation.azimuth_scale = AxisScale::linear;
    recipe.discretisation.albedo_scale = AxisScale::square_root_of_complement;
    expect_same(resolved, recipe.discretisation);
}

/// Numbers that are chosen unless given, and one that may be given.
const struct {
    const char* name;
    int Discretisation::*member;
    int given;
} numbers[] = {
    {"nodes", &Discretisation::nodes, 7},
    {"modes", &Discretisation::modes, 2},
    {"mu_samples", &Discretisation::mu_samples, 9},
    {"azimuth_samples", &Discretisation::azimuth_samples, 7},
    {"optical_depth_samples_per_octave", &Discretisation::optical_depth_samples_per_octave, 5},
    {"albedo_samples", &Discretisation::albedo_samples, 3},
};

TEST(Resolve, KeepsEachExplicitValue) {
    for (const auto& [name, member, value] : numbers) {
        Recipe recipe = rayleigh_recipe();
        recipe.discretisation.*member = value;
        EXPECT_EQ(resolve(recipe).discretisation.*member, value);
    }
}

TEST(Resolve, IsIdempotent) {
    for (const Recipe& recipe : {deep_recipe(), peaked_recipe()}) {
        const Recipe once = resolve(recipe);
        expect_same(resolve(once).discretisation, once.discretisation);
    }
}

TEST(Resolve, TakesNodesBetweenTwoCandidatesWhereTheseDo) {
    const Recipe recipe = parse_recipe(
        "phase_function = '0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5'\n"
        "tolerance = 1e-4\noptical_depth = { min = 0.01, max = 8.0 }\n"
        "albedo = { min = 0.0, max = 1.0 }\n");
    const int nodes = resolve(recipe).discretisation.nodes;
    EXPECT_GT(nodes, 20);
    EXPECT_LT(nodes, 24);
    const auto solve = [&](int count) {
        SolverOptions options;
        options.nodes = count;
        return solve_layer(recipe.phase_function, 1, 1, {0.1, 0.3, 0.6, 1}, options);
    };
    const LayerSolution coarse = solve(nodes), fine = solve(2 * nodes);
    for (const Side side : both_sides)
        for (int in = 0; in < 4; ++in)
            for (int out = 0; out < 4; ++out) {
                const double expected = fine.values(side, in, out, {0.7})[0].total;
                EXPECT_NEAR(coarse.values(side, in, out, {0.7})[0].total, expected, 1e-5 * expected)
                    << in << ' ' << out;
            }
}

TEST(Resolve, GoesOnFromNodesWhoseSeriesIsTooNegative) {
    const Recipe recipe = parse_recipe(
        "phase_function = 'henyey_greenstein:g=-0.99'\nmu_in = 1.0\ntolerance = 1e-2\n"
        "optical_depth = { min = 0.5, max = 0.5 }\nalbedo = { min = 0.6, max = 0.6 }\n");
    SolverOptions fewest;
    fewest.nodes = 8;
    EXPECT_THROW(solve_layer(recipe.phase_function, 0.6, 0.5, {1.0}, fewest), TooFewNodes);
    EXPECT_GT(resolve(recipe).discretisation.nodes, 12);
}

TEST(Resolve, TakesTheSquareRootOfAzimuthWhereFewerSamplesDo) {
    const Recipe smooth = resolve(rayleigh_recipe()), peaked = resolve(peaked_recipe());
    EXPECT_EQ(smooth.discretisation.azimuth_scale, AxisScale::linear);
    EXPECT_EQ(peaked.discretisation.azimuth_scale, AxisScale::square_root);
    Recipe linear = peaked_recipe();
    linear.discretisation.azimuth_scale = AxisScale::linear;
    const Discretisation even = resolve(linear).discretisation;
    EXPECT_EQ(even.azimuth_scale, AxisScale::linear);
    EXPECT_GT(even.azimuth_samples, peaked.discretisation.azimuth_samples);
}

TEST(Resolve, TakesTheFourthRootOfComplementWhereFewerAlbedosDo) {
    const AxisScale square = AxisScale::square_root_of_complement,
                    fourth = AxisScale::fourth_root_of_complement;
    EXPECT_EQ(resolve(rayleigh_recipe()).discretisation.albedo_scale, square);
    Recipe recipe = parse_recipe(
        "phase_function = 'isotropic'\n"
        "tolerance = 1e-4\n"
        "optical_depth = { min = 16.0, max = 256.0 }\n"
        "albedo = { min = 0.99, max = 1.0 }\n");
    const Discretisation deep = resolve(recipe).discretisation;
    EXPECT_EQ(deep.albedo_scale, fourth);
    recipe.discretisation.albedo_scale = square;
    EXPECT_GT(resolve(recipe).discretisation.albedo_samples, deep.albedo_samples);
    recipe.discretisation = {};
    recipe.discretisation.albedo_samples = 7;
    EXPECT_EQ(resolve(recipe).discretisation.albedo_scale, square);
}

TEST(Resolve, TakesGivenAzimuthsAsLinear) {
    Recipe recipe = peaked_recipe();
    recipe.discretisation.azimuth_samples = 7;
    EXPECT_EQ(resolve(recipe).discretisation.azimuth_scale, AxisScale::linear);
    recipe.discretisation.azimuth_scale = AxisScale::square_root;
    EXPECT_EQ(resolve(recipe).discretisation.azimuth_scale, AxisScale::square_root);
}

TEST(Resolve, IsIndependentOfThreads) {
    BakeOptions one, three;
    one.threads = 1;
    three.threads = 3;
    expect_same(resolve(rayleigh_recipe(), one).discretisation,
                resolve(rayleigh_recipe(), three).discretisation);
}

TEST(Resolve, RefinesWithTolerance) {
    Recipe strict = rayleigh_recipe();
    strict.tolerance = 1e-3;
    const Discretisation coarse = resolve(rayleigh_recipe()).discretisation;
    const Discretisation fine = resolve(strict).discretisation;
    EXPECT_GE(fine.nodes, coarse.nodes);
    EXPECT_GT(fine.mu_samples, coarse.mu_samples);
    EXPECT_GE(fine.azimuth_samples, coarse.azimuth_samples);
    EXPECT_GT(fine.optical_depth_samples_per_octave, coarse.optical_depth_samples_per_octave);
    EXPECT_GT(fine.albedo_samples, coarse.albedo_samples);
}

TEST(Resolve, SamplesDepthsAsCloselyAsFewOrdersNeed) {
    const Recipe recipe = parse_recipe(
        "phase_function = 'isotropic'\n"
        "tolerance = 1e-3\n"
        "orders = 17\n"
        "optical_depth = { min = 2.0, max = 10.0 }\n"
        "albedo = { min = 0.99, max = 1.0 }\n"
        "sides = ['transmission']\n");
    const Resolution resolution = resolve_as_first(recipe, {});
    EXPECT_GT(resolution.recipe.discretisation.optical_depth_samples_per_octave, 6);
    EXPECT_TRUE(resolution.at_cap.empty());
}

TEST(Resolve, SamplesAFamilyOfTwoAxesAsCloselyAsItsPeakedEndNeeds) {
    const auto mixtures = [](double tolerance, const std::string& g) {
        const Recipe recipe = parse_recipe(
            "phase_function = 'henyey_greenstein:g=0.8'\n"
            "second_phase_function = 'rayleigh'\n"
            "tolerance = " +
            std::to_string(tolerance) +
            "\noptical_depth = { min = 1.0, max = 4.0 }\nalbedo = { min = 1.0, max = 1.0 }\n"
            "[family]\nmixture = [0.0, 1.0]\n" +
            g +
            "[discretisation]\nnodes = 16\nmodes = 20\nmu_samples = 10\nazimuth_samples = 5\n"
            "optical_depth_samples_per_octave = 3\n");
        const auto mixture =
            std::ranges::find(recipe.family, PhaseParameter::mixture, &FamilyRange::parameter);
        return resolve(recipe).discretisation.family_samples.at(
            static_cast<std::size_t>(mixture - recipe.family.begin()));
    };
    const std::string g = "g = [-0.4, 0.8]\n";
    const int both = mixtures(1e-2, g);
    EXPECT_GE(both, mixtures(2e-2, ""));
    EXPECT_LE(both, mixtures(1e-2, ""));
}

TEST(Resolve, SamplesASingleAlbedoAndDepthOnce) {
    Recipe recipe = rayleigh_recipe();
    recipe.albedo = {0.9, 0.9};
    recipe.optical_depth = {1, 1};
    const Discretisation d = resolve(recipe).discretisation;
    EXPECT_EQ(d.albedo_samples, 1);
    EXPECT_EQ(d.optical_depth_samples_per_octave, 1);
}

TEST(Resolve, NotesEveryChoice) {
    std::string notes;
    BakeOptions options;
    options.note = [&](const std::string& line) { notes += line + "\n"; };
    const Discretisation d = resolve(rayleigh_recipe(), options).discretisation;
    for (const auto& [name, member, given] : numbers) {
        const std::string begin = std::string(name) + " " + std::to_string(d.*member) + ": ";
        expect_holds(notes, {begin});
    }
}

/// Even points are drawn as accuracy.h has it.
TEST(Choices, WeighDirectionsOfNarrowPeaksByTheRandomPointsNearestToThem) {
    for (const char* const phase : {"henyey_greenstein:g=0.85", "henyey_greenstein:g=0.97"}) {
        Recipe recipe = rayleigh_recipe();
        recipe.phase_function = parse_phase_function(phase);
        const Probes probes = place_probes(recipe, 1e-3, {});
        const DirectionGrid& grid = probes.directions;
        const double least = std::sqrt(least_judged_cosine);
        const DirectionWeights weight(recipe, grid);
        PerSide<double> all, forward;
        std::vector<double> of_out(static_cast<std::size_t>(grid.out_count()));  // R
        for_each_direction(grid, [&](int i, int j, int k) {
            for (const Side side : both_sides) {
                all[side] += weight(side, i, j, k);
                if (grid.cos_scattering_angle(side)[grid.at(i, j, k)] > std::cos(radians(10)))
                    forward[side] += weight(side, i, j, k);
            }
            for (const int place : {i, j})
                of_out[static_cast<std::size_t>(place)] += weight(Side::reflection, i, j, k) / 2;
        });
        EXPECT_NEAR(all.reflection, pi * std::pow(1 - least, 2), 1e-9) << phase;
        EXPECT_NEAR(forward.transmission / all.transmission, 0.1, 1e-9) << phase;
        std::mt19937 random(1);
        std::uniform_real_distribution<double> root(least, 1);
        std::vector<double> drawn(of_out.size());
        constexpr int draws = 100000;
        for (int n = 0; n < draws; ++n) {
            const double x = root(random);
            std::size_t nearest = drawn.size();
            for (const auto j : indices(drawn)) {
                const double mu = grid.mu_out(static_cast<int>(j));
                if (std::sqrt(mu) < least) continue;
                if (nearest == drawn.size() ||
                    std::abs(std::sqrt(mu) - x) <
                        std::abs(std::sqrt(grid.mu_out(static_cast<int>(nearest))) - x))
                    nearest = j;
            }
            drawn[nearest] += all.reflection / draws;
        }
        expect_all_near(of_out, drawn, 0, 0.01);
    }
}

TEST(Choices, ProbeBetweenTheSamplesOfMuWhateverTheirNumber) {
    const Probes probes = place_probes(rayleigh_recipe(), 1e-3, {});
    for (const int samples :
         {16, 18, 20, 22, 24, 26, 28, 30, 32, 36, 38, 40, 42, 44, 46, 48, 52, 56}) {
        const Axis axis = mu_axis({0, 1}, samples);
        double sum = 0;
        int count = 0;
        for (const double mu : probes.directions.mu()) {
            if (mu < 0.35 || mu == 1) continue;  // a cubic misses most halfway between two samples
            const double index = axis.view().index(mu), x = index - std::floor(index);
            sum += x * (1 - x) * (1 + x) * (2 - x) / 0.5625;
            ++count;
        }
        EXPECT_GT(sum / count, 0.5) << samples;
    }
}

TEST(Choices, LetOneInAThousandBeLargerAndOneInFiveThousandFiveTimes) {
    const Probes probes = place_probes(rayleigh_recipe(), 1e-3, {});
    Errors errors(9990, {1.0, 1.0});
    errors.insert(errors.end(), 10, {4.0, 1.0});
    EXPECT_EQ(quantile_of_all(probes, errors, 0.999), 1);
    errors.insert(errors.end(), {4.0f, 0.1f});
    EXPECT_EQ(quantile_of_all(probes, errors, 0.999), 4);
    errors.assign(9990, {1.0, 1.0});
    errors.insert(errors.end(), 8, {1.0, 1.0});
    errors.insert(errors.end(), 2, {40.0, 1.0});
    EXPECT_EQ(quantile_of_all(probes, errors, 0.999), 1);
    errors.insert(errors.end(), {40.0f, 0.1f});
    EXPECT_EQ(quantile_of_all(probes, errors, 0.999), 8);
    EXPECT_EQ(quantile_of_all(probes, {{3.0, 1.0}, {2.0, 5.0}}, 0.999), 3);
    EXPECT_EQ(quantile_of_all(probes, {}, 0.999), 0);
}

TEST(Choices, TakeTheFirstCandidateThatHolds) {
    const Probes probes = place_probes(rayleigh_recipe(), 1e-3, {});
    const std::vector<int> candidates{4, 6, 8, 10, 12, 16, 20, 24, 28, 32, 40, 48, 56};
    const std::vector<std::function<double(int)>> laws{
        [](int c) { return std::pow(c / 20.0, -4); }, [](int c) { return std::pow(c / 20.0, -2); },
        [](int c) { return std::exp(20.0 - c); },     [](int c) { return c < 20 ? 1e6 : 1e-6; },
        [](int c) { return c < 20 ? 1.01 : 0.99; },
    };
    for (const auto law : indices(laws))
        for (const double scale : {1e-9, 0.3, 1.0, 1.7, 30.0}) {
            const auto error = [&](int c) { return scale * 1e-3 * laws[law](c); };
            std::size_t first = 0;
            while (first + 1 < candidates.size() && error(candidates[first]) > 1e-3) ++first;
            for (const double share : {1.0, 0.8, 0.1}) {  // of the error that at_least tells
                std::set<int> asked, worked_out;
                const Choice choice = choose_cheapest(
                    probes, "samples", candidates,
                    [&](int c) {
                        worked_out.insert(c);
                        return error(c);
                    },
                    [&](int c) {
                        asked.insert(c);
                        return share * error(c);
                    });
                EXPECT_EQ(choice.value, candidates[first]) << law << ", " << scale;
                EXPECT_EQ(choice.error_at_cap, error(56) > 1e-3 ? error(56) : 0);
                EXPECT_LE(asked.size(), 9);
                if (share == 1 && choice.error_at_cap == 0) {
                    EXPECT_EQ(worked_out.size(), 1);
                }
            }
            int asked = 0;
            const Choice choice = choose_cheapest(probes, "samples", candidates, [&](int c) {
                ++asked;
                return error(c);
            });
            EXPECT_EQ(choice.value, candidates[first]) << law << ", " << scale;
            EXPECT_LE(asked, 9);
            EXPECT_EQ(choice.error_at_cap, error(56) > 1e-3 ? error(56) : 0);
        }
}

}  // namespace
}  // namespace stratus::test
