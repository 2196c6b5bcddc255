#include <stratus/transfer/quadrature.h>

#include <stratus/phase/phase_function.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

const NodeMap maps[] = {NodeMap::grazing, NodeMap::forward, NodeMap::square};
const int counts[] = {1, 2, 3, 7, 8, 32, 65, 512};

TEST(GaussDirections, HaveAscendingCosinesBetweenZeroAndOne) {
    for (const NodeMap map : maps)
        for (const int nodes : counts) {
            const Directions directions = gauss_directions(nodes, map);
            ASSERT_EQ(directions.size(), nodes);
            EXPECT_GT(directions.mu(0), 0);
            EXPECT_LT(directions.mu(nodes - 1), 1);
            for (int i = 1; i < nodes; ++i) EXPECT_GT(directions.mu(i), directions.mu(i - 1));
            EXPECT_GT(directions.weight.minCoeff(), 0);
        }
}

TEST(GaussDirections, HaveWeightsThatSumToOne) {
    for (const NodeMap map : maps)
        for (const int nodes : counts)  // one rounding per node
            EXPECT_NEAR(gauss_directions(nodes, map).weight.sum(), 1, 1e-15 + 1e-16 * nodes);
}

TEST(GaussDirections, IntegratePowersOfTheCosineExactly) {
    // Both maps are cubics in x: mu^k dmu is a polynomial of degree 3 k + 2 <= 2 nodes - 1.
    for (const NodeMap map : maps)
        for (const int nodes : {2, 3, 7, 8, 32, 65})
            for (int k = 0; 3 * k + 2 <= 2 * nodes - 1; ++k) {
                const Directions directions = gauss_directions(nodes, map);
                const double integral =
                    directions.mu.array().pow(k).matrix().dot(directions.weight);
                EXPECT_NEAR(integral * (k + 1), 1, 1e-13) << nodes << " nodes, power " << k;
            }
}

TEST(GaussDirections, ResolveGrazingSingularities) {
    // int mu log(1/mu) dmu = 1/4, a singularity of the kind found in the light field
    const Directions directions = gauss_directions(24, NodeMap::grazing);
    const Eigen::ArrayXd mu = directions.mu.array();
    EXPECT_NEAR((-mu * mu.log()).matrix().dot(directions.weight), 0.25, 1e-11);
}

TEST(GaussDirections, ConcentrateWhereTheMapSays) {
    const Directions grazing = gauss_directions(32, NodeMap::grazing);
    const Directions forward = gauss_directions(32, NodeMap::forward);
    EXPECT_LT(grazing.mu(0), 0.1 * forward.mu(0));
    // d mu/d x at 1 is 3 and 1
    EXPECT_NEAR((1 - grazing.mu(31)) / (1 - forward.mu(31)), 3, 0.05);
}

TEST(GaussDirections, KeepExtraCosinesWithWeightZero) {
    const Directions directions = gauss_directions(4, NodeMap::grazing, {1, 1e-4, 0.3});
    ASSERT_EQ(directions.nodes, 4);
    ASSERT_EQ(directions.size(), 7);
    const double extra[] = {1, 1e-4, 0.3};
    for (int e = 0; e < 3; ++e) {
        EXPECT_EQ(directions.mu(4 + e), extra[e]);
        EXPECT_EQ(directions.weight(4 + e), 0);
        EXPECT_DOUBLE_EQ(directions.s(4 + e), std::sqrt(2 * extra[e]));  // weight 1 in the scaling
    }
    for (int i = 0; i < 4; ++i)
        EXPECT_DOUBLE_EQ(directions.s(i), std::sqrt(2 * directions.mu(i) * directions.weight(i)));
}

TEST(GaussDirections, RefuseNodesOutOfRange) {
    for (const int nodes : {0, -1, 513})
        expect_refusal([&] { gauss_directions(nodes, NodeMap::grazing); },
                       {"gauss_directions", "nodes", "[1, 512]", std::to_string(nodes).c_str()});
}

TEST(GaussDirections, RefuseCosinesOutOfRange) {
    for (const double mu : {0.0, -0.5, 1.0001, double{NAN}})
        expect_refusal(
            [&] {
                gauss_directions(8, NodeMap::grazing, {0.5, mu});
            },
            "gauss_directions: mu must be in [1e-100, 1]");
}

NodeMap map_for(const PhaseFunction& phase_function, int nodes) {
    return choose_node_map(phase_function.moments(2 * nodes), nodes);
}

TEST(ChooseNodeMap, IsGrazingForSmoothPhaseFunctions) {
    for (const int nodes : {1, 8, 24, 64}) {
        EXPECT_EQ(map_for(PhaseFunction::isotropic(), nodes), NodeMap::grazing);
        EXPECT_EQ(map_for(PhaseFunction::henyey_greenstein(0.5), nodes), NodeMap::grazing);
    }
}

TEST(ChooseNodeMap, IsForwardForPeaks) {
    // g^N > 10^(-N/4), g > 0.5623
    for (const int nodes : {8, 24, 64}) {
        EXPECT_EQ(map_for(PhaseFunction::henyey_greenstein(0.57), nodes), NodeMap::forward);
        EXPECT_EQ(map_for(PhaseFunction::henyey_greenstein(0.55), nodes), NodeMap::grazing);
        EXPECT_EQ(map_for(PhaseFunction::henyey_greenstein(-0.75), nodes), NodeMap::forward);
    }
}

TEST(ChooseNodeMap, AcceptsFewMoments) { EXPECT_EQ(choose_node_map({1}, 8), NodeMap::grazing); }

}  // namespace
}  // namespace stratus
