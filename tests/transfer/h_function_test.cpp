// The solver against Chandrasekhar's exact solution for a semi-infinite isotropic layer, and the
// solution itself against what is known of it in closed form.
#include "../reference/h_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <stratus/transfer/solve.h>

namespace stratus {
namespace {

using test::HFunction;

TEST(HFunction, HasThePublishedValueAtNormalDirection) {
    EXPECT_NEAR(HFunction(1)(1), 2.907810529, 5e-10);  // the digits printed
}

TEST(HFunction, HasTheMomentsOfConservativeScattering) {
    const HFunction H(1);  // [C60] V, 37 to 43
    EXPECT_NEAR(H.moment(0), 2, 1e-13);
    EXPECT_NEAR(H.moment(1), 2 / std::sqrt(3.0), 1e-13);
}

TEST(HFunction, HasTheMeanThatItsEquationImplies) {
    for (const double w : {0.1, 0.5, 0.9, 0.999, 1.0})
        EXPECT_NEAR(HFunction(w).moment(0), 2 / w * (1 - std::sqrt(1 - w)), 1e-13) << w;
}

class SemiInfiniteLayer : public testing::TestWithParam<double> {};

TEST_P(SemiInfiniteLayer, ReflectsAsTheHFunctionsSay) {
    const double w = GetParam();
    const HFunction H(w);
    SolverOptions options;
    options.nodes = 24;
    const LayerSolution layer =
        solve_layer(PhaseFunction::isotropic(), w, std::numeric_limits<double>::infinity(),
                    {0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0}, options);
    for (int i = 0; i < layer.mu.size(); ++i) {
        const double mu0 = layer.mu(i);
        for (int j = 0; j < layer.mu.size(); ++j) {
            const double mu = layer.mu(j);
            const double exact = w / 4 * H(mu) * H(mu0) / (mu + mu0);
            // what 24 nodes leave
            EXPECT_NEAR(layer.reflection(i, j, 1).total / exact, 1, 1e-10) << mu0 << ' ' << mu;
        }
        EXPECT_NEAR(layer.plane_albedo(i), 1 - H(mu0) * std::sqrt(1 - w), 1e-10) << mu0;
    }
}

INSTANTIATE_TEST_SUITE_P(OfAlbedo, SemiInfiniteLayer, testing::Values(0.5, 0.9, 0.999, 1.0));

}  // namespace
}  // namespace stratus
