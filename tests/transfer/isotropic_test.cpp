// Chandrasekhar's functions against their closed-form properties, and the solver against them.
#include <stratus/transfer/reference/solvers.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

const std::vector<double> isotropic_cosines{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0};

TEST(HFunction, HasThePublishedValueAtNormalDirection) {
    EXPECT_NEAR(HFunction(1)(1), 2.907810529, 5e-10);  // the digits printed
}

TEST(HFunction, HasTheMomentsOfConservativeScattering) {
    const HFunction H(1);  // [C60] V, 37 to 43
    EXPECT_NEAR(H.moment(1), 2 / std::sqrt(3.0), 1e-13);
}

TEST(HFunction, HasTheMeanThatItsEquationImplies) {
    for (const double w : {0.1, 0.5, 0.9, 0.999, 1.0})
        EXPECT_NEAR(HFunction(w).moment(0), 2 / w * (1 - std::sqrt(1 - w)), 1e-13) << w;
}

TEST(HFunction, RefusesAlbedosOutOfRange) {
    for (const double albedo : {-0.25, 1.25})
        expect_refusal([&] { HFunction{albedo}; }, {"HFunction", "albedo", "[0, 1]", "25"});
}

class IsotropicLayer : public testing::TestWithParam<double> {};

/// By the H functions at infinite depth, by X and Y above.
TEST_P(IsotropicLayer, MatchesDoubling) {
    const double w = GetParam();
    for (const double tau : {1e-12, 1e-3, 0.1, 1.0, 8.0, 64.0, infinity}) {
        SCOPED_TRACE(tau);
        const bool is_deep = tau == infinity;
        const LayerSolution layer =
            solve_layer(isotropic, w, tau, isotropic_cosines, with_nodes(is_deep ? 24 : 48));
        const IsotropicSolution exact = solve_isotropic(w, tau, isotropic_cosines);
        const auto expect_near_share = [&](double found, double expected, double share) {
            EXPECT_NEAR(found, expected, (is_deep ? 1e-10 : share) * expected);
        };
        for (int i = 0; i < layer.mu.size(); ++i) {
            for (int j = 0; j < layer.mu.size(); ++j) {  // error of the nodes in thin layers
                expect_near_share(layer.reflection(i, j, 1).total, exact.reflection(i, j), 1e-9);
                expect_near_share(layer.transmission(i, j, 1).total, exact.transmission(i, j),
                                  1e-9);
            }
            expect_near_share(layer.plane_albedo(i), exact.plane_albedo(i), 2e-9);
            expect_near_share(layer.diffuse_transmittance(i), exact.diffuse_transmittance(i), 2e-9);
        }
        expect_near_share(layer.spherical_albedo, exact.spherical_albedo, 1e-9);
        expect_near_share(layer.total_transmittance, exact.total_transmittance, 1e-10);
    }
}

TEST_P(IsotropicLayer, IsConvergedInNodes) {
    for (const double tau : {1e-3, 8.0}) {
        const std::vector<double> mu{1e-12, 1e-4, 0.02, 1};
        const IsotropicSolution layer = solve_isotropic(GetParam(), tau, mu, 64),
                                finer = solve_isotropic(GetParam(), tau, mu, 128);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                EXPECT_NEAR(layer.reflection(i, j) / finer.reflection(i, j), 1, 1e-11) << tau;
                EXPECT_NEAR(layer.transmission(i, j) / finer.transmission(i, j), 1, 1e-10) << tau;
            }
    }
}

/// (w/4) (X Y0 - Y X0) / (mu0 - mu); the solution integrates T over depth instead.
TEST_P(IsotropicLayer, TransmitsAsXAndY) {
    for (const double tau : {0.1, 1.0, 8.0}) {
        const IsotropicSolution layer = solve_isotropic(GetParam(), tau, isotropic_cosines);
        for (int i = 0; i < layer.mu.size(); ++i)
            for (int j = 0; j < i; ++j)  // cancellation loses a factor below 1e3
                EXPECT_NEAR(GetParam() / 4 * (layer.X(i) * layer.Y(j) - layer.Y(i) * layer.X(j)) /
                                (layer.mu(j) - layer.mu(i)) / layer.transmission(i, j),
                            1, 1e-12)
                    << tau << ' ' << layer.mu(i) << ' ' << layer.mu(j);
    }
}

