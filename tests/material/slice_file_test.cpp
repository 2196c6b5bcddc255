// Slices, read as their layout says, beside the solver.
#include "material_check.h"
#include "row_name.h"
#include "slice_reader.h"
#include "solved_stack.h"

#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// A layer whose slice is to be close to the solver.
struct Row {
    std::string name;
    Stack stack;
    double median, most;  // 99 %
};

class SliceFile : public testing::TestWithParam<Row> {};

// Bounds are 1.5 times and more what docs/exports.md measures.
INSTANTIATE_TEST_SUITE_P(
    Layers, SliceFile,
    testing::Values(Row{"Wide", layer("henyey_greenstein:g=0.5", 1, 1), 5e-4, 6e-3},
                    Row{"Rings", layer("0.6*lambert_sphere + 0.4*isotropic", 0.9, 0.3), 5e-4, 6e-3},
                    Row{"Deep", layer("rayleigh", 1, infinity), 3e-4, 3e-3},
                    Row{"OverGround", over(layer("henyey_greenstein:g=0.5", 0.9, 2), 0.3), 3e-4,
                        3e-3}),
    row_name);

TEST_P(SliceFile, IsTheSolverAtRandomPairs) {
    const Stack& stack = GetParam().stack;
    const SliceReader file(written({{stack}, ""}, MaterialFormat::slice));
    const bool passes = is_transparent(stack);
    ASSERT_EQ(file.has("transmission"), passes);
    const SliceReader::Side R = file.side("reflection"), rest = file.side("reflection_multiple"),
                            T = file.side(passes ? "transmission" : "reflection");
    Errors of_R, of_T, of_rest;
    for (const Expected& at : random_geometries(stack, 500, 0.01)) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        of_R.add(R(mu_in, mu_out, azimuth), at.reflection);
        // Orders n >= 2, the rest in closed form.
        const double single = single_reflection(stack, at.geometry);
        of_rest.add(single + rest(mu_in, mu_out, azimuth), at.reflection);
        if (passes) of_T.add(T(mu_in, mu_out, azimuth), at.transmission);
    }
    for (Errors* errors : {&of_R, &of_rest, &of_T}) {
        if (errors == &of_T && !passes) continue;
        EXPECT_LT(errors->quantile(0.5), GetParam().median);
        EXPECT_LT(errors->quantile(0.99), GetParam().most);
    }
}

TEST(SliceFile, SaysWhereItsSamplesLie) {
    const SliceReader file(
        written({{layer("isotropic", 0.9, 1.5)}, "A \"slice\""}, MaterialFormat::slice));
    EXPECT_EQ(file.text("format"), "stratus-slice");
    EXPECT_EQ(file.text("format_version"), "1");
    const std::vector<std::size_t> shape = file.shape("reflection");
    EXPECT_EQ(shape, file.shape("transmission_multiple"));
    const auto mu = file.numbers<double>("mu_in"), azimuth = file.numbers<double>("azimuth");
    ASSERT_EQ(shape, (std::vector<std::size_t>{1, mu.size(), mu.size(), azimuth.size()}));
    EXPECT_EQ(mu, file.numbers<double>("mu_out"));
    EXPECT_EQ(mu.front(), 0);
    EXPECT_EQ(mu.back(), 1);
    for (const auto k : indices(mu))
        EXPECT_NEAR(std::asin(std::sqrt(mu[k])) * 2 / pi * static_cast<double>(mu.size() - 1),
                    static_cast<double>(k), 1e-6);
    EXPECT_EQ(azimuth.front(), 0);
    EXPECT_EQ(azimuth.back(), pi);
    EXPECT_EQ(file.numbers<double>("optical_depth"), std::vector<double>{1.5});
    // A sample by itself.
    const SolvedStack solved(layer("isotropic", 0.9, 1.5), {mu[20], mu[50]}, 48);
    const std::size_t at = (20 * mu.size() + 50) * azimuth.size() + 7;
    EXPECT_NEAR(static_cast<double>(file.numbers<float>("reflection")[at]),
                (mu[20] + mu[50]) * solved.values(LitSide::reflection, 0, 1, {1.0})[0].total, 1e-6);
}

// Light of all directions comes out again, or passes.
TEST(SliceFile, LosesNothingInAWhiteFurnace) {
    const SliceReader file(
        written({{layer("henyey_greenstein:g=0.5", 1, 1)}, ""}, MaterialFormat::slice));
    const SliceReader::Side R = file.side("reflection"), T = file.side("transmission");
    const auto mu = file.numbers<double>("mu_in"), albedo = file.numbers<double>("plane_albedo"),
               through = file.numbers<double>("diffuse_transmittance");
    for (const std::size_t k : {std::size_t{12}, std::size_t{30}, std::size_t{63}}) {
        const auto sent = [&](const SliceReader::Side& side) {
            return sent_out([&](double out, double azimuth) { return side(mu[k], out, azimuth); });
        };
        const double sum_R = sent(R), sum_T = sent(T);
        EXPECT_NEAR(sum_R, albedo[k], 4e-4) << mu[k];
        EXPECT_NEAR(sum_R + sum_T + std::exp(-1 / mu[k]), 1, 5e-4) << mu[k];
        EXPECT_NEAR(albedo[k] + through[k] + std::exp(-1 / mu[k]), 1, 1e-10);
    }
}

TEST(SliceFile, HoldsColoursAndStacks) {
    const Stack stack{{{parse_phase_function("rayleigh"), 1, 0.1},
                       {parse_phase_function("henyey_greenstein:g=0.3"), 0.8, 1}},
                      {}};
    Stack red = stack, blue = stack;
    red.layers[1].albedo = 0.95;
    blue.layers[0].optical_depth = 0.3;
    const SliceReader file(written({{red, stack, blue}, ""}, MaterialFormat::slice));
    EXPECT_EQ(file.shape("reflection_below")[0], 3u);
    const SliceReader::Side of_R = file.side("reflection"), of_T = file.side("transmission"),
                            of_below = file.side("reflection_below");
    std::size_t colour = 0;
    for (const Stack& one : {red, stack, blue}) {
        Errors R, T, below;
        for (const Expected& at : random_geometries(one, 40, 0.1)) {
            const auto& [mu_in, mu_out, azimuth] = at.geometry;
            R.add(of_R(mu_in, mu_out, azimuth, colour), at.reflection);
            T.add(of_T(mu_in, mu_out, azimuth, colour), at.transmission);
            below.add(of_below(mu_in, mu_out, azimuth, colour), at.reflection_below);
        }
        for (Errors* errors : {&R, &T, &below}) EXPECT_LT(errors->quantile(0.99), 6e-3) << colour;
        ++colour;
    }
}

}  // namespace
}  // namespace stratus::test
