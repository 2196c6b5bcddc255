// The Markov chain agrees with the solver within its stated errors.
#include <stratus/transfer/reference/solvers.h>

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/expint.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

const std::vector<double> chain_cosines{0.1, 0.3, 0.5, 0.8, 1.0};
const std::vector<double> chain_azimuths{0, 1, pi};

MarkovOptions chain_of(int nodes, int sublayers, int orders = 0) {
    return {.nodes = nodes, .sublayers = sublayers, .orders = orders};
}

// ---- against the solver ------------------------------------------------------------------------

/// All modes; six of them, and other layers, in agreement_test.
TEST(MarkovChain, MatchesTheSolverWithinItsStatedError) {
    for (const double optical_depth : {0.1, 1.0, 8.0}) {
        SCOPED_TRACE(optical_depth);
        // As the chain: its nodes, no truncation.
        const LayerSolution layer = solve_layer(saturn, 0.99, optical_depth, chain_cosines,
                                                with_nodes(8, Truncate::nothing));
        const MarkovSolution chain =
            solve_markov(saturn, 0.99, optical_depth, chain_cosines, chain_of(8, 32));
        for (const Way& way : ways(5, chain_azimuths)) {
            const auto [value, error] = way.of(chain);
            const SolvedValue expected = way.of(layer);
            // 1e-10: omitted modes
            EXPECT_NEAR(value.total, expected.total, error + 1e-10 * expected.total) << way;
            EXPECT_EQ(value.single, expected.single);
            EXPECT_LT(error, 0.05 * expected.total + 1e-6) << "stated error too large";
        }
        for (int i = 0; i < 5; ++i) {
            EXPECT_NEAR(chain.layer.plane_albedo(i), layer.plane_albedo(i), chain.flux_error);
            EXPECT_NEAR(chain.layer.diffuse_transmittance(i), layer.diffuse_transmittance(i),
                        chain.flux_error);
        }
        EXPECT_NEAR(chain.layer.spherical_albedo, layer.spherical_albedo, chain.flux_error);
        EXPECT_NEAR(chain.layer.total_transmittance, layer.total_transmittance, chain.flux_error);
        EXPECT_LT(chain.flux_error, 1e-2 * optical_depth);  // and is small
    }
}

TEST(MarkovChain, MatchesTheConvergedSolverTo1e5) {
    // The nodes of either cause 1e-9; K = 32 causes 4e-6, most of it at mu = mu0 = 0.1.
    EXPECT_LE(difference(solve_markov({}, 0.99, 1, chain_cosines, chain_of(24, 32)).layer,
                         solve_layer({}, 0.99, 1, chain_cosines), {0}),
              1e-5);
}

// ---- the chain alone ---------------------------------------------------------------------------

TEST(MarkovChain, SumsItsOrdersToItsInverse) {
    const PhaseFunction phase_function = PhaseFunction::rayleigh();
    // Orders decay faster than w^n: 300 of them suffice for 1e-14.
    const MarkovSolution all = solve_markov(phase_function, 0.9, 2, chain_cosines, chain_of(6, 4));
    const MarkovSolution one_by_one =
        solve_markov(phase_function, 0.9, 2, chain_cosines, chain_of(6, 4, 300));
    ASSERT_EQ(one_by_one.order.size(), 299u);
    for (const auto& [side, in, out, azimuth] : ways(5, chain_azimuths)) {
        if (out != 2) continue;
        double sum = 0;
        for (int n = 300; n > 0; --n) sum += one_by_one.of_order(side, n, in, 2, azimuth);
        for (const MarkovSolution* of : {&all, &one_by_one})
            EXPECT_NEAR(value_at(*of, side, in, 2, azimuth).value.total / sum, 1, 1e-12);
    }
}

