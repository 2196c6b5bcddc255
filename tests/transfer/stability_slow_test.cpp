// The corners of the stability matrix with many nodes: all modes at 128 nodes, two at 256.
#include "stability_checks.h"
#include "stability_matrix.h"

#include <gtest/gtest.h>

namespace stratus {
namespace {

struct Fine {
    const char* phase_function;
    int nodes, modes;
};

void PrintTo(const Fine& fine, std::ostream* out) {
    *out << fine.phase_function << ", " << fine.nodes << " nodes";
}

class FineStability : public testing::TestWithParam<Fine> {};

TEST_P(FineStability, Holds) {
    SolverOptions options;
    options.nodes = GetParam().nodes;
    options.modes = GetParam().modes;
    for (const double w : {1 - 1e-15, 1.0}) {
        double thinner = 0;
        for (const double tau : {1.0, 1e12}) {
            const LayerSolution layer = solve_layer(parse_phase_function(GetParam().phase_function),
                                                    w, tau, test::stability_cosines, options);
            const std::vector<test::LayerValue> values = test::values_of(layer);
            test::expect_finite(layer, values);
            if (options.modes == 0) test::expect_negative_only_with_its_series(layer);
            EXPECT_GE(layer.spherical_albedo, thinner) << test::at(layer);
            thinner = layer.spherical_albedo;
            if (w < 1) continue;
            EXPECT_NEAR(layer.spherical_albedo + layer.total_transmittance, 1, 1e-12);
            for (int i = 0; i < layer.mu.size(); ++i)
                EXPECT_NEAR(layer.plane_albedo(i) + layer.diffuse_transmittance(i) +
                                direct_transmittance(tau, layer.mu(i)),
                            1, 1e-12)
                    << test::at(layer) << ' ' << layer.mu(i);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Of, FineStability,
                         testing::Values(Fine{"isotropic", 128, 0}, Fine{"lambert_sphere", 128, 0},
                                         Fine{"henyey_greenstein:g=-0.9", 128, 0},
                                         Fine{"henyey_greenstein:g=0.9999", 128, 0},
                                         Fine{"isotropic", 256, 0},
                                         Fine{"henyey_greenstein:g=-0.9", 256, 2},
                                         Fine{"henyey_greenstein:g=0.9999", 256, 2}));

}  // namespace
}  // namespace stratus
