#include <stratus/material/material.h>
#include <stratus/table/member_and_ground.h>

#include "indices.h"
#include "material_check.h"
#include "refusal.h"
#include "row_name.h"
#include "solved_stack.h"
#include "tensor_reader.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus::test {
namespace {

TensorReader table_of(const Material& material, MaterialFormat format = MaterialFormat::tensor) {
    return TensorReader(written(material, format));
}

double reflected(const TensorReader& table, const Geometry& at, std::size_t band = 0) {
    return pi * table(at.mu_out, at.mu_in, pi - at.azimuth, band);
}

/// The lines of 96 x 96 half vectors are within 0.1 % in the median and 1 % for 99 % of all pairs
/// 8.6 degrees above the horizon or more.
constexpr double away_from_horizon = 0.15;

void expect_close(const TensorReader& table, const Stack& stack, std::size_t band, int count) {
    Errors errors;
    for (const Expected& at : random_geometries(stack, count, away_from_horizon))
        errors.add(reflected(table, at.geometry, band), at.reflection);
    EXPECT_LE(errors.quantile(0.5), 1e-3);
    EXPECT_LE(errors.quantile(0.99), 1e-2);
}

struct Case {
    const char* name;
    Stack stack;
};

class TensorFile : public testing::TestWithParam<Case> {};

TEST_P(TensorFile, IsTheSolverAtRandomPairs) {
    const Stack& stack = GetParam().stack;
    expect_close(table_of({{stack}, ""}), stack, 0, 500);
}

INSTANTIATE_TEST_SUITE_P(
    Layers, TensorFile,
    testing::ValuesIn<Case>(
        {{"thin", layer("rayleigh", 1, 0.1)},
         {"forward", layer("henyey_greenstein:g=0.5", 0.9, 1)},
         {"peaked", layer("henyey_greenstein:g=0.85", 1, 1)},
         {"endless", layer("henyey_greenstein:g=0.5", 0.9, infinity)},
         {"over_sea", {layer("rayleigh", 1, 0.2).layers, read_ground("ocean:wind=5")}},
         {"stack_over_ground", over({{{parse_phase_function("rayleigh"), 1, 0.2},
                                      {parse_phase_function("henyey_greenstein:g=0.7"), 0.98, 2}},
                                     {}},
                                    0.5)}}),
    row_name);

double albedo_of(const TensorReader& table, double mu_o) {
    return sent_out([&](double mu, double azimuth) { return pi * table(mu_o, mu, azimuth); });
}

TEST(TensorTable, LosesNoLightInAWhiteFurnace) {
    const TensorReader endless = table_of({{layer("henyey_greenstein:g=0.5", 1, infinity)}, ""});
    const TensorReader over_white = table_of({{over(layer("rayleigh", 1, 0.5), 1)}, ""});
    for (const TensorReader* table : {&endless, &over_white}) {
        EXPECT_NEAR(albedo_of(*table, 0.06), 1, 4e-4);
        for (const double mu : {0.1, 0.2, 0.37, 0.5, 0.71, 0.9, 0.99})
            EXPECT_NEAR(albedo_of(*table, mu), 1, 2e-4) << mu;
    }
}

// What directions are drawn by is f cos, so that a weight f cos / pdf is nearly the albedo.
TEST(TensorTable, IsDrawnInProportionToItsLight) {
    const TensorReader table = table_of({{layer("henyey_greenstein:g=0.5", 1, infinity)}, ""});
    for (const double mu_o : {0.4, 0.9})
        for (const double mu_i : {0.3, 0.6, 0.95})
            for (const double azimuth : {0.2, 1.5, 3.0}) {
                const double weight =
                    table(mu_o, mu_i, azimuth) * mu_i / table.pdf(mu_o, mu_i, azimuth);
                EXPECT_NEAR(weight, 1, 0.1) << mu_o << ' ' << mu_i << ' ' << azimuth;
            }
}

/// Light within 2 degrees of the horizon: the fewer samples lie between, the coarser.
TEST(TensorTable, IsCloseToTheSolverInGrazingLight) {
    for (const Stack& stack :
         {layer("henyey_greenstein:g=0.5", 1, 1), layer("henyey_greenstein:g=0.85", 1, 0.1)}) {
        const TensorReader table = table_of({{stack}, ""});
        const std::vector<double> mu{0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9};
        const double largest_median[] = {0.2, 0.1, 0.07, 0.06};
        const SolvedStack exact(stack, mu, 64);
        for (int in = 0; in < 4; ++in) {
            Errors errors;
            for (int out = 4; out < static_cast<int>(mu.size()); ++out)
                for (int k = 1; k < 36; ++k) {
                    const Geometry at{mu[static_cast<std::size_t>(in)],
                                      mu[static_cast<std::size_t>(out)], k * pi / 36};
                    errors.add(reflected(table, at),
                               exact.values(LitSide::reflection, in, out, {at.azimuth})[0].total);
                }
            EXPECT_LE(errors.quantile(0.5), largest_median[in]) << mu[static_cast<std::size_t>(in)];
            EXPECT_LE(errors.quantile(1), 0.9) << mu[static_cast<std::size_t>(in)];
        }
    }
}

TEST(TensorTable, IsNegativeNowhereAboveTheHorizon) {
    for (const double depth : {0.1, 1.0}) {
        const TensorReader table = table_of({{layer("henyey_greenstein:g=0.85", 1, depth)}, ""},
                                            MaterialFormat::tensor_rgb);
        for (const double mu_in : {1e-4, 1e-3, 5e-3, 0.02})
            for (int out = 1; out < 400; ++out)
                for (int k = 0; k <= 60; ++k)
                    ASSERT_GE(table(out / 400.0, mu_in, k * pi / 60), 0)
                        << depth << ' ' << mu_in << ' ' << out / 400.0 << ' ' << k * 3;
    }
}

TEST(TensorTable, HoldsRedGreenAndBlueInEitherForm) {
    const Material material{{layer("henyey_greenstein:g=0.3", 0.95, 2), layer("rayleigh", 0.8, 1),
                             layer("isotropic", 0.5, 0.5)},
                            ""};
    const TensorReader rgb = table_of(material, MaterialFormat::tensor_rgb);
    const TensorReader spectral = table_of(material);
    EXPECT_EQ(rgb.fields.count("spectra"), 0);
    EXPECT_EQ(rgb.fields.count("wavelengths"), 0);
    EXPECT_EQ(spectral.fields.count("rgb"), 0);
    const std::vector<float>& wavelengths = spectral.fields.at("wavelengths").values;
    EXPECT_EQ(wavelengths, (std::vector<float>{473, 503, 575, 605}));
    const std::size_t bands[] = {3, 1, 0};
    for (const auto colour : three_channels) {
        expect_close(rgb, material.colours[colour], colour, 100);
        expect_close(spectral, material.colours[colour], bands[colour], 100);
    }
    const TensorReader grey = table_of({{material.colours[1]}, ""}, MaterialFormat::tensor_rgb);
    for (const auto colour : three_channels) expect_close(grey, material.colours[1], colour, 100);
}

/// XYZ at a wavelength in nm: fits of CIE 1931 by Wyman, Sloan and Shirley, JCGT 2 (2013).
std::array<double, 3> colour_matching(double wavelength) {
    const auto lobe = [&](double height, double middle, double below, double above) {
        const double t = (wavelength - middle) * (wavelength < middle ? below : above);
        return height * std::exp(-t * t / 2);
    };
    return {lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(0.362, 442, 0.0624, 0.0374) +
                lobe(-0.065, 501.1, 0.049, 0.0382),
            lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
            lobe(1.217, 437, 0.0845, 0.0278) + lobe(0.681, 459, 0.0385, 0.0725)};
}

// Under D65, in sRGB, scaled so that white is seen as white.
TEST(TensorTable, IsSeenInTheColoursThatWereAskedFor) {
    const Material material{
        {layer("isotropic", 0.9, 1), layer("isotropic", 0.6, 1), layer("isotropic", 0.3, 1)}, ""};
    const TensorReader table = table_of(material),
                       rgb = table_of(material, MaterialFormat::tensor_rgb);
    const std::vector<float>& bands = table.fields.at("wavelengths").values;
    const double daylight[] = {50.0,  82.8,  93.4,  104.9, 117.8, 115.9, 109.4,
                               104.8, 104.4, 100.0, 95.8,  90.0,  87.7,  83.7,
                               80.2,  78.3,  71.6,  61.6,  75.1,  46.4,  63.4};
    const double to_srgb[3][3] = {
        {3.2405, -1.5371, -0.4985}, {-0.9693, 1.876, 0.0416}, {0.0556, -0.204, 1.0572}};
    double asked[3] = {}, seen[3][3] = {};  // seen: over (primary, colour asked for)
    for (const auto c : three_channels) asked[c] = rgb(0.6, 0.4, 1, c);
    for (int k = 0; k <= 400; ++k) {
        const double wavelength = 380 + k, place = std::min(k / 20.0, 19.999);
        const auto day = static_cast<std::size_t>(place);
        const double light = std::lerp(daylight[day], daylight[day + 1], place - std::floor(place));
        const auto xyz = colour_matching(wavelength);
        std::size_t next = 0;
        while (next < bands.size() && static_cast<double>(bands[next]) < wavelength) ++next;
        const std::size_t ends[] = {next == 0 ? 0 : next - 1, std::min(next, bands.size() - 1)};
        const double before = static_cast<double>(bands[ends[0]]),
                     after = static_cast<double>(bands[ends[1]]);
        const double share = after > before ? (wavelength - before) / (after - before) : 0;
        for (std::size_t e = 0; e < 2; ++e)
            for (const auto c : three_channels) {
                if (std::abs(table(0.6, 0.4, 1, ends[e]) / asked[c] - 1) > 1e-6) continue;
                for (std::size_t p = 0; p < 3; ++p)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        seen[p][c] +=
                            to_srgb[p][axis] * xyz[axis] * light * (e == 0 ? 1 - share : share);
            }
    }
    for (std::size_t p = 0; p < 3; ++p)
        for (const auto c : three_channels)
            EXPECT_NEAR(seen[p][c] / (seen[p][0] + seen[p][1] + seen[p][2]), p == c, 0.042)
                << p << ' ' << c;
}

TEST(TensorTable, HasTheShapesThatReadersExpect) {
    const TensorReader table = table_of({{layer("isotropic", 0.9, 1)}, "A layer"});
    const auto shape = [&](const char* name) { return table.fields.at(name).shape; };
    using Shape = std::vector<std::size_t>;
    EXPECT_EQ(shape("theta_i"), (Shape{96}));
    EXPECT_EQ(shape("phi_i"), (Shape{1}));
    EXPECT_EQ(shape("ndf"), (Shape{2, 2}));
    EXPECT_EQ(shape("sigma"), (Shape{2, 2}));
    EXPECT_EQ(shape("vndf"), (Shape{1, 96, 2, 2}));
    EXPECT_EQ(shape("luminance"), (Shape{1, 96, 96, 96}));
    EXPECT_EQ(shape("spectra"), (Shape{1, 96, 1, 96, 96}));
    EXPECT_EQ(table.fields.at("jacobian").text, std::string(1, '\1'));
    expect_holds(table.fields.at("description").text, "A layer");
    for (const float value : table.fields.at("luminance").values) ASSERT_GT(value, 0);
}

TEST(TensorTable, TellsWhatIsNotInIt) {
    const auto notes = [](const Stack& stack) {
        return make_material({{stack}, ""}, MaterialFormat::tensor).notes;
    };
    const std::vector<std::string> said = notes(layer("isotropic", 1, 0.5));
    ASSERT_EQ(said.size(), 2);
    expect_holds(said[0], "beam");
    expect_holds(said[1], "transmission");
    EXPECT_TRUE(notes(over(layer("isotropic", 1, 0.5), 0.2)).empty());
}

}  // namespace
}  // namespace stratus::test
