// Stacks agree with their parts, with a single equivalent layer, and with closed forms for the
// lower boundary.
#include <stratus/transfer/stack.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "layer.h"
#include "refusal.h"
#include "uniform.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

using Eigen::VectorXd;

const PhaseFunction haze = PhaseFunction::henyey_greenstein(0.85);
const PhaseFunction dust = PhaseFunction::lambert_sphere();

/// As stacks do.
SolverOptions stack_options(int nodes) { return with_nodes(nodes, Truncate::delta_m); }

/// Largest difference of R and T over all geometries, relative to the brightest one with the same
/// mu_in: rounding stays the same where a phase function vanishes, as that of dust does at forward
/// directions.
template <class A, class B>
double difference_of_stacks(const A& a, const B& b) {
    double worst = 0;
    for (int in = 0; in < a.mu.size(); ++in)
        for (const auto part : {&SolvedValue::total, &SolvedValue::single})
            for (const Side side : both_sides) {
                double apart = 0, brightest = 0;
                for (int out = 0; out < a.mu.size(); ++out)
                    for (const double azimuth : azimuths) {
                        const double of_a = value_at(a, side, in, out, azimuth).*part,
                                     of_b = value_at(b, side, in, out, azimuth).*part;
                        apart = std::max(apart, std::abs(of_a - of_b));
                        brightest = std::max(brightest, std::abs(of_b));
                    }
                if (apart > 0) worst = std::max(worst, apart / brightest);
            }
    return worst;
}

double difference_of_stacks(const VectorXd& a, const VectorXd& b) {
    return ((a - b).array() / b.array()).abs().maxCoeff();
}

/// Parts of a layer whose phase functions are the same in other words, so that the solver does not
/// take them for one layer.
std::vector<StackLayer> split(const StackLayer& layer, const std::vector<double>& shares) {
    const PhaseFunction two_halves =
        PhaseFunction::sum({{0.5, layer.phase_function}, {0.5, layer.phase_function}});
    std::vector<StackLayer> parts;
    for (const double share : shares)
        parts.push_back({parts.size() % 2 == 0 ? layer.phase_function : two_halves, layer.albedo,
                         share * layer.optical_depth});
    return parts;
}

// ---- one layer ---------------------------------------------------------------------------------

TEST(Stack, OfOneLayerEqualsTheLayer) {
    for (const PhaseFunction& phase_function : {isotropic, rayleigh, haze})
        for (const double w : {0.0, 0.9, 1.0})
            for (const double tau : {0.0, 1e-300, 1e-6, 0.7, 50.0, 1e10, infinity}) {
                const LayerSolution layer =
                    solve_layer(phase_function, w, tau, cosines, stack_options(16));
                const StackSolution stack =
                    solve_stack({{phase_function, w, tau}}, nothing, cosines, stack_options(16));
                // Where doubling stops T goes on from the difference of 1/T between 2^11 and 2^12
                // reduced depths: 1e-16 times that. At w = 0, R is rounding alone.
                if (w > 0) {
                    EXPECT_LE(difference_of_stacks(stack, layer), tau == 1e10 ? 1e-11 : 1e-13)
                        << w << ' ' << tau;
                }
                EXPECT_LE((stack.plane_albedo - layer.plane_albedo).cwiseAbs().maxCoeff(), 1e-15);
                EXPECT_LE((stack.diffuse_transmittance - layer.diffuse_transmittance)
                              .cwiseAbs()
                              .maxCoeff(),
                          1e-15);
                EXPECT_NEAR(stack.spherical_albedo, layer.spherical_albedo, 1e-15);
                EXPECT_NEAR(stack.total_transmittance, layer.total_transmittance, 1e-15);
                EXPECT_NEAR(stack.spherical_albedo_below,
                            std::isinf(tau) ? 0 : layer.spherical_albedo, 1e-15);
            }
}

