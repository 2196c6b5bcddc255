#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/base/constants.h>
#include <stratus/layer/ground_law.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace stratus::test {
namespace {

std::vector<ErrorSample> samples_with(const std::vector<double>& errors) {
    std::vector<ErrorSample> samples;
    for (const double error : errors)
        samples.push_back({Side::reflection, 1, 1, {}, 0, 1, 1, error});
    return samples;
}

/// So many errors of 1e-3, the last of them larger.
std::vector<ErrorSample> samples_beyond(std::size_t count, std::size_t beyond, double worst) {
    std::vector<double> errors(count - beyond, 1e-3);
    errors.insert(errors.end(), beyond, worst);
    return samples_with(errors);
}

TEST(ErrorQuantile, BoundsItsShareOfErrors) {
    std::vector<double> errors;
    for (int n = 1000; n >= 0; --n) errors.push_back(n / 1000.0);
    std::vector<ErrorSample> samples = samples_with(errors);
    EXPECT_EQ(error_quantile(samples, 0), 0);
    EXPECT_EQ(error_quantile(samples, 0.5), 0.5);
    EXPECT_NEAR(error_quantile(samples, 0.999), 0.999, 1e-15);
    EXPECT_EQ(error_quantile(samples, 1), 1);
    EXPECT_TRUE(std::ranges::is_sorted(samples, {}, &ErrorSample::error));
    EXPECT_EQ(error_quantile(samples, 0.9991), 1) << "the next one, not the one before";
}

TEST(ErrorQuantile, IsWithinToleranceWhereThatShareIs) {
    for (const std::size_t count : {1u, 2u, 99u, 100u, 999u, 1000u, 1001u, 2000u, 4000u, 7000u})
        for (const std::size_t beyond : {0u, 1u, 2u, 3u, 4u, 5u, 7u, 8u}) {
            if (beyond > count) continue;
            Verification verification;
            verification.samples = samples_beyond(count, beyond, 2e-3);
            EXPECT_EQ(verification.meets(1e-3), 1000 * beyond <= count)
                << beyond << " of " << count;
            EXPECT_EQ(error_quantile(verification.samples, 0.999) <= 1e-3, 1000 * beyond <= count)
                << beyond << " of " << count;
        }
}

TEST(ErrorQuantile, IsZeroWithoutSamples) {
    std::vector<ErrorSample> none;
    EXPECT_EQ(error_quantile(none, 0.5), 0);
}

TEST(Verification, AllowsOneInAThousandUpToFiveTimesTheTolerance) {
    const auto meets = [](std::size_t beyond, double worst) {
        Verification result;
        result.samples = samples_beyond(2000, beyond, worst);
        return result.meets(1e-3);
    };
    EXPECT_TRUE(meets(0, 0));
    EXPECT_TRUE(meets(2, 4.9e-3));
    EXPECT_FALSE(meets(3, 4.9e-3));
    EXPECT_FALSE(meets(1, 5.1e-3));
}

TEST(Verification, AllowsOneInAHundredNearForwardAndAtGrazingPairs) {
    const auto verification = [](std::size_t beyond_forward, std::size_t beyond_grazing) {
        Verification result;
        result.samples = samples_beyond(1000, 0, 1e-1);
        result.forward = samples_beyond(1000, beyond_forward, 1e-1);
        result.grazing = samples_beyond(1000, beyond_grazing, 1e-1);
        return result;
    };
    EXPECT_TRUE(verification(10, 10).meets(1e-3));
    EXPECT_FALSE(verification(11, 0).meets(1e-3));
    EXPECT_FALSE(verification(0, 11).meets(1e-3));
    Verification unjudged = verification(11, 11);
    unjudged.judges_grazing = false;
    EXPECT_FALSE(unjudged.meets(1e-3));
    unjudged.judges_forward = false;
    EXPECT_TRUE(unjudged.meets(1e-3));
}

TEST(IsPeaked, BeginsAboveHenyeyGreensteinOfThreeQuarters) {
    EXPECT_FALSE(is_peaked(PhaseFunction::isotropic()));
    EXPECT_FALSE(is_peaked(PhaseFunction::henyey_greenstein(0.75)));
    EXPECT_FALSE(is_peaked(PhaseFunction::henyey_greenstein(-0.9)));
    EXPECT_TRUE(is_peaked(PhaseFunction::henyey_greenstein(0.8)));
}

TEST(Floor, IsOnePercentOfTheLargestValue) {
    std::vector<double> mu = floor_cosines();
    mu.push_back(0.01);  // grazing: brighter still, and left out
    const LayerSolution layer = solve_layer(PhaseFunction::isotropic(), 0.9, 1, mu);
    double R = 0, T = 0;
    for (int i = 0; i < static_cast<int>(floor_cosines().size()); ++i)
        for (int j = 0; j <= i; ++j) {
            R = std::max(R, layer.reflection(i, j, 0).total);
            T = std::max(T, layer.transmission(i, j, 0).total);
        }
    EXPECT_NEAR(error_floor(layer, Side::reflection), 0.01 * R, 1e-15);
    EXPECT_NEAR(error_floor(layer, Side::transmission), 0.01 * T, 1e-15);
}

TEST(Floor, HasALowerLimit) {
    const LayerSolution dark = solve_layer(PhaseFunction::isotropic(), 0.5, 1000, floor_cosines());
    EXPECT_EQ(error_floor(dark, Side::transmission), 1e-8);
}

TEST(Verify, ComparesEverySideAtEveryPoint) {
    const Table table = bake(explicit_recipe());
    const Verification verification = verify(table, {.samples = 101});
    EXPECT_EQ(verification.samples.size(), 202u);
    EXPECT_GT(verification.reference_nodes, 9);
    for (const ErrorSample& sample : verification.samples) {
        EXPECT_TRUE(sample.albedo >= 0.75 && sample.albedo <= 1);
        EXPECT_TRUE(sample.optical_depth >= 0.5 && sample.optical_depth <= 2);
        EXPECT_GT(sample.expected, 0);
        const double off = std::abs(sample.found - sample.expected);
        EXPECT_LE(sample.error, off / sample.expected * (1 + 1e-12));
        EXPECT_TRUE(sample.scattering_angle >= 0 && sample.scattering_angle <= pi);
    }
}

TEST(Verify, DrawsForwardAndGrazingPointsOfPeakedPhaseFunctionsAlone) {
    Recipe recipe = explicit_recipe();
    VerifyOptions options;
    options.samples = 400;
    const Verification smooth = verify(solve_table(recipe), options);
    EXPECT_TRUE(smooth.forward.empty());
    EXPECT_TRUE(smooth.grazing.empty());

    recipe.phase_function = PhaseFunction::henyey_greenstein(0.8);
    recipe.phase_text = recipe.phase_function.text();
    const Verification peaked = verify(solve_table(recipe), options);
    EXPECT_EQ(peaked.samples.size(), 800u);
    EXPECT_EQ(peaked.grazing.size(), 200u);
    for (const ErrorSample& sample : peaked.grazing) {
        EXPECT_LE(sample.geometry.mu_in, grazing_cosine);
        EXPECT_LE(sample.geometry.mu_out, grazing_cosine);
    }
    double sum = 0;
    int transmitted = 0, reflected = 0;
    for (const ErrorSample& sample : peaked.forward) {
        EXPECT_LE(degrees(sample.scattering_angle), forward_cone * (1 + 1e-6));
        EXPECT_GT(sample.expected, 0);
        if (sample.side == Side::reflection) ++reflected;
        if (sample.side == Side::reflection) continue;
        sum += degrees(sample.scattering_angle);
        ++transmitted;
    }
    EXPECT_GT(reflected, 190);  // but for those that a hundred trials did not find
    EXPECT_EQ(transmitted, 200);
    // Evenly over the angle: 5 degrees in the mean, its standard error 0.2.
    EXPECT_NEAR(sum / transmitted, forward_cone / 2, 0.8);
    // The even points are those of any phase function.
    const auto azimuths = [](const std::vector<ErrorSample>& samples) {
        std::vector<double> all;
        for (const ErrorSample& sample : samples) all.push_back(sample.geometry.azimuth);
        std::ranges::sort(all);
        return all;
    };
    EXPECT_EQ(azimuths(peaked.samples), azimuths(smooth.samples));
}

TEST(Verify, ShowsWhereAnOceanMirrorsTheSunAtGrazingAngles) {
    Recipe recipe = explicit_recipe();
    recipe.lower_boundary = LowerBoundary::ground(read_ground_law("ocean:wind=9"));
    recipe.transmission = false;
    const Verification smooth = verify(solve_table(recipe), {.samples = 400});
    EXPECT_GT(smooth.forward.size(), 190u);
    EXPECT_EQ(smooth.grazing.size(), 100u);
    EXPECT_FALSE(smooth.judges_forward || smooth.judges_grazing);

    recipe.phase_function = PhaseFunction::henyey_greenstein(0.8);
    recipe.phase_text = recipe.phase_function.text();
    const Verification peaked = verify(solve_table(recipe), {.samples = 400});
    EXPECT_TRUE(peaked.judges_forward && peaked.judges_grazing);
}

TEST(Verify, LeavesNoWideGapsBetweenAlbedosAndDepths) {
    const Table table = bake(explicit_recipe());
    for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
        std::set<double> of_albedo, of_depth;  // shares of the way along the axes, 0 and 1 the same
        const Verification verification = verify(table, {.samples = 1200, .seed = seed});
        for (const ErrorSample& sample : verification.samples) {
            const auto add = [](std::set<double>& shares, double value) {
                shares.insert(std::round(1e9 * (value - std::floor(value))) / 1e9);
            };
            add(of_albedo, std::sqrt(1 - sample.albedo) / 0.5);
            add(of_depth, std::log2(sample.optical_depth / 0.5));
        }
        for (const std::set<double>& shares : {of_albedo, of_depth}) {
            EXPECT_GE(shares.size(), 10u);
            double before = *shares.rbegin() - 1;
            for (const double share : shares) {
                EXPECT_LE(share - before, 2 / static_cast<double>(shares.size())) << seed;
                before = share;
            }
        }
    }
}

