
#include <stratus/base/constants.h>

#include "least_squares.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(ChiSquare, HasThePublishedQuantiles) {
    struct Quantile {
        double probability;
        int degrees;
        double chi_square;
    };
    // Abramowitz and Stegun, Handbook of Mathematical Functions, table 26.8, printed to half a
    // unit of 1e-4 at most, in which a probability changes by less than 0.4 of itself
    constexpr double printed = 0.4 * 0.5e-4;
    for (const auto& [probability, degrees, chi_square] :
         {Quantile{0.05, 1, 3.84146}, Quantile{0.01, 2, 9.21034}, Quantile{0.05, 10, 18.3070},
          Quantile{0.995, 3, 0.0717212}, Quantile{0.001, 30, 59.7031}})
        EXPECT_NEAR(chi_square_probability(chi_square, degrees), probability,
                    printed * probability);
}

/// The integral of the density from chi_square on, by the trapezoid rule in ln(chi_square).
double integrated(double chi_square, int degrees) {
    const double a = degrees / 2.0;
    const double from = std::log(chi_square / 2), to = std::log(chi_square / 2 + a + 800);
    constexpr int steps = 400000;
    double sum = 0;
    for (int i = 0; i <= steps; ++i) {
        const double log_x = from + (to - from) * i / steps;
        const double share = i == 0 || i == steps ? 0.5 : 1;
        sum += share * std::exp(a * log_x - std::exp(log_x) - std::lgamma(a));
    }
    return sum * (to - from) / steps;
}

TEST(ChiSquare, IsTheIntegralOfItsDensity) {
    for (const int degrees : {1, 2, 3, 7, 48, 501})
        for (const double chi_square : {0.01, 0.7, 5.0, 70.0, 450.0, 700.0}) {
            const double expected = integrated(chi_square, degrees);
            EXPECT_NEAR(chi_square_probability(chi_square, degrees), expected,
                        1e-8 * expected + 1e-12)
                << degrees << ' ' << chi_square;
        }
}

TEST(ChiSquare, EndsAtOneAndZero) {
    for (const int degrees : {1, 2, 9, 10}) {
        EXPECT_EQ(chi_square_probability(0, degrees), 1);
        EXPECT_EQ(chi_square_probability(infinity, degrees), 0);
        EXPECT_EQ(chi_square_probability(1e5, degrees), 0);
    }
    EXPECT_NEAR(chi_square_probability(1e5, 100000), 0.5, 1e-3);  // no overflow on the way
}

}  // namespace
}  // namespace stratus