TEST(Stack, IsUnchangedBySplittingALayer) {
    for (const PhaseFunction& phase_function : {isotropic, rayleigh, haze, dust})
        for (const double w : {0.6, 1.0})
            for (const double tau : {1e-4, 0.3, 8.0, 300.0}) {
                const StackLayer layer{phase_function, w, tau};
                const SolverOptions options = stack_options(16);
                const StackSolution whole = solve_stack({layer}, nothing, cosines, options);
                for (const auto& shares : {std::vector<double>{0.5, 0.5},
                                           {0.3, 0.7},
                                           {1e-6, 1 - 1e-6},
                                           {0.999, 0.001},
                                           {0.1, 0.2, 0.3, 0.4}}) {
                    const StackSolution parts =
                        solve_stack(split(layer, shares), nothing, cosines, options);
                    EXPECT_LE(difference_of_stacks(parts, whole), 1e-12)
                        << phase_function.text() << ' ' << w << ' ' << tau << ' ' << shares[0];
                    EXPECT_LE(difference_of_stacks(parts.plane_albedo, whole.plane_albedo), 1e-12);
                    EXPECT_LE(difference_of_stacks(parts.diffuse_transmittance,
                                                   whole.diffuse_transmittance),
                              1e-12);
                    EXPECT_NEAR(parts.spherical_albedo_below / whole.spherical_albedo, 1, 1e-12);
                }
            }
    // with 16 nodes HG 0.85 is truncated
    EXPECT_GT(solve_stack({{haze, 1, 1}}, nothing, {1}, stack_options(16)).truncations[0].fraction,
              1e-3);
}

TEST(Stack, OfLayersThatScatterAlikeIsOneLayer) {
    const PhaseFunction cloud = PhaseFunction::henyey_greenstein(0.97);
    const LayerSolution layer = solve_layer(cloud, 0.99, 2, cosines);
    const StackSolution stack =
        solve_stack({{cloud, 0.99, 0.5}, {cloud, 0.99, 1.5}}, nothing, cosines);
    EXPECT_EQ(stack.layers.size(), 1u);
    EXPECT_LE(difference_of_stacks(stack, layer), 1e-14);
}

TEST(Stack, OfPeakedLayersIsUnchangedBySplittingOne) {
    // Where the layers are unlike in name, the path law is integrated over the depth of the turn.
    for (const double g : {0.9, 0.97})
        for (const double tau : {1e-3, 20.0}) {
            const StackLayer layer{PhaseFunction::henyey_greenstein(g), 0.99, tau};
            const StackSolution whole = solve_stack({layer}, nothing, cosines);
            const StackSolution parts = solve_stack(split(layer, {0.3, 0.7}), nothing, cosines);
            EXPECT_EQ(parts.layers.size(), 2u);
            EXPECT_LE(difference_of_stacks(parts, whole), 1e-8) << g << ' ' << tau;
        }
}

TEST(SolveLayer, OverGroundFollowsThePathsOfItsPeak) {
    const PhaseFunction cloud = PhaseFunction::henyey_greenstein(0.95);
    const LowerBoundary ground = LowerBoundary::surface(0.6);
    const std::vector<double> beyond_grazing{0.4, 0.75, 1};
    const LayerSolution reference =
        solve_layer(cloud, 0.99, 1, beyond_grazing, with_nodes(128, Truncate::nothing), ground);
    EXPECT_LE(
        difference_of_stacks(solve_layer(cloud, 0.99, 1, beyond_grazing, {}, ground), reference),
        5e-4);
}

