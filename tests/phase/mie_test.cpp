// Mie scattering against published digits, closed limits and a second way to each number.
#include <stratus/phase/phase_function.h>

#include <stratus/base/constants.h>
#include <stratus/base/instruction_set.h>
#include <stratus/base/number_text.h>

#include "phase/mie_scattering.h"

#include "csv_rows.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace stratus {
namespace {

using Complex = std::complex<double>;

const char* const cloud_text = "mie:radius=10um,variance=0.1,wavelength=0.55um,material=water";

// ---- One sphere

struct Published {
    const char* name;
    Complex m;
    double x, scattering, digit, asymmetry;  // efficiency to `digit`, g to 1e-6; NaN: not printed
};

class PublishedSphere : public testing::TestWithParam<Published> {};

TEST_P(PublishedSphere, HasItsEfficiencyAndAsymmetry) {
    const Published& row = GetParam();
    const CrossSections sphere = cross_sections(row.x, row.m);
    EXPECT_NEAR(sphere.scattering / sphere.area, row.scattering, row.digit);
    if (!std::isnan(row.asymmetry)) {
        EXPECT_NEAR(sphere.asymmetry(), row.asymmetry, 1e-6);
    }
}

// W. J. Wiscombe, Mie scattering calculations, NCAR/TN-140+STR (1979), test cases of MIEV0; those of
// index 1.5 from Appl. Opt. 19, 1505 (1980).
INSTANTIATE_TEST_SUITE_P(
    Wiscombe, PublishedSphere,
    testing::ValuesIn<Published>({{"LightSmaller", {0.75, 0}, 0.099, 7e-6, 1e-6, 0.001448},
                                  {"LightSmall", {0.75, 0}, 0.101, 8e-6, 1e-6, 0.001507},
                                  {"Light", {0.75, 0}, 10, 2.232265, 1e-6, 0.896473},
                                  {"LightLarge", {0.75, 0}, 1000, 1.997908, 1e-6, 0.844944},
                                  {"Water", {1.33, 1e-5}, 1, 0.093923, 1e-6, 0.184517},
                                  {"WaterLarge", {1.33, 1e-5}, 100, 2.096594, 1e-6, 0.868959},
                                  {"WaterHuge", {1.33, 1e-5}, 10000, 1.723857, 1e-6, 0.907840},
                                  {"DarkSmall", {1.5, 1}, 0.055, 1.1e-5, 1e-6, 0.000491},
                                  {"Dark", {1.5, 1}, 1, 0.6634538, 1e-6, 0.192136},
                                  {"DarkLarge", {1.5, 1}, 100, 1.283697, 1e-6, 0.850252},
                                  {"DarkHuge", {1.5, 1}, 10000, 1.236575, 1e-6, 0.846310},
                                  {"Metal", {10, 10}, 1, 2.049405, 1e-6, -0.110664},
                                  {"MetalLarge", {10, 10}, 100, 1.836785, 1e-6, 0.556215},
                                  {"MetalHuge", {10, 10}, 10000, 1.795393, 1e-6, 0.548194},
                                  {"Glass", {1.5, 0}, 10, 2.8820, 1e-4, NAN},
                                  {"GlassLarge", {1.5, 0}, 100, 2.0944, 1e-4, NAN},
                                  {"GlassLarger", {1.5, 0}, 1000, 2.0139, 1e-4, NAN},
                                  {"GlassHuge", {1.5, 0}, 5000, 2.0086, 1e-4, NAN}}),
    row_name);

TEST(MieAmplitudes, ArePublishedOnesAtThirtyDegreeSteps) {
    // The same, case 14: x = 1, m = 1.5 + i; our amplitudes for exp(-i omega t) are the conjugates.
    const Complex S1[] = {{0.584080, 0.190515}, {0.565702, 0.187200}, {0.517525, 0.178443},
                          {0.456340, 0.167167}, {0.400212, 0.156643}, {0.362157, 0.149391},
                          {0.348844, 0.146829}};
    const Complex S2[] = {{0.584080, 0.190515},    {0.500161, 0.145611},   {0.287964, 0.041054},
                          {0.0362285, -0.0618265}, {-0.174875, -0.122959}, {-0.305682, -0.143846},
                          {-0.348844, -0.146829}};
    for (int i = 0; i <= 6; ++i) {
        const MieAmplitudes S = mie_amplitudes(1, {1.5, 1}, std::cos(pi * i / 6));
        EXPECT_LT(std::abs(std::conj(S.S1) - S1[i]), 1e-6) << 30 * i << " degrees";
        EXPECT_LT(std::abs(std::conj(S.S2) - S2[i]), 1e-6) << 30 * i << " degrees";
    }
}

TEST(MieAmplitudes, ArePublishedOnesStraightBack) {
    // The same, cases 8, 10 and 11.
    const auto back = [](double x, Complex m) { return std::conj(mie_amplitudes(x, m, -1).S1); };
    EXPECT_LT(std::abs(back(1000, 0.75) - Complex(17.05778, 484.2510)), 2e-4);
    EXPECT_LT(std::abs(back(100, {1.33, 1e-5}) - Complex(-56.59205, 46.50974)), 2e-5);
    EXPECT_LT(std::abs(back(10000, {1.33, 1e-5}) - Complex(-182.116215, -951.909674)), 1e-3);
}

TEST(MieAmplitudes, HaveTheSameBitsOnEveryProcessor) {
    const auto value = [] {
        const PhaseFunction phi = parse_phase_function("mie:radius=2um,variance=0.1");
        return phi.moments(100);
    };
    const std::vector<double> widest = value();
    for (const auto set : {InstructionSet::generic, InstructionSet::avx2}) {
        const InstructionSetLimit limit(set);
        EXPECT_EQ(value(), widest) << instruction_set_name(set);
    }
}

TEST(MieCoefficients, ScatterAllThatTheyTakeAtRealIndices) {
    for (const double m : {0.75, 1.1, 1.333, 2.5})
        for (const double x : {1e-3, 0.1, 3.0, 114.2, 2000.0, 10000.0}) {
            const CrossSections sphere = cross_sections(x, m);
            EXPECT_NEAR(sphere.scattering / sphere.extinction, 1, 1e-11) << m << ' ' << x;
        }
}

TEST(MieCoefficients, ObeyTheOpticalTheorem) {
    for (const double x : {0.5, 20.0, 700.0}) {  // extinction = 4 pi Re S(0)
        const Complex m(1.4, 0.02);
        EXPECT_NEAR(4 * pi * mie_amplitudes(x, m, 1).S1.real() / cross_sections(x, m).extinction, 1,
                    1e-12);
    }
}

TEST(MieCoefficients, BecomeRayleighsForSmallSpheres) {
    for (const Complex m : {Complex(1.33, 0), Complex(1.5, 0.1), Complex(0.8, 2)})
        for (const double x : {1e-4, 1e-3, 1e-2}) {
            const Complex polarisability = (m * m - 1.0) / (m * m + 2.0);
            const CrossSections sphere = cross_sections(x, m);
            const double scattering = 8.0 / 3 * std::pow(x, 4) * std::norm(polarisability);
            const double absorption = 4 * x * polarisability.imag();
            // corrections go as x^2
            EXPECT_NEAR(sphere.scattering / sphere.area / scattering, 1, 5 * x * x);
            if (m.imag() > 0) {
                EXPECT_NEAR((sphere.extinction - sphere.scattering) / sphere.area / absorption, 1,
                            10 * x * x);
            }
        }
    const PhaseFunction phi = parse_phase_function("mie:radius=1e-4um");
    for (const double c : {-1.0, -0.3, 0.5, 1.0}) EXPECT_NEAR(phi(c), 0.75 * (1 + c * c), 1e-5);
}

// ---- Many spheres

TEST(SphereScattering, HasTheMomentsOfItsCrossSections) {
    const SphereScattering spheres =
        sphere_scattering({{3, 1}, {20, 0.5}, {21.5, 0.25}, {80, 0.1}, {400, 0.01}}, {1.35, 1e-3});
    EXPECT_EQ(spheres.moments[0], 1);
    EXPECT_NEAR(spheres.moments[1], spheres.total.asymmetry(), 1e-12);
}

class SumOfSpheres : public testing::TestWithParam<std::vector<SphereSize>> {};

TEST_P(SumOfSpheres, IsWhatTheyScatterAlone) {
    const Complex m(1.35, 1e-3);
    const std::vector<SphereSize>& sizes = GetParam();
    const PhaseFunction phi = PhaseFunction::from_moments(sphere_scattering(sizes, m).moments);
    double scattering = 0;
    for (const SphereSize& size : sizes)
        scattering += size.number * cross_sections(size.x, m).scattering;
    for (const double degrees : {0.0, 1.0, 30.0, 90.0, 142.0, 180.0}) {
        const double c = std::cos(radians(degrees));
        double intensity = 0;  // phi = 4 pi (|S1|^2 + |S2|^2) / (2 scattering)
        for (const SphereSize& size : sizes) {
            const MieAmplitudes S = mie_amplitudes(size.x, m, c);
            intensity += size.number * (std::norm(S.S1) + std::norm(S.S2));
        }
        EXPECT_NEAR(phi(c) / (2 * pi * intensity / scattering), 1, 1e-10) << degrees;
    }
}

/// More spheres than their series have terms.
std::vector<SphereSize> many_sizes() {
    std::vector<SphereSize> sizes;
    for (int i = 0; i < 101; ++i) sizes.push_back({0.3 + (37 * i % 101) * 0.4, 1 / (1.0 + i)});
    return sizes;
}

// They are summed in two ways.
INSTANTIATE_TEST_SUITE_P(
    SphereScattering, SumOfSpheres,
    testing::Values(std::vector<SphereSize>{{3, 1}, {20, 0.5}, {21.5, 0.25}, {60, 0.1}, {8, 0.01}},
                    many_sizes()),
    [](const auto& row) { return row.index == 0 ? "Few" : "Many"; });

// ---- Distributions

TEST(SizesOf, AreDenseEnough) {
    // phi of all sizes there are, as far as four times as many tell; the bounds are those that
    // mie.h states.
    const PhaseFunction phi = parse_phase_function(cloud_text);
    const Droplets droplets = std::get<Mie>(phi.terms()[0].second).droplets;
    const PhaseFunction finer = PhaseFunction::from_moments(
        sphere_scattering(sphere_sizes(droplets, 4 * sizes_of_a_distribution),
                          index_of_refraction(droplets))
            .moments);
    double worst = 0, squares = 0;
    const int angles = 720;
    for (int i = 0; i <= angles; ++i) {
        const double c = std::cos(pi * i / angles), off = phi(c) / finer(c) - 1;
        worst = std::max(worst, std::abs(off));
        squares += off * off;
    }
    EXPECT_LT(worst, 0.025);
    EXPECT_LT(std::sqrt(squares / (angles + 1)), 0.005);
    EXPECT_NEAR(phi.asymmetry(), finer.asymmetry(), 2e-4);
}

/// Resonances fall between the sizes of one radius and upon those of the next unless these are the same.
TEST(SizesOf, ChangeThePhaseFunctionSmoothlyWithTheRadius) {
    const auto back = [](double radius) {
        return parse_phase_function("mie:radius=" + shortest_text(radius) +
                                    "um,variance=0.1,wavelength=0.45um,index=1.3438")(-1);
    };
    const double first = back(14.25);
    for (const double radius : {14.255, 14.265, 14.28, 14.3})
        EXPECT_NEAR(back(radius) / first, 1, 1e-3) << radius;
}

// ---- A cloud of 10 um

TEST(WaterCloud, HasIndependentlyComputedMoments) {
    // of the index of Hale and Querry (1973) at 0.55 um
    const std::vector<double> chi =
        parse_phase_function("mie:radius=10um,variance=0.1,index=1.333+1.96e-9i").moments(768);
    const std::vector<CsvRow> rows = csv_rows("water_cloud_10um_moments.csv");
    ASSERT_EQ(rows.size(), 768u);
    // both sample sizes, between which resonances lie: see SizesOf.AreDenseEnough; here all 768
    for (std::size_t l = 0; l < 768; ++l) EXPECT_NEAR(chi[l], rows[l].numbers.at(1), 3e-4) << l;
}

TEST(WaterCloud, HasTheKnownFeatures) {
    const PhaseFunction phi = parse_phase_function(cloud_text);
    const Mie& cloud = std::get<Mie>(phi.terms()[0].second);
    EXPECT_NEAR(phi.asymmetry(), 0.86, 0.005);
    EXPECT_NEAR(cloud.extinction_efficiency(), 2.09, 0.01);  // 2 and a little: x = 114
    EXPECT_GT(cloud.albedo(), 0.999995);
    EXPECT_LT(cloud.albedo(), 1);
    const auto at = [&](double degrees) { return phi(std::cos(radians(degrees))); };
    double bow = 125;  // the fogbow: the largest between 125 and 155 degrees
    for (double angle = 125; angle <= 155; angle += 0.25)
        if (at(angle) > at(bow)) bow = angle;
    EXPECT_NEAR(bow, 141, 3);
    EXPECT_GT(at(bow), 3 * at(120));
    EXPECT_GT(at(bow), 1.5 * at(158));
    EXPECT_GT(at(180), 2 * at(175));  // the glory
    EXPECT_GT(at(0), 3000);
}

TEST(Mie, HasTheValuesOfItsSeries) {
    for (const char* text : {cloud_text, "mie:radius=10um", "mie:radius=60um,index=1.5+0.01i"}) {
        const PhaseFunction phi = parse_phase_function(text);
        const PhaseFunction series = PhaseFunction::from_moments(phi.moments(3000));
        for (double degrees = 0; degrees < 2; degrees += 0.0137)
            EXPECT_NEAR(phi(std::cos(radians(degrees))) / series(1),
                        series(std::cos(radians(degrees))) / series(1), 1e-7)
                << text << ' ' << degrees;
        for (double degrees = 2; degrees <= 180; degrees += 0.711)
            EXPECT_NEAR(phi(std::cos(radians(degrees))) / series(std::cos(radians(degrees))), 1,
                        1e-5)
                << text << ' ' << degrees;
        EXPECT_NEAR(phi(1) / series(1), 1, 1e-9);
    }
}

TEST(Mie, IsNotANumberAtNotANumber) {
    const PhaseFunction cloud = parse_phase_function("mie:radius=1um,index=1.33");
    EXPECT_TRUE(std::isnan(std::get<Mie>(cloud.terms()[0].second)(NAN)));
}

TEST(Mie, IsTheSameWhetherComputedOrShared) {
    // Droplets that others live of are not computed again; what differs in anything is.
    const char* const text = "mie:radius=2um,variance=0.1";
    const std::vector<double> alone = parse_phase_function(text).moments(60);
    const PhaseFunction first = parse_phase_function(text), again = parse_phase_function(text);
    EXPECT_EQ(first.moments(60), alone);
    EXPECT_EQ(again.moments(60), alone);
    EXPECT_EQ(again.albedo(), first.albedo());
    for (const char* other :
         {"mie:radius=2.1um,variance=0.1", "mie:radius=2um,variance=0.11",
          "mie:radius=2um,variance=0.1,distribution=lognormal",
          "mie:radius=2um,variance=0.1,wavelength=0.56um",
          "mie:radius=2um,variance=0.1,material=ice", "mie:radius=2um,variance=0.1,index=1.34"})
        EXPECT_NE(parse_phase_function(other).moments(60), alone) << other;
}

TEST(Mie, AbsorbsNothingAtRealIndices) {
    EXPECT_EQ(*parse_phase_function("mie:radius=5um,variance=0.1,index=1.333").albedo(), 1);
}

TEST(SizesOf, AbsorbAsRaysDoWhereDropletsAreLarge) {
    // Rays in a large sphere of weak absorption: Q_abs = (8/3) k x (n^3 - (n^2 - 1)^(3/2)) / n
    const double n = 1.333, k = 1e-6;
    Droplets droplets;
    droplets.effective_radius = 100;
    droplets.effective_variance = 0.1;
    double absorption = 0, expected = 0;
    for (const SphereSize& size : sphere_sizes(droplets, 500)) {
        const CrossSections sphere = cross_sections(size.x, {n, k});
        absorption += size.number * (sphere.extinction - sphere.scattering);
        expected += size.number * sphere.area * 8.0 / 3 * k * size.x *
                    (n * n * n - std::pow(n * n - 1, 1.5)) / n;
    }
    EXPECT_NEAR(absorption / expected, 1, 0.1);  // edges and resonances add x^(-2/3) or so
}

TEST(PhaseFunction, HasAnAlbedoWhereAllTermsHave) {
    EXPECT_FALSE(parse_phase_function("rayleigh").albedo());
    const PhaseFunction dark = parse_phase_function("mie:radius=1um,index=1.5+0.1i");
    const PhaseFunction white = parse_phase_function("mie:radius=1um,index=1.5");
    EXPECT_FALSE(PhaseFunction::mixture(0.5, dark, PhaseFunction::rayleigh()).albedo());
    // half of what is scattered by either: cross-sections 1 / w and 1
    EXPECT_NEAR(*PhaseFunction::mixture(0.5, dark, white).albedo(), 2 / (1 / *dark.albedo() + 1),
                1e-15);
}

TEST(IndexOfIce, IsThePublishedRowAndBetweenRows) {
    Droplets droplets;
    droplets.material = Droplets::Material::ice;
    EXPECT_EQ(index_of_refraction(droplets), Complex(1.3110, 2.289e-9));
    droplets.wavelength = 0.555;
    EXPECT_NEAR(index_of_refraction(droplets).real(), 1.3108, 1e-5);
    EXPECT_NEAR(index_of_refraction(droplets).imag(), std::sqrt(2.289e-9 * 2.839e-9), 2e-12);
}

TEST(Mie, HasAText) {
    EXPECT_EQ(parse_phase_function("mie:radius=10um,variance=0.1").text(),
              "mie:radius=10um,variance=0.1,distribution=gamma,wavelength=0.55um,material=water");
    EXPECT_EQ(parse_phase_function("mie:radius=800nm,index=1.5+0.01i").text(),
              "mie:radius=0.8um,variance=0,wavelength=0.55um,index=1.5+0.01i");
    EXPECT_EQ(parse_phase_function("0.5*mie:radius=1um,index=1.33+0.5*isotropic").terms().size(),
              2u);
    EXPECT_EQ(parse_phase_function("mie:radius=0.2um").caption(), "Mie water 0.2 um at 0.55 um");
}

}  // namespace
}  // namespace stratus
