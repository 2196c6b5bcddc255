#include <stratus/transfer/solve_to_tolerance.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/solve.h>

#include "csv_rows.h"
#include "indices.h"
#include "random_problems.h"
#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

namespace stratus::test {
namespace {

SolverOptions to(double tolerance) {
    SolverOptions options;
    options.tolerance = tolerance;
    return options;
}

SolvedGeometries solve(const PhaseFunction& phase_function, double albedo, double depth,
                       const std::vector<Geometry>& geometries, const SolverOptions& options) {
    return solve_geometries({{phase_function, albedo, depth}}, {}, geometries, options);
}

/// Values whose error is below 1.5 times the estimate, and all.
struct Honesty {
    int honest = 0, all = 0;

    void count(double value, double error, double expected) {
        ++all;
        honest += std::abs(value - expected) <= 1.5 * error + 1e-13 * std::abs(expected);
    }
};

TEST(SolveToTolerance, StatesErrorsThatAreTrueOfRandomLayersAndStacks) {
    std::map<std::uint64_t, std::vector<std::vector<double>>> references;  // seed geometry R T
    for (const CsvRow& row : csv_rows("random_layers.csv"))
        references[static_cast<std::uint64_t>(row.numbers.at(0))].push_back(row.numbers);
    for (const double tolerance : {1e-2, 1e-3}) {
        Honesty honesty;
        int beyond = 0;
        for (const auto& [seed, expected] : references) {
            const RandomProblem problem = random_problem(seed);
            ASSERT_EQ(expected.size(), problem.geometries.size());
            const SolvedGeometries solved = solve_geometries(problem.layers, problem.boundary,
                                                             problem.geometries, to(tolerance));
            for (const auto i : indices(expected)) {
                const SolvedGeometry& at = solved.at[i];
                const double R = expected[i].at(2), T = expected[i].at(3);
                honesty.count(at.reflection.total, at.reflection_error, R);
                honesty.count(at.transmission.total, at.transmission_error, T);
                beyond += std::abs(at.reflection.total - R) > tolerance * R;
                beyond += std::abs(at.transmission.total - T) > tolerance * T;
            }
        }
        EXPECT_GT(honesty.all, 500);
        EXPECT_GE(honesty.honest, 0.99 * honesty.all) << tolerance;
        EXPECT_LE(beyond, 0.01 * honesty.all) << tolerance;
    }
}

TEST(SolveToTolerance, StatesErrorsThatAreTrueOfIsotropicLayers) {
    const std::vector<double> mu{0.02, 0.1, 0.3, 0.6, 1};
    std::vector<Geometry> geometries;
    for (const double in : mu)
        for (const double out : mu) geometries.push_back({in, out, 0});
    for (const double albedo : {0.5, 0.99, 1.0})
        for (const double depth : {0.1, 3.0, 100.0}) {
            const IsotropicSolution exact = solve_isotropic(albedo, depth, mu);
            for (const double tolerance : {1e-2, 1e-4, 1e-7}) {
                const SolvedGeometries solved =
                    solve(isotropic, albedo, depth, geometries, to(tolerance));
                for (int i = 0; i < std::ssize(geometries); ++i) {
                    const SolvedGeometry& at = solved.at[static_cast<std::size_t>(i)];
                    const double R = exact.reflection(i / 5, i % 5),
                                 T = exact.transmission(i / 5, i % 5);
                    EXPECT_NEAR(at.reflection.total, R, 1.5 * at.reflection_error + 1e-11 * R);
                    EXPECT_NEAR(at.transmission.total, T, 1.5 * at.transmission_error + 1e-11 * T);
                    EXPECT_LE(relative_error(at.reflection.total, at.reflection_error), tolerance);
                }
            }
        }
}

TEST(SolveToTolerance, FindsBackwardPeaks) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(-0.95);
    const std::vector<Geometry> geometries{{0.5, 0.5, 0}, {0.5, 0.5, pi}, {0.2, 0.9, 1}};
    const SolvedGeometries solved = solve(phase, 1, 10, geometries, to(1e-4));
    const LayerSolution fine = solve_layer(phase, 1, 10, {0.5, 0.2, 0.9}, with_nodes(300));
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
        EXPECT_NEAR(solved.at[i].reflection.total,
                    fine.reflection(0, 0, geometries[i].azimuth).total,
                    1e-4 * solved.at[i].reflection.total);
    EXPECT_NEAR(solved.at[2].reflection.total, fine.reflection(1, 2, 1).total,
                1e-4 * solved.at[2].reflection.total);
}

TEST(SolveToTolerance, KnowsTheErrorOfFixedNodes) {
    const std::vector<Geometry> geometries{{0.5, 0.5, 0}, {0.5, 0.5, 2}, {0.2, 0.9, 1}};
    for (const char* const text :
         {"henyey_greenstein:g=0.7", "henyey_greenstein:g=-0.6", "henyey_greenstein:g=0.95"}) {
        const PhaseFunction phase = parse_phase_function(text);
        const SolvedGeometries fine = solve(phase, 0.99, 4, geometries, with_nodes(128));
        for (const int nodes : {1, 3, 7, 8, 12, 24, 32, 50}) {
            const SolvedGeometries solved = solve(phase, 0.99, 4, geometries, with_nodes(nodes));
            EXPECT_EQ(solved.nodes, nodes);
            for (const auto i : indices(geometries)) {
                const double expected = fine.at[i].reflection.total;
                EXPECT_NEAR(solved.at[i].reflection.total, expected,
                            1.5 * solved.at[i].reflection_error + 1e-12)
                    << text << ' ' << nodes;
            }
        }
    }
}

TEST(SolveToTolerance, IsTheSolverWithThoseNodes) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.9);
    std::vector<Geometry> geometries;  // more cosines than are solved at once
    std::vector<double> mu;
    for (int i = 0; i < 50; ++i) {
        geometries.push_back({0.02 * (i + 1), 1 - 0.015 * i, 0.06 * i});
        mu.insert(mu.end(), {geometries.back().mu_in, geometries.back().mu_out});
    }
    const SolvedGeometries solved = solve(phase, 0.9, 2, geometries, with_nodes(40));
    const LayerSolution layer = solve_layer(phase, 0.9, 2, mu, with_nodes(40));
    ASSERT_EQ(solved.at.size(), geometries.size());
    for (int i = 0; i < 50; ++i) {
        const SolvedValue R =
            layer.reflection(2 * i, 2 * i + 1, geometries[static_cast<std::size_t>(i)].azimuth);
        const SolvedGeometry& at = solved.at[static_cast<std::size_t>(i)];
        EXPECT_NEAR(at.reflection.total, R.total, 1e-12 * R.total);
        EXPECT_DOUBLE_EQ(at.reflection.single, R.single);
    }
}

