#include <stratus/layer/effects.h>

#include <stratus/base/constants.h>

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

TEST(Density, IsTheShareOfTheVolumeThatParticlesFill) {
    EXPECT_NEAR(volume_fraction(0.1, 0.5), 0.1 * 4 / 3 * pi * 0.125, 1e-15);
    EXPECT_NEAR(volume_fraction(1e8, 0.5e-3), volume_fraction(0.1, 0.5), 1e-15);  // per m^3 and m
    EXPECT_EQ(volume_fraction(0, 2), 0);
    expect_refusal([] { volume_fraction(-1, 1); }, {"number_density must be in [0, inf), got -1"});
    expect_refusal([] { volume_fraction(1, 0); }, {"radius must be in (0, inf), got 0"});
    expect_refusal(
        [] { volume_fraction(1, 1); },
        {"number_density * (4/3) pi radius^3 must be in [0, 1), got 4.1887902047863905"});
}

TEST(Effects, RefuseNumbersOutOfRange) {
    Effects effects;
    effects.density = 1;
    expect_refusal([&] { check_effects(effects); }, {"density must be in [0, 1), got 1"});
    effects.density = NAN;
    expect_refusal([&] { check_effects(effects); }, {"density must be in [0, 1), got nan"});
    effects = {};
    effects.opposition.law = Opposition::Law::hapke;
    expect_refusal([&] { check_effects(effects); },
                   {"opposition.width must be in (0, inf), or 0 with a density above 0, got 0"});
    effects.opposition = Opposition::hapke(1, 0.1);
    effects.single = false;
    expect_refusal([&] { check_effects(effects); }, {"opposition must be none without single"});
}

}  // namespace
}  // namespace stratus
