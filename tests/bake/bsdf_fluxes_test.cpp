// BSDFs of baked tables: what they scatter in all against the fluxes that the solver worked out.
#include <stratus/bake/bake.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>

#include "bsdf_estimate.h"
#include "indices.h"
#include "water_cloud.h"

#include <gtest/gtest.h>

#include <string>

namespace stratus {
namespace {

/// Mean of eval * cos / pdf, and `albedo`, of a table of one layer against its fluxes, at each of
/// its cosines.
void expect_fluxes(const Table& table, double tolerance, double largest_deviation) {
    const Bsdf bsdf(bind(table.view(), table.optical_depth.values[0], table.albedo.values[0]));
    for (const auto i : indices(table.mu_in.values)) {
        const double mu = table.mu_in.values[i];
        const double R = double{table.plane_albedo[i]};
        const double T =
            table.diffuse_transmittance.empty() ? 0 : double{table.diffuse_transmittance[i]};
        const Vector wi = direction(mu, 1, true);
        const ScatteredShares<float> shares = bsdf.albedo(wi);
        EXPECT_NEAR(shares.reflected, R, tolerance) << "mu_in " << mu;
        EXPECT_NEAR(shares.transmitted, T, tolerance) << "mu_in " << mu;
        const Estimate estimate = estimated(bsdf, wi, 1 << 15);
        EXPECT_NEAR(estimate.reflected, R, tolerance) << "mu_in " << mu;
        EXPECT_NEAR(estimate.transmitted, T, tolerance) << "mu_in " << mu;
        EXPECT_LT(estimate.deviation, largest_deviation) << "mu_in " << mu;
    }
}

/// One layer, which bakes in a moment.
Recipe layer_recipe(const char* phase, const char* depth, const char* albedo,
                    const std::string& rest = "") {
    const auto range = [](const char* name, const std::string& value) {
        return name + (" = { min = " + value) + ", max = " + value + " }\n";
    };
    return parse_recipe("phase_function = '" + std::string(phase) + "'\ntolerance = 1e-3\n" +
                        range("optical_depth", depth) + range("albedo", albedo) + rest);
}

TEST(BsdfOfTable, ReflectsAndTransmitsTheTableFluxes) {
    expect_fluxes(bake(layer_recipe("henyey_greenstein:g=0.6", "1.0", "0.95")), 1e-3, 0.12);
    expect_fluxes(bake(layer_recipe("rayleigh", "0.1", "1.0")), 1e-3, 0.12);
    expect_fluxes(bake(layer_recipe("isotropic", "8.0", "1.0")), 1e-3, 0.12);
}

/// Deep enough for light of all orders, with the peak of what is scattered forward alone on top.
TEST(BsdfOfTable, FollowsThePeakOfACloud) {
    Recipe recipe = layer_recipe("isotropic", "8.0", "1.0",
                                 "[discretisation]\nnodes = 24\nmodes = 24\nmu_samples = 24\n"
                                 "azimuth_samples = 33\nscheme = 'harmonic'\n");
    recipe.phase_function = water_cloud();
    const Table table = bake(recipe);
    const Bsdf bsdf(bind(table.view(), 8, 1));
    for (const double mu : {0.05, 0.1, 0.3, 0.6, 1.0}) {
        const Vector wi = direction(mu, 1, true);
        const Estimate estimate = estimated(bsdf, wi, 1 << 17);
        const ScatteredShares<float> shares = bsdf.albedo(wi);
        EXPECT_LT(estimate.deviation, 0.15) << "mu_in " << mu;
        EXPECT_NEAR(estimate.reflected, shares.reflected, 1e-3) << "mu_in " << mu;
        EXPECT_NEAR(estimate.transmitted, shares.transmitted, 1e-3) << "mu_in " << mu;
    }
}

TEST(BsdfOfTable, ReflectsThePlaneAlbedoOverGround) {
    const Table table = bake(
        layer_recipe("henyey_greenstein:g=0.5", "1.0", "0.95", "[below]\nlambert_albedo = 0.3\n"));
    expect_fluxes(table, 1e-3, 0.1);
    const Bsdf bsdf(bind(table.view(), 1, 0.95));
    const Vector from_below = direction(0.5, 1, false);
    EXPECT_EQ(bsdf.sample(from_below, 0.3f, 0.3f, 0.3f).pdf, 0);
    EXPECT_EQ(bsdf.pdf(from_below, direction(0.5, 1, true)), 0);
    EXPECT_EQ(bsdf.albedo(from_below).reflected, 0);
    EXPECT_EQ(bsdf.pdf(direction(0.5, 1, true), from_below), 0);
}

TEST(BsdfOfTable, ConservesEnergyInAWhiteFurnace) {
    for (const char* const phase : {"isotropic", "henyey_greenstein:g=0.5"}) {
        const Table table = bake(layer_recipe(phase, "inf", "1.0", "sides = ['reflection']\n"));
        const Bsdf bsdf(bind(table.view(), infinity, 1));
        for (double mu = 0.01; mu <= 1; mu += mu < 0.1 ? 0.01 : 0.05) {
            const Vector wi = direction(std::min(mu, 1.0), 1, true);
            EXPECT_NEAR(bsdf.albedo(wi).reflected, 1, 2e-3) << phase << " mu_in " << mu;
            EXPECT_NEAR(estimated(bsdf, wi, 1 << 15).reflected, 1, 2e-3)
                << phase << " mu_in " << mu;
        }
        EXPECT_NEAR(bsdf.albedo(1.0f).reflected, 1, 2e-3) << phase;
    }
}

TEST(SliceOfTable, SeesABackgroundByWhatIsNotReflected) {
    // tau = 1, w = 1: 29.7 by the formula of [Blinn82] 2.5 at g = 0.85
    for (const char* const phase : {"isotropic", "henyey_greenstein:g=0.85"}) {
        const Table table = bake(layer_recipe(phase, "1.0", "1.0"));
        const Slice slice = bind(table.view(), 1, 1);
        for (const auto i : indices(table.mu_in.values))
            EXPECT_NEAR(slice.background(static_cast<float>(table.mu_in.values[i])),
                        1 - double{table.plane_albedo[i]}, 1e-4)
                << phase << " mu " << table.mu_in.values[i];
    }
}

}  // namespace
}  // namespace stratus
