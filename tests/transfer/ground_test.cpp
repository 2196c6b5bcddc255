// Layers over grounds with laws of their own; photons: stack_photons_test.cpp.
#include <stratus/table/member_and_ground.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "light_inside.h"

#include <gtest/gtest.h>

#include <vector>

namespace stratus {
namespace {

const std::vector<double> mu{0.1, 0.4, 0.9};

std::vector<StackLayer> haze_over_air(double albedo) {
    return {{PhaseFunction::henyey_greenstein(0.7), albedo, 0.4},
            {PhaseFunction::rayleigh(), albedo, 0.2}};
}

const char* const laws[] = {"ocean:wind=5", "rpv:rho0=0.2,k=0.7,theta=-0.1,rho_c=0.4"};

TEST(Ground, WhoseLawIsLambertsIsALambertSurface) {
    const StackSolution lambert = solve_stack(haze_over_air(0.9), LowerBoundary::surface(0.3), mu),
                        rpv = solve_stack(haze_over_air(0.9),
                                          read_ground("rpv:rho0=0.3,k=1,theta=0,rho_c=1"), mu);
    for (int in = 0; in < 3; ++in) {
        for (int out = 0; out < 3; ++out) {
            const SolvedValue expected = lambert.reflection(in, out, 0.7),
                              met = rpv.reflection(in, out, 0.7);
            EXPECT_NEAR(met.total, expected.total, 1e-13);
            EXPECT_NEAR(met.single, expected.single, 1e-13);
        }
        EXPECT_NEAR(rpv.plane_albedo(in), lambert.plane_albedo(in), 1e-13);
        EXPECT_NEAR(rpv.ground_absorptance(in), lambert.ground_absorptance(in), 1e-13);
        EXPECT_NEAR(rpv.diffuse_transmittance(in), lambert.diffuse_transmittance(in), 1e-13);
    }
    EXPECT_NEAR(rpv.total_transmittance, lambert.total_transmittance, 1e-13);
}

TEST(Ground, IsSeenThroughNothingAsItIs) {
    for (const char* text : laws) {
        const LowerBoundary ground = read_ground(text);
        const StackSolution bare = solve_stack({{PhaseFunction::rayleigh(), 1, 0}}, ground, mu);
        for (int in = 0; in < 3; ++in) {
            for (int out = 0; out < 3; ++out)
                EXPECT_NEAR(bare.reflection(in, out, 0.2).total,
                            (*ground.law)({mu[static_cast<std::size_t>(in)],
                                           mu[static_cast<std::size_t>(out)], 0.2}),
                            1e-12);
            // The law's own quadrature and the solver's nodes.
            EXPECT_NEAR(bare.plane_albedo(in),
                        plane_albedo(*ground.law, mu[static_cast<std::size_t>(in)]), 1e-3);
        }
    }
}

TEST(Ground, AbsorbsAllThatALayerWithoutAbsorptionDoesNotReflect) {
    for (const char* text : laws) {
        const StackSolution solved = solve_stack(haze_over_air(1), read_ground(text), mu);
        for (int in = 0; in < 3; ++in)
            EXPECT_NEAR(solved.plane_albedo(in) + solved.ground_absorptance(in), 1, 1e-12) << text;
        EXPECT_NEAR(solved.spherical_albedo + solved.spherical_ground_absorptance, 1, 1e-12);
    }
}

TEST(Ground, KeepsAllLightBetweenAWhiteSurfaceAndAWhiteLayerOfAnyDepth) {
    // From 1e16 on, I - R* R is singular to the last bit at some of these nodes.
    for (const double g : {-0.5, 0.0, 0.75})
        for (const int nodes : {1, 4, 16})
            for (const double depth : {1e10, 1e17, 1e30, 1e300}) {
                SolverOptions options;
                options.nodes = nodes;
                const StackSolution solved =
                    solve_stack({{PhaseFunction::henyey_greenstein(g), 1, depth}},
                                LowerBoundary::surface(1), mu, options);
                EXPECT_NEAR(solved.spherical_albedo, 1, 1e-12) << g << ' ' << nodes << ' ' << depth;
                EXPECT_GT(solved.reflection(0, 2, 0.2).total, 0);
            }
}

TEST(Ground, LeavesReflectionReciprocal) {
    for (const char* text : laws) {
        const StackSolution solved = solve_stack(haze_over_air(0.9), read_ground(text), mu);
        for (const double azimuth : {0.0, 2.0})
            EXPECT_NEAR(solved.reflection(0, 2, azimuth).total,
                        solved.reflection(2, 0, azimuth).total, 1e-13)
                << text;
    }
}

TEST(Ground, SendsUpALayersLightInWhicheverWayItIsSolved) {
    for (const char* text : laws) {
        const LowerBoundary ground = read_ground(text);
        const std::vector<StackLayer> layers = haze_over_air(0.6);
        SolverOptions options, by_order;
        options.nodes = by_order.nodes = 12;
        by_order.orders = 16;
        const StackSolution all = solve_stack(layers, ground, mu, options);
        const InsideSolution inside = solve_inside(layers, ground, {0}, mu, options);
        const std::vector<StackSolution> orders = solve_orders(layers, ground, mu, by_order);
        double sum = 0;
        for (const StackSolution& order : orders) sum += order.reflection(1, 2, 0.3).total;
        EXPECT_NEAR(sum, all.reflection(1, 2, 0.3).total, 1e-6) << text;
        EXPECT_NEAR(inside.values(Side::reflection, 1, 2, {0.3})[0].total,
                    all.reflection(1, 2, 0.3).total, 1e-6);
        // A single layer takes another way, by a ladder of depths.
        const StackLayer& top = layers[0];
        const LayerSolution ladder =
            solve_layer(top.phase_function, top.albedo, top.optical_depth, mu, {}, ground);
        EXPECT_NEAR(ladder.reflection(1, 2, 0.3).total,
                    solve_stack({top}, ground, mu).reflection(1, 2, 0.3).total, 1e-9);
    }
}

}  // namespace
}  // namespace stratus
