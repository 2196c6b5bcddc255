// Bakes straight into packed tables, of which all samples are never formed.
#include "random_recipe.h"

#include <stratus/bsdf/slice.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "indices.h"
#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus::test {
namespace {

void expect_met(const std::string& recipe) {
    const PackedBake baked(parse_recipe(recipe));
    EXPECT_TRUE(baked.meets()) << recipe << "largest error "
                               << baked.verification.samples.back().error;
}

class RandomRecipe : public testing::TestWithParam<unsigned> {};

TEST_P(RandomRecipe, MeetsItsTolerance) { expect_met(test::RandomRecipe(GetParam()).text()); }

INSTANTIATE_TEST_SUITE_P(Seeds, RandomRecipe, testing::Values(3u, 11u, 19u));

TEST(PackedBake, TransmitsBetweenTheMembersOfAMixtureHoweverDeep) {
    expect_met(
        "phase_function = 'anisotropic:x=-0.77'\n"
        "second_phase_function = 'rayleigh'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 4, max = 24 }\n"
        "albedo = { min = 0.6, max = 0.9 }\n"
        "sides = ['transmission']\n");
    expect_met(
        "phase_function = 'lambert_sphere'\n"
        "second_phase_function = 'rayleigh'\n"
        "tolerance = 7e-3\n"
        "optical_depth = { min = 0.109, max = inf }\n"
        "albedo = { min = 0.551, max = 1 }\n"
        "mu_in = 0.765\n");
}

TEST(PackedBake, MeetsItsToleranceBeyondItsDeepestFiniteSample) {
    const PackedBake baked(
        parse_recipe("phase_function = 'isotropic'\n"
                     "tolerance = 5.4e-3\n"
                     "optical_depth = { min = 0.01472, max = inf }\n"
                     "albedo = { min = 0.3316, max = 0.3316 }\n"
                     "sides = ['reflection']\n"));
    EXPECT_GT(*(baked.header.optical_depth.values.end() - 2), 3);  // the last finite sample
    EXPECT_TRUE(baked.meets()) << baked.verification.samples.back().error;
}

TEST(PackedBake, InterpolatesDeepLayersDownToAlbedo0) {
    expect_met(
        "phase_function = 'henyey_greenstein:g=0.75'\n"
        "tolerance = 2e-3\n"
        "optical_depth = { min = 12, max = 16 }\n"
        "albedo = { min = 0.0, max = 0.41 }\n"
        "sides = ['transmission']\n"
        "[discretisation]\n"
        "nodes = 24\n"
        "modes = 30\n"
        "mu_samples = 36\n"
        "azimuth_samples = 33\n"
        "azimuth_scale = 'square_root'\n"
        "optical_depth_samples_per_octave = 6\n"
        "albedo_samples = 8\n"
        "albedo_scale = 'fourth_root_of_complement'\n");
}

TEST(PackedBake, InterpolatesFromAlbedosWhoseLightNoFloatHolds) {
    for (const char* const darkest : {"1e-30", "1e-300"})
        expect_met(std::string("phase_function = 'henyey_greenstein:g=-0.7'\n"
                               "tolerance = 2e-3\n"
                               "optical_depth = { min = 0.5, max = 2 }\n"
                               "albedo = { max = 1e-3, min = ") +
                   darkest + " }\n");
}

TEST(PackedBake, HoldsTheFaintLightOfAStackUnderABlackLayer) {
    expect_met(
        "tolerance = 1e-2\n"
        "[[layers]]\n"
        "phase_function = 'isotropic'\n"
        "albedo = 0.0\n"
        "optical_depth = 6.0\n"
        "[[layers]]\n"
        "phase_function = 'rayleigh'\n"
        "albedo = 1.0\n"
        "optical_depth = 5.0\n");
}

TEST(PackedBake, HoldsWhatTheGroundReflectsUnderABlackLayer) {
    expect_met(
        "phase_function = 'isotropic'\n"
        "tolerance = 1e-1\n"
        "optical_depth = { min = 0.1, max = 0.2 }\n"
        "albedo = { min = 0, max = 0 }\n"
        "[below]\n"
        "ground = 'ocean:wind=20'\n");
}

TEST(PackedBake, LooksUpWhatATableOfAllSamplesHolds) {
    const Recipe recipe = explicit_recipe();
    const PackedBake baked(recipe);
    const Table table = solve_table(resolve(recipe));
    const PackedTable direct(baked.file), packed(pack(table));
    const Table found = direct.unpacked();
    ASSERT_EQ(found.reflection_multiple.size(), table.reflection_multiple.size());
    // Both miss the solver by half of the tolerance at most.
    for (const double mu : {0.05, 0.3, 1.0})
        for (const double azimuth : {0.0, 1.0, 3.0})
            for (const double depth : {0.3, 1.0}) {
                const Geometry at{mu, 0.6, azimuth};
                const double expected = packed.reflection(0.8, depth, at).total();
                EXPECT_NEAR(direct.reflection(0.8, depth, at).total(), expected,
                            recipe.tolerance * expected);
            }
    EXPECT_EQ(baked.header.plane_albedo, table.plane_albedo);
    EXPECT_EQ(baked.header.spherical_albedo, table.spherical_albedo);
}

TEST(PackedBake, JudgesWhatNarrowPeaksScatterBackByItself) {
    // The ground leaves no path law, and at grazing angles the peak outshines all that goes back.
    const Recipe recipe = parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.89'\n"
        "tolerance = 6e-3\n"
        "optical_depth = { min = 1, max = 16 }\n"
        "albedo = { min = 0.14, max = 1 }\n"
        "[below]\n"
        "phase_function = 'henyey_greenstein:g=-0.5'\n"
        "albedo = 0.76\n"
        "[discretisation]\n"
        "nodes = 16\n"
        "modes = 40\n"
        "mu_samples = 14\n"
        "azimuth_samples = 17\n"
        "azimuth_scale = 'square_root'\n"
        "optical_depth_samples_per_octave = 3\n"
        "albedo_samples = 24\n"
        "albedo_scale = 'square_root_of_complement'\n");
    const Table table = solve_table(recipe);
    const PackedTable packed(pack(table));
    const TableView view = table.view();
    double worst = 0;
    for (const double w : table.albedo.values)
        for (const double tau : table.optical_depth.values) {
            std::vector<double> expected, error;
            for (const double mu : {0.12, 0.3, 0.6, 0.97})
                for (const double other : {0.12, 0.4, 0.8, 0.98})
                    for (const double azimuth : {1.6, 2.0, 2.5, 3.1}) {
                        const Geometry at{mu, other, azimuth};
                        expected.push_back(reflection(view, w, tau, at).total());
                        error.push_back(packed.reflection(w, tau, at).total() - expected.back());
                    }
            const double floor = 0.01 * *std::ranges::max_element(expected);
            for (const auto n : indices(error))
                worst = std::max(worst, std::abs(error[n]) / std::max(expected[n], floor));
        }
    EXPECT_LE(worst, recipe.tolerance / 2);
}

