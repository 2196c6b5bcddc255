#include <stratus/base/constants.h>
#include <stratus/layer/effects.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace stratus {
namespace {

struct Path {
    double mu_in, mu_out, azimuth;  // 0: both on one side, so that a is least

    double cos_phase_angle() const {
        return mu_in * mu_out +
               std::sqrt((1 - mu_in * mu_in) * (1 - mu_out * mu_out)) * std::cos(azimuth);
    }
    double phase_angle() const { return std::acos(std::min(1.0, cos_phase_angle())); }
};

double factor(double density, double optical_depth, const Path& at) {
    return opposition_factor(Opposition::blinn(density), -at.cos_phase_angle(), optical_depth,
                             at.mu_in, at.mu_out);
}

/// Where the layer's boundary cuts the cylinders.
enum class Boundary { across_the_bisector, horizontal };

/// The law by brute force: small cubes counted where they lie in both cylinders, of radius 1, by the
/// depth of the particle from which on they do; then trapezoids over depth.
double counted_factor(double density, double optical_depth, const Path& at, Boundary boundary) {
    const double half = at.phase_angle() / 2, cos_half = std::cos(half), sin_half = std::sin(half);
    const double s = 1 / at.mu_in + 1 / at.mu_out;
    const double radius = 0.75 * density;  // over mean free path: depth t = radius * z
    const double deepest = std::min(optical_depth, 20 / s) / radius;
    // Along the bisector, across it in the plane of both axes, and along that plane's normal.
    const double mu_bisector = (at.mu_in + at.mu_out) / (2 * cos_half);
    const double mu_across = (at.mu_in - at.mu_out) / (2 * sin_half);
    const double mu_normal =
        std::sqrt(std::max(0.0, 1 - mu_bisector * mu_bisector - mu_across * mu_across));
    constexpr int normals = 80, acrosses = 160, depths = 4000;
    constexpr int alongs = 1000;
    const double reach = std::min(1 / sin_half, deepest / mu_bisector + 3), width = 1 / cos_half;
    const double cube = 4 * width * reach / (normals * acrosses * double{alongs});
    std::vector<double> volume(depths + 1, 0.0);
    for (int i = 0; i < normals; ++i)
        for (int j = 0; j < acrosses; ++j)
            for (int k = 0; k < alongs; ++k) {
                const double normal = 2 * (i + 0.5) / normals - 1,
                             across = width * (2 * (j + 0.5) / acrosses - 1),
                             along = reach * (k + 0.5) / alongs;
                bool inside = true;
                for (const double side : {-1.0, 1.0}) {
                    const double axial = along * cos_half + side * across * sin_half,
                                 aside = along * sin_half - side * across * cos_half;
                    inside = inside && axial > 0 && aside * aside + normal * normal < 1;
                }
                if (!inside) continue;
                double z = along * mu_bisector;
                if (boundary == Boundary::horizontal)
                    z = std::max(0.0, z + across * mu_across + normal * mu_normal);
                const double place = std::ceil(z / deepest * depths);
                if (place <= depths) volume[static_cast<std::size_t>(place)] += cube;
            }
    double with = 0, without = 0, overlap = 0;
    const double step = deepest * radius / depths;
    for (std::size_t i = 0; i <= depths; ++i) {
        overlap += volume[i];
        const double t = static_cast<double>(i) * step;
        const double weight = (i == 0 || i == depths ? 0.5 : 1) * std::exp(-s * t);
        with += weight * std::exp(radius / pi * overlap);
        without += weight;
    }
    return with / without;
}

constexpr double degree = pi / 180;

TEST(BlinnOpposition, IsTheProbabilityThatTheUnionOfBothWaysIsFree) {
    const double c = std::cos(4 * degree);
    for (const Path& at : {Path{1, std::cos(8 * degree), 0}, Path{c, c, pi}, Path{0.5, 0.5, 0.3},
                           Path{0.2, 0.7, 0.5}, Path{0.3, 0.25, 0.05}, Path{0.9, 0.6, 2}})
        for (const double density : {0.03, 0.1, 0.3})
            for (const double optical_depth : {0.3, 8.0})
                EXPECT_NEAR(
                    factor(density, optical_depth, at),
                    counted_factor(density, optical_depth, at, Boundary::across_the_bisector), 1e-3)
                    << at.mu_in << ' ' << at.mu_out << ' ' << density << ' ' << optical_depth;
}

TEST(BlinnOpposition, HardlyDependsOnHowTheBoundaryCutsTheCylinders) {
    for (const Path& at : {Path{1, std::cos(8 * degree), 0}, Path{0.8, 0.75, 0.1},
                           Path{0.5, 0.5, 0.16}, Path{0.6, 0.9, 1}})
        EXPECT_NEAR(factor(0.1, 8, at), counted_factor(0.1, 8, at, Boundary::horizontal), 2e-3)
            << at.mu_in << ' ' << at.mu_out;
}

TEST(BlinnOpposition, AttenuatesOnceTheLightThatLeavesByTheWayItCame) {
    const Opposition opposition = Opposition::blinn(0.1);
    for (const double tau : {1e-6, 0.1, 1.0, 30.0})
        for (const double mu : {1e-3, 0.05, 0.5, 1.0}) {
            // [Blinn82] 5.2: (1 - e) / (0.5 (1 - e^2)), e = exp(-tau / mu)
            const double once = -std::expm1(-tau / mu), twice = -0.5 * std::expm1(-2 * tau / mu);
            EXPECT_NEAR(opposition_factor(opposition, -1, tau, mu, mu), once / twice, 1e-9);
            EXPECT_NEAR(OppositionTable(opposition).factor(-1, tau, mu, mu), once / twice, 1e-6);
        }
    EXPECT_NEAR(opposition_factor(opposition, -1, infinity, 0.3, 0.3), 2, 1e-9);
    EXPECT_EQ(opposition_factor(opposition, -1, 0, 0.3, 0.3), 1);
}

TEST(BlinnOpposition, EndsAtPhaseAnglePi) {
    for (const double tau : {1e-3, 1.0, infinity}) {
        EXPECT_EQ(opposition_factor(Opposition::blinn(0.3), 1, tau, 1e-3, 1e-3), 1);
        EXPECT_EQ(OppositionTable(Opposition::blinn(0.3)).factor(1, tau, 1e-3, 1e-3), 1);
    }
}

TEST(BlinnOpposition, VanishesWithTheDensityAwayFromOpposition) {
    const Path at{0.5, 0.5, 0.02};
    EXPECT_NEAR(factor(1e-9, infinity, at), 1, 1e-6);
    EXPECT_NEAR(OppositionTable(Opposition::blinn(1e-9))
                    .factor(-at.cos_phase_angle(), infinity, at.mu_in, at.mu_out),
                1, 1e-6);
    EXPECT_LT(factor(0.01, 10, at), factor(0.1, 10, at));
    EXPECT_LT(factor(0.1, 10, at), factor(0.5, 10, at));
}

TEST(BlinnOpposition, DeepInTheLayerIsTheWholeOverlap) {
    // exp((4 / (3 pi)) R cot(a/2)) where that is reached within a small share of the free path.
    const Path at{1, 0.5, 0};
    const double whole = std::exp(4 / (3 * pi) * 0.75 * 1e-4 / std::tan(at.phase_angle() / 2));
    EXPECT_NEAR((factor(1e-4, infinity, at) - 1) / (whole - 1), 1, 1e-3);
}

/// Narrow and wide angles, grazing and steep light.
Path random_path(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double mu =
        uniform(random) < 0.7 ? 1 - uniform(random) : std::pow(10, -3 * uniform(random));
    const double other = uniform(random) < 0.5
                             ? 1 - uniform(random)
                             : std::min(1.0, mu * std::exp(0.3 * (uniform(random) - 0.5)));
    const double narrow = uniform(random) < 0.6 ? 0.2 * uniform(random) * uniform(random) : 1;
    return {mu, other, pi * uniform(random) * narrow};
}

double largest_error_of_table(const Opposition& opposition) {
    const OppositionTable table(opposition);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    double largest = 0;
    for (int i = 0; i < 20000; ++i) {
        const Path at = random_path(random);
        const double tau = uniform(random) < 0.2 ? infinity : std::pow(10, 5 * uniform(random) - 3);
        const double c = -at.cos_phase_angle();
        largest =
            std::max(largest, std::abs(table.factor(c, tau, at.mu_in, at.mu_out) -
                                       opposition_factor(opposition, c, tau, at.mu_in, at.mu_out)));
    }
    return largest;
}

TEST(OppositionTable, HoldsBlinnsLaw) {
    for (const double density : {1e-6, 1e-3, 0.03, 0.1, 0.3, 0.5})
        for (const double seen_in : {0.0, density})
            EXPECT_LT(largest_error_of_table(seen_opposition(Opposition::blinn(density), seen_in)),
                      1e-3)
                << density;
    EXPECT_LT(largest_error_of_table(seen_opposition(Opposition::blinn(0.9), 0.9)), 2e-3);
}

TEST(OppositionTable, GivesAnyLaw) {
    const Opposition hapke = Opposition::hapke(0.7, 0.05);
    EXPECT_EQ(OppositionTable(hapke).factor(-0.99, 1, 0.4, 0.6),
              opposition_factor(hapke, -0.99, 1, 0.4, 0.6));
    EXPECT_EQ(OppositionTable().factor(-1, 1, 0.5, 0.5), 1);
}

TEST(OppositionTable, IsFiniteEverywhere) {
    for (const double density : {1e-15, 0.1, 1 - 1e-9}) {
        const Opposition opposition = Opposition::blinn(density);
        const OppositionTable table(opposition);
        for (const double mu : {1e-12, 0.3, 1.0})
            for (const double other : {1e-12, 0.3, 1.0})
                for (const double tau : {0.0, 1e-30, 1.0, infinity})
                    for (const double c : {-1.0, -1 + 1e-15, 0.0, 1.0}) {
                        const double exact = opposition_factor(opposition, c, tau, mu, other);
                        EXPECT_TRUE(exact >= 1 && exact <= 2 + 1e-9) << exact;
                        const double held = table.factor(c, tau, mu, other);
                        EXPECT_TRUE(held >= 1 && held <= 2 + 1e-3) << held;
                    }
    }
}

TEST(HapkeOpposition, IsOneOverOnePlusTanOfHalfThePhaseAngleOverItsWidth) {
    const Opposition opposition = Opposition::hapke(0.7, 0.05);
    for (const double a : {0.0, 0.01, 0.1, 1.0, 3.0})
        EXPECT_NEAR(opposition_factor(opposition, -std::cos(a), 1, 0.4, 0.6),
                    1 + 0.7 / (1 + std::tan(a / 2) / 0.05), 1e-12);
    EXPECT_EQ(opposition_factor(opposition, 1, 1, 0.4, 0.6), 1);  // straight on: a = pi
}

TEST(Opposition, HasNoEffectWhenOff) { EXPECT_EQ(opposition_factor({}, -1, 1, 0.5, 0.5), 1); }

TEST(Opposition, IsAsWideAsParticlesAreLargeBesideTheirFreePath) {
    EXPECT_EQ(Opposition::radius_in_free_paths(0.1), 0.75 * 0.1);
    // Hapke's h is half of that for few particles.
    EXPECT_NEAR(Opposition::width_of_density(1e-6), 0.375e-6, 1e-12);
    EXPECT_NEAR(Opposition::width_of_density(0.5), 0.375 * std::log(2.0), 1e-15);
}

TEST(Opposition, IsSeenInALayerOfItsDensity) {
    const Opposition blinn = seen_opposition(Opposition::blinn(), 0.2);
    EXPECT_DOUBLE_EQ(blinn.width, 0.75 * 0.2 / 0.8);  // of n / (1 - D)
    EXPECT_DOUBLE_EQ(seen_opposition(Opposition::blinn(0.1), 0.2).width, 0.75 * 0.1 / 0.8);
    EXPECT_EQ(seen_opposition(Opposition::blinn(0.1), 0).width, 0.75 * 0.1);
    const Opposition hapke = seen_opposition(Opposition::hapke(0.8), 0.2);
    EXPECT_EQ(hapke.width, Opposition::width_of_density(0.2));
    EXPECT_EQ(hapke.amplitude, 0.8);
    EXPECT_EQ(seen_opposition(Opposition::hapke(0.8, 0.05), 0.2).width, 0.05);
}

TEST(Opposition, RefusesNumbersOutOfRange) {
    expect_refusal([] { Opposition::blinn(0); }, "density must be in (0, 1), got 0");
    expect_refusal([] { Opposition::blinn(1); }, "density must be in (0, 1), got 1");
    expect_refusal([] { Opposition::hapke(1.5); }, "amplitude must be in [0, 1], got 1.5");
    expect_refusal([] { Opposition::hapke(1, 0); }, "width must be in (0, inf), got 0");
    expect_refusal([] { seen_opposition(Opposition::blinn(), 0); },
                   "density must be in (0, 1), got 0");
    expect_refusal([] { OppositionTable{Opposition::blinn()}; }, "opposition.width");
}

TEST(Density, DividesTheDepthByTheFreeVolume) {
    EXPECT_EQ(effective_optical_depth(2, 0), 2);
    EXPECT_DOUBLE_EQ(effective_optical_depth(2, 0.2), 2.5);
    EXPECT_EQ(effective_optical_depth(infinity, 0.5), infinity);
    EXPECT_EQ(effective_optical_depth(0, 0.5), 0);
}

TEST(Density, IsTheShareOfTheVolumeThatParticlesFill) {
    EXPECT_NEAR(volume_fraction(0.1, 0.5), 0.1 * 4 / 3 * pi * 0.125, 1e-15);
    EXPECT_NEAR(volume_fraction(1e8, 0.5e-3), volume_fraction(0.1, 0.5), 1e-15);  // per m^3 and m
    EXPECT_EQ(volume_fraction(0, 2), 0);
    expect_refusal([] { volume_fraction(-1, 1); }, "number_density must be in [0, inf), got -1");
    expect_refusal([] { volume_fraction(1, 0); }, "radius must be in (0, inf), got 0");
    expect_refusal([] { volume_fraction(1, 1); },
                   "number_density * (4/3) pi radius^3 must be in [0, 1), got 4.1887902047863905");
}

TEST(Effects, RefuseNumbersOutOfRange) {
    Effects effects;
    effects.density = 1;
    expect_refusal([&] { check_effects(effects); }, "density must be in [0, 1), got 1");
    effects.density = NAN;
    expect_refusal([&] { check_effects(effects); }, "density must be in [0, 1), got nan");
    effects = {};
    effects.opposition.law = Opposition::Law::hapke;
    expect_refusal([&] { check_effects(effects); },
                   "opposition.width must be in (0, inf), or 0 with a density above 0, got 0");
    effects.opposition = Opposition::hapke(1, 0.1);
    effects.single = false;
    expect_refusal([&] { check_effects(effects); }, "opposition must be none without single");
}

}  // namespace
}  // namespace stratus