TEST(Stack, OfUnlikeCloudsMatchesASolutionThatTruncatesNothing) {
    const std::vector<StackLayer> all{{rayleigh, 0.95, 0.3},
                                      {PhaseFunction::henyey_greenstein(0.95), 0.99, 2},
                                      {PhaseFunction::henyey_greenstein(0.85), 0.9, 1}};
    const std::vector<double> beyond_grazing{0.2, 0.75, 0.8, 1};
    for (const LowerBoundary& below : {nothing, LowerBoundary::surface(0.3)}) {
        const StackSolution stack = solve_stack(all, below, beyond_grazing);
        // Of 192 moments, the last of which are 5e-5.
        const StackSolution reference =
            solve_stack(all, below, beyond_grazing, with_nodes(96, Truncate::nothing));
        EXPECT_LE(difference_of_stacks(stack, reference), 5e-4);
        EXPECT_GT(difference_of_stacks(solve_stack(all, below, beyond_grazing, stack_options(32)),
                                       reference),
                  1e-3);
    }
}

TEST(Stack, IsUnchangedBySplittingADeepConservativeLayer) {
    // Light is reflected some tau times between two such layers: the rounding of T grows as tau, as
    // it does when one layer is doubled.
    for (const double tau : {1e4, 1e6, 1e9}) {
        const StackLayer layer{haze, 1, tau};
        const StackSolution whole = solve_stack({layer}, nothing, cosines, stack_options(16));
        for (const double share : {1e-6, 0.3}) {
            const StackSolution parts =
                solve_stack(split(layer, {share, 1 - share}), nothing, cosines, stack_options(16));
            for (const Way& way : ways(5, {1})) {
                const double expected = way.of(whole).total;
                const double rounding = way.side == Side::reflection ? 1e-12 : 1e-16 * tau;
                EXPECT_NEAR(way.of(parts).total, expected, rounding * expected)
                    << tau << ' ' << share << ' ' << way;
            }
        }
    }
}

TEST(Stack, EqualsTheSemiInfiniteLayerOverItsContinuation) {
    for (const PhaseFunction& phase_function : {rayleigh, haze})
        for (const double w : {0.5, 0.99, 1.0}) {
            const LayerSolution whole =
                solve_layer(phase_function, w, infinity, cosines, stack_options(16));
            for (const double tau : {1e-6, 0.5, 20.0}) {
                const StackSolution over =
                    solve_stack({{phase_function, w, tau}}, LowerBoundary::layer(phase_function, w),
                                cosines, stack_options(16));
                const StackSolution last =
                    solve_stack({{phase_function, w, tau}, {phase_function, w, infinity}}, nothing,
                                cosines, stack_options(16));
                // At w = 1 doubling to infinity stops 1e-9 short in R - T, and R + T is as exact
                // as rounding.
                EXPECT_LE(difference_of_stacks(over, whole), 1e-12) << w << ' ' << tau;
                EXPECT_LE(difference_of_stacks(last, whole), 1e-12) << w << ' ' << tau;
                EXPECT_LE(difference_of_stacks(over.plane_albedo, whole.plane_albedo), 1e-12);
                EXPECT_EQ(over.ground_absorptance.size(), 5);
                EXPECT_EQ(last.ground_absorptance.size(), 0);
            }
        }
}

// ---- symmetries --------------------------------------------------------------------------------

std::vector<StackLayer> twenty_layers() {
    std::vector<StackLayer> layers;
    const PhaseFunction kinds[] = {isotropic, rayleigh, haze, dust};
    Uniform uniform(7);
    for (int k = 0; k < 20; ++k)
        layers.push_back(
            {kinds[k % 4], k % 3 ? uniform() : 1.0, std::pow(10, 3 * uniform() - 2.5)});
    return layers;
}