TEST(Verify, SeesFourTimesAsManyMembersOfAFamilyOfTwoAxes) {
    const auto members_of = [](const std::string& family) {
        const Table table = solve_table(parse_recipe(
            "phase_function = 'henyey_greenstein:g=0.2'\nsecond_phase_function = 'rayleigh'\n"
            "tolerance = 1e-2\noptical_depth = { min = 0.5, max = 2.0 }\n"
            "albedo = { min = 0.5, max = 1.0 }\n[family]\nmixture = [0.0, 1.0]\n" +
            family +
            "[discretisation]\nnodes = 4\nmodes = 3\nmu_samples = 4\nazimuth_samples = 3\n"
            "optical_depth_samples_per_octave = 5\nalbedo_samples = 8\nmixture_samples = 4\n" +
            (family.empty() ? "" : "g_samples = 2\n")));
        const Verification verification = verify(table, {.samples = 960});
        EXPECT_EQ(verification.samples.size(), 1920u);
        std::set<double> mixtures;
        for (const ErrorSample& sample : verification.samples) mixtures.insert(sample.member[0]);
        return mixtures.size();
    };
    const std::size_t alone = members_of(""), of_two_axes = members_of("g = [0.0, 0.3]\n");
    EXPECT_GE(alone, 15u);
    EXPECT_GE(of_two_axes, 4 * alone - 4);
}

