#include <stratus/layer/diffusion.h>

#include <stratus/base/constants.h>

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace stratus {
namespace {

constexpr double q = 0.7104;

TEST(Diffusion, IsTheFormulaOfTheHeader) {
    for (const double k : {1e-3, 0.05, 0.3, 1.0, 2.5})
        for (const double tau : {0.01, 0.5, 3.0, 20.0}) {
            const long double depth = static_cast<long double>(tau) + q;
            const long double transmitted =
                std::sinh(k * static_cast<long double>(q)) / std::sinh(k * depth);
            const long double deficit = std::expm1(2.0L * k * q) / std::expm1(2 * k * depth);
            // a few roundings, and those of an exponent of up to 100
            EXPECT_NEAR(transmission_scale(tau, k, q) / static_cast<double>(transmitted), 1, 2e-14);
            EXPECT_NEAR(reflection_deficit(tau, k, q) / static_cast<double>(deficit), 1, 4e-14);
            const auto d = static_cast<double>(deficit);
            EXPECT_NEAR(reflection_scale(tau, k, q), 1 / (1 + d + d * d), 1e-15);
        }
}

TEST(Diffusion, IsAlgebraicWithoutAbsorption) {
    for (const double tau : {0.0, 1e-12, 1.0, 1e9}) {
        EXPECT_DOUBLE_EQ(transmission_scale(tau, 0, q), q / (tau + q));
        EXPECT_DOUBLE_EQ(reflection_deficit(tau, 0, q), q / (tau + q));
    }
}

TEST(Diffusion, ReachesThatLimitSmoothly) {
    for (const double tau : {1e-9, 1e-3, 1.0, 100.0}) {
        const double k = 1e-12;  // corrections are of the order k (tau + q) <= 1e-10
        EXPECT_NEAR(transmission_scale(tau, k, q) * (tau + q) / q, 1, 2e-10);
        EXPECT_NEAR(reflection_deficit(tau, k, q) * (tau + q) / q, 1, 2e-10);
    }
}

TEST(Diffusion, StartsAtDepthZero) {
    for (const double k : {0.0, 1e-6, 0.3, 2.0}) {
        EXPECT_DOUBLE_EQ(reflection_deficit(0, k, q), 1);
        EXPECT_DOUBLE_EQ(reflection_scale(0, k, q), 1.0 / 3);
        EXPECT_DOUBLE_EQ(transmission_scale(0, k, q), 1);
    }
}

TEST(Diffusion, EndsAtInfinity) {
    for (const double k : {0.0, 1e-6, 1.0, 1e3}) {
        EXPECT_EQ(transmission_scale(infinity, k, q), 0);
        EXPECT_EQ(reflection_deficit(infinity, k, q), 0);
        EXPECT_EQ(reflection_scale(infinity, k, q), 1);
    }
}

TEST(Diffusion, GrowsInThinLayersAsTheMeanOfE1OverPairsOfDepths) {
    constexpr double euler = 0.57721566490153286;
    for (const auto& [tau, accuracy] : {std::pair{1e-9, 1e-6},
                                        {1e-3, 1e-4},
                                        {0.1, 2e-3},
                                        {0.3, 1e-2},
                                        {1.0, 0.032},
                                        {5.0, 0.14}}) {
        double mean = 1.5 - euler - std::log(tau), power = 1;  // by the series of E1, term by term
        for (int k = 1; k < 60; ++k) {
            power *= -tau / k;
            mean -= 2 * power / (k * (k + 1.0) * (k + 2.0));
        }
        EXPECT_NEAR(thin_growth(tau) / mean, 1, accuracy) << tau;
    }
    EXPECT_TRUE(std::isfinite(thin_growth(0)));
}

TEST(Diffusion, OverflowsNowhere) {
    for (const double k : {0.0, 1e-300, 1e-12, 1.0, 1e3})
        for (const double tau : {0.0, 1e-300, 1e-6, 1.0, 1e6, 1e300, 1.7e308})
            for (const double scale : {transmission_scale(tau, k, q), reflection_deficit(tau, k, q),
                                       reflection_scale(tau, k, q)}) {
                EXPECT_GE(scale, 0) << "k " << k << " tau " << tau;
                EXPECT_LE(scale, 1) << "k " << k << " tau " << tau;
            }
}

}  // namespace
}  // namespace stratus