TEST(Stack, OfManyLayersIsReciprocalFromBothSides) {
    std::vector<StackLayer> layers = twenty_layers();
    const StackSolution above = solve_stack(layers, nothing, cosines, stack_options(16));
    std::ranges::reverse(layers);
    const StackSolution under = solve_stack(layers, nothing, cosines, stack_options(16));
    EXPECT_GT(std::abs(above.spherical_albedo - under.spherical_albedo), 0.01);  // the sides differ
    EXPECT_NEAR(above.spherical_albedo_below, under.spherical_albedo, 1e-13);
    EXPECT_NEAR(under.spherical_albedo_below, above.spherical_albedo, 1e-13);
    EXPECT_NEAR(under.total_transmittance / above.total_transmittance, 1, 1e-12);
    for (const Way& way : ways(5)) {
        const SolvedValue T = way.of(above), back = way.back().of(under);
        EXPECT_GT(T.total, 0);
        if (way.side == Side::reflection) continue;
        EXPECT_NEAR(back.total, T.total, 1e-12 * T.total);
        EXPECT_NEAR(back.single, T.single, 1e-12 * T.single);
        EXPECT_NEAR(T.single + T.multiple, T.total, 1e-14 * T.total);
    }
}

// ---- ground ------------------------------------------------------------------------------------

/// Incident = reflected + absorbed by the layer + absorbed by the ground, the layer's share computed
/// from the layer alone; and the ground absorbs 1 - A of the light incident on it.
TEST(Stack, OverALambertSurfaceEqualsItsClosedFormAndBalancesTheFluxIncidentOnIt) {
    for (const PhaseFunction& phase_function : {isotropic, haze})
        for (const double w : {0.7, 1.0})
            for (const double tau : {0.0, 1e-3, 1.0, 30.0})
                for (const double A : {0.0, 0.3, 0.9, 1.0}) {
                    SCOPED_TRACE(testing::Message() << tau << ' ' << A);
                    const SolverOptions options = stack_options(24);
                    const LowerBoundary surface = LowerBoundary::surface(A);
                    const LayerSolution layer =
                        solve_layer(phase_function, w, tau, cosines, options);
                    const LayerSolution lit =
                        solve_layer(phase_function, w, tau, cosines, options, surface);
                    const StackSolution over =
                        solve_stack({{phase_function, w, tau}}, surface, cosines, options);
                    // Beam and diffuse light reach the surface; the layer reflects the share s of
                    // what the surface reflects.
                    const double s = layer.spherical_albedo;
                    const auto beam = [&](int i) { return direct_transmittance(tau, layer.mu(i)); };
                    const auto t = [&](int i) { return beam(i) + layer.diffuse_transmittance(i); };
                    for (int in = 0; in < layer.mu.size(); ++in) {
                        // s = 1 - UTU loses what is left of a deep conservative layer: 1e-15 UTU^-1
                        EXPECT_NEAR(over.ground_absorptance(in), (1 - A) * t(in) / (1 - A * s),
                                    1e-13);
                        EXPECT_NEAR(over.plane_albedo(in),
                                    layer.plane_albedo(in) +
                                        A * t(in) * layer.total_transmittance / (1 - A * s),
                                    1e-13);
                        for (int out = 0; out < layer.mu.size(); ++out)
                            for (const double azimuth : azimuths) {
                                const SolvedValue alone = layer.reflection(in, out, azimuth);
                                const double R = alone.total + A * t(in) * t(out) / (1 - A * s);
                                const SolvedValue found = over.reflection(in, out, azimuth);
                                EXPECT_NEAR(found.total, R, 1e-12 * R + 1e-16);
                                EXPECT_NEAR(found.single, alone.single + A * beam(in) * beam(out),
                                            1e-14);
                                EXPECT_EQ(over.transmission(in, out, azimuth).total, 0);
                            }
                        const double down = beam(in) + lit.diffuse_transmittance(in);
                        const double absorbed = 1 - layer.plane_albedo(in) - t(in) +
                                                A * down * (1 - s - layer.total_transmittance);
                        EXPECT_NEAR((1 - A) * down, lit.ground_absorptance(in), 1e-14);
                        EXPECT_NEAR(lit.plane_albedo(in) + absorbed + lit.ground_absorptance(in), 1,
                                    1e-13);
                    }
                    EXPECT_NEAR((1 - A) * lit.total_transmittance, lit.spherical_ground_absorptance,
                                1e-14);
                }
}

