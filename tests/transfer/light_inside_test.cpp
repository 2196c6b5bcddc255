// The light inside: against what leaves the layers, energy, closed forms deep down, and the equation of
// transfer.

#include <stratus/base/gauss_legendre.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/solve_to_tolerance.h>
#include <stratus/transfer/stack.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "indices.h"
#include "light_inside.h"
#include "refusal.h"
#include "usual_layers.h"

namespace stratus {
namespace {

const PhaseFunction haze = parse_phase_function("henyey_greenstein:g=0.6");
const PhaseFunction& air = rayleigh;

std::vector<StackLayer> air_over_haze(double w_air, double w_haze) {
    return {{air, w_air, 0.5}, {haze, w_haze, 1.5}};
}

void expect_what_leaves(const std::vector<StackLayer>& layers, const LowerBoundary& ground,
                        double depth) {
    const std::vector<double> mu{0.15, 0.6, 1};
    const StackSolution outside = solve_stack(layers, ground, mu, with_nodes(24));
    const InsideSolution inside =
        solve_inside(layers, ground, {depth, 0, 0.35 * depth}, mu, with_nodes(24));
    const LightAtLevel &bottom = inside.levels[0], &top = inside.levels[1];
    const double tolerance = 1e-9;  // of the path law's integral
    for (int in = 0; in < 3; ++in) {
        EXPECT_NEAR(top.plane_albedo(in), outside.plane_albedo(in), 1e-13);
        EXPECT_NEAR(top.diffuse_transmittance(in), 0, 1e-15);
        EXPECT_NEAR(bottom.diffuse_transmittance(in), outside.diffuse_transmittance(in), 1e-13);
        for (int out = 0; out < 3; ++out) {
            const auto up = inside.values(Side::reflection, in, out, azimuths, 1);
            const auto down = inside.values(Side::transmission, in, out, azimuths);
            for (const auto k : indices(azimuths)) {
                const SolvedValue R = outside.reflection(in, out, azimuths[k]);
                EXPECT_NEAR(up[k].total, R.total, tolerance * R.total + 1e-12);
                EXPECT_NEAR(up[k].single, R.single, 1e-13 * R.single);
                EXPECT_NEAR(inside.values(Side::transmission, in, out, azimuths, 1)[k].total, 0,
                            1e-14);
                if (ground.is_present()) continue;
                const SolvedValue T = outside.transmission(in, out, azimuths[k]);
                EXPECT_NEAR(down[k].total, T.total, tolerance * T.total + 1e-12);
                EXPECT_NEAR(down[k].single, T.single, 1e-13 * T.single);
            }
        }
    }
}

TEST(LightInside, IsAtBothEndsWhatLeaves) {
    const PhaseFunction narrow = parse_phase_function("henyey_greenstein:g=0.97");
    for (const LowerBoundary& ground :
         {LowerBoundary{}, LowerBoundary::surface(0.4), LowerBoundary::layer(haze, 0.9),
          LowerBoundary::layer(narrow, 0.9)}) {
        expect_what_leaves(air_over_haze(1, 0.9), ground, 2);
        expect_what_leaves({{air, 0.9, 0.4}, {narrow, 1, 1.2}}, ground, 1.6);
    }
}

// 88 nodes resolve the peaks; 32 leave the rest to the path law.
TEST(LightInside, FollowsThePathsOfNarrowPeaks) {
    const std::vector<StackLayer> layers{
        {parse_phase_function("henyey_greenstein:g=0.9"), 0.99, 0.7},
        {parse_phase_function("henyey_greenstein:g=0.87"), 1, 1}};
    const std::vector<double> mu{0.4, 0.5, 1}, azimuths{0, 0.2, 1, 3};
    const SolverOptions resolved = with_nodes(88, Truncate::nothing);
    const std::vector<double> levels{0.3, 1.2};
    const InsideSolution few = solve_inside(layers, {}, levels, mu, with_nodes(32));
    const InsideSolution exact = solve_inside(layers, {}, levels, mu, resolved);
    EXPECT_NE(few.path, nullptr);
    for (const std::size_t l : {0u, 1u})
        for (const Way& way : ways(3, azimuths)) {
            const auto total = [&](const InsideSolution& inside) {
                return inside.values(way.side, way.in, way.out, {way.azimuth}, l)[0].total;
            };
            EXPECT_NEAR(total(few), total(exact), 1e-3 * total(exact)) << levels[l] << ' ' << way;
        }
}

double net_flux(const LightAtLevel& at, int in) {
    return at.direct_flux(in) + at.diffuse_transmittance(in) - at.plane_albedo(in);
}

TEST(LightInside, CarriesOneNetFluxWithoutAbsorption) {
    const std::vector<double> mu{0.1, 0.5, 1};
    std::vector<StackLayer> layers = air_over_haze(1, 1);
    for (const double deep : {1.5, 40.0}) {
        layers[1].optical_depth = deep;
        const InsideSolution solution = solve_inside(
            layers, LowerBoundary::surface(0.3), {0, 0.2, 0.5, 0.5001, 1, deep, 0.5 + deep}, mu);
        for (int in = 0; in < 3; ++in)
            for (const LightAtLevel& at : solution.levels) {
                EXPECT_NEAR(net_flux(at, in), 1 - solution.levels[0].plane_albedo(in), 1e-12);
                EXPECT_EQ(at.heating_rate(in), 0);
            }
    }
}

/// Two levels, and those between at which a rule integrates over them.
std::vector<double> levels_between(double top, double bottom, const GaussLegendre& gauss) {
    std::vector<double> levels{top, bottom};
    for (const double x : gauss.x) levels.push_back((top + bottom) / 2 + x * (bottom - top) / 2);
    return levels;
}

// The heating between two levels by Gauss quadrature over levels between: the field is smooth there.
TEST(LightInside, LosesWhatIsAbsorbedBetweenLevels) {
    const GaussLegendre gauss(20);
    const double top = 0.8, bottom = 1.3;
    const std::vector<double> levels = levels_between(top, bottom, gauss);
    for (const PhaseFunction& lower : {haze, parse_phase_function("henyey_greenstein:g=0.95")}) {
        const std::vector<StackLayer> layers{{air, 0.8, 0.5}, {lower, 0.7, 1.5}};
        const InsideSolution solution =
            solve_inside(layers, LowerBoundary::surface(0.2), levels, {0.3, 1}, with_nodes(24));
        for (int in = 0; in < 2; ++in) {
            double absorbed = 0;
            for (const auto k : indices(gauss.x))
                absorbed +=
                    gauss.weight[k] * solution.levels[k + 2].heating_rate(in) * (bottom - top) / 2;
            EXPECT_NEAR(net_flux(solution.levels[0], in) - net_flux(solution.levels[1], in),
                        absorbed, 1e-12);
        }
    }
}

// Deep in a semi-infinite isotropic layer without absorption light is uniform: 4 pi J / (mu0 F0) =
// sqrt(3) H(mu0). [C60] The H function by its own integral equation.
TEST(LightInside, IsUniformDeepInAConservativeLayer) {
    const std::vector<double> mu{0.2, 0.5, 1};
    const IsotropicSolution reference = solve_isotropic(1, infinity, mu);
    const InsideSolution solution = solve_inside({{PhaseFunction{}, 1, infinity}}, {}, {30}, mu);
    const LightAtLevel& deep = solution.levels[0];
    for (int i = 0; i < 3; ++i) {
        const double H =
            std::sqrt(8 * mu[static_cast<std::size_t>(i)] * reference.reflection(i, i));
        EXPECT_NEAR(deep.actinic_flux(i), std::sqrt(3.0) * H, 1e-7 * H);
        EXPECT_NEAR(deep.plane_albedo(i), deep.diffuse_transmittance(i) + deep.direct_flux(i),
                    1e-12);
        const double up = solution.values(Side::reflection, i, 0, {1.0})[0].total;
        EXPECT_NEAR(4 * up, deep.actinic_flux(i), 1e-6 * up);  // pi I, and 4 pi J
    }
    EXPECT_NEAR(deep.actinic_flux(2), std::sqrt(3.0) * 2.9078, 1e-4);  // H(1) as printed
}

// ---- The equation of transfer, in space and without Fourier series.

/// Directions on a grid of cosines, downward ones first, and azimuths.
struct Sphere {
    std::vector<double> mu, azimuth, weight;  // weights of solid angle; sum 4 pi
    int cosines, azimuths;