TEST(PackedBake, FollowsTheLawOfThinLayersBelowItsThinnestSample) {
    SolverOptions options;
    options.nodes = 128;  // fewer have no cosine small enough for light along so thin a layer
    // The law is that of isotropic scattering; times tau^2 alone all would be 60 % low at 1e-6.
    for (const auto& [phase_function, accuracy] : {std::pair{"isotropic", 0.02},
                                                   {"rayleigh", 0.15},
                                                   {"lambert_sphere", 0.16},
                                                   {"henyey_greenstein:g=0.5", 0.5}}) {
        const Recipe recipe = parse_recipe("phase_function = '" + std::string(phase_function) +
                                           "'\n"
                                           "tolerance = 1e-2\n"
                                           "optical_depth = { min = 0.01, max = 0.04 }\n"
                                           "albedo = { min = 0.9, max = 0.9 }\n");
        const PackedBake baked(recipe);
        const PackedTable table(baked.file);
        const std::vector<double> mu{0.2, 0.5, 0.9};
        for (const double depth : {3e-3, 1e-4, 1e-6}) {
            const LayerSolution exact = solve_layer(recipe.phase_function, 0.9, depth, mu, options);
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) {
                    const Geometry at{mu[static_cast<std::size_t>(i)],
                                      mu[static_cast<std::size_t>(j)], 1};
                    const auto close = [&, accuracy = accuracy](double found, double expected) {
                        EXPECT_NEAR(found / expected, 1, accuracy)
                            << recipe.phase_text << ' ' << depth;
                    };
                    close(table.reflection(0.9, depth, at).multiple,
                          exact.reflection(i, j, at.azimuth).multiple);
                    close(table.transmission(0.9, depth, at).multiple,
                          exact.transmission(i, j, at.azimuth).multiple);
                }
        }
    }
}

/// Errors of thin layers relative to R or T, at albedo 1.
struct ThinErrors {
    double most = 0, most_estimated = 0;

    /// Takes all pairs of cosines at azimuth 1; expected(i, j) is R or T.
    template <class Expected>
    void add(const PackedTable& table, Side side, double depth, const std::vector<double>& mu,
             const Expected& expected) {
        for (const auto i : indices(mu))
            for (const auto j : indices(mu)) {
                const Geometry at{mu[i], mu[j], 1};
                const double found = table.scattering(side, 1, depth, at).total();
                most = std::max(
                    most, std::abs(found / expected(static_cast<int>(i), static_cast<int>(j)) - 1));
                most_estimated =
                    std::max(most_estimated, thin_layer_error(table.view(), side, 1, depth, at));
            }
    }

    double octaves_apart() const { return std::abs(std::log2(most_estimated / most)); }
};