TEST(SolveToTolerance, AnswersForLayersThatDoNothing) {
    const std::vector<Geometry> geometries{{0.5, 0.8, 1}};
    for (const double depth : {0.0, 1e-300, 1.0, infinity}) {
        const SolvedGeometries black = solve(rayleigh, 0, depth, geometries, to(1e-6));
        EXPECT_NEAR(black.at[0].reflection.total, 0, 1e-15);
        EXPECT_LE(relative_error(black.at[0].reflection.total, black.at[0].reflection_error), 1e-6);
        EXPECT_LE(relative_error(black.at[0].transmission.total, black.at[0].transmission_error),
                  1e-6);
        const SolvedFluxes fluxes = solve_fluxes({{rayleigh, 0, depth}}, {}, {0.03, 0.5}, to(1e-6));
        EXPECT_EQ(fluxes.plane_albedo, (std::vector<double>{0, 0}));
        EXPECT_EQ(fluxes.diffuse_transmittance, (std::vector<double>{0, 0}));
        EXPECT_LE(fluxes.relative_error, 1e-6);
    }
    const SolvedFluxes over_ground =
        solve_fluxes({{rayleigh, 0, 0.03}}, LowerBoundary::surface(0.5), {0.03}, to(1e-6));
    EXPECT_LE(over_ground.relative_error, 1e-6);
    EXPECT_TRUE(solve(rayleigh, 1, 1, {}, to(1e-6)).at.empty());
}

TEST(SolveToTolerance, SaysWhatItMisses) {
    const SolvedGeometries solved =
        solve(PhaseFunction::henyey_greenstein(0.999), 1, 2, {{0.1, 0.15, 0}}, to(1e-6));
    EXPECT_LE(solved.nodes, 512);
    EXPECT_GT(relative_error(solved.at[0].reflection.total, solved.at[0].reflection_error), 1e-6);
}

TEST(SolveToTolerance, FindsFluxesWithTheirErrors) {
    const std::vector<double> mu{0.05, 0.5, 1};
    for (const char* const text :
         {"rayleigh", "henyey_greenstein:g=0.97", "henyey_greenstein:g=-0.9"}) {
        const std::vector<StackLayer> layers{{parse_phase_function(text), 0.999, 8}};
        const LowerBoundary ground = LowerBoundary::surface(0.3);
        const SolvedFluxes fine = solve_fluxes(layers, ground, mu, with_nodes(256));
        for (const double tolerance : {1e-3, 1e-6}) {
            const SolvedFluxes solved = solve_fluxes(layers, ground, mu, to(tolerance));
            EXPECT_LE(solved.relative_error, tolerance);
            EXPECT_NEAR(solved.spherical_albedo, fine.spherical_albedo, 1.5 * solved.error);
            for (std::size_t i = 0; i < 3; ++i) {
                EXPECT_NEAR(solved.plane_albedo[i], fine.plane_albedo[i], 1.5 * solved.error)
                    << text;
                EXPECT_NEAR(solved.ground_absorptance[i], fine.ground_absorptance[i],
                            1.5 * solved.error);
            }
        }
    }
}

TEST(SolveToTolerance, RefusesInWords) {
    const std::vector<StackLayer> two{{isotropic, 1, 1}, {rayleigh, 1, 1}};
    const auto refused = [&](const SolverOptions& options, Fragments fragments) {
        expect_refusal([&] { solve_geometries(two, {}, {{0.5, 0.5, 0}}, options); }, fragments);
        expect_refusal([&] { solve_fluxes(two, {}, {}, options); }, fragments);
    };
    refused(to(2), "tolerance must be 0 or in [1e-12, 1], got 2");
    refused(to(1e-13), "tolerance must be 0 or in [1e-12, 1], got 1e-13");
    refused(to(NAN), "tolerance must be 0 or in [1e-12, 1], got nan");
    refused(with_nodes(513), "nodes must be in [1, 512], got 513");
    const auto refused_at = [&](const Geometry& at, Fragments fragments) {
        const std::vector<Geometry> geometries{{0.5, 0.5, 0}, at};
        expect_refusal([&] { solve_geometries(two, {}, geometries, with_nodes(8)); }, fragments);
        expect_refusal([&] { solve_geometries_inside(two, {}, 1, geometries, with_nodes(8)); },
                       fragments);
    };
    refused_at({NAN, 0.5, 0}, "mu must be in [1e-100, 1], got nan");
    refused_at({0.5, NAN, 0}, "mu must be in [1e-100, 1], got nan");
    refused_at({0.5, 0.5, NAN}, "azimuth must be finite, got nan");
}

}  // namespace
}  // namespace stratus::test
