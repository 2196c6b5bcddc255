// Energy conservation without absorption, and absorption with it.
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solve.h>

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>

namespace stratus {
namespace {

const std::vector<double> energy_cosines{1e-3, 0.02, 0.1, 0.3, 0.5, 0.8, 1.0};

struct Medium {
    const char* name;
    const char* phase_function;
    int nodes;
};

void PrintTo(const Medium& of, std::ostream* out) { *out << of.phase_function << ' ' << of.nodes; }

class ConservativeLayer : public testing::TestWithParam<Medium> {
  protected:
    static SolverOptions options() {
        SolverOptions options;
        options.nodes = GetParam().nodes;
        options.modes = 1;  // the others carry no flux
        return options;
    }

    /// A few hundred roundings, at any depth and with any quadrature.
    static constexpr double tolerance = 1e-13;

    static void expect_balance(const LayerSolution& layer) {
        const double tau = layer.optical_depth;
        EXPECT_NEAR(layer.spherical_albedo + layer.total_transmittance, 1, tolerance) << tau;
        EXPECT_GE(layer.spherical_albedo, 0);
        EXPECT_GE(layer.total_transmittance, 0);
        for (int i = 0; i < layer.mu.size(); ++i)
            EXPECT_NEAR(layer.plane_albedo(i) + layer.diffuse_transmittance(i) +
                            direct_transmittance(tau, layer.mu(i)),
                        1, tolerance)
                << "tau " << tau << " mu " << layer.mu(i);
    }
};

TEST_P(ConservativeLayer, ConservesEnergyAtEveryOctave) {
    // 2^80 = 1.2e24: from 1e-12 to 1e12
    const auto solutions = solve_ladder(parse_phase_function(GetParam().phase_function), {1},
                                        {1e-12, 81, true}, energy_cosines, options());
    ASSERT_EQ(solutions[0].size(), 82u);
    for (const LayerSolution& layer : solutions[0]) expect_balance(layer);
}

TEST_P(ConservativeLayer, ConservesEnergyWhereTheDoublingCountChanges) {
    for (const double tau : {1e-12, 1e-6, 0.01, 1.0, 100.0, 1e6, 1e12})
        expect_balance(solve_layer(parse_phase_function(GetParam().phase_function), 1, tau,
                                   energy_cosines, options()));
}

std::vector<Medium> media() {
    std::vector<Medium> all;
    for (const int nodes : {8, 16, 24, 32, 48, 64}) {
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

TEST(AbsorbingLayer, AbsorbsLight) {
    for (const double w : {0.2, 0.9, 1 - 1e-6})
        for (const double tau : {0.1, 2.0, 50.0}) {
            const LayerSolution layer =
                solve_layer(PhaseFunction::henyey_greenstein(0.75), w, tau, energy_cosines);
            EXPECT_LT(layer.spherical_albedo + layer.total_transmittance, 1);
            for (int i = 0; i < layer.mu.size(); ++i) {
                EXPECT_GT(layer.plane_albedo(i), 0);
                EXPECT_LT(layer.plane_albedo(i) + layer.diffuse_transmittance(i) +
                              direct_transmittance(tau, layer.mu(i)),
                          1);
            }
        }
}

TEST(AbsorbingLayer, AbsorbsInProportionToDepthWhenThin) {
    // A thin layer absorbs 1 - w of the light it intercepts; the rest leaves, except the
    // O(tau log tau) part that is intercepted twice. 8 nodes: truncated, f = 0.01.
    const double tau = 1e-12, w = 0.75;
    SolverOptions options;
    options.nodes = 8;
    const LayerSolution layer =
        solve_layer(PhaseFunction::henyey_greenstein(0.75), w, tau, {0.3, 1}, options);
    ASSERT_GT(layer.truncation.fraction, 0);
    for (int i = 0; i < 2; ++i)
        EXPECT_NEAR((layer.plane_albedo(i) + layer.diffuse_transmittance(i)) /
                        intercepted_share(tau, layer.mu(i)),
                    w, 3 * tau * -std::log(tau));
}

TEST(LayerSolution, HasFluxesEqualToIntegratedReflection) {
    // Over the Gauss nodes of mode 0, with single scattering's share from the azimuths: for the
    // isotropic and the Rayleigh layer five azimuths integrate it exactly.
    SolverOptions options;
    options.nodes = 16;
    const Directions nodes = gauss_directions(16, NodeMap::grazing);
    const LayerSolution layer = solve_layer(PhaseFunction::rayleigh(), 0.95, 1.5, {}, options);
    double spherical = 0;
    for (int i = 0; i < 16; ++i) {
        double up = 0, down = 0;
        for (int j = 0; j < 16; ++j)
            for (int k = 0; k < 5; ++k) {
                const double share = 2 * nodes.mu(j) * nodes.weight(j) / 5;
                const double azimuth = 2 * std::acos(-1.0) * k / 5;
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
