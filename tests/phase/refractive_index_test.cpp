// Indices of refraction: the rows of water, what lies between rows, and files of users.
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>

#include "phase/mie_scattering.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

namespace stratus {
namespace {

std::complex<double> water_at(double wavelength) {
    Droplets droplets;
    droplets.wavelength = wavelength;
    return index_of_refraction(droplets);
}

std::vector<IndexRow> all_of_water() {
    return {water_rows().first, water_rows().first + water_rows().count};
}

TEST(WaterIndex, IsItsRows) {
    // Segelstein's rows in the bands at 1.45, 1.94 and 2.95 um, and at either end.
    EXPECT_EQ(water_at(0.19010783), std::complex<double>(1.475183, 3.6223478e-07));
    EXPECT_EQ(water_at(1.4487719), std::complex<double>(1.313055, 0.00036373923));
    EXPECT_EQ(water_at(1.9408859), std::complex<double>(1.29859, 0.0019089306));
    EXPECT_EQ(water_at(2.9512092), std::complex<double>(1.285942, 0.28235153));
    EXPECT_EQ(water_at(5.046613), std::complex<double>(1.304258, 0.011797504));
    EXPECT_EQ(water_rows().count, 416u);
}

TEST(WaterIndex, AgreesWithHaleAndQuerry) {
    // Independent measurements, Appl. Opt. 12, 555 (1973), at rows where both are well known: they
    // differ by up to a quarter in windows and edges, 6 % within the band at 3 um.
    struct Known {
        double wavelength, k, margin;
    };
    for (const Known& row : std::vector<Known>{{0.7, 3.35e-8, 0.25},
                                               {0.8, 1.25e-7, 0.25},
                                               {0.9, 4.86e-7, 0.25},
                                               {1, 2.89e-6, 0.25},
                                               {1.2, 9.89e-6, 0.25},
                                               {1.4, 0.000138, 0.25},
                                               {1.6, 8.55e-5, 0.25},
                                               {1.8, 0.000115, 0.25},
                                               {2, 0.0011, 0.25},
                                               {2.2, 0.000289, 0.25},
                                               {2.4, 0.000956, 0.25},
                                               {2.8, 0.115, 0.06 + 0.01},
                                               {2.95, 0.298, 0.06},
                                               {3, 0.272, 0.06},
                                               {3.2, 0.0924, 0.06},
                                               {3.4, 0.0195, 0.06},
                                               {3.6, 0.00515, 0.06},
                                               {4, 0.0046, 0.06}})
        EXPECT_NEAR(water_at(row.wavelength).imag() / row.k, 1, row.margin) << row.wavelength;
}

TEST(WaterIndex, LiesBetweenItsRows) {
    const std::vector<IndexRow> rows = all_of_water();
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        const IndexRow &a = rows[i], &b = rows[i + 1];
        ASSERT_LT(a.wavelength, b.wavelength);
        for (const double share : {0.1, 0.5, 0.9}) {
            const auto here = water_at(a.wavelength + share * (b.wavelength - a.wavelength));
            EXPECT_GE(here.real(), std::min(a.n, b.n) * (1 - 1e-15)) << a.wavelength;
            EXPECT_LE(here.real(), std::max(a.n, b.n) * (1 + 1e-15)) << a.wavelength;
            EXPECT_GE(here.imag(), std::min(a.k, b.k) * (1 - 1e-13)) << a.wavelength;
            EXPECT_LE(here.imag(), std::max(a.k, b.k) * (1 + 1e-13)) << a.wavelength;
        }
    }
}

struct Band {
    double begin, end;      // um
    double typical, worst;  // relative errors of k: root mean square and largest
};

class WaterWithoutARow : public testing::TestWithParam<Band> {};

TEST_P(WaterWithoutARow, IsFoundBetweenTheOthers) {
    // Intervals are twice as wide there as in the table. docs/recipes.md states these bounds.
    const Band& band = GetParam();
    const std::vector<IndexRow> rows = all_of_water();
    double squares = 0, worst = 0;
    int count = 0;
    for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
        if (rows[i].wavelength < band.begin || rows[i].wavelength >= band.end) continue;
        std::vector<IndexRow> others = rows;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
        const double off =
            interpolated_index({others.data(), others.size()}, rows[i].wavelength).imag() /
                rows[i].k -
            1;
        squares += off * off;
        worst = std::max(worst, std::abs(off));
        ++count;
    }
    ASSERT_GT(count, 10);
    const double typical = std::sqrt(squares / count);
    EXPECT_LT(typical, band.typical);
    EXPECT_LT(worst, band.worst);
    EXPECT_GT(worst, 0.8 * band.worst);  // what is stated is what is met
}

INSTANTIATE_TEST_SUITE_P(Bands, WaterWithoutARow,
                         testing::ValuesIn<Band>({{0.19, 0.3, 0.031, 0.11},
                                                  {0.3, 0.4, 0.0046, 0.011},
                                                  {0.4, 0.7, 0.015, 0.053},
                                                  {0.7, 1.3, 0.017, 0.051},
                                                  {1.3, 1.6, 0.043, 0.15},
                                                  {1.6, 1.8, 0.0085, 0.017},
                                                  {1.8, 2.1, 0.045, 0.19},
                                                  {2.1, 2.6, 0.014, 0.035},
                                                  {2.6, 3.4, 0.028, 0.11},
                                                  {3.4, 5.1, 0.0094, 0.02}}),
                         [](const auto& row) {
                             return "From" +
                                    std::to_string(
                                        static_cast<int>(std::lround(1000 * row.param.begin))) +
                                    "nm";
                         });

