#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>

#include "../reference/discrete_ordinates.h"
#include "csv_rows.h"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

const double scattering_cosines[] = {0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0};
const double scattering_depths[] = {1e-6, 0.01, 0.3, 1.0, 7.0, 40.0};

TEST(SingleScattering, EqualsTheReferenceRows) {
    const std::vector<CsvRow> rows = csv_rows("single_scattering.csv");
    EXPECT_GE(rows.size(), 40u);
    for (const auto& [phase, row] : rows) {  // w tau mu0 mu dphi_deg R T
        const PhaseFunction phi = test::reference_phase_function(phase);
        const double w = row.at(0), tau = row.at(1), mu0 = row.at(2), mu = row.at(3);
        const Geometry geometry{mu0, mu, radians(row.at(4))};
        const double up = phi(cos_scattering_angle_reflected(geometry));
        const double down = phi(cos_scattering_angle_transmitted(geometry));
        // 14 digits printed; where Theta is near 0 a peak of g = 0.95 adds the rounding of cos
        // Theta
        EXPECT_NEAR(single_reflection(up, w, tau, mu0, mu) / row.at(5), 1, 4e-13) << phase;
        EXPECT_NEAR(single_transmission(down, w, tau, mu0, mu), row.at(6),
                    4e-13 * std::abs(row.at(6)))
            << phase;
    }
}

TEST(SingleScattering, IsReciprocal) {
    for (const double tau : scattering_depths)
        for (const double mu0 : scattering_cosines)
            for (const double mu : scattering_cosines) {
                EXPECT_EQ(single_reflection(1, 1, tau, mu0, mu),
                          single_reflection(1, 1, tau, mu, mu0));
                EXPECT_EQ(single_transmission(1, 1, tau, mu0, mu),
                          single_transmission(1, 1, tau, mu, mu0));
            }
}

TEST(SingleScattering, EqualsTheIntegralOfTheSourceOverDepth) {
    const auto integral = [](double end, const auto& function) {
        return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(function, 0, end, 15,
                                                                             1e-12);
    };
    for (const double tau : {0.01, 0.3, 1.0, 7.0})
        for (const double mu0 : {0.1, 0.5, 1.0})
            for (const double mu : {0.1, 0.3, 0.5, 0.9}) {
                const double source = 0.9 * 1.7 / (4 * mu * mu0);
                const double up = source * integral(tau, [&](double t) {
                                      return std::exp(-t / mu0) * std::exp(-t / mu);
                                  });
                const double down = source * integral(tau, [&](double t) {
                                        return std::exp(-t / mu0) * std::exp(-(tau - t) / mu);
                                    });
                EXPECT_NEAR(single_reflection(1.7, 0.9, tau, mu0, mu) / up, 1, 1e-11);
                EXPECT_NEAR(single_transmission(1.7, 0.9, tau, mu0, mu) / down, 1, 1e-11);
            }
}

TEST(SingleTransmission, HasItsLimitAtEqualCosines) {
    for (const double tau : scattering_depths)
        for (const double mu : scattering_cosines) {
            const double limit = 0.8 / 4 * 1.3 * tau * std::exp(-tau / mu) / (mu * mu);
            EXPECT_NEAR(single_transmission(1.3, 0.8, tau, mu, mu), limit, 1e-15 * limit);
        }
}

TEST(SingleTransmission, IsSmoothThroughEqualCosines) {
    // (exp(-tau/mu0) - exp(-tau/mu)) / (mu0 - mu) in long double has lost log10(1/offset) of its
    // 19 digits; closer than that, the first two terms of its series are used.
    const double mu = 0.4;
    for (const double tau : {1e-6, 0.3, 1.0, 7.0})
        for (const double offset : {1e-16, 1e-13, 1e-10, 1e-7, 1e-5, 1e-3, 0.1})
            for (const double side : {-1.0, 1.0}) {
                const double mu0 = mu + side * offset;
                const long double x = tau;
                const long double apart = static_cast<long double>(mu0) - mu;
                const long double limit =
                    x * std::exp(-x / mu) / (static_cast<long double>(mu) * mu);
                const long double expected = offset < 1e-6
                                                 ? limit * (1 + apart * (x / 2 / mu - 1) / mu)
                                                 : (std::exp(-x / mu0) - std::exp(-x / mu)) / apart;
                const double tolerance =
                    offset < 1e-6 ? 3e-15 + 1e3 * offset * offset : 1e-12 / tau;
                EXPECT_NEAR(
                    4 * single_transmission(1, 1, tau, mu0, mu) / static_cast<double>(expected), 1,
                    tolerance)
                    << "tau " << tau << " offset " << side * offset;
            }
}

TEST(SingleScattering, OfAThinLayerIsThatOfItsParticles) {
    for (const double tau : {1e-300, 1e-30, 1e-18})
        for (const double mu0 : scattering_cosines)
            for (const double mu : scattering_cosines) {
                const double particles = 0.25 * tau / (mu * mu0);
                EXPECT_NEAR(single_reflection(1, 1, tau, mu0, mu) / particles, 1, 1e-15);
                EXPECT_NEAR(single_transmission(1, 1, tau, mu0, mu) / particles, 1, 1e-15);
            }
}