TEST(SolveLayer, SolvesTheLowerBoundaryWithClassicDoubling) {
    SolverOptions classic = stack_options(16);
    classic.scheme = Scheme::classic;
    for (const double tau : {1e-290, 0.5, infinity}) {
        const LowerBoundary surface = LowerBoundary::surface(0.5);
        const LayerSolution expected =
            solve_layer(rayleigh, 0.9, tau, cosines, stack_options(16), surface);
        const LayerSolution found = solve_layer(rayleigh, 0.9, tau, cosines, classic, surface);
        // The diamond start has an error of 1e-6.
        EXPECT_NEAR(found.spherical_albedo, expected.spherical_albedo, 1e-5);
        EXPECT_NEAR(found.total_transmittance, expected.total_transmittance, 1e-5);
    }
}

TEST(Stack, ReflectsNothingOfBlackLayersFromEitherSide) {
    const std::vector<StackLayer> black = {{PhaseFunction::anisotropic(-0.42), 0, 0.1817},
                                           {PhaseFunction::anisotropic(0.67), 0, 0.02211}};
    for (const int nodes : {6, 7, 9, 12, 16}) {
        const StackSolution solution = solve_stack(black, {}, {}, stack_options(nodes));
        EXPECT_GE(solution.spherical_albedo_below, 0);
        EXPECT_LT(solution.spherical_albedo_below, 1e-15);
        EXPECT_LT(solution.plane_albedo.cwiseAbs().maxCoeff(), 1e-15);
    }
}

TEST(Stack, BalancesEnergyOverEveryGround) {
    for (const int nodes : {1, 2, 16})
        for (const double tau : {0.0, 1e-12, 0.01, 3.0, 1e3, 1e6, 1e12, 1e16, 1e250})
            for (const LowerBoundary& boundary :
                 {LowerBoundary::surface(0), LowerBoundary::surface(0.5),
                  LowerBoundary::surface(1 - 1e-9), LowerBoundary::surface(1),
                  LowerBoundary::layer(haze, 0.9), LowerBoundary::layer(rayleigh, 0),
                  LowerBoundary::layer(dust, 1)}) {
                SCOPED_TRACE(testing::Message() << nodes << ' ' << tau << ' ' << boundary.albedo);
                const StackSolution stack = solve_stack({{haze, 1, tau}, {rayleigh, 1, 0.4}},
                                                        boundary, cosines, stack_options(nodes));
                EXPECT_NEAR(stack.spherical_albedo + stack.spherical_ground_absorptance, 1, 1e-13);
                for (int i = 0; i < stack.mu.size(); ++i)
                    EXPECT_NEAR(stack.plane_albedo(i) + stack.ground_absorptance(i), 1, 1e-13);
                // All that falls on a white ground leaves again: as much has to come down, however
                // deep the layer.
                if (boundary.albedo < 1) continue;
                EXPECT_EQ(stack.spherical_ground_absorptance, 0);
                EXPECT_NEAR(stack.total_transmittance, 1, 1e-12);
            }
}

TEST(Stack, ConservesEnergyThroughDifferentLayers) {
    for (const double tau : {1e-9, 0.3, 100.0, 1e6}) {
        const StackSolution stack =
            solve_stack({{haze, 1, tau}, {rayleigh, 1, 0.4}, {dust, 1, tau}}, nothing, cosines,
                        stack_options(16));
        expect_conserved(stack, 2 * tau + 0.4, 1e-13);
        EXPECT_NEAR(stack.spherical_albedo_below + stack.total_transmittance, 1, 1e-13) << tau;
    }
}

