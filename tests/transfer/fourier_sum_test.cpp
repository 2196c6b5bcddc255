#include <stratus/transfer/fourier_sum.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
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
    for (const Side side : both_sides) {
        const GridValues values = evaluate(layer, side, grid);
        EXPECT_EQ(evaluate_tabulated(layer, side, grid), values.tabulated);
        for (int k = 0; const double azimuth : grid_azimuths) {
            for (const Way& way : ways(3, {azimuth})) {
                if (way.side != side) continue;
                const SolvedValue expected = way.of(layer);
                const std::size_t at = grid.at(way.in, way.out, k);
                // Mirrored pairs differ by the rounding of the peak's series.
                const double bound = 1e-12 * std::abs(expected.total);
                EXPECT_NEAR(values.closed_form[at], expected.single, bound);
                EXPECT_NEAR(values.tabulated[at], expected.multiple, bound);
            }
            ++k;
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

using Layers = std::vector<std::vector<LayerSolution>>;

Layers solve_peaked_layers(const SolverOptions& options, const TakeMode& take) {
    return solve_ladder(peaked, {0.4, 0.9}, {0.1, 9, true}, grid_cosines, options, {}, take);
}

/// Every seventh position of a grid, of many layers at once whose modes are summed as they are solved, and all
/// of one by one.
void expect_sketch_of_all(const SolverOptions& options, const DirectionGrid& grid) {
    std::vector<std::size_t> positions;
    for (std::size_t at = 2; at < grid.size(); at += 7) positions.push_back(at);
    const Layers layers = solve_peaked_layers(options, {});
    ASSERT_NE(layers[0][0].path, nullptr);
    for (const Side side : both_sides) {
        const GridPositions sketch(grid, side, positions);
        const Layers summed = solve_peaked_layers(
            options, [&](ModeSolution& to, Side of_mode, int number, const AzimuthalMode& mode) {
                if (of_mode == side) sketch.add_mode(to, number, mode);
                return true;
            });
        std::vector<const LayerSolution*> solutions;
        for (const std::vector<LayerSolution>& of_albedo : summed)
            for (const LayerSolution& layer : of_albedo) {
                EXPECT_TRUE(layer.modes[side].empty());
                solutions.push_back(&layer);
            }
        const auto some = sketch.evaluate_tabulated(solutions);
        for (const auto n : indices(some)) {
            const std::vector<double> all =
                evaluate_tabulated(layers[n / layers[0].size()][n % layers[0].size()], side, grid);
            for (const auto k : indices(positions))
                EXPECT_NEAR(some[n][k], all[positions[k]], 1e-12 * std::abs(all[positions[k]]))
                    << n << ' ' << positions[k];
        }
    }
}

TEST(FourierSum, AtSomePositionsOfManyLayersEqualsAllOfEach) {
    const DirectionGrid grid(peaked, LowerBoundary(), grid_cosines, grid_azimuths, 32);
    const DirectionGrid with_path_law(peaked, LowerBoundary(), grid_cosines, grid_azimuths, 32,
                                      PathOrders::of_any(peaked));
    for (const int orders : {0, 4}) {
        SolverOptions options = few_nodes;
        options.modes = 2 * options.nodes;
        options.orders = orders;
        expect_sketch_of_all(options, grid);
        expect_sketch_of_all(options, with_path_law);
    }
}

TEST(FourierSum, RefusesAGridOfOtherCosinesOrTooFewModes) {
    const LayerSolution layer = solve_layer(peaked, 0.9, 1, grid_cosines, few_nodes);
    const LowerBoundary none;
    expect_refusal(
        [&] {
            evaluate(layer, Side::reflection, {peaked, none, {0.5}, grid_azimuths, 32});
        },
        "cosines of the solution must be 1, got 3");
    expect_refusal(
        [&] {
            evaluate(layer, Side::reflection, {peaked, none, grid_cosines, grid_azimuths, 2});
        },
        "modes of the solution must be at most 2");
}

}  // namespace
}  // namespace stratus
