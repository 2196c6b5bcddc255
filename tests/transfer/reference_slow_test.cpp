// 64 nodes against discrete ordinates, every phase function.
#include "reference_comparison.h"

#include <gtest/gtest.h>

namespace stratus {
namespace {

using test::Accuracy;
using test::Compared;

class DiscreteOrdinates64 : public testing::TestWithParam<Accuracy> {};

TEST_P(DiscreteOrdinates64, AreMatchedAtEveryGeometry) {
    const Compared worst = test::compare_geometries(GetParam().phase, 64).back();
    EXPECT_LE(worst.error, GetParam().allowed) << worst.row;
}

TEST_P(DiscreteOrdinates64, AreMatchedInFluxes) {
    const Compared worst = test::compare_fluxes(GetParam().phase, 64).back();
    EXPECT_LE(worst.error, 1e-10) << worst.row;  // 6e-12 measured
}

// To the accuracy of the references: 7e-11 measured (Lambert sphere), 1e-11 for HG 0.85.
INSTANTIATE_TEST_SUITE_P(Phase, DiscreteOrdinates64,
                         testing::Values(Accuracy{"iso", 1e-9}, Accuracy{"rayl", 1e-9},
                                         Accuracy{"lin", 1e-9}, Accuracy{"dhg", 1e-9},
                                         Accuracy{"lambert", 1e-9}, Accuracy{"hg50", 1e-9},
                                         Accuracy{"hg75", 1e-9}, Accuracy{"hg85", 1e-9}),
                         [](const auto& row) { return row.param.phase; });

TEST(DiscreteOrdinates64, AreMatchedByAPeakOf095) {
    // 128 moments do not resolve g = 0.95 (0.95^128 = 1e-3): 9.5e-5 measured at worst, 1.7e-6 in
    // the median.
    const std::vector<Compared> all = test::compare_geometries("hg95", 64);
    EXPECT_LE(all.back().error, 2e-4) << all.back().row;
    EXPECT_LE(all[all.size() / 2].error, 4e-6) << all[all.size() / 2].row;
}

TEST(DiscreteOrdinates64, AreMatchedInFluxesByAPeakOf095) {
    const Compared worst = test::compare_fluxes("hg95", 64).back();
    EXPECT_LE(worst.error, 3e-6) << worst.row;  // 1.3e-6 measured
}

}  // namespace
}  // namespace stratus