TEST(Verify, DependsOnTheSeedButNotOnThreads) {
    const Table table = bake(explicit_recipe());
    VerifyOptions options{.samples = 200, .threads = 1};
    const Verification one = verify(table, options);
    options.threads = 3;
    const Verification three = verify(table, options);
    ASSERT_EQ(one.samples.size(), three.samples.size());
    for (const auto n : indices(one.samples))
        EXPECT_EQ(one.samples[n].error, three.samples[n].error);
    options.seed = 2;
    EXPECT_NE(verify(table, options).samples.back().error, one.samples.back().error);
}

TEST(Verify, ReportsProgressUpToTheEnd) {
    double last = 0;
    VerifyOptions options;
    options.samples = 50;
    options.progress = [&](double done) {
        EXPECT_GT(done, last);
        last = done;
    };
    verify(bake(explicit_recipe()), options);
    EXPECT_EQ(last, 1);
}

TEST(Verify, RefusesZeroSamples) {
    const Table table = bake(explicit_recipe());
    expect_refusal([&] { verify(table, {.samples = 0}); }, {"verify", "samples", ">= 1", "got 0"});
}

/// A table good to 1e-3: one percent of its higher orders is a difference that must show.
Table fine_table() {
    return bake(
        parse_recipe("phase_function = 'isotropic'\n"
                     "tolerance = 1e-3\n"
                     "optical_depth = { min = inf, max = inf }\n"
                     "albedo = { min = 0.5, max = 1.0 }\n"
                     "sides = ['reflection']\n"));
}

TEST(Verify, PassesAFreshTable) {
    const Verification verification = verify(fine_table());
    EXPECT_TRUE(verification.meets(1e-3));
    EXPECT_LE(verification.furnace_defect, 1e-3);
}

TEST(Verify, DetectsAOnePercentError) {
    Table table = fine_table();
    const std::size_t block = block_size(table), from = table.albedo.values.size() / 2 * block;
    for (std::size_t n = from; n < from + block; ++n) table.reflection_multiple[n] *= 1.01F;
    EXPECT_FALSE(verify(table).meets(1e-3));
}

TEST(Verify, DetectsInconsistentFluxes) {
    Table table = fine_table();
    for (float& albedo : table.plane_albedo) albedo *= 1.05F;
    const Verification verification = verify(table, {.samples = 50});
    EXPECT_GT(verification.furnace_defect, 1e-2);
    EXPECT_GT(verification.energy_defect, 1e-3);
    EXPECT_FALSE(verification.meets(1e-3));
}

TEST(Verify, SkipsEnergyWhereEveryLayerAbsorbs) {
    Recipe recipe = explicit_recipe();
    recipe.albedo = {0.75, 0.9};
    EXPECT_EQ(verify(bake(recipe), {.samples = 50}).energy_defect, -1);
}

}  // namespace
}  // namespace stratus::test
