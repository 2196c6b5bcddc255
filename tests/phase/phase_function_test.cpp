#include <stratus/base/constants.h>
#include <stratus/phase/phase_function.h>

#include "indices.h"
#include "refusal.h"
#include "row_name.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <random>
#include <sstream>
#include <vector>

namespace stratus {
namespace {

/// (1/2) times the integral of phi P_l sin Theta over the scattering angle by Simpson's rule, whose
/// nodes include all whole degrees, where tables have their knots.
double moment_by_simpson(const PhaseFunction& phi, unsigned l) {
    const int panels = 18000;
    const auto integrand = [&](double angle) {
        const double c = std::cos(angle);
        return static_cast<long double>(phi(c) * std::legendre(l, c) * std::sin(angle));
    };
    const double step = pi / panels;
    long double sum = 0;
    for (int i = 0; i < panels; ++i)
        sum += integrand(i * step) + 4 * integrand((i + 0.5) * step) + integrand((i + 1) * step);
    return static_cast<double>(sum * step / 12);
}

const char* const saturn = "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5";
const char* const points =
    "tabulated:points=0 3.5/5 2.9/12 2.25/40 1.1/90 0.5/91 0.52/135 0.45/150 0.9/180 1.4";

struct Case {
    const char* name;
    const char* text;
    double asymmetry;  // NaN: known from quadrature only
};

class EveryPhaseFunction : public testing::TestWithParam<Case> {
  protected:
    PhaseFunction phi() const { return parse_phase_function(GetParam().text); }
};

TEST_P(EveryPhaseFunction, HasMeanOne) {
    EXPECT_NEAR(moment_by_simpson(phi(), 0), 1, 1e-12);  // Simpson's own error
    EXPECT_EQ(phi().moments(3)[0], 1);
}

TEST_P(EveryPhaseFunction, HasTheMomentsOfItsValues) {
    const std::vector<double> chi = phi().moments(41);
    for (const unsigned l : {1u, 2u, 3u, 4u, 5u, 10u, 17u, 40u})
        EXPECT_NEAR(chi[l], moment_by_simpson(phi(), l), 1e-12) << "l = " << l;
}

TEST_P(EveryPhaseFunction, MomentsDoNotDependOnTheirNumber) {
    const std::vector<double> few = phi().moments(5), many = phi().moments(300);
    for (const auto l : indices(few)) EXPECT_NEAR(few[l], many[l], 1e-14);
    EXPECT_EQ(phi().moments(1).size(), 1u);
}

TEST_P(EveryPhaseFunction, HasItsAsymmetryAsFirstMoment) {
    EXPECT_EQ(phi().asymmetry(), phi().moments(2)[1]);
    if (!std::isnan(GetParam().asymmetry)) {
        EXPECT_NEAR(phi().asymmetry(), GetParam().asymmetry, 1e-15);
    }
}

TEST_P(EveryPhaseFunction, ComesBackFromItsTextBitForBit) {
    const PhaseFunction before = phi();
    const PhaseFunction after = parse_phase_function(before.text());
    EXPECT_EQ(after.text(), before.text());
    Uniform cosine(7, -1, 1);
    for (int i = 0; i < 1000; ++i) {
        const double c = cosine(), one = before(c), other = after(c);
        EXPECT_EQ(std::memcmp(&one, &other, sizeof one), 0) << c;
    }
}

TEST_P(EveryPhaseFunction, IsNonNegativeAndAcceptsRoundedCosines) {
    const PhaseFunction phi = this->phi();
    for (int i = 0; i <= 2000; ++i) EXPECT_GE(phi(std::cos(pi * i / 2000)), 0);
    EXPECT_EQ(phi(std::nextafter(1.0, 2.0)), phi(1));
    EXPECT_EQ(phi(std::nextafter(-1.0, -2.0)), phi(-1));
}

TEST_P(EveryPhaseFunction, IsIsotropicOnlyWhenFlat) {
    const bool flat = phi()(-0.9) == 1 && phi()(0.1) == 1 && phi()(0.8) == 1;
    EXPECT_EQ(phi().is_isotropic(), flat);
}

INSTANTIATE_TEST_SUITE_P(
    Each, EveryPhaseFunction,
    testing::ValuesIn<Case>(
        {{"Isotropic", "isotropic", 0},
         {"Rayleigh", "rayleigh", 0},
         {"Anisotropic", "anisotropic:x=0.5", -0.5 / 3},
         {"AnisotropicForward", "anisotropic:x=-1", 1.0 / 3},
         {"AnisotropicFlat", "anisotropic:x=0", 0},
         {"LambertSphere", "lambert_sphere", -4.0 / 9},
         {"HenyeyGreenstein", "henyey_greenstein:g=0.75", 0.75},
         {"HenyeyGreensteinBackward", "henyey_greenstein:g=-0.325", -0.325},
         {"HenyeyGreensteinFlat", "henyey_greenstein:g=0", 0},
         {"Moments", "moments:chi=1 0.6 0.3 0.1 0.02", 0.6},
         {"MomentsFlat", "moments:chi=1", 0},
         {"Tabulated", points, NAN},
         {"ThreePoints", "tabulated:points=0 1/90 0/180 0.25", NAN},
         {"SmallDroplets", "mie:radius=0.15um,variance=0.1", NAN},
         {"OneDroplet", "mie:radius=500nm,wavelength=1064nm,index=1.5+0.01i", NAN},
         {"IceCrystals",
          "mie:radius=0.2um, variance=0.2, distribution=lognormal, material=ice, "
          "wavelength=2um",
          NAN},
         {"Saturn", saturn, 0.5 * (0.404 - 0.596)},
         {"SumOfEveryKind",
          "0.1*rayleigh + 0.2*lambert_sphere + 0.3*henyey_greenstein:g=0.1 + "
          "0.15*tabulated:points=0 1/90 0/180 0.25 + 0.25*moments:chi=1 0.1",
          NAN}}),
    row_name);

// ---- Each kind

TEST(HenyeyGreenstein, KeepsItsPrecisionNearTheEndsOfItsRange) {
    // phi(+-1) = (1 + |g|) / (1 - |g|)^2 towards the peak, (1 - |g|) / (1 + |g|)^2 away from it
    for (const double g : {0.999999, 1 - 1e-12}) {
        const double peak = (1 + g) / ((1 - g) * (1 - g)), back = (1 - g) / ((1 + g) * (1 + g));
        EXPECT_NEAR(PhaseFunction::henyey_greenstein(g)(1) / peak, 1, 1e-14);
        EXPECT_NEAR(PhaseFunction::henyey_greenstein(g)(-1) / back, 1, 1e-14);
        EXPECT_NEAR(PhaseFunction::henyey_greenstein(-g)(-1) / peak, 1, 1e-14);
        EXPECT_NEAR(PhaseFunction::henyey_greenstein(-g)(1) / back, 1, 1e-14);
    }
}

TEST(HenyeyGreenstein, IsNotRoundedToAFullPeakInItsCaption) {
    for (const auto& [g, text] : {std::pair(0.9994, "0.999"), std::pair(0.9996, "0.9996"),
                                  std::pair(0.999999, "0.999999"), std::pair(-0.99999, "-0.99999")})
        EXPECT_EQ(PhaseFunction::henyey_greenstein(g).caption(),
                  std::string("Henyey-Greenstein g = ") + text);
}

TEST(HenyeyGreenstein, IsBlinn82WithTheOppositeSign) {
    const double blinns_g = 0.325;  // backward scattering, in the phase angle
    for (const double a : {0.0, 0.5, 1.5, 3.0}) {
        const double base = 1 + blinns_g * blinns_g - 2 * blinns_g * std::cos(a);
        EXPECT_NEAR(PhaseFunction::henyey_greenstein(-blinns_g)(std::cos(pi - a)),
                    (1 - blinns_g * blinns_g) / std::pow(base, 1.5), 1e-14);
    }
}

TEST(LambertSphere, IsBlinn82InThePhaseAngle) {
    const PhaseFunction phi = PhaseFunction::lambert_sphere();
    for (const double a : {0.0, 0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 2.9})
        EXPECT_NEAR(phi(std::cos(pi - a)), 8 / (3 * pi) * (std::sin(a) + (pi - a) * std::cos(a)),
                    1e-14);
    EXPECT_NEAR(phi(-1), 8.0 / 3, 1e-15);
}

TEST(LambertSphere, IsCubicInSmallScatteringAngles) {
    const PhaseFunction phi = PhaseFunction::lambert_sphere();
    for (const double angle : {1e-3, 1e-2, 0.09, 0.11}) {
        const long double x = angle;
        const long double exact = 8 / (3 * acosl(-1.0L)) * (sinl(x) - x * cosl(x));
        // cos(angle) rounds to 1e-16, and with it the angle to 1e-16 / angle
        EXPECT_NEAR(phi(std::cos(angle)) / static_cast<double>(exact), 1,
                    1e-12 + 1e-15 / (angle * angle));
    }
    EXPECT_EQ(phi(1), 0);
}

TEST(Sum, IsTheWeightedSumOfItsParts) {
    const PhaseFunction sum = parse_phase_function(saturn);
    const PhaseFunction back = PhaseFunction::henyey_greenstein(-0.5);
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.5);
    for (const double c : {-1.0, -0.3, 0.2, 0.9})
        EXPECT_DOUBLE_EQ(sum(c), 0.596 * back(c) + 0.404 * forward(c));
}

TEST(Tabulated, PassesThroughItsScaledPointsAndNeverOvershoots) {
    const std::vector<double> angle = {0, 10, 11, 12, 60, 100, 180}, value = {0, 0, 9, 9, 1, 0, 0};
    const PhaseFunction phi = PhaseFunction::tabulated(angle, value);
    const double scale = std::get<Tabulated>(phi.terms()[0].second).normalisation;
    const auto at = [&](double degrees) { return phi(-std::cos(radians(degrees))) / scale; };
    EXPECT_NEAR(at(180), value.back(), 1e-12);
    for (std::size_t i = 0; i + 1 < angle.size(); ++i) {
        EXPECT_NEAR(at(angle[i]), value[i], 1e-12);
        for (int percent = 1; percent < 100; ++percent) {
            const double here = at(angle[i] + percent * (angle[i + 1] - angle[i]) / 100);
            EXPECT_GE(here, std::min(value[i], value[i + 1]) - 1e-12);
            EXPECT_LE(here, std::max(value[i], value[i + 1]) + 1e-12);
        }
    }
}

TEST(Tabulated, ConvergesToTheSampledFunction) {
    std::vector<double> angle, value;
    const PhaseFunction exact = PhaseFunction::henyey_greenstein(-0.4);
    for (int i = 0; i <= 180; ++i) {
        angle.push_back(i);
        value.push_back(2 * exact(-std::cos(radians(i))));
    }
    const PhaseFunction phi = PhaseFunction::tabulated(angle, value);
    // a cubic with parabolic slopes: h^3 phi''' / 12 with h = 0.0175
    for (int i = 0; i < 1800; ++i)
        EXPECT_NEAR(phi(std::cos(pi * i / 1800)) / exact(std::cos(pi * i / 1800)), 1, 2e-5);
    for (std::size_t l = 0; l < 20; ++l)
        EXPECT_NEAR(phi.moments(20)[l], std::pow(-0.4, static_cast<double>(l)), 1e-6);
}

TEST(Tabulated, IsFlatAtBothEnds) {
    const PhaseFunction phi = parse_phase_function(points);
    for (const double end : {0.0, pi}) {
        const double near = std::abs(phi(-std::cos(std::abs(end - 1e-4))) - phi(-std::cos(end)));
        EXPECT_LT(near, 1e-5);  // a slope of 1 would give 1e-4
    }
}

/// Rows of Henyey-Greenstein's function every 2.5 degrees from `first` to `last`, times 3.
Tabulated table_of_lobe(double g, double first, double last, const Tabulated::Options& options) {
    const PhaseFunction exact = PhaseFunction::henyey_greenstein(g);
    std::vector<double> angle, value;
    for (double a = first; a <= last; a += 2.5) {
        angle.push_back(a);
        value.push_back(3 * exact(-std::cos(radians(a))));
    }
    return {angle, value, options};
}

/// Largest relative error of a table against the lobe that it was taken from, anywhere.
double error_of_lobe(const Tabulated& table, double g) {
    const PhaseFunction exact = PhaseFunction::henyey_greenstein(g);
    double largest = 0;
    for (int i = 0; i <= 1800; ++i) {
        const double c = std::cos(pi * i / 1800);
        largest = std::max(largest, std::abs(table(c) / exact(c) - 1));
    }
    return largest;
}

TEST(Tabulated, IsContinuedByTheFittedLobe) {
    Tabulated::Options fit;
    fit.tail = Tabulated::Tail::hg;
    for (const double g : {-0.5, 0.3, 0.6}) {
        // Cubics between rows 2.5 degrees apart.
        EXPECT_LT(error_of_lobe(table_of_lobe(g, 5, 150, fit), g), 1e-3) << g;
        EXPECT_LT(error_of_lobe(table_of_lobe(g, 0, 150, fit), g), 1e-3) << g;
        EXPECT_LT(error_of_lobe(table_of_lobe(g, 5, 180, fit), g), 1e-3) << g;
    }
}

TEST(Tabulated, MeetsItsOuterRowsWhereItIsContinued) {
    Tabulated::Options fit;
    fit.tail = Tabulated::Tail::hg;
    const Tabulated table({5, 20, 40, 60, 90, 120, 130, 150}, {4, 2, 1.5, 1, 0.5, 0.3, 0.4, 1},
                          fit);
    const auto at = [&](double a) { return table(-std::cos(radians(a))) / table.normalisation; };
    EXPECT_NEAR(at(5), 4, 1e-12);
    EXPECT_NEAR(at(150), 1, 1e-12);
    EXPECT_NEAR(at(4.99), at(5.01), 0.01);
    EXPECT_GT(at(0), 4);
    EXPECT_GT(at(180), 1);
    EXPECT_NEAR(table.moments(1)[0], 1, 1e-13);
}

TEST(Tabulated, IsContinuedByItsOuterRowsUnlessAFitIsAskedFor) {
    const Tabulated table = table_of_lobe(0.3, 5, 150, {});
    const auto at = [&](double a) { return table(-std::cos(radians(a))); };
    EXPECT_NEAR(at(0), at(5), 1e-12);
    EXPECT_NEAR(at(180), at(150), 1e-12);
    // The mean over the sphere lacks what the forward peak has beyond the last row: 6 % of 0.067,
    // the share of the sphere there, times 2. Straight on the lobe is 22 % above its value there.
    const PhaseFunction exact = PhaseFunction::henyey_greenstein(0.3);
    for (double a = 5; a <= 150; a += 5) EXPECT_NEAR(at(a) / exact(-std::cos(radians(a))), 1, 0.02);
    EXPECT_LT(error_of_lobe(table, 0.3), 0.22);
    EXPECT_EQ(table.continuation(),
              "values below 5 and beyond 150 degrees of phase angle are continued by that of the "
              "outer row");
}

TEST(Tabulated, HasAnAlbedoByItsGeometricAlbedo) {
    // A white Lambert sphere: p = 2/3. Its phase function straight back is 8/3.
    std::string points = "tabulated:points=";
    const PhaseFunction sphere = PhaseFunction::lambert_sphere();
    for (int a = 0; a <= 180; ++a)
        points += (a == 0 ? "" : "/") + std::to_string(a) + " " +
                  std::to_string(sphere(-std::cos(radians(a))));
    const PhaseFunction white = parse_phase_function(points + ",geometric_albedo=0.6666");
    EXPECT_NEAR(*white.albedo(), 0.6666 * 1.5, 1e-5);
    EXPECT_NEAR(*parse_phase_function(points + ",geometric_albedo=0.2").albedo(), 0.3, 1e-5);
    EXPECT_EQ(*parse_phase_function(points + ",geometric_albedo=0").albedo(), 0);
    EXPECT_FALSE(parse_phase_function(points).albedo().has_value());
    EXPECT_NEAR(*parse_phase_function("0.5*" + points + ",geometric_albedo=0.2 + 0.5*" + points +
                                      ",geometric_albedo=0.2")
                     .albedo(),
                0.3, 1e-5);
}

TEST(Tabulated, KeepsItsOptionsInItsText) {
    const char* const text =
        "tabulated:points=5 3/20 2/60 1/120 0.5/150 0.8,tail=hg,"
        "geometric_albedo=0.25";
    std::vector<std::string> notes;
    const PhaseFunction phi = parse_phase_function(text, &notes);
    EXPECT_EQ(phi.text(), text);
    const PhaseFunction again = parse_phase_function(phi.text());
    for (const double c : {-1.0, -0.3, 0.95, 1.0}) EXPECT_EQ(again(c), phi(c));
    ASSERT_EQ(notes.size(), 1u);
    expect_holds(notes[0], {"below 5 and beyond 150 degrees", "fitted to the outer rows"});
}

TEST(Moments, MayBeSlightlyNegative) {
    // a truncated series with a minimum of -5e-4, returned as it is
    const PhaseFunction phi = PhaseFunction::from_moments({1, 0.3335});
    EXPECT_NEAR(phi(-1), 1 - 3 * 0.3335, 1e-15);
    EXPECT_LT(phi(-1), 0);
}

TEST(Moments, AreSoonChecked) {               // 16 s for 20,000 when each angle summed them all
    const std::clock_t begin = std::clock();  // which other programs do not move on
    std::vector<double> chi(20'000);
    for (const auto l : indices(chi)) chi[l] = std::pow(0.999, static_cast<double>(l));
    const PhaseFunction phase{Moments(chi)};
    EXPECT_LT(std::clock() - begin, 4 * CLOCKS_PER_SEC);
    // The closed form, to what the 20,001st moment and more would add.
    EXPECT_NEAR(phase(0.0) / PhaseFunction(HenyeyGreenstein(0.999))(0.0), 1, 1e-2);
}

TEST(Moments, AreRefusedWhereTheirSumIsNegativeOrTheyAreMoreThan65536) {
    // 1 + 3 chi_1 cos x + 5 chi_2 P_2 is lowest between the angles of a coarse grid.
    expect_refusal([] { Moments({1, 0.3, 0.9}); }, "no lower than");
    expect_refusal([] { Moments({1, 0.5}); }, "got -0.5");
    std::vector<double> chi(65'537);
    chi[0] = 1;
    expect_refusal([&] { Moments{chi}; }, "at most 65536 moments, got 65537");
}

TEST(Moments, AreDividedByTheFirst) {
    const PhaseFunction phi = PhaseFunction::from_moments({1 + 5e-7, 0.25});
    EXPECT_EQ(phi.moments(2)[0], 1);
    EXPECT_DOUBLE_EQ(phi.moments(2)[1], 0.25 / (1 + 5e-7));
}

TEST(Sum, IsFlattenedAndNormalised) {
    const PhaseFunction inner =
        PhaseFunction::sum({{1, PhaseFunction::rayleigh()}, {3, PhaseFunction::isotropic()}});
    const PhaseFunction outer =
        PhaseFunction::sum({{2, inner}, {6, PhaseFunction::lambert_sphere()}, {0, inner}});
    ASSERT_EQ(outer.terms().size(), 3u);
    EXPECT_DOUBLE_EQ(outer.terms()[0].first, 0.0625);
    EXPECT_DOUBLE_EQ(outer.terms()[1].first, 0.1875);
    EXPECT_DOUBLE_EQ(outer.terms()[2].first, 0.75);
}

TEST(Sum, ComesBackFromItsTextBitForBit) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> weight(0.01, 1), g(-0.9, 0.9);
    for (int n = 0; n < 300; ++n) {
        std::vector<std::pair<double, PhaseFunction>> parts;
        for (int i = 0; i < 2 + n % 6; ++i)
            parts.emplace_back(weight(random), PhaseFunction::henyey_greenstein(g(random)));
        const PhaseFunction before = PhaseFunction::sum(parts);
        const PhaseFunction after = parse_phase_function(before.text());
        ASSERT_EQ(after.text(), before.text());
        ASSERT_EQ(after(0.3), before(0.3));
    }
}

// ---- Text

TEST(ParsePhaseFunction, IgnoresSpacesAndDefaultsToWeightOne) {
    const PhaseFunction tight = parse_phase_function("0.5*rayleigh+0.5*henyey_greenstein:g=0.25");
    const PhaseFunction loose =
        parse_phase_function("  0.5 * rayleigh  +  0.5  *henyey_greenstein : g = 0.25  ");
    EXPECT_EQ(tight.text(), loose.text());
    std::vector<std::string> notes;
    const PhaseFunction implied = parse_phase_function("rayleigh + 0.25*lambert_sphere", &notes);
    EXPECT_DOUBLE_EQ(implied.terms()[0].first, 0.8);
    EXPECT_DOUBLE_EQ(implied.terms()[1].first, 0.2);
}

TEST(ParsePhaseFunction, NotesWeightsThatDidNotSumToOne) {
    std::vector<std::string> notes;
    parse_phase_function("0.5*rayleigh + 0.7*isotropic", &notes);
    ASSERT_EQ(notes.size(), 1u);
    expect_holds(notes[0], "1.2");
    notes.clear();
    parse_phase_function(saturn, &notes);
    EXPECT_TRUE(notes.empty());
}

TEST(PhaseFunctionHelp, HasAnExampleOfEachKindThatParses) {
    std::istringstream help(phase_function_help());
    std::string line, example;
    std::size_t kinds = 0;
    const auto reader = [](const std::string& file, const std::vector<std::string>& columns) {
        const bool is_table = columns[0] == "phase_angle_deg or scattering_angle_deg";
        return PhaseColumns{file,
                            is_table ? std::vector<std::vector<double>>{{0, 90, 180}, {1, 1, 1}}
                                     : std::vector<std::vector<double>>{{0, 1}, {1, 0.25}},
                            [](std::size_t) { return std::string(); }};
    };
    for (; std::getline(help, line) && line.rfind("or a sum: ", 0) != 0; ++kinds) {
        std::istringstream(line) >> example;
        EXPECT_NO_THROW(parse_phase_function(example, nullptr, reader)) << example;
    }
    EXPECT_EQ(kinds, std::variant_size_v<PhaseFunction::Term>);
    EXPECT_NO_THROW(parse_phase_function(line.substr(10)));
}

TEST(ParsePhaseFunction, HandsFilesToTheReader) {
    const auto reader = [](const std::string& file, const std::vector<std::string>& columns) {
        EXPECT_EQ(file, "haze+l.csv");
        EXPECT_EQ(columns, (std::vector<std::string>{"l", "chi"}));
        return PhaseColumns{file, {{0, 1}, {1, 0.25}}, [](std::size_t) { return std::string(); }};
    };
    EXPECT_EQ(parse_phase_function("moments:file=haze+l.csv", nullptr, reader).text(),
              "moments:chi=1 0.25");
}

TEST(PhaseFunction, HasACaption) {
    EXPECT_EQ(parse_phase_function(saturn).caption(),
              "0.596 Henyey-Greenstein g = -0.5  +  0.404 Henyey-Greenstein g = 0.5");
    EXPECT_EQ(parse_phase_function("moments:chi=1 0.1").caption(), "2 Legendre moments");
}

class ParsePhaseFunctionRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(ParsePhaseFunctionRefuses, NamingWhatIsWrong) {
    expect_refusal([] { parse_phase_function(GetParam().text); }, GetParam().fragments);
}

INSTANTIATE_TEST_SUITE_P(
    Each, ParsePhaseFunctionRefuses,
    testing::ValuesIn<Refusal>(
        {{"Nothing", "", "phase function must stand here"},
         {"UnknownName", "raleigh", {"'raleigh'", "did you mean 'rayleigh'", "lambert_sphere"}},
         {"Initials", "HG:g=0.7", "'HG'; did you mean 'henyey_greenstein'"},
         {"FirstWord", "lambert", {"'lambert'", "did you mean 'lambert_sphere'"}},
         {"UnknownKey", "henyey_greenstein:h=0.5", {"henyey_greenstein", "'h'", "'g'"}},
         {"NearestKey", "tabulated:fiel=x.csv", "'fiel'; did you mean 'file'"},
         {"NoKey", "henyey_greenstein", "henyey_greenstein needs g="},
         {"FileWithoutKey", "tabulated:moon.csv",
          "must be written file=... or points=..., got 'moon.csv'"},
         {"NoKeyAtAll", "tabulated", "tabulated needs file=... or points=..."},
         {"NeedlessKey", "isotropic:g=0", "isotropic takes no parameter, got 'g=0'"},
         {"NoEquals", "henyey_greenstein:g 0.5", "'=' must follow g, got '0.5'"},
         {"NoNumber", "henyey_greenstein:g=half", "g must be a number, got 'half'"},
         {"NotANumber", "henyey_greenstein:g=nan", "g must be a number, got 'nan'"},
         {"GOfOne", "henyey_greenstein:g=1", "henyey_greenstein: g must be in (-1, 1), got 1"},
         {"GBelow", "henyey_greenstein:g=-1.5",
          "henyey_greenstein: g must be in (-1, 1), got -1.5"},
         {"GInfinite", "henyey_greenstein:g=inf",
          "henyey_greenstein: g must be in (-1, 1), got inf"},
         {"XAbove", "anisotropic:x=1.01", "x must be in [-1, 1], got 1.01"},
         {"TrailingWord", "rayleigh please", "'please' must be '+'"},
         {"TrailingKey", "henyey_greenstein:g=0.5,g=0.2", "',g=0.2'"},
         {"TrailingPlus", "rayleigh + ", "phase function must stand here"},
         {"NoStar", "0.5 rayleigh", "'*' must follow the weight 0.5, got 'rayleigh'"},
         {"NegativeWeight", "-0.5*rayleigh", "weight must be finite and at least 0, got -0.5"},
         {"InfiniteWeight", "inf*rayleigh", "weight must be finite and at least 0, got inf"},
         {"NoWeightAtAll", "0*rayleigh + 0*isotropic", "total weight must be above 0"},
         {"TwoPoints", "tabulated:points=0 1/180 1", "at least 3 rows, got 2"},
         {"HalfAPoint", "tabulated:points=0 1/90/180 1",
          "value of a point must be a number, got '/180 1'"},
         {"Tail", "tabulated:points=0 1/90 1/170 1,tail=flat",
          "tail must be hg or constant, got 'flat'"},
         {"FewOuterRows", "tabulated:points=0 1/90 1/130 2/170 3,tail=hg",
          "at least 4 rows within 40 degrees of the ends that tail=hg continues, got 2"},
         {"DarkOuterRow", "tabulated:points=0 1/140 1/150 2/160 0/170 3,tail=hg",
          "value (row 4) must be above 0 for tail=hg, got 0"},
         {"BrightParticle",
          "tabulated:points=0 1/90 1/180 1,geometric_albedo=0.3",
          {"geometric_albedo", "[0, 0.25]", "got 0.3"}},
         {"UnknownOption", "tabulated:points=0 1/90 1/180 1,tial=hg", "tail"},
         {"DarkTable", "tabulated:points=0 0/90 0/180 0", "above 0 somewhere"},
         {"UnsortedRow", "tabulated:points=0 1/90 1/80 1/180 1",
          "row 3) must be above the one before it, got 80"},
         {"ChiZero", "moments:chi=0.9 0.5", "chi_0 must be 1 (to 1e-6), got 0.9"},
         {"ChiAboveOne", "moments:chi=1 3.5", "chi_1 must be in [-1, 1], got 3.5"},
         {"WeightedChi", "moments:chi=1 1.5 1",
          "chi_1 must be in [-1, 1], which (2 l + 1) chi_l divided by 2 l + 1 would be, got 1.5"},
         {"NegativeSeries", "moments:chi=1 0.5", "-1e-3 of its largest value, got -0.5"},
         {"NoChi", "moments:chi=", "chi must be a number"},
         {"FileWithoutReader", "moments:file=haze.csv", {"moments", "must be chi", "'file'"}},
         {"BareNumber", "henyey_greenstein:0.5",
          "parameter of henyey_greenstein must be written g=0.5, got '0.5'"},
         {"BareNegativeNumber", "0.5*anisotropic: -0.5 + 0.5*rayleigh",
          "parameter of anisotropic must be written x=-0.5, got '-0.5'"},
         {"NoRadius", "mie:variance=0.1", "mie needs radius="},
         {"NoParameter", "mie", "mie needs radius=... or variance=..."},
         {"UnknownParameter",
          "mie:radius=1um,varience=0.1",
          {"parameter of mie", "'varience'", "did you mean 'variance'"}},
         {"ParameterTwice", "mie:radius=1um,radius=2um",
          "radius=1um,radius=2um': mie: radius must be given once"},
         {"RadiusWithoutUnit", "mie:radius=1",
          "radius=1': mie: radius must have a unit, um or nm, as in radius=0.55um, got '1'"},
         {"WavelengthWithoutUnit",
          "mie:radius=1um,wavelength=0.55",
          {"wavelength", "unit", "um or nm", "got '0.55'"}},
         {"NegativeRadius", "mie:radius=-1um", "radius (um) must be above 0 and finite, got -1"},
         {"InfiniteRadius", "mie:radius=infum", "radius"},
         {"NegativeVariance", "mie:radius=1um,variance=-0.1",
          "variance must be 0 or in [1e-6, 0.5], got -0.1"},
         {"VarianceAbove", "mie:radius=1um,variance=0.51",
          "variance must be 0 or in [1e-6, 0.5], got 0.51"},
         {"NoWavelength", "mie:radius=1um,wavelength=0um", "wavelength (um) must be above 0"},
         {"WavelengthOfWater", "mie:radius=1um,wavelength=5.1um",
          "wavelength must be in [0.19010783, 5.046613] um in water, got 5.1"},
         {"WavelengthOfIce", "mie:radius=1um,material=ice,wavelength=240nm",
          "wavelength must be in [0.25, 4] um in ice, got 0.24"},
         {"NegativeIndex", "mie:radius=1um,index=-1.33", "index must be in [0.01, 10], got -1.33"},
         {"TinyIndex", "mie:radius=1um,index=1e-300", "index must be in [0.01, 10], got 1e-300"},
         {"GainInIndex", "mie:radius=1um,index=1.33-1e-6i",
          "imaginary part of index, which absorbs, must be in [0, 10], got -1e-06"},
         {"IndexOfVacuum", "mie:radius=1um,index=1", "index must be at least 1e-3 from 1, got 1"},
         {"IndexAndMaterial", "mie:radius=1um,material=ice,index=1.3",
          "index=1.3': mie: index must be absent where material"},
         {"UnknownMaterial", "mie:radius=1um,material=steam",
          "material=steam': mie: material must be water or ice, got 'steam'"},
         {"UnknownDistribution",
          "mie:radius=1um,variance=0.1,distribution=normal",
          {"distribution", "gamma, lognormal, modified_gamma or", "'normal'"}},
         {"DropletTooLarge",
          "mie:radius=900um",
          {"2 pi radius / wavelength", "at most 10000", "got 10281"}},
         {"LargestDropletTooLarge", "mie:radius=220um,variance=0.1",
          "largest droplet must be at most 10000"},
         {"DropletTooSmall", "mie:radius=1e-6um", "at least 1e-4"},
         {"BareRadius", "mie:10um", "must be written radius=10, got '10'"},
         {"BareMoments", "moments:1 0.5", "must be written chi=1, got '1'"}}),
    row_name);

TEST(PhaseFunction, RefusesSumsWithoutWeightUnequalColumnsAndNoMoments) {
    const PhaseFunction phi;
    expect_refusal([] { PhaseFunction::sum({}); }, "total weight");
    expect_refusal(
        [&] {
            PhaseFunction::sum({{-1, phi}});
        },
        "weight must be finite and at least 0, got -1");
    expect_refusal(
        [&] {
            PhaseFunction::sum({{NAN, phi}});
        },
        "weight must be finite and at least 0, got nan");
    expect_refusal(
        [] {
            PhaseFunction::tabulated({0, 90, 180}, {1, 1});
        },
        "value must be as many numbers as phase_angle_deg, got 2");
    expect_refusal([&] { phi.moments(0); }, "count must be at least 1, got 0");
}

TEST(PhaseFunction, IsIsotropicByDefault) {
    EXPECT_EQ(PhaseFunction().text(), "isotropic");
    EXPECT_TRUE(PhaseFunction().is_isotropic());
}

}  // namespace
}  // namespace stratus
