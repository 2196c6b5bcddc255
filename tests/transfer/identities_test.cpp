// Identities that hold for any layer: symmetries, and agreement of the solver with itself.
#include <stratus/base/constants.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "instruction_sets.h"
#include "usual_layers.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

using Eigen::VectorXd;

// ---- symmetries --------------------------------------------------------------------------------

/// By classic doubling: the products of the harmonic scheme are symmetric by construction.
TEST(SolveLayer, IsReciprocal) {
    for (const PhaseFunction& phase_function : {rayleigh, forward})
        for (const double tau : {1e-6, 0.1, 8.0, infinity}) {
            const LayerSolution layer =
                solve_layer(phase_function, 0.95, tau, cosines, {.scheme = Scheme::classic});
            for (const Way& way : ways(5)) {
                const double there = way.of(layer).total;
                EXPECT_NEAR(way.back().of(layer).total, there, 1e-13 * there) << tau << ' ' << way;
            }
        }
}

TEST(LayerSolution, SumsSingleAndMultipleScattering) {
    for (const Truncate truncate : {Truncate::nothing, Truncate::delta_m, Truncate::smooth}) {
        const LayerSolution layer =
            solve_layer(forward, 0.9, 0.7, cosines, with_nodes(8, truncate));
        ASSERT_EQ(layer.truncation.fraction > 0, truncate != Truncate::nothing);
        ASSERT_EQ(layer.truncation.narrow, truncate == Truncate::smooth);
        for (const Way& way : ways(5)) {
            const SolvedValue value = way.of(layer);
            const Geometry at = way.geometry(layer);
            EXPECT_EQ(value.single,
                      single_scattering(way.side, forward(cos_scattering_angle(way.side, at)), 0.9,
                                        0.7, at.mu_in, at.mu_out));
            EXPECT_NEAR(value.single + value.multiple, value.total, 1e-15 * value.total);
        }
    }
}

TEST(LayerSolution, GivesTheSameValuesForManyAzimuths) {
    for (const LowerBoundary& boundary : {LowerBoundary{}, LowerBoundary::layer(rayleigh, 0.4)}) {
        const LayerSolution layer =
            solve_layer(forward, 0.9, 0.7, cosines, with_nodes(8), boundary);
        for (const Side side : both_sides) {
            const std::vector<SolvedValue> values = layer.values(side, 1, 3, azimuths);
            ASSERT_EQ(values.size(), azimuths.size());
            for (const auto k : indices(azimuths))
                EXPECT_EQ(values[k].total, value_at(layer, side, 1, 3, azimuths[k]).total);
        }
    }
}

TEST(LayerSolution, ReportsThePeakCorrections) {
    const LayerSolution layer = solve_layer(forward, 0.9, 0.7, cosines, with_nodes(8));
    for (const Way& way : ways(5, {1.1})) {
        const auto& [side, in, out, azimuth] = way;
        const double cosine = cos_scattering_angle(side, way.geometry(layer));
        double orders = 0, factor = 1;  // the Fourier sum alone
        for (int m = 0; const AzimuthalMode& mode : layer.modes[side]) {
            orders += factor * std::cos(azimuth * m++) * mode(in, out);
            factor = 2;
        }
        EXPECT_NEAR(orders + layer.peak_correction(side, in, out)(forward(cosine), cosine),
                    way.of(layer).multiple, 1e-13 * way.of(layer).total);
    }
    const PeakCorrection none =
        solve_layer(rayleigh, 0.9, 0.7, cosines).peak_correction(Side::reflection, 0, 1);
    EXPECT_EQ(none.single, 0);
    EXPECT_TRUE(none.legendre.empty());
}

// ---- self-agreement ----------------------------------------------------------------------------