TEST(Stack, TransmitsByTheLawOfDiffusionHoweverDeep) {
    // T of deep white layers is 4/3 over the sum of their (1 - g) tau [vdH80].
    for (const double tau : {1e12, 1e15, 1e100}) {
        const StackSolution stack =
            solve_stack({{PhaseFunction::henyey_greenstein(-0.5), 1, tau},
                         {rayleigh, 1, 3 * tau},
                         {PhaseFunction::henyey_greenstein(0.7), 1, 5 * tau}},
                        nothing, cosines, stack_options(24));
        EXPECT_NEAR(stack.total_transmittance * (1.5 + 3 + 0.3 * 5) * tau, 4.0 / 3, 1e-11) << tau;
    }
}

TEST(Stack, ScattersOnceWhenThin) {
    const double tau = 1e-7;
    for (const LowerBoundary& boundary :
         {nothing, LowerBoundary::surface(1e-7), LowerBoundary::layer(haze, 1e-8)}) {
        const StackSolution stack = solve_stack({{rayleigh, 0.9, tau}, {haze, 0.7, 2 * tau}},
                                                boundary, {0.3, 0.8}, stack_options(16));
        for (const Way& way : ways(2)) {
            if (way.out == 0 || (way.side == Side::transmission && boundary.is_present())) continue;
            const SolvedValue value = way.of(stack);
            EXPECT_NEAR(value.total / value.single, 1, 1e-4) << way;  // O(tau log tau / mu)
        }
    }
}

TEST(SolveLadder, OverABoundaryEqualsStacksOfOneLayer) {
    const std::vector<double> albedos{0.5, 0.9, 1};
    for (const LowerBoundary& boundary :
         {LowerBoundary::surface(0.4), LowerBoundary::layer(haze, 0.9)}) {
        const auto ladder =
            solve_ladder(rayleigh, albedos, {0.1, 8, true}, cosines, stack_options(16), boundary);
        for (const auto a : indices(albedos))
            for (std::size_t d = 0; d < 8; ++d) {
                const StackSolution stack =
                    solve_stack({{rayleigh, albedos[a], ladder[a][d].optical_depth}}, boundary,
                                cosines, stack_options(16));
                EXPECT_LE(difference_of_stacks(ladder[a][d], stack), 1e-12) << a << ' ' << d;
                EXPECT_LE(difference_of_stacks(ladder[a][d].plane_albedo, stack.plane_albedo),
                          1e-12);
            }
        // a semi-infinite layer hides its lower boundary
        const LayerSolution bare = solve_layer(rayleigh, 0.9, infinity, cosines, stack_options(40));
        EXPECT_LE(
            difference_of_stacks(
                solve_layer(rayleigh, 0.9, infinity, cosines, stack_options(40), boundary), bare),
            1e-7);  // nodes of another map
    }
}

TEST(LayerSolution, ReportsTheBoundaryCorrection) {
    const LowerBoundary boundary = LowerBoundary::layer(haze, 0.9);
    const LayerSolution layer = solve_layer(dust, 0.8, 0.3, {0.4, 0.9}, stack_options(8), boundary);
    ASSERT_GT(layer.boundary_truncation.fraction, 0);
    const Geometry at{0.4, 0.9, 1};
    const double cosine = cos_scattering_angle_reflected(at);
    EXPECT_NEAR(sum_modes(layer.modes.reflection, 0, 1, 1) +
                    layer.peak_correction(Side::reflection, 0, 1)(dust(cosine), cosine) +
                    layer.boundary_correction(0, 1) * haze(cosine),
                layer.reflection(0, 1, 1).multiple, 1e-14);
    // the truncated beam reaches a surface less attenuated
    const LayerSolution over =
        solve_layer(haze, 0.8, 0.3, {0.4, 0.9}, stack_options(8), LowerBoundary::surface(0.4));
    EXPECT_NEAR(sum_modes(over.modes.reflection, 0, 1, 1) +
                    over.peak_correction(Side::reflection, 0, 1)(haze(cosine), cosine) +
                    over.boundary_correction(0, 1),
                over.reflection(0, 1, 1).multiple, 1e-14);
    EXPECT_GT(over.boundary_correction(0, 1), 1e-4);
}

