// The stability matrix: no breakdown at any phase function, albedo, depth or number of nodes.
#include <stratus/base/constants.h>
#include <stratus/layer/diffusion.h>

#include "indices.h"
#include "stability_checks.h"
#include "stability_matrix.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus::test {
namespace {

const int count = static_cast<int>(stability_cosines.size());

struct Medium {
    NamedPhaseFunction of;
    int nodes;
};

class Stability : public testing::TestWithParam<Medium> {
  protected:
    LayerSolution solve(double albedo, double optical_depth, int modes = 0) const {
        SolverOptions options = with_nodes(GetParam().nodes);
        options.modes = modes;
        return solve_layer(GetParam().of.phase_function, albedo, optical_depth, stability_cosines,
                           options);
    }
    double asymmetry() const { return GetParam().of.phase_function.asymmetry(); }
};

void expect_limits_of_single_scattering(const LayerSolution& layer,
                                        const std::vector<LayerValue>& values) {
    const double tau = layer.optical_depth;
    const double backward_peak = std::max(1.0, layer.phase_function(-1));  // scattered twice
    for (const auto& [side, value, single, i, j] : values) {
        if (tau == 0) {
            EXPECT_EQ(value.total, 0);
        }
        if (layer.albedo == 0) {
            EXPECT_NEAR(value.total, 0, rounding) << at(layer);
        }
        if (tau <= 1e-12) {
            // second order: tau log(tau), at most 30 tau; truncation: tau/mu
            const double twice = tau * (100 + 2 / layer.mu(i) + 2 / layer.mu(j));
            EXPECT_NEAR(value.total, value.single,
                        (twice + 1e-14) * (value.single + backward_peak * single))
                << at(layer);
        }
        if (layer.albedo == 1e-12) {
            EXPECT_NEAR(value.total, value.single, 1e-10 * (value.single + single) + rounding)
                << at(layer);
        }
    }
}

TEST_P(Stability, IsFiniteAndAsPositiveAsItsSeries) {
    // Sums over 10^5 moments take long: there, each of 2, 8 and 32 nodes has another third of the pairs.
    const bool long_series = asymmetry() > 0.999;
    double pair = std::log2(GetParam().nodes);
    for (const double w : stability_albedos) {
        ++pair;  // another diagonal, as the depths are nine
        for (const double tau : stability_depths) {
            if (std::fmod(++pair, 3) != 0 && long_series) continue;
            const LayerSolution layer = solve(w, tau);
            const std::vector<LayerValue> values = values_of(layer);
            expect_finite(layer, values);
            const double lowest = expect_negative_only_with_its_series(layer);
            if (GetParam().nodes >= 8) {
                EXPECT_GE(lowest, -1e-5) << at(layer);
            }
            expect_limits_of_single_scattering(layer, values);
        }
    }
}

/// (4/3) / (1-g) / q sinh(k q) / sinh(k (tau + q)), q = 1.42/(1-g), k^2 = 3 (1-w) (1-wg).
void expect_law_of_diffusion(const LayerSolution& layer, double g, double tolerance) {
    const double w = layer.albedo, tau = layer.optical_depth, q = 1.4208921792 / (1 - g);
    const double k = std::sqrt(3 * (1 - w) * (1 - w * g));
    const double law = 4.0 / 3 / (1 - g) / q * transmission_scale(tau, k, q);
    if (law < 1e-290) return;
    EXPECT_NEAR(std::log(layer.total_transmittance / law), 0, tolerance * std::max(1.0, k * tau))
        << at(layer);
}

TEST_P(Stability, ConservesEnergyGrowsWithDepthAndAlbedoAndTransmitsByTheLawOfDiffusion) {
    // Errors of the nodes in T and in k; with two nodes, half of T under a forward peak.
    const double tolerance = GetParam().nodes == 2 ? 0.7 : GetParam().nodes == 8 ? 1e-2 : 1e-3;
    std::vector<double> darker(stability_depths.size(), 0);
    for (const double w : stability_albedos) {
        double thinner = 0;
        for (const auto d : indices(stability_depths)) {
            const double tau = stability_depths[d];
            const LayerSolution layer = solve(w, tau, 1);
            if (w == 1) expect_conserved(layer, tau, 1e-12);
            if (w >= 1 - 1e-9 && (tau == 1e6 || tau == 1e12))
                expect_law_of_diffusion(layer, asymmetry(), tolerance);
            EXPECT_GE(layer.spherical_albedo, thinner - rounding) << at(layer);
            EXPECT_GE(layer.spherical_albedo, darker[d] - rounding) << at(layer);
            EXPECT_LE(layer.spherical_albedo + layer.total_transmittance, 1 + rounding)
                << at(layer);
            EXPECT_GE(layer.total_transmittance, 0) << at(layer);
            thinner = darker[d] = layer.spherical_albedo;
        }
    }
}

TEST(LayerSolution, IsNegativeWithItsSeries) {
    // Four moments of a backward peak: a series with a minimum of -21 %.
    const SolverOptions options = with_nodes(2, Truncate::nothing);
    const PhaseFunction backward = PhaseFunction::henyey_greenstein(-0.9);
    const double share = most_negative(solve_layer(backward, 0.99, 1, stability_cosines, options));
    EXPECT_LT(share, -0.1);
    EXPECT_GT(share, -0.3);
    EXPECT_EQ(
        most_negative(solve_layer(PhaseFunction::isotropic(), 0.99, 1, stability_cosines, options)),
        0);
}

TEST_P(Stability, ReachesTheSemiInfiniteLayer) {
    for (const double w : {0.3, 0.99, 1 - 1e-9, 1 - 1e-15}) {
        const LayerSolution deep = solve(w, 1e12), endless = solve(w, infinity);
        EXPECT_NEAR(deep.spherical_albedo, endless.spherical_albedo, 1e-14) << at(deep);
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j)  // rounding of 50 doublings, times the peak
                EXPECT_NEAR((deep.mu(i) + deep.mu(j)) * (deep.reflection(i, j, 1).total -
                                                         endless.reflection(i, j, 1).total),
                            0, 2e-12)
                    << at(deep);
    }
}

std::vector<Medium> media() {
    std::vector<Medium> media;
    for (const int nodes : {2, 8, 32})
        for (const NamedPhaseFunction& of : stability_phase_functions())
            media.push_back({of, nodes});
    return media;
}

INSTANTIATE_TEST_SUITE_P(Of, Stability, testing::ValuesIn(media()), [](const auto& info) {
    return info.param.of.name + "_" + std::to_string(info.param.nodes) + "_nodes";
});

}  // namespace
}  // namespace stratus::test
