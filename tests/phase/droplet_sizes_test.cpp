// Distributions of droplets by their own parameters or by rows: closed forms, and published light.
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>

#include "csv_rows.h"
#include "all_near.h"
#include "phase/mie_scattering.h"
#include "refusal.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace stratus {
namespace {

const char* const cloud_c1 =
    "mie:distribution=modified_gamma,mode_radius=4um,alpha=6,gamma=1,wavelength=0.7um,index=1.33";
const char* const haze_l =
    "mie:distribution=modified_gamma,mode_radius=0.07um,alpha=2,gamma=0.5,wavelength=0.7um,"
    "index=1.33";

Droplets droplets_of(const PhaseFunction& phi) {
    return std::get<Mie>(phi.terms()[0].second).droplets;
}

/// Effective radius (um) and variance of the spheres that stand for droplets [HT74] 2.53, 2.54.
EffectiveSize summed_size(const Droplets& droplets) {
    double area = 0, volume = 0, spread = 0;
    const std::vector<SphereSize> sizes = sphere_sizes(droplets);
    for (const SphereSize& size : sizes) {
        area += size.number * size.x * size.x;
        volume += size.number * size.x * size.x * size.x;
    }
    const double x = volume / area;
    for (const SphereSize& size : sizes) spread += size.number * std::pow((size.x - x) * size.x, 2);
    return {x * droplets.wavelength / (2 * pi), spread / (area * x * x)};
}

// ---- Modified gamma

TEST(ModifiedGamma, HasTheEffectiveSizeOfItsGammaIntegrals) {
    // The integral of r^(alpha + p) exp(-b r^gamma) is Gamma((alpha + p + 1) / gamma) but for powers
    // of b. gamma = 1: radius (alpha + 3) / b, variance 1 / (alpha + 3); here b = 6 / 4.
    const EffectiveSize cloud = effective_size(droplets_of(parse_phase_function(cloud_c1)));
    EXPECT_NEAR(cloud.radius, 6, 1e-12);
    EXPECT_NEAR(cloud.variance, 1.0 / 9, 1e-12);
    // gamma = 1/2: Gamma(12) / Gamma(10) = 110 over b^2, b = 4 / sqrt(0.07);
    // Gamma(14) Gamma(10) / Gamma(12)^2 = 156 / 110.
    const EffectiveSize haze = effective_size(droplets_of(parse_phase_function(haze_l)));
    EXPECT_NEAR(haze.radius, 110 * 0.07 / 16, 1e-12);
    EXPECT_NEAR(haze.variance, 46.0 / 110, 1e-12);
}

void expect_sampled_with_its_effective_size(const Droplets& droplets) {
    const EffectiveSize exact = effective_size(droplets), met = summed_size(droplets);
    // 1e-7 of each end is left out
    EXPECT_NEAR(met.radius / exact.radius, 1, 1e-5) << droplets.effective_variance;
    EXPECT_NEAR(met.variance / exact.variance, 1, 1e-3) << droplets.effective_variance;
}

TEST(SizesOf, HaveTheEffectiveRadiusAndVarianceAskedFor) {
    for (const auto distribution :
         {Droplets::Distribution::gamma, Droplets::Distribution::lognormal})
        for (const double variance : {1e-6, 0.01, 0.1, 0.25, 0.5}) {
            Droplets droplets;
            droplets.effective_radius = 2 * 0.55 / (2 * pi);  // size parameter 2
            droplets.effective_variance = variance;
            droplets.distribution = distribution;
            EXPECT_EQ(effective_size(droplets).radius, droplets.effective_radius);
            EXPECT_EQ(effective_size(droplets).variance, variance);
            expect_sampled_with_its_effective_size(droplets);
        }
}

TEST(ModifiedGamma, IsSampledWithItsEffectiveSize) {
    for (const double alpha : {0.1, 1.0, 2.0, 6.0, 100.0})
        for (const double gamma : {0.25, 0.5, 1.0, 3.0, 10.0}) {
            Droplets droplets;
            droplets.distribution = Droplets::Distribution::modified_gamma;
            droplets.alpha = alpha;
            droplets.gamma = gamma;
            SCOPED_TRACE(testing::Message() << alpha << ' ' << gamma);
            expect_sampled_with_its_effective_size(droplets);
            const double by_library =
                4 * std::exp(std::lgamma((alpha + 4) / gamma) - std::lgamma((alpha + 3) / gamma) -
                             std::log(alpha / gamma) / gamma);
            EXPECT_NEAR(effective_size(droplets).radius / by_library, 1, 1e-11);
        }
}

TEST(ModifiedGamma, OfGammaOneIsTheGammaDistribution) {
    // alpha = 1 / v - 3 and b = 1 / (a v).
    const PhaseFunction modified = parse_phase_function(
        "mie:distribution=modified_gamma,mode_radius=0.7um,alpha=7,gamma=1,index=1.4+0.01i");
    const PhaseFunction gamma =
        parse_phase_function("mie:radius=1um,variance=0.1,distribution=gamma,index=1.4+0.01i");
    const std::vector<double> a = modified.moments(60), b = gamma.moments(60);
    expect_all_near(a, b, 0, 1e-9);
    EXPECT_NEAR(*modified.albedo(), *gamma.albedo(), 1e-9);
}

TEST(ModifiedGamma, OfHazeLHasThePublishedMoments) {
    // Garcia and Siewert (1985) print (2 l + 1) chi_l, of light of 0.7 um and index 1.33.
    const std::vector<double> chi = parse_phase_function(haze_l).moments(83);
    const std::vector<CsvRow> rows = csv_rows("haze_l_moments.csv");
    ASSERT_EQ(rows.size(), 83u);
    for (std::size_t l = 0; l < 83; ++l) EXPECT_NEAR(chi[l], rows[l].numbers.at(1), 2e-6) << l;
}

// ---- Rows

TEST(SizeRows, HaveTheEffectiveSizeOfTheirIntegrals) {
    // A triangle over [1, 3] um with its top at 2 um: the mean of r^2 is 4 + 1/6, of r^3 8 + 1, of
    // r^4 16 + 4 + 1/15.
    const double second = 4 + 1.0 / 6, third = 9, fourth = 20 + 1.0 / 15;
    const Droplets droplets = droplets_of(
        parse_phase_function("mie:distribution=1 0/2 5/3 0,wavelength=2um,index=1.4+0.01i"));
    const EffectiveSize exact = effective_size(droplets), met = summed_size(droplets);
    EXPECT_NEAR(exact.radius, third / second, 1e-13);
    EXPECT_NEAR(exact.variance, fourth * second / (third * third) - 1, 1e-13);
    EXPECT_NEAR(met.radius / exact.radius, 1, 1e-9);
    EXPECT_NEAR(met.variance / exact.variance, 1, 1e-9);
}

TEST(SizeRows, OfADistributionScatterAsItDoes) {
    std::string rows;
    for (int i = 0; i <= 300; ++i) {  // haze L, in steps of 3 %
        const double r = 0.005 * std::exp(0.03 * i);
        std::ostringstream row;
        row.precision(17);
        row << (i == 0 ? "" : "/") << r << ' ' << r * r * std::exp(-4 * std::sqrt(r / 0.07));
        rows += row.str();
    }
    const PhaseFunction listed =
        parse_phase_function("mie:distribution=" + rows + ",wavelength=0.7um,index=1.33");
    const PhaseFunction haze = parse_phase_function(haze_l);
    // Straight lines of 3 % lie off by (0.03)^2 / 12 of curvatures of some 10.
    EXPECT_NEAR(effective_size(droplets_of(listed)).radius / 0.48125, 1, 1e-3);
    const std::vector<double> a = listed.moments(40), b = haze.moments(40);
    expect_all_near(a, b, 0, 3e-4);
    const auto efficiency = [](const PhaseFunction& phi) {
        return std::get<Mie>(phi.terms()[0].second).extinction_efficiency();
    };
    EXPECT_NEAR(efficiency(listed) / efficiency(haze), 1, 1e-3);
}

TEST(DropletSizes, ComeBackFromTheirText) {
    for (const char* text :
         {cloud_c1, haze_l,
          "mie:distribution=0.1 3/0.25 5e-07/1 0,wavelength=0.55um,material=ice"}) {
        const PhaseFunction phi = parse_phase_function(text);
        EXPECT_EQ(phi.text(), text);
        EXPECT_EQ(parse_phase_function(phi.text()).moments(100), phi.moments(100));
    }
    EXPECT_EQ(parse_phase_function(cloud_c1).caption(), "Mie index 1.33 6 um at 0.7 um");
}

TEST(SizeRows, ScatterAlikeAtTwiceTheSizeAndWavelength) {
    const Droplets droplets =
        droplets_of(parse_phase_function("mie:distribution=1 0/2 5/3 0,index=1.4"));
    Droplets twice = droplets_of(parse_phase_function("mie:distribution=2 0/4 5/6 0,index=1.4"));
    twice.wavelength *= 2;
    const std::vector<double> a = Mie(droplets).moments(30), b = Mie(twice).moments(30);
    expect_all_near(a, b, 0, 1e-10);
    EXPECT_TRUE(have_same_sizes(droplets, droplets));
    EXPECT_FALSE(have_same_sizes(droplets, twice));
}

// ---- Families

TEST(DropletFamily, VariesRadiusAndVarianceOfGammaAndLognormalAlone) {
    for (const char* text : {cloud_c1, "mie:distribution=1 0/2 5/3 0"})
        for (const PhaseParameter parameter : {PhaseParameter::radius, PhaseParameter::variance})
            expect_refusal(
                [&] { with_parameter(parse_phase_function(text), parameter, 0.2); },
                {"family", parameter_name(parameter), "distribution gamma or lognormal"});
    const PhaseFunction blue =
        with_parameter(parse_phase_function(cloud_c1), PhaseParameter::wavelength, 0.45);
    EXPECT_EQ(droplets_of(blue).wavelength, 0.45);
    EXPECT_NE(blue.asymmetry(), parse_phase_function(cloud_c1).asymmetry());
}

// ---- Refusals

class DropletSizesRefuse : public testing::TestWithParam<Refusal> {};

TEST_P(DropletSizesRefuse, NamingWhatIsWrong) {
    expect_refusal([] { parse_phase_function(GetParam().text); }, GetParam().fragments);
}

INSTANTIATE_TEST_SUITE_P(
    Texts, DropletSizesRefuse,
    testing::ValuesIn<Refusal>(
        {{"RadiusOfModified",
          "mie:radius=1um,distribution=modified_gamma,mode_radius=4um,alpha=6,gamma=1",
          "radius must be absent where mode_radius, alpha and gamma"},
         {"VarianceOfModified",
          "mie:distribution=modified_gamma,mode_radius=4um,alpha=6,gamma=1,variance=0.1",
          "variance must be absent where mode_radius, alpha and gamma"},
         {"NoModeRadius", "mie:distribution=modified_gamma,alpha=6,gamma=1",
          "mie needs mode_radius="},
         {"NoGamma", "mie:distribution=modified_gamma,mode_radius=4um,alpha=6", "mie needs gamma="},
         {"AlphaOfGamma", "mie:radius=1um,variance=0.1,alpha=6",
          "alpha must be absent unless distribution=modified_gamma"},
         {"ModeRadiusOfZero", "mie:distribution=modified_gamma,mode_radius=0um,alpha=6,gamma=1",
          "mode_radius (um) must be above 0 and finite, got 0"},
         {"SmallAlpha", "mie:distribution=modified_gamma,mode_radius=1um,alpha=0.09,gamma=1",
          "alpha must be in [0.1, 100], got 0.09"},
         {"LargeGamma", "mie:distribution=modified_gamma,mode_radius=1um,alpha=2,gamma=10.1",
          "gamma must be in [0.25, 10], got 10.1"},
         {"LargeDroplets", "mie:distribution=modified_gamma,mode_radius=200um,alpha=2,gamma=0.5",
          "largest droplet must be at most 10000"},
         {"RadiusOfRows", "mie:distribution=1 0/2 1,radius=3um",
          "radius must be absent where the rows of the distribution"},
         {"OneRow", "mie:distribution=1 1", "rows of a distribution must be 2 to 1000, got 1"},
         {"RowsOutOfOrder", "mie:distribution=1 1/1 2",
          "radius_um (row 2) must be above the one before it, got 1"},
         {"RadiusOfARowTooSmall", "mie:distribution=0.00001 1/1 2",
          "radius_um (row 1) must be at least 1e-4 and finite, got 1e-05"},
         {"NegativeNumber", "mie:distribution=1 1/2 -2",
          "number_per_um (row 2) must be at least 0 and finite, got -2"},
         {"NoDroplets", "mie:distribution=1 0/2 0", "number_per_um must be above 0 somewhere"},
         {"FileWithoutReader",
          "mie:distribution=drops.csv",
          {"distribution", "where no files are read", "'drops.csv'"}},
         {"UnknownWord",
          "mie:distribution=gama,index=my.csv",
          {"distribution", "gamma, lognormal, modified_gamma or a file", "'gama"}}}),
    row_name);

}  // namespace
}  // namespace stratus
