#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/scene/figure.h>

#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

class PlottedLobes : public ::testing::Test {
  protected:
    const LobePlot plot = plot_lobes(
        {PhaseFunction::henyey_greenstein(0.4), {radians(36), radians(144)}, {2, 0.1}, {0.5, 1}});
};

TEST_F(PlottedLobes, SingleScatteringIsBlinnsBrightnessTimesMu) {
    const LobeCurve& curve = plot.blocks[0].rows[0][0].curves[0];  // tau = 2, 36 degrees, w = 0.5
    const double mu_in = std::cos(radians(36));
    const auto steps = curve.above.size() - 1;
    for (std::size_t k = 1; k < steps; k += 7) {
        // Light that comes from -36 degrees and leaves at `angle` was turned by 180 - 36 - angle
        // degrees above the layer, by angle - 36 below it.
        const double angle = pi * (static_cast<double>(k) / static_cast<double>(steps) - 0.5);
        const double mu = std::cos(angle);
        const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.4);
        const double back = phase(-std::cos(angle + radians(36))),
                     on = phase(std::cos(angle - radians(36)));
        EXPECT_NEAR(curve.above[k], 4 * mu * mu_in * single_reflection(back, 0.5, 2, mu_in, mu),
                    1e-12);
        EXPECT_NEAR(curve.below[k], 4 * mu * mu_in * single_transmission(on, 0.5, 2, mu_in, mu),
                    1e-12);
    }
    EXPECT_EQ(curve.above.front(), 0);
    EXPECT_EQ(curve.above.back(), 0);
}

TEST_F(PlottedLobes, LightFromBelowMirrorsLightFromAbove) {
    for (const LobeBlock& block : plot.blocks)
        for (const auto& row : block.rows)
            for (std::size_t w = 0; w < 2; ++w)
                for (const auto k : indices(row[0].curves[w].above)) {
                    EXPECT_NEAR(row[0].curves[w].above[k], row[1].curves[w].below[k], 1e-12);
                    EXPECT_NEAR(row[0].curves[w].below[k], row[1].curves[w].above[k], 1e-12);
                }
}

TEST_F(PlottedLobes, AllOrdersExceedSingleScattering) {
    for (std::size_t w = 0; w < 2; ++w)
        EXPECT_GT(plot.blocks[1].rows[0][0].curves[w].above[20],
                  1.1 * plot.blocks[0].rows[0][0].curves[w].above[20]);
}

TEST(LambertFigure, ConservativeCloudReflectsAllLight) {
    const LambertComparison made =
        compare_with_lambert({PhaseFunction::isotropic(), 1, infinity, {1, 0.5}});
    ASSERT_EQ(made.plot.lines.size(), 4u);
    for (const std::size_t n : {1u, 2u}) {
        const auto& points = made.plot.lines[n].points;
        double flux = points[0].first * points[0].first * points[0].second;  // below the first
        for (std::size_t k = 1; k < points.size(); ++k)
            flux +=
                (points[k].first - points[k - 1].first) *
                (points[k].first * points[k].second + points[k - 1].first * points[k - 1].second);
        EXPECT_NEAR(flux, 1, 1e-4);  // 2 int R mu dmu, trapezia
    }
    // R(1, 1) = H(1)^2 / 8 with H(1) = 2.9078 at w = 1. [C60]
    EXPECT_NEAR(made.plot.lines[1].points.back().second, 2.9078 * 2.9078 / 8, 1e-4);
    EXPECT_GT(made.deviation, 0);
    EXPECT_GE(made.mu, 0.2);
}

}  // namespace
}  // namespace stratus
