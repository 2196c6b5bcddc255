#include <stratus/transfer/solve.h>

#include "indices.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stratus {
namespace {

double diffusion_exponent(const PhaseFunction& phase_function, double albedo) {
    return compute_diffusion_exponents(phase_function, {albedo})[0];
}

/// Root of (w/2k) log((1 + k)/(1 - k)) = 1 in (0, 1), by bisection: the left side grows with k.
double isotropic_exponent(double w) {
    double low = 1e-9, high = 1 - 1e-16;
    for (int n = 0; n < 100; ++n) {
        const double k = (low + high) / 2;
        (w * std::atanh(k) < k ? low : high) = k;
    }
    return low;
}

TEST(DiffusionExponent, SolvesTheCharacteristicEquationOfIsotropicScattering) {
    const struct {
        double albedo;
        double tolerance;  // the eigenfunction 1/(1 - k mu) peaks at mu = 1 as k nears 1
    } rows[] = {{0.5, 1e-7}, {0.7, 1e-10}, {0.9, 1e-12}, {0.99, 1e-12}, {0.999, 1e-12}};
    for (const auto& [w, tolerance] : rows) {
        const double k = diffusion_exponent(PhaseFunction::isotropic(), w);
        EXPECT_NEAR(k / isotropic_exponent(w), 1, tolerance) << w;  // [C60] I, 9
    }
}

TEST(DiffusionExponent, FollowsTheDiffusionLimitNearConservativeScattering) {
    const double w = 1 - 1e-6;
    for (const double g : {-0.6, 0.0, 0.5, 0.75, 0.85}) {
        const double limit = std::sqrt(3 * (1 - w) * (1 - w * g));  // corrections: O(1 - w)
        EXPECT_NEAR(diffusion_exponent(PhaseFunction::henyey_greenstein(g), w) / limit, 1, 3e-6)
            << g;
    }
}

TEST(DiffusionExponent, IsZeroWithoutAbsorption) {
    EXPECT_EQ(diffusion_exponent(PhaseFunction::henyey_greenstein(0.75), 1), 0);
}

TEST(DiffusionExponent, IsTheDecayRateOfDeepTransmission) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.75);
    const double w = 0.95, k = diffusion_exponent(phase_function, w);
    SolverOptions options;
    options.modes = 1;
    const double at_100 = solve_layer(phase_function, w, 100, {}, options).total_transmittance;
    const double at_101 = solve_layer(phase_function, w, 101, {}, options).total_transmittance;
    // the next eigenvalue's share after 100 mean free paths, and rounding
    EXPECT_NEAR(std::log(at_100 / at_101) / k, 1, 1e-9);
}

TEST(DiffusionExponent, IsTheSameForSeveralAlbedos) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.6);
    const std::vector<double> albedos{0, 0.3, 0.99, 1};
    const std::vector<double> exponents = compute_diffusion_exponents(phase, albedos);
    ASSERT_EQ(exponents.size(), albedos.size());
    for (const auto i : indices(albedos))
        EXPECT_EQ(exponents[i], diffusion_exponent(phase, albedos[i]));
}

TEST(DiffusionExponent, RefusesAlbedosOutOfRange) {
    for (const double w : {-1e-9, 1.0001, double{NAN}})
        expect_refusal([&] { diffusion_exponent(PhaseFunction::isotropic(), w); },
                       "compute_diffusion_exponents: albedo must be in [0, 1]");
}

}  // namespace
}  // namespace stratus