/// Order 2 of an isotropic layer from its source function: light of depth t' that scatters again at
/// t arrives with E_1(|t - t'|)/2, and both beams are exponentials, so that one integral over
/// v = |t - t'| remains:
///
///     R_2 = w^2/(8 mu mu0) int E_1(v) (exp(-v/mu) + exp(-v/mu0)) c(1/mu + 1/mu0, tau - v) dv
///     T_2 = w^2/(8 mu mu0) int E_1(v) (exp(-(tau - v)/mu) c(1/mu0 - 1/mu, tau - v)
///                                    + exp(-v/mu0 - tau/mu) c(1/mu0 - 1/mu, tau - v)) dv
///
/// with c(a, L) = int_0^L exp(-a s) ds.
double second_order(Side side, double albedo, double tau, double mu0, double mu) {
    const bool reflected = side == Side::reflection;
    const auto c = [](double a, double length) {
        return a == 0 ? length : -std::expm1(-a * length) / a;
    };
    const double a = reflected ? 1 / mu + 1 / mu0 : 1 / mu0 - 1 / mu;
    boost::math::quadrature::tanh_sinh<double> integrate;
    const double integral = integrate.integrate(
        [&](double v) {
            if (v == 0) return 0.0;  // E_1 is infinite there and its weight 0
            const double pair = reflected
                                    ? std::exp(-v / mu) + std::exp(-v / mu0)
                                    : std::exp(-(tau - v) / mu) + std::exp(-v / mu0 - tau / mu);
            return boost::math::expint(1, v) * pair * c(a, tau - v);
        },
        0.0, tau);
    return albedo * albedo / (8 * mu * mu0) * integral;
}

TEST(MarkovChain, HasTheSecondOrderOfTheIsotropicLayer) {
    for (const double tau : {0.1, 1.0, 4.0}) {
        const MarkovSolution chain = solve_markov({}, 0.8, tau, chain_cosines, chain_of(24, 32, 2));
        for (const Way& way : ways(5, {0})) {
            const auto& [mu0, mu, azimuth] = way.geometry(chain.layer);
            const double expected = second_order(way.side, 0.8, tau, mu0, mu),
                         error = way.of(chain).error;
            // 1e-8: error of 24 nodes
            EXPECT_NEAR(chain.of_order(way.side, 2, way.in, way.out, 0), expected,
                        error + 1e-8 * expected)
                << tau << ' ' << way;
            if (way.side == Side::reflection) {
                EXPECT_LT(error, 5e-3 * expected);
            }
        }
    }
}

TEST(MarkovChain, ConvergesAsTheSquareOfTheSublayers) {
    const SolverOptions same = with_nodes(8, Truncate::nothing);
    const LayerSolution layer = solve_layer({}, 0.99, 1, chain_cosines, same);
    const auto errors = [&](int sublayers, bool extrapolate) {
        MarkovOptions options = chain_of(8, sublayers);
        options.extrapolate = extrapolate;
        const MarkovSolution chain = solve_markov({}, 0.99, 1, chain_cosines, options);
        double sum = 0;
        for (int in = 1; in < 5; ++in)
            for (const Side side : both_sides)
                sum += std::abs(value_at(chain, side, in, 2, 0).value.total -
                                value_at(layer, side, in, 2, 0).total);
        return sum;
    };
    EXPECT_NEAR(std::log2(errors(16, false) / errors(32, false)), 2, 0.1);
    // Extrapolation is of third order at least, and thirty times more accurate at K = 32.
    EXPECT_GT(std::log2(errors(16, true) / errors(32, true)), 2.8);
    EXPECT_LT(errors(32, true), errors(32, false) / 30);
}

TEST(MarkovChain, IsReciprocalAndConservesEnergy) {
    const MarkovSolution chain =
        solve_markov(PhaseFunction::rayleigh(), 1, 1, chain_cosines, chain_of(8, 16));
    for (const Way& way : ways(5, {1})) {
        const double there = way.of(chain).value.total;
        EXPECT_NEAR(way.back().of(chain).value.total, there, 1e-11 * there);
    }
    EXPECT_NEAR(chain.layer.spherical_albedo + chain.layer.total_transmittance, 1,
                2 * chain.flux_error);
    EXPECT_LT(chain.flux_error, 1e-3);
}

TEST(MarkovChain, VanishesWithoutScattering) {
    const MarkovSolution empty = solve_markov({}, 1, 0, chain_cosines);
    EXPECT_EQ(empty.reflection(0, 1, 0).value.total, 0);
    EXPECT_EQ(empty.transmission(0, 0, 0).value.total, 0);
    EXPECT_EQ(empty.layer.spherical_albedo, 0);
    EXPECT_NEAR(empty.layer.total_transmittance, 1, 1e-15);
    const MarkovSolution black = solve_markov({}, 0, 1, chain_cosines);
    EXPECT_EQ(black.reflection(0, 1, 0).value.total, 0);
    EXPECT_EQ(black.layer.plane_albedo(2), 0);
    // 16 nodes integrate the beam to 1e-9
    EXPECT_NEAR(black.layer.total_transmittance, 2 * boost::math::expint(3, 1.0), 1e-8);
}

