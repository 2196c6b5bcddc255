// Energy conservation without absorption, and absorption with it.
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solve.h>

#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace stratus {
namespace {

const std::vector<double> energy_cosines{1e-3, 0.02, 0.1, 0.3, 0.5, 0.8, 1.0};

struct Medium {
    const char* name;
    const char* phase_function;
    int nodes;
};

class ConservativeLayer : public testing::TestWithParam<Medium> {};

/// A few hundred roundings, at any depth and with any quadrature; where the count of doublings
/// changes, too.
TEST_P(ConservativeLayer, ConservesEnergy) {
    const PhaseFunction phase_function = parse_phase_function(GetParam().phase_function);
    SolverOptions options = with_nodes(GetParam().nodes);
    options.modes = 1;  // the others carry no flux
    // 2^80 = 1.2e24: from 1e-12 to 1e12
    std::vector<LayerSolution> solutions =
        solve_ladder(phase_function, {1}, {1e-12, 81, true}, energy_cosines, options)[0];
    ASSERT_EQ(solutions.size(), 82u);
    for (const double tau : {1e-12, 1e-6, 0.01, 1.0, 100.0, 1e6, 1e12})
        solutions.push_back(solve_layer(phase_function, 1, tau, energy_cosines, options));
    for (const LayerSolution& layer : solutions) {
        expect_conserved(layer, layer.optical_depth, 1e-13);
        EXPECT_GE(layer.spherical_albedo, 0);
        EXPECT_GE(layer.total_transmittance, 0);
    }
}

std::vector<Medium> media() {
    std::vector<Medium> all;
    for (const int nodes : {1, 2, 3, 8, 16, 24, 32, 48, 64}) {
        all.push_back({"isotropic", "isotropic", nodes});
        all.push_back({"rayleigh", "rayleigh", nodes});
        all.push_back({"forward", "henyey_greenstein:g=0.75", nodes});
        all.push_back({"backward", "henyey_greenstein:g=-0.6", nodes});
    }
    return all;
}

INSTANTIATE_TEST_SUITE_P(Medium, ConservativeLayer, testing::ValuesIn(media()),
                         [](const auto& row) {
                             return std::string(row.param.name) + std::to_string(row.param.nodes);
                         });

TEST(AbsorbingLayer, AbsorbsInProportionToDepthWhenThin) {
    // A thin layer absorbs 1 - w of the light it intercepts; the rest leaves, except the
    // O(tau log tau) part that is intercepted twice. 8 nodes: truncated, f = 0.01.
    const double tau = 1e-12, w = 0.75;
    const LayerSolution layer = solve_layer(forward, w, tau, {0.3, 1}, with_nodes(8));
    ASSERT_GT(layer.truncation.fraction, 0);
    for (int i = 0; i < 2; ++i)
        EXPECT_NEAR((layer.plane_albedo(i) + layer.diffuse_transmittance(i)) /
                        intercepted_share(tau, layer.mu(i)),
                    w, 3 * tau * -std::log(tau));
}

TEST(LayerSolution, HasFluxesEqualToIntegratedReflection) {
    // Over the Gauss nodes of mode 0, with single scattering's share from the azimuths: for the
    // isotropic and the Rayleigh layer five azimuths integrate it exactly.
    const Directions nodes = gauss_directions(16, NodeMap::grazing);
    const LayerSolution layer = solve_layer(rayleigh, 0.95, 1.5, {}, with_nodes(16));
    double spherical = 0;
    for (int i = 0; i < 16; ++i) {
        double up = 0, down = 0;
        for (int j = 0; j < 16; ++j)
            for (int k = 0; k < 5; ++k) {
                const double share = 2 * nodes.mu(j) * nodes.weight(j) / 5;
                const double azimuth = 2 * pi * k / 5;
                up += share * layer.reflection(i, j, azimuth).total;
                down += share * layer.transmission(i, j, azimuth).total;
            }
        spherical += 2 * nodes.mu(i) * nodes.weight(i) * up;
        EXPECT_NEAR(layer.plane_albedo(i), up, 1e-13);
        EXPECT_NEAR(layer.diffuse_transmittance(i), down, 1e-13);
    }
    EXPECT_NEAR(layer.spherical_albedo, spherical, 1e-13);
}

}  // namespace
}  // namespace stratus