/// X = 1 + (w/2) mu int (X X' - Y Y')/(mu + mu') dmu' = 1 + 2 mu int R(mu, mu') dmu'.  [C60] VIII
TEST_P(IsotropicLayer, ObeysTheIntegralEquationOfX) {
    const int nodes = 32;
    const Directions directions = gauss_directions(nodes, NodeMap::grazing);
    std::vector<double> mu(directions.mu.begin(), directions.mu.end());
    mu.push_back(0.3);
    mu.push_back(1);
    for (const double tau : {1.0, 64.0}) {
        const IsotropicSolution layer = solve_isotropic(GetParam(), tau, mu);
        for (const int i : {nodes, nodes + 1})
            EXPECT_NEAR(
                layer.X(i),
                1 + 2 * layer.mu(i) * directions.weight.dot(layer.reflection.col(i).head(nodes)),
                1e-11)
                << tau << ' ' << layer.mu(i);
    }
}

INSTANTIATE_TEST_SUITE_P(OfAlbedo, IsotropicLayer,
                         testing::Values(0.3, 0.5, 0.9, 0.99, 0.999, 1.0));

TEST(SolveIsotropic, ConservesEnergyWithoutAbsorption) {
    for (const double tau : {1e-300, 1e-6, 0.1, 1.0, 8.0, 64.0})
        expect_conserved(solve_isotropic(1, tau, isotropic_cosines), tau, 1e-12);
}

TEST(SolveIsotropic, ApproachesTheSemiInfiniteLayer) {
    const IsotropicSolution deep = solve_isotropic(0.9, 64, isotropic_cosines);
    for (int i = 0; i < deep.mu.size(); ++i) {
        EXPECT_NEAR(deep.X(i), HFunction(0.9)(deep.mu(i)), 1e-12) << deep.mu(i);
        EXPECT_NEAR(deep.Y(i), 0, 1e-12) << deep.mu(i);  // exp(-0.525 * 64) = 3e-15
    }
}

TEST(SolveIsotropic, AcceptsRepeatedCosines) {
    const IsotropicSolution layer = solve_isotropic(0.9, 2, {0.5, 1, 0.5});
    for (int i = 0; i < 3; ++i) {
        EXPECT_DOUBLE_EQ(layer.transmission(i, 0), layer.transmission(i, 2)) << i;
        EXPECT_DOUBLE_EQ(layer.transmission(0, i), layer.transmission(i, 0)) << i;
        EXPECT_DOUBLE_EQ(layer.reflection(i, 0), layer.reflection(i, 2)) << i;
    }
}

TEST(SolveIsotropic, TransmitsOnlyTheBeamAtDepthZeroAndAlbedoZero) {
    const IsotropicSolution empty = solve_isotropic(1, 0, isotropic_cosines),
                            black = solve_isotropic(0, 2, isotropic_cosines);
    for (const IsotropicSolution& layer : {empty, black}) {
        EXPECT_EQ(layer.reflection.cwiseAbs().maxCoeff(), 0);
        EXPECT_EQ(layer.transmission.cwiseAbs().maxCoeff(), 0);
    }
    EXPECT_EQ(empty.spherical_albedo, 0);
    EXPECT_NEAR(empty.total_transmittance, 1, 1e-15);
    EXPECT_EQ(empty.X.minCoeff(), 1);
    EXPECT_EQ(empty.Y.minCoeff(), 1);
    for (int i = 0; i < black.mu.size(); ++i)
        EXPECT_DOUBLE_EQ(black.Y(i), std::exp(-2 / black.mu(i))) << black.mu(i);
}

TEST(SolveIsotropic, RefusesArgumentsOutOfRange) {
    const auto refused = [](double albedo, double optical_depth, double mu, int nodes,
                            const char* reason) {
        expect_refusal([&] { solve_isotropic(albedo, optical_depth, {mu}, nodes); }, reason);
    };
    refused(1.25, 1, 1, 8, "solve_isotropic: albedo must be in [0, 1], got 1.25");
    refused(-0.25, 1, 1, 8, "albedo must be in [0, 1], got -0.25");
    refused(1, -0.5, 1, 8, "optical_depth must be in [0, 1024] or inf, got -0.5");
    refused(1, 1025, 1, 8, "optical_depth must be in [0, 1024] or inf, got 1025");
    refused(1, NAN, 1, 8, "optical_depth must be in [0, 1024] or inf, got nan");
    refused(1, 1, 5e-13, 8, "mu must be in [1e-12, 1], got 5e-13");
    refused(1, 1, 1.25, 8, "mu must be in [1e-12, 1], got 1.25");
    refused(1, infinity, 0, 8, "mu must be in [1e-12, 1], got 0");
    refused(1, 1, 1, 0, "nodes must be in [1, 512], got 0");
    refused(1, 1, 1, 513, "nodes must be in [1, 512], got 513");
}

}  // namespace
}  // namespace stratus
