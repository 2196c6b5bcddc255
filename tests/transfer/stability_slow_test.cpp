// The corners of the stability matrix with many nodes: all modes at 128 nodes, two at 256.
#include "stability_checks.h"
#include "stability_matrix.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

namespace stratus::test {
namespace {

struct Fine {
    const char* phase_function;
    int nodes, modes;
};

class FineStability : public testing::TestWithParam<Fine> {};

TEST_P(FineStability, Holds) {
    SolverOptions options = with_nodes(GetParam().nodes);
    options.modes = GetParam().modes;
    for (const double w : {1 - 1e-15, 1.0}) {
        double thinner = 0;
        for (const double tau : {1.0, 1e12}) {
            const LayerSolution layer = solve_layer(parse_phase_function(GetParam().phase_function),
                                                    w, tau, stability_cosines, options);
            const std::vector<LayerValue> values = values_of(layer);
            expect_finite(layer, values);
            if (options.modes == 0) expect_negative_only_with_its_series(layer);
            EXPECT_GE(layer.spherical_albedo, thinner) << at(layer);
            thinner = layer.spherical_albedo;
            if (w < 1) continue;
            expect_conserved(layer, tau, 1e-12);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Of, FineStability,
                         testing::ValuesIn<Fine>({{"isotropic", 128, 0},
                                                  {"lambert_sphere", 128, 0},
                                                  {"henyey_greenstein:g=-0.9", 128, 0},
                                                  {"henyey_greenstein:g=0.9999", 128, 0},
                                                  {"isotropic", 256, 0},
                                                  {"henyey_greenstein:g=-0.9", 256, 2},
                                                  {"henyey_greenstein:g=0.9999", 256, 2}}));

}  // namespace
}  // namespace stratus::test
