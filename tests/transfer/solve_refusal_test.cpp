// Refusals of the solver: one test per check, with values just outside the range.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

void expect_solve_refusal(double albedo, double optical_depth, const std::vector<double>& mu,
                          const SolverOptions& options, const std::vector<const char*>& fragments) {
    expect_refusal(
        [&] { solve_layer(isotropic, albedo, optical_depth, mu, options); }, fragments);
}

TEST(SolveLayer, RefusesAlbedosOutOfRange) {
    expect_solve_refusal(1.2, 1, {1}, {}, {"solve: albedo must be in [0, 1], got 1.2"});
    expect_solve_refusal(1 + 1e-15, 1, {1}, {}, {"solve", "albedo", "[0, 1]", "1.0000000000000"});
    expect_solve_refusal(-0.25, 1, {1}, {}, {"solve", "albedo", "[0, 1]", "-0.25"});
    expect_solve_refusal(NAN, 1, {1}, {}, {"solve", "albedo", "[0, 1]", "nan"});
}

TEST(SolveLayer, RefusesDepthsBelowZero) {
    expect_solve_refusal(0.5, -0.5, {1}, {}, {"solve", "optical_depth", "[0, inf]", "-0.5"});
    expect_solve_refusal(0.5, -infinity, {1}, {}, {"solve", "optical_depth", "[0, inf]", "-inf"});
}

TEST(SolveLayer, RefusesDepthNaN) {
    expect_solve_refusal(0.5, NAN, {1}, {}, {"solve", "optical_depth", "[0, inf]", "nan"});
}

TEST(SolveLayer, RefusesCosinesOutOfRange) {
    expect_solve_refusal(0.5, 1, {1, 0}, {}, {"mu", "[1e-100, 1]", "got 0"});
    expect_solve_refusal(0.5, 1, {-0.5}, {}, {"mu", "[1e-100, 1]", "-0.5"});
    expect_solve_refusal(0.5, 1, {1.25}, {}, {"mu", "[1e-100, 1]", "1.25"});
    expect_solve_refusal(0.5, 1, {NAN}, {}, {"mu", "[1e-100, 1]", "nan"});
}

TEST(SolveLayer, RefusesNodeCountsOutOfRange) {
    SolverOptions options;
    options.nodes = 0;
    expect_solve_refusal(0.5, 1, {1}, options, {"nodes", "[1, 512]", "got 0"});
    options.nodes = 513;
    expect_solve_refusal(0.5, 1, {1}, options, {"nodes", "[1, 512]", "got 513"});
}

TEST(SolveLayer, RefusesModesBelowZero) {
    SolverOptions options;
    options.modes = -1;
    expect_solve_refusal(0.5, 1, {1}, options, {"solve", "modes", ">= 0", "-1"});
}

TEST(SolveLadder, RefusesOctavesBelowZero) {
    expect_refusal(
        [] {
            solve_ladder(isotropic, {0.5}, {1, -1, false}, {1});
        },
        {"solve", "octaves", ">= 0", "-1"});
}

TEST(SolveLadder, RefusesAFirstDepthOutOfRange) {
    for (const double first : {0.0, -1.0, 1e-281, infinity, NAN})
        expect_refusal(
            [&] {
                solve_ladder(isotropic, {0.5}, {first, 1, false}, {1});
            },
            {"solve", "first depth", "[1e-280, inf)"});
}

TEST(SolveLadder, RefusesAnEmptyAlbedoList) {
    expect_refusal(
        [] {
            solve_ladder(isotropic, {}, {1, 1, false}, {1});
        },
        {"solve", "albedos", "at least one"});
}

TEST(SolveLadder, RefusesEveryAlbedoOutOfRange) {
    expect_refusal(
        [] {
            solve_ladder(isotropic, {0.5, 1, 1.5}, {1, 1, false}, {1});
        },
        {"solve", "albedo", "[0, 1]", "1.5"});
}

}  // namespace
}  // namespace stratus