    Sphere(int cosine_count, int azimuth_count) : cosines(cosine_count), azimuths(azimuth_count) {
        const GaussLegendre gauss(static_cast<std::size_t>(cosines));
        for (const double sign : {1.0, -1.0})
            for (int i = 0; i < cosines; ++i)
                for (int a = 0; a < azimuths; ++a) {
                    const double x = (1 + gauss.x[static_cast<std::size_t>(i)]) / 2;
                    mu.push_back(sign * x * x);  // dense at grazing angles
                    azimuth.push_back(2 * pi * a / azimuths);
                    weight.push_back(gauss.weight[static_cast<std::size_t>(i)] * x * 2 * pi /
                                     azimuths);
                }
    }
    std::size_t size() const { return mu.size(); }
    double cos_angle(std::size_t i, double other_mu, double other_azimuth) const {
        return mu[i] * other_mu + std::sqrt((1 - mu[i] * mu[i]) * (1 - other_mu * other_mu)) *
                                      std::cos(azimuth[i] - other_azimuth);
    }
};

// Along a ray from the top of a layer to its bottom, or up, pi I is what enters, attenuated, and the
// light that the layer scatters into the ray: that of all directions, and of the beam, mu0 F0 = 1.
TEST(LightInside, SolvesTheEquationOfTransfer) {
    const std::vector<StackLayer> layers{
        {air, 0.9, 0.3}, {parse_phase_function("henyey_greenstein:g=0.4"), 0.7, 0.5}};
    const double mu0 = 0.6, ground = 0.4;
    const Sphere sphere(14, 16);
    std::vector<double> mu{mu0};
    for (int i = 0; i < sphere.cosines; ++i)
        mu.push_back(sphere.mu[static_cast<std::size_t>(i * sphere.azimuths)]);
    const std::vector<double> azimuths(sphere.azimuth.begin(), sphere.azimuth.begin() + 16);
    const GaussLegendre gauss(12);
    double top = 0;
    for (const StackLayer& layer : layers) {
        const double bottom = top + layer.optical_depth;
        const std::vector<double> levels = levels_between(top, bottom, gauss);
        const InsideSolution solution =
            solve_inside(layers, LowerBoundary::surface(ground), levels, mu);
        std::vector<std::vector<double>> light(levels.size());  // [level][direction]: pi I
        for (const auto l : indices(levels)) {
            double up = 0, down = 0, actinic = std::exp(-levels[l] / mu0) / mu0;
            for (const Side side : {Side::transmission, Side::reflection})
                for (int c = 0; c < sphere.cosines; ++c)
                    for (const SolvedValue& value : solution.values(side, 0, 1 + c, azimuths, l)) {
                        const std::size_t i = light[l].size();
                        light[l].push_back(value.total);
                        const double share = value.total / pi * sphere.weight[i];
                        (side == Side::transmission ? down : up) += share * std::abs(sphere.mu[i]);
                        actinic += share;
                    }
            EXPECT_NEAR(solution.levels[l].plane_albedo(0), up, 2e-5);
            EXPECT_NEAR(solution.levels[l].diffuse_transmittance(0), down, 2e-5);
            EXPECT_NEAR(solution.levels[l].actinic_flux(0), actinic, 2e-4 * actinic);
        }
        const auto scattered = [&](std::size_t l, std::size_t into) {
            double sum = layer.phase_function(sphere.cos_angle(into, mu0, 0)) *
                         std::exp(-levels[l] / mu0) / mu0 / 4;
            for (const auto i : indices(sphere))
                sum +=
                    sphere.weight[i] / (4 * pi) * light[l][i] *
                    layer.phase_function(sphere.cos_angle(into, sphere.mu[i], sphere.azimuth[i]));
            return layer.albedo * sum;
        };
        for (std::size_t i = 0; i < sphere.size(); i += 3) {
            const double cosine = std::abs(sphere.mu[i]);
            if (cosine < 0.05) continue;  // attenuated too steeply for twelve levels
            const bool is_down = sphere.mu[i] > 0;
            double expected = light[is_down ? 0 : 1][i] * std::exp((top - bottom) / cosine);
            for (const auto k : indices(gauss.x)) {
                const double level = levels[k + 2];
                expected += gauss.weight[k] * (bottom - top) / 2 / cosine *
                            std::exp((is_down ? level - bottom : top - level) / cosine) *
                            scattered(k + 2, i);
            }
            EXPECT_NEAR(light[is_down ? 1 : 0][i], expected, 1e-4 * expected)
                << top << ' ' << sphere.mu[i] << ' ' << sphere.azimuth[i];
        }
        top = bottom;
        if (&layer == &layers.back()) {
            const LightAtLevel& at = solution.levels[1];
            EXPECT_NEAR(light[1].back(), ground * (at.direct_flux(0) + at.diffuse_transmittance(0)),
                        1e-12);
        }
    }
}

TEST(LightInside, MeetsItsTolerance) {
    const std::vector<StackLayer> layers{
        {parse_phase_function("henyey_greenstein:g=0.8"), 0.99, 4}};
    SolverOptions options;
    options.tolerance = 1e-5;
    const SolvedInside loose = solve_fluxes_inside(layers, {}, {0, 1, 4}, {0.3, 1}, options);
    EXPECT_LE(loose.relative_error, 1e-5);
    const InsideSolution fine = solve_inside(layers, {}, {0, 1, 4}, {0.3, 1}, with_nodes(72));
    for (std::size_t l = 0; l < 3; ++l)
        for (int in = 0; in < 2; ++in) {
            const FluxesAtLevel& found = loose.levels[l];
            const LightAtLevel& exact = fine.levels[l];
            const auto i = static_cast<std::size_t>(in);
            EXPECT_NEAR(found.upward[i], exact.plane_albedo(in), 2 * loose.error);
            EXPECT_NEAR(found.diffuse[i], exact.diffuse_transmittance(in), 2 * loose.error);
            EXPECT_NEAR(found.actinic[i], exact.actinic_flux(in), 2 * loose.error);
        }
    const SolvedGeometries radiance =
        solve_geometries_inside(layers, {}, 1, {{0.3, 0.7, 1}, {1, 0.5, 0}}, options);
    const InsideSolution at_one = solve_inside(layers, {}, {1}, {0.3, 0.7, 0.5, 1}, with_nodes(72));
    const double up = at_one.values(Side::reflection, 0, 1, {1})[0].total;
    const double down = at_one.values(Side::transmission, 3, 2, {0})[0].total;
    EXPECT_NEAR(radiance.at[0].reflection.total, up, 1e-5 * up);
    EXPECT_NEAR(radiance.at[1].transmission.total, down, 1e-5 * down);
}

TEST(LightInside, OfNothingIsTheBeam) {
    const InsideSolution empty = solve_inside({{air, 0.5, 0}}, {}, {0}, {0.5});
    EXPECT_EQ(empty.levels[0].direct_flux(0), 1);
    EXPECT_EQ(empty.levels[0].plane_albedo(0), 0);
    EXPECT_NEAR(empty.levels[0].actinic_flux(0), 2, 1e-15);
    const InsideSolution black = solve_inside({{air, 0, 2}}, {}, {1}, {0.5});
    EXPECT_NEAR(black.levels[0].direct_flux(0), std::exp(-2), 1e-15);
    EXPECT_NEAR(black.levels[0].diffuse_transmittance(0), 0, 1e-15);
    EXPECT_NEAR(black.levels[0].heating_rate(0), 2 * std::exp(-2), 1e-15);
}

/// 0.7 + 0.1 < 0.8 in floating point.
TEST(LightInside, IsTakenToTheWholeDepthInSpiteOfRounding) {
    const InsideSolution inside =
        solve_inside({{air, 0.5, 0.7}, {air, 0.5, 0.1}}, {}, {0.8}, {0.5});
    EXPECT_NEAR(inside.levels[0].direct_flux(0), std::exp(-1.6), 1e-15);
}

TEST(LightInside, IsRefusedOutsideTheLayers) {
    const auto refused = [](std::vector<double> levels, const SolverOptions& options,
                            Fragments fragments) {
        expect_refusal([&] { solve_inside(air_over_haze(1, 1), {}, levels, {1}, options); },
                       fragments);
    };
    refused({0.5, 2.5}, {}, "solve: levels must be in [0, 2], the optical depth, got 2.5");
    refused({-0.5}, {}, "levels must be in [0, 2], the optical depth, got -0.5");
    refused({}, {}, "levels must be one or more, got none");
    refused({1}, {.orders = 3}, "orders must be 0, all, got 3");
    expect_refusal(
        [&] {
            solve_inside({{air, 1, infinity}}, {}, {infinity}, {1});
        },
        "[0, inf), got inf");
}

}  // namespace
}  // namespace stratus
