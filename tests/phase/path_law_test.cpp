#include <stratus/phase/path_law.h>

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace stratus {
namespace {

template <class Function>
double integral(double low, double high, const Function& function) {
    return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(function, low, high, 15,
                                                                         1e-12);
}

/// Probability of n - 1 scatterings along a path.
double poisson(int n, double s) {
    return s > 0 ? std::exp((n - 1) * std::log(s) - s - std::lgamma(n)) : n == 1 ? 1.0 : 0.0;
}

TEST(PathWeights, AreIntegralsOverTheDepthOfTheTurn) {
    for (const double tau : {0.01, 0.5, 6.0})
        for (const auto& [mu_in, mu_out] :
             {std::pair{0.4, 0.9}, std::pair{0.7, 0.7}, std::pair{0.7, 0.701}, {0.1, 0.9}}) {
            const double in = mu_in, out = mu_out;
            const PathWeights up = path_weights(Side::reflection, 12, tau, in, out);
            const PathWeights down = path_weights(Side::transmission, 12, tau, in, out);
            for (const int n : {1, 2, 3, 7, 11}) {
                const double scale = 1 / (4 * in * out * n);
                const double reflected =
                    integral(0, tau, [&](double t) { return poisson(n, t / in + t / out); });
                const double transmitted = integral(
                    0, tau, [&](double t) { return poisson(n, t / in + (tau - t) / out); });
                EXPECT_NEAR(up.of_order[n], scale * reflected, 1e-8 * scale * reflected)
                    << tau << ' ' << in << ' ' << n;
                EXPECT_NEAR(down.of_order[n], scale * transmitted, 1e-8 * scale * transmitted)
                    << tau << ' ' << in << ' ' << n;
            }
        }
}

TEST(PathWeights, LeaveTheGlobalSignOfLgammaAlone) {  // which threads that bind would race for
    signgam = 7;
    path_weights(Side::reflection, 100, 50, 0.5, 0.6);
    EXPECT_EQ(signgam, 7);
}

TEST(PathWeights, OfOrder1AreSingleScattering) {
    for (const double tau : {1e-12, 0.3, 40.0, infinity})
        for (const auto& [in, out] : {std::pair{0.4, 0.9}, std::pair{0.02, 0.02}}) {
            const double once = single_reflection(1, 1, tau, in, out);
            const double through = single_transmission(1, 1, tau, in, out);
            EXPECT_NEAR(path_weights(Side::reflection, 4, tau, in, out).of_order[1], once,
                        1e-12 * once);
            EXPECT_NEAR(path_weights(Side::transmission, 4, tau, in, out).of_order[1], through,
                        1e-12 * through);
        }
}

TEST(PathWeights, AreFiniteAndReciprocalEverywhere) {
    for (const double tau : {0.0, 1e-300, 1e-9, 1.0, 1e6, 1e12, infinity})
        for (const double in : {1e-6, 0.3, 1.0})
            for (const double out : {1e-6, 0.3, 0.3000001})
                for (const Side side : both_sides) {
                    const PathWeights weights = path_weights(side, 300, tau, in, out);
                    const PathWeights back = path_weights(side, 300, tau, out, in);
                    EXPECT_EQ(weights.count, back.count);
                    for (int n = 1; n < weights.count; ++n) {
                        EXPECT_TRUE(weights.of_order[n] >= 0 && std::isfinite(weights.of_order[n]))
                            << tau << ' ' << in << ' ' << out << ' ' << n;
                        EXPECT_NEAR(weights.of_order[n], back.of_order[n],
                                    1e-12 * weights.of_order[n]);
                    }
                }
}

TEST(PathWeights, LeaveOutOrdersThatAddNothing) {
    for (const double tau : {1e-9, 1e-3, 0.1, 1.0, 10.0, 200.0}) {
        const double s = tau / 0.4 + tau / 0.8;
        const int count =
            path_weights(Side::reflection, PathWeights::max_count, tau, 0.4, 0.8).count;
        EXPECT_LT(count, PathWeights::max_count);
        EXPECT_LT(boost::math::gamma_p(count, s), 1e-16 * boost::math::gamma_p(2, s)) << s;
        EXPECT_EQ(path_weights(Side::reflection, 9, tau, 0.4, 0.8).count, 9);
    }
}

TEST(PathLaw, IsForNarrowForwardPeaksAlone) {
    for (const double g : {0.85, 0.95, 0.997})
        EXPECT_NE(PathOrders::of(PhaseFunction::henyey_greenstein(g)), nullptr) << g;
    for (const double g : {-0.95, 0.0, 0.5, 0.75})
        EXPECT_EQ(PathOrders::of(PhaseFunction::henyey_greenstein(g)), nullptr) << g;
    EXPECT_EQ(PathOrders::of(PhaseFunction::rayleigh()), nullptr);
    EXPECT_EQ(PathOrders::of(PhaseFunction::lambert_sphere()), nullptr);
    // too narrow for any series
    EXPECT_EQ(PathOrders::of(PhaseFunction::henyey_greenstein(0.9999)), nullptr);
}

double polynomial_sum(const std::vector<double>& coefficients, double x) {
    double before = 0, here = 1, sum = 0;
    for (const auto l : indices(coefficients)) {
        const double order = static_cast<double>(l);
        sum += coefficients[l] * here;
        before = std::exchange(here, ((2 * order + 1) * x * here - order * before) / (order + 1));
    }
    return sum;
}

class PathOrdersOf : public testing::TestWithParam<double> {};

TEST_P(PathOrdersOf, AreTheirLegendreSums) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(GetParam());
    const PathLaw law(significant_moments(phase));
    const PathOrders orders(law);
    for (const double albedo : {0.5, 1.0})
        for (const double tau : {0.2, 3.0, infinity})
            for (double degrees = 0.02; degrees < 180; degrees *= 1.2) {
                const double half = degrees / 360 * pi;
                PathWeights weights =
                    path_weights(Side::reflection, orders.order_count(), tau, 0.8, 1);
                for (int n = 0; n < weights.count; ++n) weights.of_order[n] *= std::pow(albedo, n);
                const double exact = polynomial_sum(law.legendre(weights), std::cos(2 * half));
                const double found = orders(weights, 2 * std::pow(std::sin(half), 2),
                                            2 * std::pow(std::cos(half), 2));
                const double once = weights.of_order[1] * phase(std::cos(2 * half));
                double all = 0;  // of isotropic scattering
                for (int n = 1; n < weights.count; ++n) all += weights.of_order[n];
                EXPECT_NEAR(found, exact, 4e-4 * (once + std::abs(exact) + all))
                    << albedo << ' ' << tau << ' ' << degrees;
            }
}

INSTANTIATE_TEST_SUITE_P(, PathOrdersOf, testing::Values(0.85, 0.95, 0.99));

TEST(PathOrders, EndWhereTheSeriesDoes) {
    const auto law = PathOrders::of(PhaseFunction::henyey_greenstein(0.95));
    const Geometry geometry{0.7, 0.8, 0.1};
    const double cosine = cos_scattering_angle_transmitted(geometry);
    const auto up_to = [&](int highest) {
        return (*law)(Side::transmission, 0.9, 2, geometry, highest);
    };
    EXPECT_EQ(up_to(1), 0);
    PathWeights weights = path_weights(Side::transmission, 7, 2, 0.7, 0.8);
    for (int n = 0; n < 4; ++n) weights.of_order[n] = 0;
    for (int n = 4; n < 7; ++n) weights.of_order[n] *= std::pow(0.9, n);
    EXPECT_NEAR(up_to(6) - up_to(3), (*law)(weights, 1 - cosine, 1 + cosine), 1e-12);
    EXPECT_NEAR(up_to(0), up_to(law->order_count() - 1), 0);
    EXPECT_NEAR(up_to(0), up_to(60), 1e-6 * std::abs(up_to(0)));
}

}  // namespace
}  // namespace stratus
