#include <stratus/runtime/effects.h>

#include <stratus/runtime/constants.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(Density, DividesTheDepthByTheFreeVolume) {
    EXPECT_EQ(effective_optical_depth(2, 0), 2);
    EXPECT_DOUBLE_EQ(effective_optical_depth(2, 0.2), 2.5);
    EXPECT_EQ(effective_optical_depth(infinity, 0.5), infinity);
    EXPECT_EQ(effective_optical_depth(0, 0.5), 0);
}

TEST(BlinnOpposition, AttenuatesOnceTheLightThatLeavesByTheWayItCame) {
    const Opposition opposition = Opposition::blinn(0.1);
    for (const double tau : {1e-6, 0.1, 1.0, 30.0})
        for (const double mu : {0.05, 0.5, 1.0}) {
            // [Blinn82] 5.2: (1 - e) / (0.5 (1 - e^2)), e = exp(-tau / mu)
            const double once = -std::expm1(-tau / mu), twice = -0.5 * std::expm1(-2 * tau / mu);
            EXPECT_NEAR(opposition_factor(opposition, -1, tau, mu, mu), once / twice, 1e-14);
        }
    EXPECT_EQ(opposition_factor(opposition, -1, infinity, 0.3, 0.3), 2);
    EXPECT_EQ(opposition_factor(opposition, -1, 0, 0.3, 0.3), 1);
}

TEST(BlinnOpposition, FallsFasterWhereParticlesAreSparse) {
    const double a = 0.05, c = -std::cos(a);
    const auto factor = [&](double density) {
        return opposition_factor(Opposition::blinn(density), c, 10, 0.5, 0.5);
    };
    EXPECT_LT(factor(0.01), factor(0.1));
    EXPECT_LT(factor(0.1), factor(0.5));
    EXPECT_GT(factor(0.01), 1);
}

TEST(BlinnOpposition, IsHalfAtHalfItsWidth) {
    // (h^2 / (h^2 + t^2))^2 (1 + t^2)^2 = 1/2 in t = tan(a/2), to first order in h^2 at
    // t = h sqrt(sqrt(2) - 1).
    const double density = 1e-3, h = Opposition::width_of_density(density);
    const double a = 2 * std::atan(h * std::sqrt(std::sqrt(2.0) - 1));
    const double bump =
        opposition_factor(Opposition::blinn(density), -std::cos(a), infinity, 0.5, 0.5) - 1;
    EXPECT_NEAR(bump, 0.5, 1e-6);
}

TEST(HapkeOpposition, IsOneOverOnePlusTanOfHalfThePhaseAngleOverItsWidth) {
    const Opposition opposition = Opposition::hapke(0.7, 0.05);
    for (const double a : {0.0, 0.01, 0.1, 1.0, 3.0})
        EXPECT_NEAR(opposition_factor(opposition, -std::cos(a), 1, 0.4, 0.6),
                    1 + 0.7 / (1 + std::tan(a / 2) / 0.05), 1e-12);
    EXPECT_EQ(opposition_factor(opposition, 1, 1, 0.4, 0.6), 1);  // straight on: a = pi
}

TEST(Opposition, HasNoEffectWhenOff) {
    EXPECT_EQ(opposition_factor({}, -1, 1, 0.5, 0.5), 1);
}

TEST(Opposition, IsAsWideAsParticlesAreLargeBesideTheirFreePath) {
    // Radius over mean free path is 3 D / 4 for few particles: an angle a of that is tan(a/2) = 3/8
    // D.
    EXPECT_NEAR(Opposition::width_of_density(1e-6), 0.375e-6, 1e-12);
    EXPECT_NEAR(Opposition::width_of_density(0.5), 0.375 * std::log(2.0), 1e-15);
}

TEST(Effects, RefuseNumbersOutOfRange) {
    using Error = std::invalid_argument;
    expect_refusal<Error>([] { Opposition::blinn(0); }, {"density", "(0, 1)", "got 0"});
    expect_refusal<Error>([] { Opposition::blinn(1); }, {"density", "(0, 1)", "got 1"});
    expect_refusal<Error>([] { Opposition::hapke(1.5, 0.1); }, {"amplitude", "[0, 1]", "1.5"});
    expect_refusal<Error>([] { Opposition::hapke(1, 0); }, {"width", "(0, inf)", "got 0"});
    Effects effects;
    effects.density = 1;
    expect_refusal<Error>([&] { check_effects(effects); }, {"density", "[0, 1)", "got 1"});
    effects.density = std::nan("");
    expect_refusal<Error>([&] { check_effects(effects); }, {"density", "[0, 1)", "nan"});
    effects = {};
    effects.opposition.law = Opposition::Law::hapke;
    expect_refusal<Error>([&] { check_effects(effects); }, {"opposition.width", "got 0"});
    effects.opposition = Opposition::hapke(1, 0.1);
    effects.single = false;
    expect_refusal<Error>([&] { check_effects(effects); }, {"opposition", "single"});
}

}  // namespace
}  // namespace stratus