TEST(MarkovChain, KeepsItsRelativeAccuracyInThinLayers) {
    const SolverOptions same = with_nodes(8, Truncate::nothing);
    for (const double tau : {1e-140, 1e-12, 1e-9, 1e-3}) {
        const LayerSolution layer = solve_layer({}, 1, tau, {0.5}, same);
        const MarkovSolution chain = solve_markov({}, 1, tau, {0.5}, chain_of(8, 16));
        EXPECT_NEAR(chain.layer.plane_albedo(0) / layer.plane_albedo(0), 1, 1e-6) << tau;
        const SolvedValue R = layer.reflection(0, 0, 0);
        EXPECT_NEAR(chain.reflection(0, 0, 0).value.total / R.total, 1, 1e-6) << tau;
        const double multiple = chain.reflection(0, 0, 0).value.multiple / R.total;
        if (tau < 1e-100) {
            EXPECT_GT(multiple, tau);  // tau log(1/tau), not rounding
            EXPECT_LT(multiple, 1e4 * tau);
        } else {  // the solver subtracts: 5 digits remain at 1e-12
            EXPECT_NEAR(multiple * R.total / R.multiple, 1, 1e-4) << tau;
        }
    }
}

TEST(MarkovChain, StopsAfterOrderOne) {
    const MarkovSolution once = solve_markov({}, 1, 1, chain_cosines, chain_of(8, 16, 1));
    EXPECT_EQ(once.reflection(1, 2, 0).value.multiple, 0);
    EXPECT_EQ(once.of_order(Side::reflection, 1, 1, 2, 0), once.reflection(1, 2, 0).value.single);
    EXPECT_EQ(once.reflection(1, 2, 0).error, 0);
    EXPECT_LT(once.layer.spherical_albedo + once.layer.total_transmittance, 0.9);
}

TEST(MarkovChain, UsesTheGaussNodesByDefault) {
    const MarkovSolution chain = solve_markov({}, 0.9, 1, {}, chain_of(8, 16));
    ASSERT_EQ(chain.layer.mu.size(), 8);
    const MarkovSolution asked = solve_markov({}, 0.9, 1, {chain.layer.mu(5)}, chain_of(8, 16));
    EXPECT_NEAR(chain.reflection(5, 5, 0).value.total / asked.reflection(0, 0, 0).value.total, 1,
                1e-13);
    EXPECT_NEAR(chain.layer.plane_albedo(5), asked.layer.plane_albedo(0), 1e-13);
}

// ---- refusals ----------------------------------------------------------------------------------

TEST(MarkovChain, RefusesArgumentsOutOfRange) {
    const auto refused = [](double albedo, double optical_depth, double mu,
                            const MarkovOptions& options, const Fragments& reason) {
        expect_refusal([&] { solve_markov({}, albedo, optical_depth, {mu}, options); }, reason);
    };
    const std::string finite =
        "markov: optical_depth must be in [0, inf) (a semi-infinite layer cannot be divided into "
        "sublayers)";
    refused(1.5, 1, 1, {}, "markov: albedo must be in [0, 1], got 1.5");
    refused(NAN, 1, 1, {}, "markov: albedo must be in [0, 1], got nan");
    refused(0.5, -1, 1, {}, {finite, ", got -1"});
    refused(0.5, NAN, 1, {}, {finite, ", got nan"});
    refused(0.5, infinity, 1, {}, {finite, ", got inf"});
    refused(0.5, 1, 0, {}, "mu must be in [1e-100, 1], got 0");
    refused(0.5, 1, 1, chain_of(0, 32), "markov: nodes must be in [1, 512], got 0");
    refused(0.5, 1, 1, chain_of(513, 4), "markov: nodes must be in [1, 512], got 513");
    for (const int sublayers : {2, 15})
        refused(
            0.5, 1, 1, chain_of(8, sublayers),
            {"markov: sublayers must be even and in [4, 8192], got", std::to_string(sublayers)});
    refused(0.5, 1, 1, chain_of(8, 16, -1), "markov: orders must be >= 0, got -1");
    refused(0.5, 1, 1, {.modes = -1}, "markov: modes must be >= 0, got -1");
    refused(
        0.5, 1, 1, chain_of(64, 66),
        "markov: 2 sublayers x nodes must be at most 8192 (a dense matrix of 512 MiB), got 8448");
}

}  // namespace
}  // namespace stratus