TEST(PackedBake, ExtrapolatesThinLayersAndEstimatesTheErrorOfIt) {
    const std::vector<double> mu{0.2, 0.5, 0.9};
    for (const char* const g : {"-0.3", "0.5", "0.75"}) {
        const PackedBake baked(
            parse_recipe("phase_function = 'henyey_greenstein:g=" + std::string(g) +
                         "'\n"
                         "tolerance = 1e-2\n"
                         "optical_depth = { min = 0.25, max = 1 }\n"
                         "albedo = { min = 1, max = 1 }\n"));
        const PackedTable table(baked.file);
        for (const double depth : {0.2, 0.1, 0.01}) {
            const LayerSolution exact = solve_layer(PhaseFunction::henyey_greenstein(std::stod(g)),
                                                    1, depth, mu, SolverOptions{.nodes = 64});
            ThinErrors errors;
            for (const Side side : both_sides)
                errors.add(table, side, depth, mu,
                           [&](int i, int j) { return exact.values(side, i, j, {1})[0].total; });
            EXPECT_LE(errors.most, 0.06) << g << ' ' << depth;
            const Slice slice = bind(table.view(), depth, 1);
            for (int i = 1; i < 3; ++i) {  // along 0.2 light bends more: 7e-3
                const double cosine = mu[static_cast<std::size_t>(i)],
                             diffuse = exact.diffuse_transmittance[static_cast<std::size_t>(i)];
                EXPECT_NEAR(double{slice.background(static_cast<float>(cosine))},
                            diffuse + direct_transmittance(depth, cosine), 2e-3)
                    << g << ' ' << depth;
            }
            EXPECT_LE(errors.octaves_apart(), 1) << g << ' ' << depth;
        }
        EXPECT_EQ(thin_layer_error(table.view(), Side::reflection, 1, 0.3, {0.5, 0.5, 1}), 0);
    }
}

TEST(PackedBake, KnowsNoLayersFarThinnerThanItsDeepOnes) {
    const PackedBake baked(
        parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                     "tolerance = 1e-2\n"
                     "optical_depth = { min = 1000, max = inf }\n"
                     "albedo = { min = 0.6, max = 1 }\n"));
    const PackedTable table(baked.file);
    const TableView view = table.view();
    expect_refusal([&] { bind(view, 1, 1); }, {"optical_depth", "of the table or inf", "got 1"});
    const Slice clamped = bind(view, 1, 1, {}, OutsideTable::clamp), nearest = bind(view, 1000, 1);
    Effects once;
    once.multiple = false;
    const auto more = [&](const Slice& all, double depth) {
        return all.reflection(0.5f, 0.5f, 1) - bind(view, depth, 1, once).reflection(0.5f, 0.5f, 1);
    };
    const double intercepted = -std::expm1(-1 / 0.5);
    EXPECT_NEAR(more(clamped, 1), intercepted * intercepted * more(nearest, 1000), 1e-3);
    for (const double depth : {0.1, 1.0, 10.0})  // lookups give something, within reason
        EXPECT_LT(table.reflection(1.0, depth, {0.5, 0.5, 1.0}).total(), 2);
}

TEST(PackedBake, TransmitsByTheLawOfDiffusionHoweverDeep) {
    const PackedBake baked(
        parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                     "tolerance = 1e-2\n"
                     "optical_depth = { min = 1e6, max = 1e8 }\n"
                     "albedo = { min = 0.6, max = 1 }\n"));
    const PackedTable table(baked.file);
    const auto transmitted = [&](double depth) {
        return table.transmission(1.0, depth, {0.5, 0.5, 1.0}).total();
    };
    for (const double deeper : {1e7, 1e8})  // 1 / (tau + q)
        EXPECT_NEAR(deeper * transmitted(deeper), 1e6 * transmitted(1e6), 1e-3);
}

TEST(PackedBake, EstimatesTheErrorOfThinLayersOverASurface) {
    const std::vector<double> mu{0.2, 0.5, 0.9};
    const auto phase = PhaseFunction::henyey_greenstein(0.5);
    const PackedBake baked(
        parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                     "tolerance = 1e-2\n"
                     "optical_depth = { min = 1, max = 4 }\n"
                     "albedo = { min = 1, max = 1 }\n"
                     "[below]\nlambert_albedo = 0.5\n"));
    const PackedTable table(baked.file);
    for (const double depth : {0.7, 0.3, 0.05}) {
        const StackSolution exact =
            solve_stack({{phase, 1, depth}}, LowerBoundary::surface(0.5), mu);
        ThinErrors errors;
        errors.add(table, Side::reflection, depth, mu,
                   [&](int i, int j) { return exact.reflection(i, j, 1).total; });
        EXPECT_LE(errors.octaves_apart(), 1) << depth << ' ' << errors.most;
    }
}

TEST(PackedBake, GivesTheSameBytesOnAnyNumberOfThreads) {
    const Recipe recipe = resolve(explicit_recipe());
    std::vector<char> files[2];
    for (int n = 0; n < 2; ++n) {
        BakeOptions options;
        options.threads = 1 + 2 * n;
        options.packed = &files[n];
        bake(recipe, options);
    }
    EXPECT_EQ(files[0], files[1]);
}

}  // namespace
}  // namespace stratus::test
