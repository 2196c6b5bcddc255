#include <stratus/layer/lower_boundary.h>

#include <stratus/base/constants.h>

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

const Geometry at{0.4, 0.9, 1.2};

TEST(LowerBoundary, ReflectsNothingWhenAbsent) {
    EXPECT_FALSE(LowerBoundary().is_present());
    EXPECT_EQ(single_reflection_of_boundary({}, 0, at), 0);
}

TEST(LowerBoundary, IsSeenThroughTheLayerOnTheWayThereAndBack) {
    const LowerBoundary surface = LowerBoundary::surface(0.3);
    EXPECT_EQ(single_reflection_of_boundary(surface, 0, at), 0.3);
    EXPECT_DOUBLE_EQ(single_reflection_of_boundary(surface, 0.5, at),
                     0.3 * std::exp(-0.5 / 0.4) * std::exp(-0.5 / 0.9));
    EXPECT_EQ(single_reflection_of_boundary(surface, infinity, at), 0);
}

TEST(LowerBoundary, ScattersOnceAsASemiInfiniteLayer) {
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.6);
    const LowerBoundary layer = LowerBoundary::layer(forward, 0.8);
    // [Blinn82] 2.7 in this normalisation: (w/4) phi / (mu + mu0)
    const double alone = 0.8 / 4 * forward(cos_scattering_angle_reflected(at)) / (0.4 + 0.9);
    EXPECT_DOUBLE_EQ(single_reflection_of_boundary(layer, 0, at), alone);
    EXPECT_DOUBLE_EQ(single_reflection_of_boundary(layer, 0.5, at),
                     alone * std::exp(-0.5 / 0.4) * std::exp(-0.5 / 0.9));
    EXPECT_EQ(boundary_phase_value(layer, at), forward(cos_scattering_angle_reflected(at)));
    EXPECT_EQ(boundary_phase_value(LowerBoundary::surface(0.3), at), 1);
}

}  // namespace
}  // namespace stratus
