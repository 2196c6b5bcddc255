#include <stratus/transfer/truncation.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "usual_layers.h"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace stratus {
namespace {

const Truncation truncation = truncate_peak(peaked, 48);
const std::vector<double> moments = significant_moments(peaked);

double kept(std::size_t l) {  // c_l
    return l < truncation.moments.size() ? (1 - truncation.fraction) * truncation.moments[l] : 0;
}

/// Orders n >= 2 along a path of depth s with one turn, for each depth of the turn: those of the
/// true layer less those that the truncated layer scatters twice or more.
double path_moment(std::size_t l, double w, double s) {
    const auto twice_or_more = [&](double chi, double passing) {
        const double u = w * chi * s;
        return std::exp(-(1 - w * passing) * s) * (std::expm1(u) - u) / s;
    };
    return twice_or_more(moments[l], 0) - twice_or_more(kept(l), truncation.fraction);
}

/// All that a solution adds to the modes, at albedo w.
std::vector<double> added(const TruncatedPath& path, Side side, double w, double tau, double in,
                          double out) {
    PathWeights weights = path_weights(side, path.law().order_count(), tau, in, out);
    for (int n = 0; n < weights.count; ++n) weights.of_order[n] *= std::pow(w, n);
    std::vector<double> sum = path.law().legendre(weights);
    const Eigen::VectorXd rest = path.rest({&weights, 1});
    for (Eigen::Index l = 0; l < rest.size(); ++l) sum[static_cast<std::size_t>(l)] += rest(l);
    return sum;
}

TEST(TruncatedPath, EqualsItsIntegralOverDepth) {
    boost::math::quadrature::tanh_sinh<double> integrate;
    const TruncatedPath path(PathLaw(moments), truncation);
    for (const double w : {0.3, 1.0})
        for (const double tau : {0.3, 4.0})
            for (const auto& [mu_in, mu_out] : {std::pair{0.4, 0.9}, std::pair{0.7, 0.7}}) {
                const double in = mu_in, out = mu_out;  // which lambdas can capture
                const std::vector<double> up = added(path, Side::reflection, w, tau, in, out);
                const std::vector<double> down = added(path, Side::transmission, w, tau, in, out);
                for (const std::size_t l : {1u, 2u, 5u, 10u, 25u, 40u, 47u, 48u, 60u, 200u}) {
                    const double size = 2 * static_cast<double>(l) + 1;
                    const auto reflected = [&](double t) {
                        return t > 0 ? path_moment(l, w, t / in + t / out) : 0;
                    };
                    const auto transmitted = [&](double t) {
                        return path_moment(l, w, t / in + (tau - t) / out);
                    };
                    const double scale = size / (4 * in * out);
                    EXPECT_NEAR(up[l], scale * integrate.integrate(reflected, 0.0, tau),
                                1e-9 * scale)
                        << l;
                    EXPECT_NEAR(down[l], scale * integrate.integrate(transmitted, 0.0, tau),
                                1e-9 * scale)
                        << l;
                }
            }
}

TEST(TruncatedPath, VanishesWithoutScatteringAndEndsWithTheTruncatedSeries) {
    const TruncatedPath path(PathLaw(moments), truncation);
    for (const Side side : both_sides)
        for (const double c : added(path, side, 0, 2, 0.3, 0.8)) EXPECT_EQ(c, 0);
    const PathWeights weights = path_weights(Side::reflection, 20, 1, 0.5, 0.7);
    EXPECT_EQ(path.rest({&weights, 1}).rows(), std::ssize(truncation.moments));
}

TEST(SumLegendre, IsTheSumOfThePolynomials) {
    std::vector<double> coefficients(1000);
    for (const auto l : indices(coefficients)) coefficients[l] = std::cos(static_cast<double>(l));
    for (const double x : {-1.0, -0.3, 0.0, 0.7, 1.0}) {
        double sum = 0;
        for (const auto l : indices(coefficients))
            sum += coefficients[l] * std::legendre(static_cast<unsigned>(l), x);
        EXPECT_NEAR(sum_legendre(coefficients, x), sum, 1e-11);
    }
    EXPECT_EQ(sum_legendre({}, 0.5), 0);
}

// ---- errors by region --------------------------------------------------------------------------

struct Region {
    std::vector<double> errors;  // relative, ascending
    double median() const { return errors[errors.size() / 2]; }
    double worst() const { return errors.back(); }
};

struct Regions {
    // Scattering angles within 10 degrees, and beyond; either cosine below 0.15, whatever the angle.
    Region forward, elsewhere, grazing;
};

/// Errors of R and T with few nodes against many.
Regions compare(double g, double tau, int few, int many) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(g);
    const std::vector<double> mu{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1};
    const LayerSolution found = solve_layer(phase_function, 1, tau, mu, with_nodes(few)),
                        expected = solve_layer(phase_function, 1, tau, mu, with_nodes(many));
    Regions regions;
    for (int i = 0; i < 7; ++i)
        for (int j = i; j < 7; ++j)
            for (int k = 0; k <= 6; ++k) {
                const double azimuth = k * pi / 6;
                const Geometry at{found.mu(i), found.mu(j), azimuth};
                for (const Side side : both_sides) {
                    Region& region = std::min(found.mu(i), found.mu(j)) < 0.15 ? regions.grazing
                                     : cos_scattering_angle(side, at) > std::cos(pi / 18)
                                         ? regions.forward
                                         : regions.elsewhere;
                    region.errors.push_back(
                        std::abs(found.values(side, i, j, {azimuth})[0].total /
                                     expected.values(side, i, j, {azimuth})[0].total -
                                 1));
                }
            }
    for (Region* region : {&regions.forward, &regions.elsewhere, &regions.grazing})
        std::ranges::sort(region->errors);
    return regions;
}

