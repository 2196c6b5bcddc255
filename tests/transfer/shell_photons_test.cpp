#include "shell_photons.h"

#include <stratus/transfer/solve.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

// Far from limb and terminator a shell of little height is plane.
TEST(ShellPhotons, OfLittleHeightAreThoseOfAPlaneLayer) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
    const double impact = 0.6, angle = 0.9;  // of the sun from the eye, on the ray's side
    const ShellLight light =
        shell_photons(phase, 0.9, 2, 1e-5, {impact, {std::sin(angle), 0, std::cos(angle)}}, 40000);
    const double mu_out = std::sqrt(1 - impact * impact),
                 mu_in = std::cos(angle - std::asin(impact));
    // The sun's and the eye's azimuths are opposite where the normal lies between both directions.
    const Geometry at{mu_in, mu_out, 0};
    const double across = std::asin(impact) < angle ? 3.14159265358979323846 : 0;
    const LayerSolution layer = solve_layer(phase, 0.9, 2, {at.mu_in, at.mu_out});
    const SolvedValue expected = layer.reflection(0, 1, 3.14159265358979323846 - across);
    EXPECT_NEAR(light.single.value, mu_in * expected.single, 4 * light.single.standard_error);
    EXPECT_NEAR(light.multiple.value, mu_in * (expected.total - expected.single),
                4 * light.multiple.standard_error);
    EXPECT_LT(light.multiple.standard_error, 0.02 * light.multiple.value);
}

TEST(ShellPhotons, AreNoneInTheShadowAndOfNoAlbedo) {
    const PhaseFunction phase = PhaseFunction::isotropic();
    EXPECT_EQ(shell_photons(phase, 1, 1, 0.01, {0, {0, 0, -1}}, 100).single.value, 0);
    EXPECT_EQ(shell_photons(phase, 0, 1, 0.01, {0.5, {0, 0, 1}}, 100).multiple.value, 0);
    EXPECT_GT(shell_photons(phase, 1, 1, 0.01, {1.005, {0, 0, -1}}, 100).single.value, 0)
        << "beside the planet the sun shines through";
}

TEST(ShellPhotons, AreRefusedBeyondTheirRange) {
    const PhaseFunction phase = PhaseFunction::isotropic();
    const ShellView view{0.5, {0, 0, 1}};
    const auto refuse = [](const auto& call, const Fragments& fragments) {
        expect_refusal(call, fragments);
    };
    refuse([&] { shell_photons(phase, 1.1, 1, 0.1, view, 10); },
           {"albedo must be in [0, 1], got 1.1"});
    refuse([&] { shell_photons(phase, 1, 0, 0.1, view, 10); },
           {"optical_depth must be in (0, inf), got 0"});
    refuse([&] { shell_photons(phase, 1, 1, 0, view, 10); }, {"height must be in (0, inf), got 0"});
    refuse(
        [&] {
            shell_photons(phase, 1, 1, 0.1, {1.1, {0, 0, 1}}, 10);
        },
        {"impact must be in [0, 1 + height), got 1.1"});
    refuse([&] { shell_photons(phase, 1, 1, 0.1, view, 1); },
           {"shell_photons: photons must be >= 2, got 1"});
}

}  // namespace
}  // namespace stratus