// ---- other properties --------------------------------------------------------------------------

TEST(Stack, SumsSingleScatteringOfItsLayers) {
    const std::vector<StackLayer> layers{{rayleigh, 0.9, 0.2}, {haze, 0.8, 0.5}};
    const StackSolution stack =
        solve_stack(layers, LowerBoundary::layer(dust, 0.3), {0.4, 0.9}, stack_options(8));
    const Geometry at{0.4, 0.9, 1};
    const double cosine = cos_scattering_angle_reflected(at);
    auto passed = [](double tau) { return std::exp(-tau / 0.4 - tau / 0.9); };
    const double expected = single_reflection(rayleigh(cosine), 0.9, 0.2, 0.4, 0.9) +
                            passed(0.2) * single_reflection(haze(cosine), 0.8, 0.5, 0.4, 0.9) +
                            passed(0.7) * single_reflection(dust(cosine), 0.3, infinity, 0.4, 0.9);
    EXPECT_NEAR(stack.reflection(0, 1, 1).single, expected, 1e-15);
    const StackSolution free = solve_stack(layers, nothing, {0.4, 0.9}, stack_options(8));
    const double down = cos_scattering_angle_transmitted(at);
    EXPECT_NEAR(free.transmission(0, 1, 1).single,
                std::exp(-0.5 / 0.9) * single_transmission(rayleigh(down), 0.9, 0.2, 0.4, 0.9) +
                    std::exp(-0.2 / 0.4) * single_transmission(haze(down), 0.8, 0.5, 0.4, 0.9),
                1e-15);
}

TEST(Stack, ConvergesWithNodesOverAPeakedGround) {
    const std::vector<StackLayer> layers{{rayleigh, 1, 0.5}, {haze, 0.98, 2}};
    const LowerBoundary boundary = LowerBoundary::layer(PhaseFunction::henyey_greenstein(0.8), 0.9);
    const StackSolution coarse = solve_stack(layers, boundary, {0.2, 0.7, 1}, stack_options(40));
    const StackSolution fine = solve_stack(layers, boundary, {0.2, 0.7, 1}, stack_options(80));
    EXPECT_LE(difference_of_stacks(coarse, fine),
              1e-5);  // HG 0.85 alone has an error of 3e-6 with 40 nodes
}

// ---- refusals ----------------------------------------------------------------------------------

TEST(Stack, RefusesArgumentsOutOfRange) {
    const auto refused = [](const std::vector<StackLayer>& layers, const Fragments& fragments,
                            const LowerBoundary& boundary = {}, const SolverOptions& options = {}) {
        expect_refusal([&] { solve_stack(layers, boundary, {1}, options); }, fragments);
    };
    const std::vector<StackLayer> one{{isotropic, 1, 1}}, endless{{isotropic, 1, infinity}};
    refused({}, "layers must be at least one");
    refused({{isotropic, 1, 1}, {isotropic, 1.2, 1}},
            "albedo of layer 2 must be in [0, 1], got 1.2");
    refused(one, {"albedo of the lower boundary must be in [0, 1], got -0.1"},
            LowerBoundary::surface(-0.1));
    refused({{isotropic, 1, 1}, {isotropic, 0.5, -1}},
            "optical_depth of layer 2 must be in [0, inf], got -1");
    refused({{isotropic, 1, NAN}}, "optical_depth must be in [0, inf], got nan");
    refused({endless[0], one[0]}, {"optical_depth of layer 1", "finite", "inf"});
    refused(endless,
            {"optical_depth must be finite above another layer or a lower boundary, got inf"},
            LowerBoundary::surface(0.5));
    refused(one, {"scheme must be harmonic"}, {}, {.scheme = Scheme::classic});
}

}  // namespace
}  // namespace stratus