// The limits are twice the measured errors.

TEST(PeakedPhaseFunctions, MatchTheReference) {
    const Regions at_090 = compare(0.9, 2, 48, 96);
    EXPECT_LT(at_090.elsewhere.worst(), 2e-5);
    EXPECT_LT(at_090.elsewhere.median(), 5e-7);
    EXPECT_LT(at_090.forward.worst(), 4e-5);
    const Regions at_095 = compare(0.95, 8, 48, 128);
    EXPECT_LT(at_095.elsewhere.worst(), 2.5e-3);
    EXPECT_LT(at_095.elsewhere.median(), 6e-6);
    EXPECT_LT(at_095.forward.worst(), 7e-3);
    EXPECT_LT(at_095.forward.median(), 8e-4);
    EXPECT_LT(at_095.grazing.worst(), 2e-2);
    const Regions at_099 = compare(0.99, 2, 32, 128);
    EXPECT_LT(at_099.elsewhere.median(), 3e-3);
    EXPECT_LT(at_099.forward.median(), 3e-3);
}

/// T near the normal by small-angle theory: light keeps its slant depth s while its Legendre moments
/// fall to exp(-s (1 - w chi_l)).
double small_angle_transmission(const std::vector<double>& chi, double tau, double cosine) {
    std::vector<double> light(chi.size());
    for (const auto l : indices(chi))
        light[l] =
            (2 * static_cast<double>(l) + 1) * (std::exp(-tau * (1 - chi[l])) - std::exp(-tau));
    return sum_legendre(light, cosine) / 4;
}

void expect_small_angle_theory(const PhaseFunction& phase, const std::vector<double>& degrees,
                               double deepest, double limit) {
    const std::vector<double> chi = significant_moments(phase, 1 << 20);
    ASSERT_FALSE(chi.empty());
    std::vector<double> mu;
    for (const double angle : degrees) mu.push_back(std::cos(angle * pi / 180));
    for (double tau = 0.1; tau <= deepest; tau *= tau < 10 ? 10 : 2) {
        const LayerSolution layer = solve_layer(phase, 1, tau, mu);
        for (const auto k : indices(mu)) {
            const double expected = small_angle_transmission(chi, tau, mu[k]);
            EXPECT_NEAR(layer.transmission(0, static_cast<int>(k), 0).total / expected, 1, limit)
                << phase.caption() << ", tau " << tau << ", " << degrees[k] << " degrees";
        }
    }
}

// What small-angle theory leaves out grows with the width of the beam: at g = 0.99 and a depth of 20,
// 4e-3.
TEST(NarrowPeaks, FollowSmallAngleTheory) {
    for (const double g : {0.99, 0.997, 0.998, 0.999, 0.9999})
        expect_small_angle_theory(PhaseFunction::henyey_greenstein(g), {0, 0.01, 0.1, 0.5, 1, 2},
                                  20, 5e-3);
}

TEST(NarrowPeaks, OfLargeDropletsFollowSmallAngleTheoryWithinTheDiffractionLobe) {
    for (const char* const droplets :
         {"mie:radius=50um,wavelength=0.45um", "mie:radius=350um,wavelength=0.45um"})
        expect_small_angle_theory(parse_phase_function(droplets), {0, 0.01}, 1, 1e-3);
}

TEST(NarrowPeaks, AreRefusedWhereNoSeriesHoldsThem) {
    EXPECT_THROW(solve_layer(PhaseFunction::henyey_greenstein(0.999995), 1, 1, {1}),
                 std::invalid_argument);
}

}  // namespace
}  // namespace stratus
