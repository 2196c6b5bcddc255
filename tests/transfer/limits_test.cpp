// Limits of the solver: no depth, infinite depth, no scattering.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "usual_layers.h"

#include <boost/math/special_functions/expint.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(SolveLayer, TransmitsOnlyTheBeamAtDepthZero) {
    for (const double w : {0.0, 0.5, 1.0}) {
        const LayerSolution layer = solve_layer(forward, w, 0, cosines);
        EXPECT_TRUE((all_values(layer) == 0).all()) << w;
        EXPECT_EQ(layer.spherical_albedo, 0);
        EXPECT_NEAR(layer.total_transmittance, 1, 1e-15);
    }
}

TEST(SolveLayer, ScattersOnceBelowTheThinnestDepth) {
    const LayerSolution layer = solve_layer(rayleigh, 0.8, 1e-300, cosines);
    for (int in = 0; in < layer.mu.size(); ++in) {
        EXPECT_EQ(layer.reflection(in, 1, 1).total, layer.reflection(in, 1, 1).single);
        // half of 0.8 tau/mu each: Rayleigh scattering is even
        EXPECT_NEAR(layer.plane_albedo(in) / (0.4e-300 / layer.mu(in)), 1, 1e-12);
        EXPECT_NEAR(layer.diffuse_transmittance(in) / (0.4e-300 / layer.mu(in)), 1, 1e-12);
    }
}

TEST(SolveLayer, TransmitsOnlyTheBeamAtAlbedoZero) {
    for (const double tau : {1e-9, 0.5, 8.0, infinity}) {
        const LayerSolution layer = solve_layer(forward, 0, tau, cosines);
        EXPECT_TRUE((all_values(layer).abs() <= 1e-15).all()) << tau;
        EXPECT_NEAR(layer.spherical_albedo, 0, 1e-15);
        const double beam = std::isinf(tau) ? 0 : 2 * boost::math::expint(3, tau);
        // error of 32 nodes of the forward map in the integral of the beam, mu exp(-tau/mu)
        EXPECT_NEAR(layer.total_transmittance, beam, 1e-12) << tau;
    }
}

TEST(SolveLayer, ApproachesSingleScatteringAsTauLogTau) {
    // The ratio of orders 2 and 1 in a thin isotropic layer is (w / 2 tau) times the double
    // integral of E_1(|t - t'|) over it, (w/2) tau (3/2 - gamma - log tau).
    const double w = 0.8, gamma = 0.57721566490153286;
    for (const double tau : {1e-3, 1e-4, 1e-5}) {
        const LayerSolution layer = solve_layer(isotropic, w, tau, {0.5, 1}, with_nodes(48));
        const double again = w / 2 * tau * (1.5 - gamma - std::log(tau));
        for (int i = 0; i < 2; ++i)
            for (const Side side : both_sides) {
                const SolvedValue value = value_at(layer, side, i, 1, 0);
                // the next order of both expansions
                EXPECT_NEAR(value.multiple / value.single / again, 1, 20 * tau) << tau;
            }
    }
}

TEST(SolveLayer, ReachesTheConservativeInfiniteLayerAsOneOverDepth) {
    const LayerSolution infinite = solve_layer(forward, 1, infinity, cosines);
    EXPECT_NEAR(infinite.spherical_albedo, 1, 1e-13);
    for (int in = 0; in < infinite.mu.size(); ++in)
        EXPECT_NEAR(infinite.plane_albedo(in), 1, 1e-13);
    const double tau = 1e10;
    const LayerSolution deep = solve_layer(forward, 1, tau, cosines);
    const Eigen::ArrayXd R = all_radiances(infinite, {1}).head(25), both = all_radiances(deep, {1});
    // escape functions below 3, over (1 - g) tau
    EXPECT_LE((both.head(25) - R).abs().maxCoeff(), 10 / (0.25 * tau));
    expect_near(both.head(25) + both.tail(25), R, 1e-12 * R);
}

TEST(SolveLayer, IsContinuousWhereDoublingStops) {
    // At w = 1 doubling stops where (1 - g) tau = 2^12, and the law of diffusion takes over; just
    // before that, T has a relative rounding error of some 1e-16 tau.
    const double stop = std::ldexp(1.0, 12) / (1 - forward.asymmetry());
    const LayerSolution before = solve_layer(forward, 1, 0.999 * stop, cosines, with_nodes(16));
    const LayerSolution after = solve_layer(forward, 1, 1.001 * stop, cosines, with_nodes(16));
    EXPECT_EQ(after.optical_depth, 1.001 * stop);
    EXPECT_NEAR(1 / after.total_transmittance - 1 / before.total_transmittance,
                0.75 * (1 - forward.asymmetry()) * 0.002 * stop, 1e-11 / after.total_transmittance);
    for (const LayerSolution& layer : {before, after}) {
        EXPECT_NEAR(layer.spherical_albedo + layer.total_transmittance, 1, 1e-14);
        for (int in = 0; in < layer.mu.size(); ++in)
            EXPECT_NEAR(layer.plane_albedo(in) + layer.diffuse_transmittance(in), 1, 1e-13);
    }
    for (int in = 0; in < after.mu.size(); ++in)
        EXPECT_NEAR(after.reflection(in, 1, 1).total + after.transmission(in, 1, 1).total,
                    before.reflection(in, 1, 1).total + before.transmission(in, 1, 1).total, 1e-12);
}

TEST(SolveLayer, ReachesAnyDepthAtAnyCosine) {
    const LayerSolution deep = solve_layer(rayleigh, 0.9, 1e250, {1e-100, 1});
    const LayerSolution infinite = solve_layer(rayleigh, 0.9, infinity, {1e-100, 1});
    EXPECT_NEAR(deep.spherical_albedo, infinite.spherical_albedo, 1e-14);  // rounding
    EXPECT_NEAR(deep.plane_albedo(0), infinite.plane_albedo(0), 1e-14);
}

TEST(SolveLayer, TransmitsNothingAtInfiniteDepth) {
    EXPECT_EQ(solve_layer(forward, 0.9, 1e15, cosines, with_nodes(16)).total_transmittance, 0);
    EXPECT_EQ(solve_layer(forward, 0.9, 1e300, cosines, with_nodes(16)).total_transmittance, 0);
}

}  // namespace
}  // namespace stratus
