#include <stratus/material/material.h>
#include <stratus/transfer/reference/solvers.h>

#include "fourier_reader.h"
#include "indices.h"
#include "material_check.h"
#include "refusal.h"
#include "row_name.h"
#include "solved_stack.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus::test {
namespace {

FourierReader table_of(const Material& material) {
    return FourierReader(written(material, MaterialFormat::fourier));
}

Stack cloud_in_haze() {
    return {{{parse_phase_function("rayleigh"), 1, 0.2},
             {parse_phase_function("henyey_greenstein:g=0.7"), 0.98, 2}},
            {}};
}

/// Reflection is at mu_o mu_i < 0, mu_i being of the propagation.
double reflected(const FourierReader& table, const Geometry& at, std::size_t colour = 0) {
    return pi * table(at.mu_out, -at.mu_in, at.azimuth)[colour];
}

double reflected_below(const FourierReader& table, const Geometry& at) {
    return pi * table(-at.mu_out, at.mu_in, at.azimuth)[0];
}

double transmitted(const FourierReader& table, const Geometry& at, std::size_t colour = 0) {
    return pi * table(-at.mu_out, -at.mu_in, at.azimuth)[colour];
}

/// Lit from below, leaving above.
double transmitted_up(const FourierReader& table, const Geometry& at) {
    return pi * table(at.mu_in, at.mu_out, at.azimuth)[0];
}

struct Case {
    const char* name;
    Stack stack;
};

class FourierFile : public testing::TestWithParam<Case> {};

// The format's own reader is within 0.1 % in the median and 0.5 % for 99 % of all pairs.
TEST_P(FourierFile, IsTheSolverAtRandomPairs) {
    const Stack& stack = GetParam().stack;
    const FourierReader table = table_of({{stack}, ""});
    Errors R, R_below, T, T_up;
    const bool transparent =
        !stack.lower_boundary.is_present() && !std::isinf(stack.layers.back().optical_depth);
    for (const Expected& expected : random_geometries(stack, 500, 0.01)) {
        R.add(reflected(table, expected.geometry), expected.reflection);
        if (!transparent) {
            EXPECT_EQ(transmitted(table, expected.geometry), 0);
            EXPECT_EQ(reflected_below(table, expected.geometry), 0);
            continue;
        }
        R_below.add(reflected_below(table, expected.geometry), expected.reflection_below);
        T.add(transmitted(table, expected.geometry), expected.transmission);
        T_up.add(transmitted_up(table, expected.geometry), expected.transmission);
    }
    for (Errors* errors : {&R, &R_below, &T, &T_up}) {
        if (errors != &R && !transparent) continue;
        EXPECT_LE(errors->quantile(0.5), 1e-3);
        EXPECT_LE(errors->quantile(0.99), 5e-3);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Layers, FourierFile,
    testing::ValuesIn<Case>(
        {{"thin", layer("rayleigh", 1, 0.1)},
         {"forward", layer("henyey_greenstein:g=0.5", 0.9, 1)},
         {"peaked", layer("henyey_greenstein:g=0.85", 1, 1)},
         {"deep", layer("henyey_greenstein:g=0.85", 0.999, 100)},
         {"endless", layer("henyey_greenstein:g=0.5", 0.9, infinity)},
         {"rings",
          layer("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5", 0.95, 1.5)},
         {"over_ground", over(layer("henyey_greenstein:g=0.7", 0.95, 0.5), 0.3)},
         {"stack", cloud_in_haze()},
         {"stack_over_ground", over(cloud_in_haze(), 0.5)}}),
    row_name);

// Another way to the same numbers, which knows no solver: forward and back, up and down.
TEST(FourierTable, IsWhatPhotonsTell) {
    const PhaseFunction phase = parse_phase_function("henyey_greenstein:g=0.5");
    const FourierReader table = table_of({{{{{phase, 0.9, 1}}, {}}}, ""});
    const std::vector<Geometry> geometries{{0.6, 0.8, 0.1}, {0.6, 0.3, 2.9}, {0.6, 0.5, 1.6}};
    const PhotonSolution photons = solve_photons(phase, 0.9, 1, geometries, {.photons = 200'000});
    for (const auto k : indices(geometries)) {
        const PhotonValue &R = photons.geometries[k].reflection,
                          &T = photons.geometries[k].transmission;
        EXPECT_NEAR(reflected(table, geometries[k]), R.value.total, 4 * R.standard_error);
        EXPECT_NEAR(transmitted(table, geometries[k]), T.value.total, 4 * T.standard_error);
    }
}

TEST(FourierTable, LosesNoLightInAWhiteFurnace) {
    for (const double depth : {0.1, 1.0, 30.0}) {
        const FourierReader table = table_of({{layer("henyey_greenstein:g=0.75", 1, depth)}, ""});
        for (double mu = 0.02; mu <= 1; mu += 0.049) {
            EXPECT_NEAR(table.albedo(mu) + std::exp(-depth / mu), 1, 2e-4) << depth << ' ' << mu;
            EXPECT_NEAR(table.albedo(-mu) + std::exp(-depth / mu), 1, 2e-4) << depth << ' ' << mu;
        }
    }
    const FourierReader endless = table_of({{layer("rayleigh", 1, infinity)}, ""});
    const FourierReader over_white = table_of({{over(layer("rayleigh", 1, 0.3), 1)}, ""});
    for (double mu = 0.02; mu <= 1; mu += 0.049) {
        EXPECT_NEAR(endless.albedo(mu), 1, 2e-4);
        EXPECT_NEAR(over_white.albedo(mu), 1, 2e-4);
    }
}

// The integrals in the file are those of what a renderer evaluates.
TEST(FourierTable, IntegralsInTheFileAreThoseOfItsValues) {
    const FourierReader table = table_of({{layer("henyey_greenstein:g=0.5", 1, 1)}, ""});
    for (const double mu_o : {0.1, 0.5, 0.93})
        EXPECT_NEAR(sent_out([&](double mu, double azimuth) {
                        return pi * (table(mu_o, mu, azimuth)[0] + table(mu_o, -mu, azimuth)[0]);
                    }),
                    table.albedo(mu_o), 1e-4);
}

// The renderer's sampler does not end where a mean is above some 16.
TEST(FourierTable, KeepsMeansAtMostEight) {
    float largest = 0;
    for (const Stack& stack : {layer("henyey_greenstein:g=0.85", 1, 1), layer("isotropic", 1, 0.01),
                               layer("henyey_greenstein:g=0.95", 1, 12)}) {
        const FourierReader table = table_of({{stack}, ""});
        for (const auto o : indices(table.mu))
            for (const auto i : indices(table.mu)) {
                largest = std::max(largest, table.mean(o, i));
                EXPECT_GE(table.mean(o, i), 0);
            }
    }
    EXPECT_LE(largest, 8);
    EXPECT_GT(largest, 0.5);
}

TEST(FourierTable, RefusesAPeakThatItsSamplerCannotDraw) {
    expect_refusal(
        [] {
            make_material({{layer("henyey_greenstein:g=0.97", 1, 1)}, ""}, MaterialFormat::fourier);
        },
        "at most 8, got ");
}

void expect_colours(const Material& material) {
    const FourierReader table = table_of(material);
    ASSERT_EQ(table.channels, 3);
    for (const auto colour : three_channels) {
        Errors R, T;
        for (const Expected& at : random_geometries(material.colours[colour], 200, 0.01)) {
            R.add(reflected(table, at.geometry, colour), at.reflection);
            T.add(transmitted(table, at.geometry, colour), at.transmission);
        }
        EXPECT_LE(R.quantile(0.5), 1e-3);
        EXPECT_LE(R.quantile(0.99), 5e-3);
        EXPECT_LE(T.quantile(0.5), 1e-3);
        EXPECT_LE(T.quantile(0.99), 5e-3);
    }
}

TEST(FourierTable, HoldsRedGreenAndBlue) {
    expect_colours({{layer("henyey_greenstein:g=0.3", 0.95, 2), layer("rayleigh", 0.8, 1),
                     layer("isotropic", 0.5, 0.5)},
                    ""});
}

TEST(FourierTable, HoldsADarkGreenBesideBrightColours) {
    expect_colours(
        {{layer("rayleigh", 1, 0.3), layer("rayleigh", 5e-4, 0.3), layer("rayleigh", 1, 0.3)}, ""});
}

TEST(FourierTable, HasTheLayoutThatReadersExpect) {
    const FourierReader table = table_of({{layer("henyey_greenstein:g=0.5", 0.9, 1)}, "A layer"});
    EXPECT_EQ(table.mu.front(), -1);
    EXPECT_EQ(table.mu.back(), 1);
    const std::size_t half = table.mu.size() / 2;
    EXPECT_TRUE(table.mu[half - 1] == 0 && std::signbit(table.mu[half - 1]));
    EXPECT_TRUE(table.mu[half] == 0 && !std::signbit(table.mu[half]));
    EXPECT_LE(table.mu[half + 1], 1e-3f);
    for (std::size_t k = 1; k < table.mu.size(); ++k)
        if (k != half) {
            EXPECT_LT(table.mu[k - 1], table.mu[k]);
        }
    for (const auto o : indices(table.mu)) {
        EXPECT_EQ(table.cdf[o * table.mu.size()], 0);
        for (std::size_t i = 1; i < table.mu.size(); ++i)
            EXPECT_GE(table.cdf[o * table.mu.size() + i], table.cdf[o * table.mu.size() + i - 1]);
    }
    // not zero but the limit for light that leaves along the surface
    EXPECT_NEAR(table.mean(half, half - 20), table.mean(half + 1, half - 20),
                0.05f * table.mean(half, half - 20));
    EXPECT_GT(table.mean(half, half - 20), 0);
    expect_holds(table.text, {"A layer", "Without the beam"});
}

// The peaks of droplets, straight on and straight back, are narrower than the steps between cosines.
TEST(FourierTable, TellsWhereItsSplinesAreOffByMoreThanTheTolerance) {
    const Material cloud{{layer("mie:radius=6um,variance=0.1,wavelength=0.55um", 1, 8)}, ""};
    MaterialOptions options;
    options.tolerance = 5e-3;
    const std::vector<std::string> said =
        make_material(cloud, MaterialFormat::fourier, options).notes;
    ASSERT_EQ(said.size(), 2);
    double told_R = 0, told_T = 0;
    ASSERT_EQ(
        std::sscanf(said[1].c_str(),
                    "between the file's cosines readers are off by up to %lf %% of R, %lf %% of T",
                    &told_R, &told_T),
        2)
        << said[1];
    const FourierReader table = table_of(cloud);
    Errors R, T;
    for (const double mu : {0.31, 0.57, 0.75, 0.9}) {
        const SolvedStack exact(cloud.colours[0], {mu, 0.8}, 64);
        for (const double azimuth : {0.0, 0.02, 0.1, 1.0, 3.0, pi}) {
            R.add(reflected(table, {mu, mu, azimuth}),
                  exact.values(LitSide::reflection, 0, 0, {azimuth})[0].total);
            T.add(transmitted(table, {mu, mu, azimuth}),
                  exact.values(LitSide::transmission, 0, 0, {azimuth})[0].total);
        }
    }
    EXPECT_GT(T.quantile(1), 0.01);
    EXPECT_LE(T.quantile(1), 1.2 * told_T / 100);
    EXPECT_LE(R.quantile(1), 1.2 * told_R / 100);
}

TEST(FourierTable, TellsThatTheBeamIsNotInIt) {
    const auto notes = [](const Stack& stack) {
        return make_material({{stack}, ""}, MaterialFormat::fourier).notes;
    };
    ASSERT_EQ(notes(layer("isotropic", 1, 0.5)).size(), 1);
    expect_holds(notes(layer("isotropic", 1, 0.5))[0], "tau = 0.5");
    EXPECT_TRUE(notes(layer("isotropic", 1, infinity)).empty());
    EXPECT_TRUE(notes(over(layer("isotropic", 1, 0.5), 0.2)).empty());
}

}  // namespace
}  // namespace stratus::test
