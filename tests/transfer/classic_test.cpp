// Textbook doubling: convergence of its starts, and reports of breakdown.
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace stratus {
namespace {

class ClassicDoubling : public testing::TestWithParam<PhaseFunction> {};

/// Largest relative difference to the harmonic scheme with the same nodes.
double error(const PhaseFunction& phase_function, ClassicStart start, double start_depth) {
    SolverOptions options = with_nodes(4);
    const LayerSolution exact = solve_layer(phase_function, 0.9, 2, {0.3, 1}, options);
    options.scheme = Scheme::classic;
    options.start = start;
    options.start_depth = start_depth;
    return difference(solve_layer(phase_function, 0.9, 2, {0.3, 1}, options), exact, {1});
}

/// The power of the start depth with which the error decreases, once that depth is below the
/// smallest cosine of four nodes, 3e-4.
double order(const PhaseFunction& phase_function, ClassicStart start) {
    const double coarse = error(phase_function, start, std::ldexp(1.0, -18));
    return std::log2(coarse / error(phase_function, start, std::ldexp(1.0, -20))) / 2;
}

TEST_P(ClassicDoubling, ConvergesLinearlyFromSingleScattering) {
    EXPECT_NEAR(order(GetParam(), ClassicStart::single), 1, 0.02);
    EXPECT_LE(error(GetParam(), ClassicStart::single, std::ldexp(1.0, -24)), 2e-6);
}

TEST_P(ClassicDoubling, ConvergesQuadraticallyFromTheDiamondRule) {
    EXPECT_NEAR(order(GetParam(), ClassicStart::diamond), 2, 0.05);
    EXPECT_LE(error(GetParam(), ClassicStart::diamond, std::ldexp(1.0, -24)), 1e-10);
}

/// Four nodes truncate the last.
INSTANTIATE_TEST_SUITE_P(Of, ClassicDoubling,
                         testing::Values(isotropic, PhaseFunction::henyey_greenstein(0.5), forward),
                         [](const auto& row) { return "Row" + std::to_string(row.index); });

TEST(ClassicDoubling, NeedsNoDoublingWithinTheStartDepth) {
    SolverOptions options;
    options.scheme = Scheme::classic;
    options.start = ClassicStart::single;
    options.start_depth = 0.5;
    const LayerSolution at_once = solve_layer(isotropic, 1, 0.5, {0.3}, options);
    EXPECT_NEAR(at_once.reflection(0, 0, 0).multiple, 0, 1e-16);
    const LayerSolution doubled = solve_layer(isotropic, 1, 0.51, {0.3}, options);
    EXPECT_GT(doubled.reflection(0, 0, 0).multiple, 0.01);
}

TEST(ClassicDoubling, RefusesAStartDepthOutOfRange) {
    for (const double depth : {-1.0, 9e-16, 1.25, double{NAN}}) {
        expect_refusal(
            [&] {
                solve_layer(isotropic, 1, 1, {1},
                            {.scheme = Scheme::classic, .start_depth = depth});
            },
            "solve: start_depth must be 0 or in [1e-15, 1]");
    }
}

TEST(ClassicDoubling, ReportsBreakdown) {
    // 32 moments of a peak that needs thousands: the series is so negative in places that R
    // amplifies light
    SolverOptions options = with_nodes(16, Truncate::nothing);
    options.scheme = Scheme::classic;
    expect_refusal<std::runtime_error>(
        [&] { solve_layer(PhaseFunction::henyey_greenstein(0.9999), 0.99, 1e6, {1}, options); },
        {"solve: classic doubling broke down in mode ", " at optical depth "});
}

}  // namespace
}  // namespace stratus