TEST(SolveLadder, EqualsSolveLayerAtEveryDepth) {
    const std::vector<double> albedos{0.3, 0.99, 1};
    const auto ladder = solve_ladder(forward, albedos, {0.05, 10, true}, cosines, with_nodes(16));
    ASSERT_EQ(ladder.size(), 3u);
    for (const auto a : indices(albedos)) {
        ASSERT_EQ(ladder[a].size(), 11u);
        for (std::size_t d = 0; d < 11; ++d) {
            const double tau = d == 10 ? infinity : std::ldexp(0.05, static_cast<int>(d));
            EXPECT_EQ(ladder[a][d].optical_depth, tau);
            EXPECT_EQ(ladder[a][d].albedo, albedos[a]);
            const LayerSolution at_once =
                solve_layer(forward, albedos[a], tau, cosines, with_nodes(16));
            EXPECT_LE(difference(ladder[a][d], at_once), 1e-11) << albedos[a] << ' ' << tau;
            EXPECT_NEAR(ladder[a][d].spherical_albedo, at_once.spherical_albedo, 1e-13);
        }
    }
}

TEST(SolveLadder, SolvesTheDepthsThatAreAskedForAlone) {
    const std::vector<double> albedos{0.3, 1};
    const auto all = solve_ladder(forward, albedos, {0.05, 12, true}, cosines, with_nodes(16));
    std::vector<bool> asked(13, false);
    const std::vector<std::size_t> depths{2, 9, 10, 12};
    for (const std::size_t d : depths) asked[d] = true;
    const auto some =
        solve_ladder(forward, albedos, {0.05, 12, true, asked}, cosines, with_nodes(16));
    for (const auto a : indices(albedos)) {
        ASSERT_EQ(some[a].size(), depths.size());
        for (const auto n : indices(depths)) {
            EXPECT_EQ(some[a][n].optical_depth, all[a][depths[n]].optical_depth);
            EXPECT_LE(difference(some[a][n], all[a][depths[n]]), 1e-11) << depths[n];
        }
    }
}

TEST(SolveLadder, SolvesMoreAlbedosThanLanes) {
    std::vector<double> albedos;
    for (int a = 0; a <= 10; ++a) albedos.push_back(a / 10.0);
    const auto ladder = solve_ladder(rayleigh, albedos, {1, 1, false}, cosines, with_nodes(8));
    for (std::size_t a = 1; a < albedos.size(); ++a)
        EXPECT_LE(
            difference(ladder[a][0], solve_layer(rayleigh, albedos[a], 1, cosines, with_nodes(8))),
            1e-13)
            << albedos[a];
}

class InstructionSets : public testing::TestWithParam<InstructionSet> {};

TEST_P(InstructionSets, GiveTheSameValues) {
    if (!is_available(GetParam())) GTEST_SKIP() << "not available on this processor";
    const SolverOptions options = with_nodes(13);  // odd: every kind of block has an edge
    for (const double w : {0.6, 1.0})
        for (const double tau : {1e-3, 1.0, 300.0}) {
            const LayerSolution widest = solve_layer(forward, w, tau, cosines, options);
            const InstructionSetLimit limit(GetParam());
            // sums in a different order, fused or not
            EXPECT_LE(difference(solve_layer(forward, w, tau, cosines, options), widest), 1e-12)
                << w << ' ' << tau;
        }
}

INSTANTIATE_TEST_SUITE_P(Each, InstructionSets, testing::ValuesIn(instruction_sets),
                         instruction_set_row);

TEST(SolveLayer, StopsWhenModesAreNegligible) {
    SolverOptions all = with_nodes(24);
    all.modes = 48;
    for (const PhaseFunction& phase_function :
         {isotropic, rayleigh, saturn, PhaseFunction::henyey_greenstein(-0.3)}) {
        const LayerSolution whole = solve_layer(phase_function, 0.99, 3, cosines, all);
        const LayerSolution stopped = solve_layer(phase_function, 0.99, 3, cosines, with_nodes(24));
        EXPECT_LE(difference(stopped, whole), 1e-13);  // mode_tolerance, summed
    }
    const auto modes = [](const PhaseFunction& phase_function) {
        return solve_layer(phase_function, 0.99, 3, cosines, with_nodes(24))
            .modes.reflection.size();
    };
    EXPECT_EQ(modes(isotropic), 1u);
    EXPECT_EQ(modes(rayleigh), 3u);
    EXPECT_LT(modes(PhaseFunction::henyey_greenstein(-0.3)), 48u);
}