// ---- Between rows

TEST(InterpolatedIndex, IsExactOnPowersOfTheWavelength) {
    std::vector<IndexRow> rows;
    for (const double wavelength : {0.5, 0.6, 1.0, 1.1, 2.0})
        rows.push_back(
            {wavelength, 1.4 - 0.1 * std::log(wavelength), 1e-3 * std::pow(wavelength, 3)});
    for (const double wavelength : {0.5, 0.55, 0.7, 1.05, 1.9, 2.0}) {
        const auto here = interpolated_index({rows.data(), rows.size()}, wavelength);
        EXPECT_NEAR(here.real(), 1.4 - 0.1 * std::log(wavelength), 1e-14) << wavelength;
        EXPECT_NEAR(here.imag() / (1e-3 * std::pow(wavelength, 3)), 1, 1e-13) << wavelength;
    }
}

TEST(InterpolatedIndex, IsLinearBesideRowsThatAbsorbNothing) {
    const std::vector<IndexRow> rows{{1, 1.5, 0}, {2, 1.5, 0.2}, {4, 1.5, 0.4}};
    const IndexRows all{rows.data(), rows.size()};
    EXPECT_EQ(interpolated_index(all, 1).imag(), 0);
    EXPECT_NEAR(interpolated_index(all, std::sqrt(2.0)).imag(), 0.1, 1e-15);
    EXPECT_NEAR(interpolated_index(all, std::sqrt(8.0)).imag(), std::sqrt(0.08), 1e-15);
}

// ---- Files

PhaseFunction with_file(const std::string& text, const std::vector<std::vector<double>>& columns) {
    return parse_phase_function(
        text, nullptr, [&](const std::string& file, const std::vector<std::string>& wanted) {
            EXPECT_EQ(file, "my.csv");
            EXPECT_EQ(wanted, (std::vector<std::string>{"wavelength_um", "n", "k"}));
            return PhaseColumns{file, columns, [](std::size_t row) {
                                    return " (my.csv, line " + std::to_string(row + 2) + ")";
                                }};
        });
}

const std::vector<std::vector<double>> three_rows{{0.5, 1, 2}, {1.5, 1.4, 1.3}, {0.01, 0.02, 0.03}};

TEST(IndexFile, IsTheIndexAtTheWavelength) {
    const PhaseFunction phi =
        with_file("mie:radius=1um,index=my.csv,wavelength=1um,variance=0.1", three_rows);
    EXPECT_EQ(phi.text(),
              "mie:radius=1um,variance=0.1,distribution=gamma,wavelength=1um,index=1.4+0.02i");
    EXPECT_EQ(with_file("0.5*mie:radius=1um,wavelength=1um,index=my.csv+0.5*rayleigh", three_rows)
                  .terms()
                  .size(),
              2u);
}

TEST(IndexFile, GivesTheSameBitsThroughItsText) {
    for (const char* wavelength : {"0.5um", "0.77um", "1234nm", "2um"}) {
        const PhaseFunction phi = with_file(
            std::string("mie:radius=0.3um,index=my.csv,wavelength=") + wavelength, three_rows);
        const PhaseFunction again = parse_phase_function(phi.text());
        EXPECT_EQ(again.text(), phi.text());
        EXPECT_EQ(again.moments(40), phi.moments(40));
        EXPECT_EQ(again.albedo(), phi.albedo());
    }
}

TEST(IndexFile, IsOfOneWavelength) {
    const PhaseFunction phi = with_file("mie:radius=1um,wavelength=1um,index=my.csv", three_rows);
    EXPECT_EQ(with_parameter(phi, PhaseParameter::radius, 2).text(),
              "mie:radius=2um,variance=0,wavelength=1um,index=1.4+0.02i");
    expect_refusal([&] { with_parameter(phi, PhaseParameter::wavelength, 1.5); },
                   {"wavelength (um)", "must be 1,", "index was read from a file", "got 1.5"});
}

TEST(IndexFile, IsRefusedWithItsRow) {
    const auto refused = [](const std::vector<std::vector<double>>& columns,
                            const Fragments& fragments) {
        expect_refusal([&] { with_file("mie:radius=1um,wavelength=1um,index=my.csv", columns); },
                       fragments);
    };
    refused({{0.5, 0.5, 2}, {1, 1, 1}, {0, 0, 0}},
            "wavelength_um (my.csv, line 3) must be above the one before it, got 0.5");
    refused({{0, 2}, {1.5, 1.5}, {0, 0}},
            "wavelength_um (my.csv, line 2) must be above 0 and finite, got 0");
    refused({{0.5, 2}, {1.5, 0}, {0, 0}}, "n (my.csv, line 3) must be in (0, 10], got 0");
    refused({{0.5, 2}, {1.5, 1.5}, {-0.1, 0}}, "k (my.csv, line 2) must be in [0, 10], got -0.1");
    refused({{1}, {1.5}, {0}}, "my.csv must be of at least 2 rows, got 1");
    refused({{1.5, 2}, {1.5, 1.5}, {0, 0}},
            "wavelength must be in [1.5, 2] um, the rows of my.csv, got 1");
}

TEST(IndexFile, IsRefusedWhereNoFilesAreRead) {
    expect_refusal([] { parse_phase_function("mie:radius=1um,index=my.csv"); },
                   "index must be n or n+ki where no files are read, got 'my.csv'");
    expect_refusal([] { parse_phase_function("mie:radius=1um,index=glass"); },
                   {"index", "n+ki", ".csv", "'glass'"});
}

}  // namespace
}  // namespace stratus
