// Refusals of the solver: one test per check, with values just outside the range.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(SolveLayer, RefusesArgumentsOutOfRange) {
    const auto refused = [](double albedo, double optical_depth, double mu, const char* reason,
                            const SolverOptions& options = {}) {
        expect_refusal(
            [&] {
                solve_layer(isotropic, albedo, optical_depth, {1, mu}, options);
            },
            reason);
    };
    refused(1.2, 1, 1, "solve: albedo must be in [0, 1], got 1.2");
    refused(1 + 1e-15, 1, 1, "solve: albedo must be in [0, 1], got 1.0000000000000");
    refused(-0.25, 1, 1, "solve: albedo must be in [0, 1], got -0.25");
    refused(NAN, 1, 1, "solve: albedo must be in [0, 1], got nan");
    refused(0.5, -0.5, 1, "solve: optical_depth must be in [0, inf], got -0.5");
    refused(0.5, -infinity, 1, "solve: optical_depth must be in [0, inf], got -inf");
    refused(0.5, NAN, 1, "solve: optical_depth must be in [0, inf], got nan");
    refused(0.5, 1, 0, "mu must be in [1e-100, 1], got 0");
    refused(0.5, 1, -0.5, "mu must be in [1e-100, 1], got -0.5");
    refused(0.5, 1, 1.25, "mu must be in [1e-100, 1], got 1.25");
    refused(0.5, 1, NAN, "mu must be in [1e-100, 1], got nan");
    refused(0.5, 1, 1, "nodes must be in [1, 512], got 0", with_nodes(0));
    refused(0.5, 1, 1, "nodes must be in [1, 512], got 513", with_nodes(513));
    refused(0.5, 1, 1, "solve: modes must be >= 0, got -1", {.modes = -1});
}

TEST(SolveLadder, RefusesArgumentsOutOfRange) {
    const auto refused = [](const std::vector<double>& albedos, double first, int octaves,
                            const Fragments& fragments, const std::vector<bool>& asked = {}) {
        expect_refusal(
            [&] {
                solve_ladder(isotropic, albedos, {first, octaves, false, asked}, {1});
            },
            fragments);
    };
    refused({0.5}, 1, -1, "solve: octaves must be >= 0, got -1");
    for (const double first : {0.0, -1.0, 1e-281, infinity, double{NAN}})
        refused({0.5}, first, 1, "solve: first depth of a ladder must be in [1e-280, inf)");
    refused({}, 1, 1, "solve: albedos must be at least one");
    refused({0.5, 1, 1.5}, 1, 1, "solve: albedo must be in [0, 1], got 1.5");
    refused({0.5}, 1, 2, {"solve: depths of a ladder must be at least one"}, {false, false});
    refused({0.5}, 1, 2, {"solve: depths of a ladder", "2, got 1"}, {true});
}

}  // namespace
}  // namespace stratus
