#include "paths.h"

#include <stratus/base/constants.h>
#include <stratus/phase/path_law.h>
#include <stratus/transfer/solve.h>

#include "usual_layers.h"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace stratus {
namespace {

/// Moments (-1)^l chi_l of light along a line of cosine mu, lit from above.
struct Line {
    double b, tau, mu;

    double k() const { return std::sqrt(1 - b * b); }
    double scale() const {
        const double K = k() * tau / mu;
        return k() * std::cosh(K) + std::sinh(K);
    }
    double down(double t) const {
        const double rest = k() * (tau - t) / mu;
        return (k() * std::cosh(rest) + std::sinh(rest)) / scale();
    }
    double up(double t) const { return b * std::sinh(k() * (tau - t) / mu) / scale(); }
};

template <class Function>
double integral(double from, double to, const Function& function) {
    return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(function, from, to, 8,
                                                                         1e-10);
}

const std::vector<double> moments = significant_moments(PhaseFunction::henyey_greenstein(-0.95));

TEST(BackwardPath, EqualsItsIntegralsOverDepthAndB) {
    const BackwardPath path(moments, {1, moments[1], moments[2]});
    const double w = 0.97;
    for (const double tau : {0.3, 4.0})
        for (const auto& [mu_in, mu_out] : {std::pair{0.4, 0.9}, std::pair{0.7, 0.7}}) {
            const double in = mu_in, out = mu_out;  // which lambdas can capture
            const std::vector<double> R = path.legendre(Side::reflection, w, tau, in, out),
                                      T = path.legendre(Side::transmission, w, tau, in, out);
            EXPECT_EQ(R[2], 0);
            for (const std::size_t l : {3u, 4u, 20u, 61u}) {
                const double end = w * std::abs(moments[l]), sign = l % 2 == 0 ? 1 : -1;
                const auto added = [&](const auto& at_depth) {
                    return (2 * static_cast<double>(l) + 1) / (4 * in * out) *
                           integral(0, end, [&](double b) {
                               const Line first{b, tau, in}, then{b, tau, out};
                               return integral(0, tau,
                                               [&](double t) { return at_depth(first, then, t); });
                           });
                };
                const double once = (1 / in + 1 / out) * tau;
                EXPECT_NEAR(R[l], sign * added([&](const Line& first, const Line& then, double t) {
                                      return first.down(t) * then.down(t) +
                                             first.up(t) * then.up(t) - std::exp(-once * t / tau);
                                  }),
                            1e-8)
                    << l;
                EXPECT_NEAR(T[l], added([&](const Line& first, const Line& then, double t) {
                                return first.down(t) * then.up(tau - t) +
                                       first.up(t) * then.down(tau - t);
                            }),
                            1e-8)
                    << l;
            }
        }
}

TEST(BackwardPath, IsTheTwoStreamSolutionWhereBothCosinesAreAlike) {
    const BackwardPath path(moments, {1});
    for (const double mu : {0.3, 1.0})
        for (const double tau : {0.01, 1.0, 30.0}) {
            const std::vector<double> R = path.legendre(Side::reflection, 1, tau, mu, mu),
                                      T = path.legendre(Side::transmission, 1, tau, mu, mu);
            for (const std::size_t l : {1u, 6u, 50u}) {
                const Line line{std::abs(moments[l]), tau, mu};
                const double size = (2 * static_cast<double>(l) + 1) / (4 * mu);
                const double once = -line.b * std::expm1(-2 * tau / mu) / 2;
                EXPECT_NEAR(std::abs(R[l]), size * (line.up(0) - once), 1e-8 * size) << l;
                EXPECT_NEAR(T[l], size * (line.down(tau) - std::exp(-tau / mu)), 1e-8 * size) << l;
            }
        }
}

TEST(BackwardPath, ReachesInfiniteDepth) {
    const BackwardPath path(moments, {1});
    const std::vector<double> deep = path.legendre(Side::reflection, 0.99, 1e4, 0.4, 0.9);
    EXPECT_EQ(path.legendre(Side::reflection, 0.99, infinity, 0.4, 0.9), deep);
    EXPECT_EQ(path.legendre(Side::transmission, 0.99, infinity, 0.4, 0.9)[3], 0);
}

LayerSolution solved(double g, double albedo, double tau, int nodes, Truncate truncate,
                     const LowerBoundary& boundary = {}) {
    return solve_layer(PhaseFunction::henyey_greenstein(g), albedo, tau, {1, 0.7, 0.4},
                       with_nodes(nodes, truncate), boundary);
}

TEST(BackwardPeaks, AgreeWithNodesThatHoldAllMoments) {
    const std::vector<double> at{0, 0.02, 0.3, 1, 2, 3, 3.1, pi};
    for (const LowerBoundary& boundary : {nothing, LowerBoundary::surface(0.5)})
        for (const double tau : {0.3, 4.0}) {
            const Eigen::ArrayXd few = all_values(
                                     solved(-0.9, 0.99, tau, 32, Truncate::smooth, boundary), at),
                                 many = all_values(
                                     solved(-0.9, 0.99, tau, 88, Truncate::nothing, boundary), at);
            // What the law leaves: most where R is least, near forward.
            expect_near(few.head(72), many.head(72), 2e-3 * many.head(72));
            expect_near(few.segment(72, 72), many.segment(72, 72), 5e-4 * many.segment(72, 72));
        }
}

/// Straight back and straight on, along the normal: the two-stream solution of all moments.
TEST(BackwardPeaks, OfAnyWidthAreTheTwoStreamSolutionAlongTheNormal) {
    const double g = -0.999, w = 1;
    for (const double tau : {0.5, 5.0}) {
        const LayerSolution layer = solved(g, w, tau, 32, Truncate::smooth);
        double R = 0, T = 0;
        for (int l = 0; l < 20000; ++l) {
            const Line line{w * std::pow(-g, l) * (l == 0 ? 1 - 1e-9 : 1), tau, 1};
            R += (2 * l + 1) * line.up(0) / 4;
            T += (2 * l + 1) * (line.down(tau) - std::exp(-tau)) / 4;
        }
        EXPECT_NEAR(layer.reflection(0, 0, 0).total / R, 1, 1e-3) << tau;
        EXPECT_NEAR(layer.transmission(0, 0, 0).total / T, 1, 1e-3) << tau;
    }
}

}  // namespace
}  // namespace stratus
