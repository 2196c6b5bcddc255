// BSDFs of baked tables: what they scatter in all against the fluxes that the solver worked out.
#include <stratus/runtime/bsdf.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include <stratus/bake/bake.h>

#include "bsdf_estimate.h"

namespace stratus {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Mean of eval * cos / pdf, and `albedo`, at every cosine of the table against its fluxes.
void expect_fluxes(const Table& table, std::size_t albedo, std::size_t depth, double tolerance,
                   double largest_deviation) {
    const Bsdf bsdf(
        table.view().bind(table.optical_depth.values[depth], table.albedo.values[albedo]));
    const std::size_t cosines = table.mu_in.values.size();
    const std::size_t first = (albedo * table.optical_depth.values.size() + depth) * cosines;
    for (std::size_t i = 0; i < cosines; ++i) {
        const double mu = table.mu_in.values[i];
        const double R = double{table.plane_albedo[first + i]};
        const double T = table.diffuse_transmittance.empty()
                             ? 0
                             : double{table.diffuse_transmittance[first + i]};
        const Vector wi = direction(mu, 1, true);
        const ScatteredShares<float> shares = bsdf.albedo(wi);
        EXPECT_NEAR(shares.reflected, R, tolerance) << "mu_in " << mu;
        EXPECT_NEAR(shares.transmitted, T, tolerance) << "mu_in " << mu;
        const Estimate estimate = estimated(bsdf, wi, 1 << 13);
        EXPECT_NEAR(estimate.reflected, R, tolerance) << "mu_in " << mu;
        EXPECT_NEAR(estimate.transmitted, T, tolerance) << "mu_in " << mu;
        EXPECT_LT(estimate.deviation, largest_deviation) << "mu_in " << mu;
    }
}

TEST(BsdfOfTable, ScattersWhatTheTableSaysIsScattered) {
    const Table table = bake(parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.6'\ntolerance = 1e-3\n"
        "optical_depth = { min = 0.5, max = 2.0 }\nalbedo = { min = 0.9, max = 1.0 }\n"));
    for (const std::size_t albedo : {std::size_t{0}, table.albedo.values.size() - 1})
        for (const std::size_t depth : {std::size_t{0}, table.optical_depth.values.size() - 1})
            expect_fluxes(table, albedo, depth, 1e-3, 0.12);
}

TEST(BsdfOfTable, ScattersWhatCloudAndGroundSendBack) {
    const Table table = bake(parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.5'\ntolerance = 1e-3\n"
        "optical_depth = { min = 1.0, max = 1.0 }\nalbedo = { min = 0.95, max = 0.95 }\n"
        "[below]\nlambert_albedo = 0.3\n"));
    expect_fluxes(table, 0, 0, 1e-3, 0.1);
    const Bsdf bsdf(table.view().bind(1, 0.95));
    const Vector from_below = direction(0.5, 1, false);
    EXPECT_EQ(bsdf.sample(from_below, 0.3f, 0.3f, 0.3f).pdf, 0);
    EXPECT_EQ(bsdf.pdf(from_below, direction(0.5, 1, true)), 0);
    EXPECT_EQ(bsdf.albedo(from_below).reflected, 0);
    EXPECT_EQ(bsdf.pdf(direction(0.5, 1, true), from_below), 0);
}

TEST(BsdfOfTable, LosesNoLightInAWhiteFurnace) {
    for (const char* const phase : {"isotropic", "henyey_greenstein:g=0.75"}) {
        const Table table = bake(parse_recipe(std::string("phase_function = '") + phase +
                                              "'\ntolerance = 1e-3\n"
                                              "optical_depth = { min = inf, max = inf }\n"
                                              "albedo = { min = 1.0, max = 1.0 }\n"));
        const Bsdf bsdf(table.view().bind(infinity, 1));
        for (double mu = 0.01; mu <= 1; mu += mu < 0.1 ? 0.01 : 0.05) {
            const Vector wi = direction(std::min(mu, 1.0), 1, true);
            EXPECT_NEAR(bsdf.albedo(wi).reflected, 1, 2e-3) << phase << " mu_in " << mu;
            EXPECT_NEAR(estimated(bsdf, wi, 1 << 13).reflected, 1, 2e-3)
                << phase << " mu_in " << mu;
        }
        EXPECT_NEAR(bsdf.albedo(1.0f).reflected, 1, 2e-3) << phase;
    }
}

}  // namespace
}  // namespace stratus
