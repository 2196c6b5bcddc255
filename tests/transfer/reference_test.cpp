// The accuracy of 24 nodes with smooth phase functions, against discrete ordinates.
#include "reference_comparison.h"

#include <gtest/gtest.h>

namespace stratus {
namespace {

using test::Accuracy;
using test::Compared;

class DiscreteOrdinates24 : public testing::TestWithParam<Accuracy> {};

TEST_P(DiscreteOrdinates24, AreMatchedAtEveryGeometry) {
    const Compared worst = test::compare_geometries(GetParam().phase, 24).back();
    EXPECT_LE(worst.error, GetParam().allowed) << worst.row;
}

TEST_P(DiscreteOrdinates24, AreMatchedInFluxes) {
    const Compared worst = test::compare_fluxes(GetParam().phase, 24).back();
    EXPECT_LE(worst.error, 1e-9) << worst.row;  // 5e-10 measured
}

// error of the quadrature at grazing angles of thin layers: 5e-9 measured
INSTANTIATE_TEST_SUITE_P(Phase, DiscreteOrdinates24,
                         testing::Values(Accuracy{"iso", 1e-8}, Accuracy{"rayl", 1e-8},
                                         Accuracy{"lin", 1e-8}, Accuracy{"dhg", 1e-8}),
                         [](const auto& row) { return row.param.phase; });

}  // namespace
}  // namespace stratus
