#include <stratus/material/material.h>

#include "material_check.h"
#include "refusal.h"
#include "solved_stack.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace stratus::test {
namespace {

TEST(CosineSeries, IsAsShortAsTheToleranceAllows) {
    const auto values = [](const std::vector<double>& azimuths) {
        std::vector<std::vector<double>> all(2);
        for (const double phi : azimuths) {
            all[0].push_back(2 + std::cos(3 * phi));
            all[1].push_back(1 / (1.25 - std::cos(phi)));  // a_k = 2^-k 8/3, a_0 = 4/3
        }
        return all;
    };
    const auto series = cosine_series(values, 1e-6);
    ASSERT_EQ(series.size(), 2);
    ASSERT_EQ(series[0].size(), series[1].size());
    EXPECT_NEAR(series[0][0], 2, 1e-12);
    EXPECT_NEAR(series[0][3], 1, 1e-12);
    EXPECT_NEAR(series[1][0], 4.0 / 3, 1e-9);
    EXPECT_NEAR(series[1][5], 8.0 / 3 / 32, 1e-9);
    EXPECT_GT(series[0].size(), 19);
    EXPECT_LT(series[0].size(), 26);
}

TEST(CosineSeries, IsEmptyInTheDark) {
    const auto dark = [](const std::vector<double>& azimuths) {
        return std::vector<std::vector<double>>{std::vector<double>(azimuths.size())};
    };
    EXPECT_TRUE(cosine_series(dark, 1e-4).empty());
}

TEST(CosineSeries, RefusesWhatItCannotHold) {
    const auto spike = [](const std::vector<double>& azimuths) {
        std::vector<double> values;
        for (const double phi : azimuths) values.push_back(phi == 0 ? 1 : 1e-3);
        return std::vector<std::vector<double>>{values};
    };
    EXPECT_THROW(cosine_series(spike, 1e-4), std::runtime_error);
}

// Between the cosines that were solved, too, R is the solver's.
TEST(ReflectionField, IsTheSolverBetweenItsCosines) {
    const Stack stacks[] = {layer("henyey_greenstein:g=0.85", 1, 1),
                            over({{{parse_phase_function("rayleigh"), 1, 0.2},
                                   {parse_phase_function("henyey_greenstein:g=0.7"), 0.98, 2}},
                                  {}},
                                 0.5)};
    for (const Stack& stack : stacks) {
        const std::vector<double> mu = ReflectionField::cosines(128);
        const SolvedStack solved(stack, mu, 40);
        const ReflectionField field(stack, solved, mu, 0);
        std::vector<double> between{mu[70]};
        for (const double cosine : {0.003, 0.05, 0.31, 0.77, 0.998}) between.push_back(cosine);
        const SolvedStack exact(stack, between, 40);
        for (int in = 1; in < 6; ++in)
            for (const double azimuth : {0.01, 1.0, 3.13}) {
                const double expected =
                    exact.values(LitSide::reflection, in, 0, {azimuth})[0].total;
                EXPECT_NEAR(field(between[static_cast<std::size_t>(in)], 70, azimuth), expected,
                            2e-5 * expected)
                    << in << ' ' << azimuth;
            }
    }
}

TEST(Material, RefusesWhatCannotBeWritten) {
    const Stack grey = layer("isotropic", 0.9, 1);
    const auto said = [](const Material& material, const MaterialOptions& options) {
        return refusal([&] { make_material(material, MaterialFormat::fourier, options); });
    };
    EXPECT_EQ(said({{grey, grey}, ""}, {}), "export: colours must be one or three, got 2");
    EXPECT_EQ(said({{Stack{}}, ""}, {}), "export: layers must be at least one, got none");
    MaterialOptions options;
    options.nodes = 513;
    EXPECT_EQ(said({{grey}, ""}, options), "export: nodes must be in [1, 512], got 513");
}

TEST(Material, StatesItsErrorAndRefusesWhatMissesItsTolerance) {
    const auto made = [](double tolerance, int nodes, bool accept, const char* phase) {
        MaterialOptions options;
        options.tolerance = tolerance;
        options.nodes = nodes;
        options.accept = accept;
        return make_material({{layer(phase, 0.9, 1)}, ""}, MaterialFormat::netcdf, options);
    };
    constexpr const char* lobe = "henyey_greenstein:g=0.75";
    EXPECT_LE(made(1e-2, 0, false, lobe).error, 1e-2);
    const MaterialFile fine = made(1e-5, 0, false, lobe), coarse = made(1e-5, 8, false, lobe);
    EXPECT_LE(fine.error, 1e-5);
    EXPECT_GT(fine.nodes, 8);
    EXPECT_GT(coarse.error, 1e-5);  // nodes were asked for
    EXPECT_EQ(coarse.nodes, 8);
    constexpr const char* narrow = "henyey_greenstein:g=0.999";
    const std::string said = refusal<std::runtime_error>([&] { made(1e-6, 0, false, narrow); });
    expect_holds(said, "the tolerance of 1e-06 is missed");
    EXPECT_GT(made(1e-6, 0, true, narrow).error, 1e-6);
}

TEST(Material, LeavesNoHalfFile) {
    const TemporaryFolder folder;
    MaterialFile file = make_material({{layer("isotropic", 0.9, 1)}, ""}, MaterialFormat::fourier);
    file.write = [](const std::filesystem::path& path) {
        set_content(path, "half");
        throw std::runtime_error("the disk is full");
    };
    EXPECT_THROW(write_material(file, folder / "m.bsdf"), std::runtime_error);
    EXPECT_EQ(folder.size(), 0);
}

}  // namespace
}  // namespace stratus::test