TEST(SingleScattering, KeepsItsRelativeAccuracyInThinLayers) {
    for (const double tau : {1e-9, 1e-5, 1e-2, 0.5}) {
        const long double path = tau * (1 / 0.3L + 1 / 0.7L);
        const long double exact = -std::expm1(-path) / 4;
        const double r = single_reflection(1, 1, tau, 0.3, 0.7);
        EXPECT_NEAR(r / static_cast<double>(exact), 1, 1e-15) << tau;
    }
}

TEST(SingleScattering, IsZeroAtDepthZero) {
    EXPECT_EQ(single_reflection(1, 1, 0, 0.5, 0.7), 0);
    EXPECT_EQ(single_transmission(1, 1, 0, 0.5, 0.7), 0);
    EXPECT_EQ(single_transmission(1, 1, 0, 0.5, 0.5), 0);
    EXPECT_EQ(direct_transmittance(0, 0.5), 1);
}

// The full moon is a flat disk: where both cosines are alike, 4 mu0 R is w phi / 2. [Blinn82] 2.7
TEST(SingleScattering, OfASemiInfiniteLayerIsHapkeIrvine) {
    for (const double mu0 : scattering_cosines)
        for (const double mu : scattering_cosines) {
            EXPECT_DOUBLE_EQ(single_reflection(1.7, 0.9, infinity, mu0, mu),
                             1.7 * 0.9 / (4 * (mu0 + mu)));
            EXPECT_EQ(single_transmission(1.7, 0.9, infinity, mu0, mu), 0);
            EXPECT_EQ(direct_transmittance(infinity, mu), 0);
        }
}

TEST(SingleScattering, NeitherOverflowsNorUnderflows) {
    const double extremes[] = {0,   1e-300, 1e-200, 1e-30, 1e-9,  1e-3,    1,
                               10., 1e3,    1e9,    1e30,  1e300, infinity};
    for (const double tau : extremes)
        for (const double mu0 : {1e-12, 1e-6, 0.5, 1.0})
            for (const double mu : {1e-12, 1e-6, 0.5, 0.5000001, 1.0}) {
                const double r = single_reflection(1, 1, tau, mu0, mu);
                const double t = single_transmission(1, 1, tau, mu0, mu);
                const double through = source_seen_through(1, 1, tau, mu);
                EXPECT_TRUE(std::isfinite(r) && r >= 0) << tau << ' ' << mu0 << ' ' << mu;
                EXPECT_TRUE(std::isfinite(t) && t >= 0) << tau << ' ' << mu0 << ' ' << mu;
                EXPECT_TRUE(std::isfinite(through) && through >= 0) << tau << ' ' << mu;
                EXPECT_LE(t * mu * mu0 * 4, tau * (1 + 1e-15));
            }
}

TEST(InterceptedShare, IsWhatTheBeamLoses) {
    EXPECT_NEAR(intercepted_share(2, 0.5), 1 - std::exp(-4.0), 1e-16);
    EXPECT_NEAR(intercepted_share(1e-300, 0.5) / 2e-300, 1, 1e-15);
    EXPECT_EQ(intercepted_share(0, 0.5), 0);
    EXPECT_EQ(intercepted_share(infinity, 0.5), 1);
}

TEST(Transparency, IsTheBeamAndBottomLitLightFromTheSameDirection) {
    for (const double tau : {0.0, 1e-6, 0.3, 7.0, infinity})
        for (const double mu : scattering_cosines) {
            const double beam = std::exp(-tau / mu);
            const double expected = beam + 4 * mu * single_transmission(4.2, 0.9, tau, mu, mu);
            EXPECT_NEAR(source_seen_through(4.2, 0.9, tau, mu), expected, 1e-14 * expected);
        }
}

TEST(ScatteringAngle, IsBackwardForLightThatReturns) {
    for (const double mu : scattering_cosines) {
        EXPECT_NEAR(cos_scattering_angle_reflected({mu, mu, pi}), -1, 1e-15);
        EXPECT_NEAR(cos_scattering_angle_transmitted({mu, mu, 0}), 1, 1e-15);
    }
}

TEST(ScatteringAngle, IsThatBetweenTheDirectionsOfPropagation) {
    const double mu0 = 0.3, mu = 0.8, azimuth = 2.1;
    const double s0 = std::sqrt(1 - mu0 * mu0), s = std::sqrt(1 - mu * mu);
    const double in[3] = {s0, 0, -mu0};  // downwards
    const double out[2] = {s * std::cos(azimuth), s * std::sin(azimuth)};
    const double horizontal = in[0] * out[0] + in[1] * out[1];
    EXPECT_NEAR(cos_scattering_angle_reflected({mu0, mu, azimuth}), horizontal + in[2] * mu, 1e-15);
    EXPECT_NEAR(cos_scattering_angle_transmitted({mu0, mu, azimuth}), horizontal - in[2] * mu,
                1e-15);
}

TEST(ScatteringAngle, StaysACosineWhenCosinesAreRoundedPastOne) {
    const double past = std::nextafter(1.0, 2.0);
    EXPECT_EQ(cos_scattering_angle_reflected({past, 1, 0}), -1);
    EXPECT_EQ(cos_scattering_angle_transmitted({past, 1, 0}), 1);
}

}  // namespace
}  // namespace stratus