TEST(SolveLayer, SolvesTheRequestedModes) {
    SolverOptions options = with_nodes(8);
    for (const int modes : {1, 3, 11, 16, 40}) {
        options.modes = modes;
        const LayerSolution layer = solve_layer(forward, 0.9, 1, cosines, options);
        // 3/2 N moments of a narrow peak have no more modes
        EXPECT_EQ(layer.modes.reflection.size(), static_cast<std::size_t>(std::min(modes, 12)));
        EXPECT_EQ(layer.modes.transmission.size(), layer.modes.reflection.size());
    }
}

TEST(SolveLayer, IsIndependentOfExtraDirections) {
    for (const double tau : {0.01, 2.0, 200.0}) {
        const LayerSolution alone = solve_layer(forward, 0.97, tau, cosines, with_nodes(16));
        std::vector<double> more = cosines;
        for (const double mu : {0.0001, 0.05, 0.3, 0.30000001, 0.5, 0.75, 0.999})
            more.push_back(mu);
        const LayerSolution among = solve_layer(forward, 0.97, tau, more, with_nodes(16));
        for (int in = 0; in < 5; ++in)
            EXPECT_NEAR(among.plane_albedo(in), alone.plane_albedo(in), 1e-14);
        for (const Way& way : ways(5, {1})) {
            const double expected = way.of(alone).total;
            EXPECT_NEAR(way.of(among).total, expected, 1e-14 * expected) << tau << ' ' << way;
        }
        EXPECT_NEAR(among.spherical_albedo, alone.spherical_albedo, 1e-15);
    }
}

TEST(SolveLayer, UsesTheGaussNodesByDefault) {
    const LayerSolution layer = solve_layer(rayleigh, 0.9, 1, {}, with_nodes(12));
    const Directions nodes = gauss_directions(12, NodeMap::grazing);
    EXPECT_EQ(layer.mu, VectorXd(nodes.mu));
    const std::vector<double> asked(nodes.mu.begin(), nodes.mu.end());
    const LayerSolution extra = solve_layer(rayleigh, 0.9, 1, asked, with_nodes(12));
    for (const Way& way : ways(12, {1})) {
        const double expected = way.of(extra).total, s = nodes.s(way.in);
        // On the diagonal the matrices of the Gauss nodes also hold the beam, whose rounding is
        // 1e-16 / (2 mu weight), large at the first nodes.
        EXPECT_NEAR(way.of(layer).total, expected,
                    1e-13 * expected + (way.in == way.out ? 1e-15 / (s * s) : 0))
            << way;
    }
}

#ifdef __SSE2__
// Modes of high order underflow: subnormal numbers are flushed meanwhile, and for the solver alone.
TEST(SolveLayer, FlushesSubnormalNumbersForItselfAlone) {
    const auto solve = [] {
        SolverOptions options = with_nodes(64, Truncate::nothing);
        options.modes = 128;
        return solve_layer(PhaseFunction::henyey_greenstein(0.95), 0.99, 1, {0.1, 0.999}, options);
    };
    const auto control = [] { return _mm_getcsr() & ~0x3fu; };  // less the flags that stick
    const unsigned before = control();
    const LayerSolution plain = solve();
    EXPECT_EQ(control(), before);
    EXPECT_ANY_THROW(solve_layer(PhaseFunction::henyey_greenstein(-0.999), 1, 1, {},
                                 with_nodes(32, Truncate::nothing)));
    EXPECT_EQ(control(), before);
    _mm_setcsr(before | 0x8040);
    const LayerSolution flushed = solve();
    _mm_setcsr(before);
    for (std::size_t m = 0; m < 128; ++m)
        EXPECT_TRUE(
            plain.modes.reflection[m].values.isApprox(flushed.modes.reflection[m].values, 1e-14))
            << m;
}
#endif

}  // namespace
}  // namespace stratus
