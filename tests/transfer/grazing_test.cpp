// Narrow peaks between grazing directions, where the path law does not hold.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "climb.h"
#include "csv_rows.h"
#include "indices.h"
#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace stratus {
namespace {

TEST(GrazingModes, FillGapsWithPolynomialsOfEitherParity) {
    const auto value = [](int m) {
        const double x = m / 100.0;
        return m % 2 == 0 ? 1 + x * x * x * x * x : 2 + x * x;
    };
    for (const int count : {1, 2, 5, 96, 97, 98, 99, 144, 301}) {
        const std::vector<int> solved = thinned_modes(count, 1e-4);
        EXPECT_TRUE(std::ranges::is_sorted(solved));
        EXPECT_EQ(solved.back(), count - 1);
        std::vector<AzimuthalMode> modes;
        for (const int m : solved) modes.push_back({Eigen::MatrixXd::Constant(2, 2, value(m))});
        fill_modes(solved, modes);
        ASSERT_EQ(std::ssize(modes), count);
        for (int m = 0; m < count; ++m)
            EXPECT_NEAR(modes[static_cast<std::size_t>(m)](1, 0), value(m), 1e-10 * value(m)) << m;
    }
    EXPECT_LT(thinned_modes(600, 1e-2).size(), 130U);
    EXPECT_GT(thinned_modes(600, 1e-4).size(), thinned_modes(600, 1e-2).size());
}

TEST(GrazingModes, FillWhatWasSolvedBeforeTheRestBecameNegligible) {
    const std::vector<int> solved = thinned_modes(301, 1e-2);
    std::vector<AzimuthalMode> modes(solved.size() - 10, {Eigen::MatrixXd::Ones(1, 1)});
    const int last = solved[modes.size() - 1];
    fill_modes(solved, modes);
    EXPECT_EQ(std::ssize(modes), last + 1);
    for (const AzimuthalMode& mode : modes) EXPECT_NEAR(mode(0, 0), 1, 1e-12);
}

TEST(GrazingLight, IsThatOfManyNodesWithoutTruncation) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.9);
    const std::vector<double> mu{0.02, 0.05, 0.14, 0.3, 0.6, 1};  // pairs of one of the first three
    const SolverOptions plain = with_nodes(96, Truncate::nothing);  // chi_192 is 2e-9
    SolverOptions grazing = with_nodes(48);
    grazing.grazing = true;
    for (const double depth : {0.1, 1.0, 20.0}) {
        const LayerSolution exact = solve_layer(phase, 1, depth, mu, plain),
                            solved = solve_layer(phase, 1, depth, mu, grazing);
        for (const Way& way : ways(6, {0, 0.05, 0.5, 2, 3.1})) {
            if (way.in >= 3) continue;
            const double expected = way.of(exact).total;
            EXPECT_NEAR(way.of(solved).total, expected, 1e-3 * expected) << depth << ' ' << way;
        }
    }
}

/// By tests/reference/grazing_clouds.csv, whose first lines say how it was made.
TEST(GrazingLight, OfCloudsIsWithinOnePerCentAndItsErrorIsTrue) {
    std::map<std::tuple<std::string, double, double>, std::vector<std::vector<double>>> clouds;
    for (const auto& [phase, row] : csv_rows("grazing_clouds.csv", ';'))
        clouds[{phase, row.at(0), row.at(1)}].push_back(row);
    EXPECT_GE(clouds.size(), 4U);
    int honest = 0, within = 0, all = 0;
    for (const auto& [cloud, rows] : clouds) {
        const auto& [text, albedo, depth] = cloud;
        std::vector<Geometry> geometries;
        for (const std::vector<double>& row : rows)
            geometries.push_back({row.at(2), row.at(3), radians(row.at(4))});
        const SolvedGeometries solved = solve_geometries(
            {{parse_phase_function(text), albedo, depth}}, {}, geometries, {.tolerance = 1e-2});
        for (const auto i : indices(rows)) {
            const SolvedGeometry& at = solved.at[i];
            for (const auto& [value, stated, expected] :
                 {std::tuple(at.reflection.total, at.reflection_error, rows[i].at(5)),
                  std::tuple(at.transmission.total, at.transmission_error, rows[i].at(6))}) {
                const double error = std::abs(value - expected);
                ++all;
                honest += error <= 1.5 * stated;
                within += error <= 1e-2 * expected;
            }
        }
    }
    EXPECT_GE(honest, 0.99 * all);
    EXPECT_GE(within, 0.99 * all);
}

TEST(GrazingLight, IsRefusedWhereItIsNotSolved) {
    expect_refusal(
        [&] {
            solve_layer(PhaseFunction::henyey_greenstein(0.9), 1, 1, {0.1},
                        {.orders = 3, .grazing = true});
        },
        "grazing must be false unless all orders");
}

}  // namespace
}  // namespace stratus
