// The accuracy of few nodes with smooth phase functions, against discrete ordinates.
#include "reference_comparison.h"

namespace stratus::test {
namespace {

// Errors of the quadrature at grazing angles of thin layers: 5e-9 measured, 5e-10 in fluxes.
INSTANTIATE_TEST_SUITE_P(Phase, DiscreteOrdinates,
                         testing::ValuesIn<Accuracy>({{"iso", 24, 1e-8, 1e-9},
                                                      {"rayl", 24, 1e-8, 1e-9},
                                                      {"lin", 24, 1e-8, 1e-9},
                                                      {"dhg", 24, 1e-8, 1e-9},
                                                      {"hg50", 24, 1e-8, 1e-9},
                                                      {"hg75", 32, 1e-7, 1e-8}}),
                         phase_name);

}  // namespace
}  // namespace stratus::test
