#include <stratus/transfer/fourier_sum.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stratus {
namespace {

const std::vector<double> grid_cosines{0.02, 0.4, 1.0};
const std::vector<double> grid_azimuths{0, 0.3, 2, pi};

/// Of them the peaked phase function is truncated.
const SolverOptions few_nodes = with_nodes(16);

void expect_values_of_pairs(const LayerSolution& layer) {
    const DirectionGrid grid(layer.phase_function, layer.lower_boundary, grid_cosines,
                             grid_azimuths, 32);
    for (const Side side : {Side::reflection, Side::transmission}) {
        const GridValues values = evaluate(layer, side, grid);
        EXPECT_EQ(evaluate_tabulated(layer, side, grid), values.tabulated);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 4; ++k) {
                    const double phi = grid_azimuths[static_cast<std::size_t>(k)];
                    const SolvedValue expected = side == Side::reflection
                                                     ? layer.reflection(i, j, phi)
                                                     : layer.transmission(i, j, phi);
                    const std::size_t at = grid.at(i, j, k);
                    // Mirrored pairs differ by the rounding of the peak's series.
                    const double bound = 1e-12 * std::abs(expected.total);
                    EXPECT_NEAR(values.closed_form[at], expected.single, bound);
                    EXPECT_NEAR(values.tabulated[at], expected.multiple, bound);
                }
    }
}

TEST(FourierSum, OverAGridEqualsPairByPair) {
    expect_values_of_pairs(solve_layer(rayleigh, 0.9, 1, grid_cosines, few_nodes));
    expect_values_of_pairs(solve_layer(peaked, 0.9, 4, grid_cosines, few_nodes));
    SolverOptions four_orders = few_nodes;
    four_orders.orders = 4;
    expect_values_of_pairs(solve_layer(peaked, 0.9, 4, grid_cosines, four_orders));
    for (const LowerBoundary& boundary :
         {LowerBoundary::surface(0.4), LowerBoundary::layer(peaked, 0.8)})
        expect_values_of_pairs(solve_layer(peaked, 0.9, 0.5, grid_cosines, few_nodes, boundary));
}

TEST(FourierSum, RefusesAGridOfOtherCosinesOrTooFewModes) {
    const LayerSolution layer = solve_layer(peaked, 0.9, 1, grid_cosines, few_nodes);
    const LowerBoundary none;
    expect_refusal(
        [&] {
            evaluate(layer, Side::reflection, {peaked, none, {0.5}, grid_azimuths, 32});
        },
        {"cosines of the solution must be 1, got 3"});
    expect_refusal(
        [&] {
            evaluate(layer, Side::reflection, {peaked, none, grid_cosines, grid_azimuths, 2});
        },
        {"modes of the solution must be at most 2"});
}

}  // namespace
}  // namespace stratus
