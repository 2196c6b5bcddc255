#include <stratus/runtime/below.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stratus {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const Geometry at{0.4, 0.9, 1.2};

TEST(Below, ReflectsNothingWhereThereIsNothing) {
    EXPECT_FALSE(Below().is_something());
    EXPECT_EQ(single_reflection_below({}, 0, at), 0);
}

TEST(Below, IsSeenThroughTheLayerOnTheWayThereAndBack) {
    const Below surface = Below::surface(0.3);
    EXPECT_EQ(single_reflection_below(surface, 0, at), 0.3);
    EXPECT_DOUBLE_EQ(single_reflection_below(surface, 0.5, at),
                     0.3 * std::exp(-0.5 / 0.4) * std::exp(-0.5 / 0.9));
    EXPECT_EQ(single_reflection_below(surface, infinity, at), 0);
}

TEST(Below, ScattersOnceAsALayerWithoutEndDoes) {
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.6);
    const Below layer = Below::layer(forward, 0.8);
    // [Blinn82] 2.7 in this normalisation: (w/4) phi / (mu + mu0)
    const double alone = 0.8 / 4 * forward(cos_scattering_angle_reflected(at)) / (0.4 + 0.9);
    EXPECT_DOUBLE_EQ(single_reflection_below(layer, 0, at), alone);
    EXPECT_DOUBLE_EQ(single_reflection_below(layer, 0.5, at),
                     alone * std::exp(-0.5 / 0.4) * std::exp(-0.5 / 0.9));
    EXPECT_EQ(phase_value_below(layer, at), forward(cos_scattering_angle_reflected(at)));
    EXPECT_EQ(phase_value_below(Below::surface(0.3), at), 1);
}

}  // namespace
}  // namespace stratus
