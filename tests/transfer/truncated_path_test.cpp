#include <stratus/transfer/forward_peak.h>

#include <stratus/runtime/constants.h>
#include <stratus/transfer/solve.h>

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace stratus {
namespace {

const PhaseFunction peaked = PhaseFunction::henyey_greenstein(0.95);
const Truncation truncation = truncate_peak(peaked, 48);
const std::vector<double> moments = peak_moments(peaked);

/// F_l(s) of the header less its limit at large l, written out.
double path_moment(std::size_t l, double w, double s) {
    const double c =
        l < truncation.moments.size() ? (1 - truncation.fraction) * truncation.moments[l] : 0;
    const double q = moments[l] - c, f = truncation.fraction;
    const auto of = [&](double rest, double taken) {
        const double u = w * (taken - f) * s;
        return std::exp(-(1 - w * f) * s) * (std::exp(w * rest * s) * std::expm1(u) - u) / s;
    };
    return of(c, q) - of(0, 0);
}

TEST(ForwardPeak, EqualsItsIntegralOverDepth) {
    boost::math::quadrature::tanh_sinh<double> integrate;
    for (const double w : {0.3, 1.0})
        for (const double tau : {0.3, 4.0})
            for (const auto& [mu_in, mu_out] : {std::pair{0.4, 0.9}, std::pair{0.7, 0.7}}) {
                const double in = mu_in, out = mu_out;  // which lambdas can capture
                const ForwardPeak peak(moments, truncation, w);
                const std::vector<double> up = peak.reflection(tau, in, out);
                const std::vector<double> down = peak.transmission(tau, in, out);
                for (const std::size_t l : {0u, 1u, 10u, 25u, 40u, 47u, 48u, 60u, 200u}) {
                    const double size = 2 * static_cast<double>(l) + 1;
                    const auto reflected = [&](double t) {
                        return t > 0 ? path_moment(l, w, t / in + t / out) : 0;
                    };
                    const auto transmitted = [&](double t) {
                        return path_moment(l, w, t / in + (tau - t) / out);
                    };
                    const double scale = size / (4 * in * out);
                    EXPECT_NEAR(up[l], scale * integrate.integrate(reflected, 0.0, tau),
                                1e-11 * scale)
                        << l;
                    EXPECT_NEAR(down[l], scale * integrate.integrate(transmitted, 0.0, tau),
                                1e-11 * scale)
                        << l;
                }
            }
}

TEST(ForwardPeak, IsReciprocalAndFiniteEverywhere) {
    for (const double w : {0.0, 1e-12, 0.9, 1.0}) {
        const ForwardPeak peak(moments, truncation, w);
        for (const double tau : {0.0, 1e-300, 1e-9, 1.0, 1e6, 1e12, infinity})
            for (const double in : {1e-6, 0.3, 1.0})
                for (const double out : {1e-6, 0.3, 0.3000001}) {
                    const double up = sum_legendre(peak.reflection(tau, in, out), 0.9);
                    const double down = sum_legendre(peak.transmission(tau, in, out), 0.9);
                    EXPECT_TRUE(std::isfinite(up) && std::isfinite(down)) << tau << ' ' << in;
                    EXPECT_NEAR(up, sum_legendre(peak.reflection(tau, out, in), 0.9),
                                1e-10 * std::abs(up));
                    EXPECT_NEAR(down, sum_legendre(peak.transmission(tau, out, in), 0.9),
                                1e-8 * std::abs(down) + 1e-12);
                }
    }
}

TEST(ForwardPeak, VanishesWithoutScattering) {
    const ForwardPeak peak(moments, truncation, 0);
    for (const double c : peak.reflection(2, 0.3, 0.8)) EXPECT_EQ(c, 0);
    for (const double c : peak.transmission(2, 0.3, 0.8)) EXPECT_EQ(c, 0);
}

TEST(SumLegendre, IsTheSumOfThePolynomials) {
    std::vector<double> coefficients(40);
    for (std::size_t l = 0; l < coefficients.size(); ++l)
        coefficients[l] = std::cos(static_cast<double>(l));
    for (const double x : {-1.0, -0.3, 0.0, 0.7, 1.0}) {
        double sum = 0;
        for (std::size_t l = 0; l < coefficients.size(); ++l)
            sum += coefficients[l] * std::legendre(static_cast<unsigned>(l), x);
        EXPECT_NEAR(sum_legendre(coefficients, x), sum, 1e-13);
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
    Region forward, elsewhere;  // scattering angles within 10 degrees, and beyond
};

/// Errors of R and T with few nodes against many.
Regions compare(double g, double tau, int few, int many) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(g);
    const std::vector<double> mu{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1};
    SolverOptions options;
    options.nodes = few;
    const LayerSolution found = solve_layer(phase_function, 1, tau, mu, options);
    options.nodes = many;
    const LayerSolution expected = solve_layer(phase_function, 1, tau, mu, options);
    Regions regions;
    for (int i = 0; i < 7; ++i)
        for (int j = i; j < 7; ++j)
            for (int k = 0; k <= 6; ++k) {
                const double azimuth = k * pi / 6;
                const Geometry at{found.mu(i), found.mu(j), azimuth};
                const auto add = [&](double cosine, double value, double reference) {
                    Region& region =
                        cosine > std::cos(pi / 18) ? regions.forward : regions.elsewhere;
                    region.errors.push_back(std::abs(value / reference - 1));
                };
                add(cos_scattering_angle_reflected(at), found.reflection(i, j, azimuth).total,
                    expected.reflection(i, j, azimuth).total);
                add(cos_scattering_angle_transmitted(at), found.transmission(i, j, azimuth).total,
                    expected.transmission(i, j, azimuth).total);
            }
    for (Region* region : {&regions.forward, &regions.elsewhere})
        std::sort(region->errors.begin(), region->errors.end());
    return regions;
}

// The limits are twice the measured errors.

TEST(PeakedPhaseFunctions, MatchTheReferenceWith48NodesAt090) {
    const Regions at = compare(0.9, 2, 48, 96);
    EXPECT_LT(at.elsewhere.worst(), 2e-5);
    EXPECT_LT(at.elsewhere.median(), 5e-7);
    EXPECT_LT(at.forward.worst(), 4e-5);
}

TEST(PeakedPhaseFunctions, MatchTheReferenceWith48NodesAt095) {
    const Regions at = compare(0.95, 8, 48, 128);
    EXPECT_LT(at.elsewhere.worst(), 2.5e-3);
    EXPECT_LT(at.elsewhere.median(), 6e-6);
    EXPECT_LT(at.forward.worst(), 7e-3);
    EXPECT_LT(at.forward.median(), 8e-4);
}

TEST(PeakedPhaseFunctions, MatchTheReferenceWith32NodesAt099) {
    const Regions at = compare(0.99, 2, 32, 128);
    EXPECT_LT(at.elsewhere.median(), 3e-3);
    EXPECT_LT(at.forward.median(), 3e-3);
}

}  // namespace
}  // namespace stratus
