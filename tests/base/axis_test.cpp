#include <stratus/base/axis.h>

#include <stratus/base/constants.h>

#include "refusal.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace stratus {
namespace {

/// The coordinates as the header defines them.
double coordinate(AxisScale scale, double value) {
    if (scale == AxisScale::arcsine_of_fourth_root) return std::asin(std::sqrt(std::sqrt(value)));
    if (scale == AxisScale::logarithmic) return std::log2(value);
    if (scale == AxisScale::square_root_of_complement) return -std::sqrt(1 - value);
    if (scale == AxisScale::square_root) return std::sqrt(value);
    if (scale == AxisScale::fourth_root_of_complement) return -std::pow(1 - value, 0.25);
    return value;
}

std::vector<double> evenly(double first, double last, int count) {
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) values.push_back(first + (last - first) * i / (count - 1));
    return values;
}

double weighted_sum(const Axis& axis, const Stencil& stencil,
                    const std::function<double(double)>& function) {
    double sum = 0;
    for (int i = 0; i < 4; ++i)
        if (stencil.weight[i] != 0)
            sum += double{stencil.weight[i]} *
                   function(axis.values.at(static_cast<std::size_t>(stencil.first + i)));
    return sum;
}

double interpolated(const Axis& axis, double value, const std::function<double(double)>& function) {
    return weighted_sum(axis, axis.view().stencil(value), function);
}

double mirrored(const Axis& axis, double value, const std::function<double(double)>& function) {
    return weighted_sum(axis, axis.view().mirrored_stencil(value), function);
}

struct Range {
    const char* name;
    AxisScale scale;
    double lowest, highest;
};

class OneSidedAxis : public testing::TestWithParam<Range> {
  protected:
    Axis axis(int count) const {
        return make_axis(GetParam().scale, GetParam().lowest, GetParam().highest, count);
    }

    double between(double share) const {
        return GetParam().lowest + share * (GetParam().highest - GetParam().lowest);
    }

    /// (1 + c)^power of the coordinate scaled to [0, 1], so that tolerances mean the same
    /// everywhere.
    std::function<double(double)> power_law(int power) const {
        const double first = coordinate(GetParam().scale, GetParam().lowest);
        const double last = coordinate(GetParam().scale, GetParam().highest);
        return [=](double value) {
            const double c = (coordinate(GetParam().scale, value) - first) / (last - first);
            return std::pow(1 + c, power);
        };
    }
};

TEST_P(OneSidedAxis, IsExactForCubicsInItsCoordinate) {
    const auto cubic = power_law(3);
    for (const int count : {4, 5, 12})
        for (const double share : evenly(0, 1, 65))
            // four float weights, each rounded once
            EXPECT_NEAR(interpolated(axis(count), between(share), cubic), cubic(between(share)),
                        2e-6);
}

TEST_P(OneSidedAxis, TakesTheTwoNearestSamplesOnEitherSide) {
    const Axis twelve = axis(12);
    for (int cell = 0; cell < 11; ++cell) {
        const auto i = static_cast<std::size_t>(cell);
        const double value = (twelve.values[i] + twelve.values[i + 1]) / 2;
        EXPECT_EQ(twelve.view().stencil(value).first, std::clamp(cell - 1, 0, 8));
    }
}

TEST_P(OneSidedAxis, LosesAnOrderForEverySampleShortOfFour) {
    for (const int count : {2, 3}) {
        const auto exact = power_law(count - 1);
        const auto beyond = power_law(count + 2);
        double worst = 0;
        for (const double share : evenly(0, 1, 65)) {
            EXPECT_NEAR(interpolated(axis(count), between(share), exact), exact(between(share)),
                        1e-6);
            worst = std::max(worst, std::abs(interpolated(axis(count), between(share), beyond) -
                                             beyond(between(share))));
        }
        EXPECT_GT(worst, 1e-2);
    }
}

TEST_P(OneSidedAxis, GivesASampleItsOwnIndex) {
    const Axis twelve = axis(12);
    for (int i = 0; i < 12; ++i)
        EXPECT_NEAR(twelve.view().index(twelve.values[static_cast<std::size_t>(i)]), i,
                    GetParam().lowest > 0.99 ? 1e-8 : 1e-12);  // an albedo's last bit is much there
}

TEST_P(OneSidedAxis, MeetsBothEndsExactly) {
    const Axis twelve = axis(12);
    EXPECT_EQ(twelve.values.front(), GetParam().lowest);
    EXPECT_EQ(twelve.values.back(), GetParam().highest);
    EXPECT_EQ(twelve.values.size(), 12u);
}

TEST_P(OneSidedAxis, ClampsToItsEnds) {
    const AxisView view = axis(6).view();
    EXPECT_EQ(view.index(-infinity), 0);
    EXPECT_EQ(view.index(std::nextafter(GetParam().lowest, -infinity)), 0);
    EXPECT_EQ(view.index(infinity), 5);
    EXPECT_EQ(view.stencil(infinity).first, 2);
    EXPECT_NEAR(view.stencil(infinity).weight[3], 1, 1e-6);
    EXPECT_NEAR(view.stencil(-infinity).weight[0], 1, 1e-6);
}

TEST_P(OneSidedAxis, NeverTurnsNotANumberIntoAnIndex) {
    const AxisView view = axis(6).view();
    EXPECT_EQ(view.index(NAN), 0);
    EXPECT_EQ(view.stencil(NAN).first, 0);
}

TEST_P(OneSidedAxis, PassesItsOwnCheck) {
    for (const int count : {2, 3, 4, 33}) EXPECT_NO_THROW(check_axis(axis(count), "axis"));
}

INSTANTIATE_TEST_SUITE_P(
    Each, OneSidedAxis,
    testing::ValuesIn<Range>({{"Cosine", AxisScale::arcsine_of_fourth_root, 0.01, 1},
                              {"CosineFromZero", AxisScale::arcsine_of_fourth_root, 0, 1},
                              {"OpticalDepth", AxisScale::logarithmic, 1.0 / 64, 96},
                              {"Albedo", AxisScale::square_root_of_complement, 0, 1},
                              {"AlbedoNearlyOne", AxisScale::square_root_of_complement, 0.999999,
                               1},
                              {"AlbedoInItsFourthRoot", AxisScale::fourth_root_of_complement, 0, 1},
                              {"Mixture", AxisScale::linear, 0.25, 1},
                              {"SquareRoot", AxisScale::square_root, 0, pi}}),
    row_name);

TEST(Azimuth, IsMirroredAtBothEnds) {
    const Axis axis = make_axis(AxisScale::linear, 0, pi, 9);
    const double step = pi / 8;
    // Weights half-way are -1/16, 9/16, 9/16, -1/16; a sample past the end is its mirror image.
    const Stencil low = axis.view().mirrored_stencil(step / 2);
    EXPECT_EQ(low.first, 0);
    const float low_expected[4] = {9.0f / 16, 9.0f / 16 - 1.0f / 16, -1.0f / 16, 0};
    const Stencil high = axis.view().mirrored_stencil(pi - step / 2);
    EXPECT_EQ(high.first, 5);
    const float high_expected[4] = {0, -1.0f / 16, 9.0f / 16 - 1.0f / 16, 9.0f / 16};
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(low.weight[i], low_expected[i], 1e-6);
        EXPECT_NEAR(high.weight[i], high_expected[i], 1e-6);
    }
}

TEST(Azimuth, IsExactForCubicsBetweenInnerSamples) {
    const Axis axis = make_axis(AxisScale::linear, 0, pi, 9);
    const auto cubic = [](double azimuth) { return azimuth * azimuth * azimuth - azimuth; };
    for (const double azimuth : evenly(pi / 8, pi * 7 / 8, 300))
        EXPECT_NEAR(mirrored(axis, azimuth, cubic), cubic(azimuth), 1e-5);
}

TEST(Azimuth, FollowsACosineToFourthOrderEverywhere) {
    const auto cosine = [](double azimuth) { return std::cos(2 * azimuth); };
    const auto worst = [&](int count) {
        const Axis axis = make_axis(AxisScale::linear, 0, pi, count);
        double error = 0;
        for (const double azimuth : evenly(0, pi, 1001))
            error = std::max(error, std::abs(mirrored(axis, azimuth, cosine) - cosine(azimuth)));
        return error;
    };
    EXPECT_LT(worst(17), 1e-3);
    EXPECT_NEAR(worst(17) / worst(33), 16, 2);
}

TEST(Azimuth, FoldsShortAxesInside) {
    const auto cosine = [](double azimuth) { return std::cos(azimuth); };
    for (const int count : {2, 3}) {
        const Axis axis = make_axis(AxisScale::linear, 0, pi, count);
        for (const double azimuth : evenly(0, pi, 32)) {
            const Stencil stencil = axis.view().mirrored_stencil(azimuth);
            EXPECT_EQ(stencil.first, 0);
            for (int i = count; i < 4; ++i) EXPECT_EQ(stencil.weight[i], 0);
            EXPECT_NEAR(mirrored(axis, azimuth, [](double) { return 1; }), 1, 1e-6);
        }
        EXPECT_NEAR(mirrored(axis, pi / 2, cosine), 0, 1e-6);
        EXPECT_NEAR(mirrored(axis, pi, cosine), -1, 1e-6);
    }
}

TEST(Azimuth, FollowsAForwardPeakBetterInItsSquareRoot) {
    const auto peak = [](double azimuth) {  // Henyey-Greenstein, g = 0.85, in the plane
        return std::pow(1 + 0.85 * 0.85 - 2 * 0.85 * std::cos(azimuth), -1.5);
    };
    const auto worst = [&](AxisScale scale) {
        const Axis axis = make_axis(scale, 0, pi, 33);
        double error = 0;
        for (const double azimuth : evenly(0, pi, 2001))
            error = std::max(error, std::abs(mirrored(axis, azimuth, peak) / peak(azimuth) - 1));
        return error;
    };
    EXPECT_LT(10 * worst(AxisScale::square_root), worst(AxisScale::linear));
}

TEST(Azimuth, InItsSquareRootIsMirroredAtZero) {
    const Axis axis = make_axis(AxisScale::square_root, 0, pi, 9);
    // In the coordinate u this is u^4, which the cubic at -1, 0, 1, 2 steps misses by 9/16 at most,
    // in fourth powers of a step; that at 0, 1, 2, 3 by 1.
    const auto even = [](double azimuth) { return azimuth * azimuth; };
    for (const double azimuth : evenly(0, axis.values[1], 30))
        EXPECT_NEAR(mirrored(axis, azimuth, even), even(azimuth), 0.57 * even(axis.values[1]));
}

TEST(Axis, OfCosinesFollowsTheSineOfTheAngleUpToTheZenith) {
    // Odd azimuthal modes carry this factor; its slope is infinite at mu = 1 in any power of mu.
    const auto sine = [](double mu) { return std::sqrt((1 - mu) * (1 + mu)); };
    const Axis axis = make_axis(AxisScale::arcsine_of_fourth_root, 0.01, 1, 24);
    for (const double mu : evenly(0.5, 1, 501))
        EXPECT_NEAR(interpolated(axis, mu, sine), sine(mu), 1e-4) << mu;
}

TEST(Axis, OfOneSampleGivesThatSampleAlone) {
    for (const AxisScale scale : {AxisScale::linear, AxisScale::arcsine_of_fourth_root,
                                  AxisScale::logarithmic, AxisScale::square_root_of_complement,
                                  AxisScale::square_root, AxisScale::fourth_root_of_complement}) {
        const Axis axis = make_axis(scale, 0.5, 0.5, 1);
        for (const double value : {0.1, 0.5, 0.9}) {
            const Stencil stencil = axis.view().stencil(value);
            EXPECT_EQ(stencil.first, 0);
            EXPECT_EQ(stencil.weight[0], 1);
            EXPECT_EQ(stencil.weight[1], 0);
        }
    }
}

TEST(Axis, ExcludesInfinityFromItsCubic) {
    const Axis axis = make_axis(AxisScale::logarithmic, 1, 16, 5, true);
    const AxisView view = axis.view();
    EXPECT_EQ(axis.values.back(), infinity);
    EXPECT_EQ(view.count, 5);
    EXPECT_EQ(view.size(), 6);
    EXPECT_TRUE(view.ends_at_infinity);
    EXPECT_EQ(view.highest, 16);
    EXPECT_EQ(view.stencil(infinity).first, 1);
    EXPECT_EQ(view.index(infinity), 4);
}

TEST(Axis, MayBeInfinityAlone) {
    const Axis axis = make_axis(AxisScale::logarithmic, 1, 1, 0, true);
    EXPECT_EQ(axis.values, std::vector<double>{infinity});
    EXPECT_EQ(axis.view().count, 0);
    EXPECT_EQ(axis.view().size(), 1);
    EXPECT_NO_THROW(check_axis(axis, "optical_depth"));
}

TEST(Axis, SamplesOctavesExactly) {
    const Axis axis = make_axis(AxisScale::logarithmic, 0.125, 8, 13);
    for (std::size_t octave = 0; octave < 7; ++octave)
        EXPECT_EQ(axis.values[2 * octave], std::exp2(static_cast<double>(octave) - 3));
}

TEST(AxisScale, HasTheNameThatFilesUse) {
    for (const auto& [scale, name] :
         {std::pair{AxisScale::linear, "linear"},
          {AxisScale::arcsine_of_fourth_root, "arcsine_of_fourth_root"},
          {AxisScale::logarithmic, "logarithmic"},
          {AxisScale::square_root_of_complement, "square_root_of_complement"},
          {AxisScale::square_root, "square_root"},
          {AxisScale::fourth_root_of_complement, "fourth_root_of_complement"}})
        EXPECT_STREQ(axis_scale_name(scale), name);
}

TEST(MakeAxis, RefusesNamingRangeAndValue) {
    const auto refused = [](AxisScale scale, double lowest, double highest, int count,
                            const char* message, bool and_infinity = false) {
        expect_refusal([&] { make_axis(scale, lowest, highest, count, and_infinity); }, {message});
    };
    const AxisScale cosines = AxisScale::arcsine_of_fourth_root, depths = AxisScale::logarithmic,
                    linear = AxisScale::linear, albedos = AxisScale::square_root_of_complement;
    refused(cosines, -0.1, 1, 4, "make_axis: lowest must be in [0, 1], got -0.1");
    refused(cosines, 0.1, 1.5, 4, "highest must be in [0, 1], got 1.5");
    refused(depths, 0, 1, 4, "lowest must be in (0, inf), got 0");
    refused(depths, 1, infinity, 4, "highest must be in (0, inf), got inf");
    for (const AxisScale scale : {albedos, AxisScale::fourth_root_of_complement})
        refused(scale, 0, 1.01, 4, "highest must be finite and at most 1, got 1.01");
    refused(linear, NAN, 1, 4, "lowest must be finite, got nan");
    refused(linear, 0, 1, 1, "highest must be equal to lowest = 0.000000, got 1");
    refused(linear, 1, 1, 2, "highest must be above lowest = 1.000000, got 1");
    refused(linear, 0, 1, 0, "count must be at least 1, got 0");
    refused(depths, 1, 2, -1, "count must be at least 0, got -1", true);
    refused(albedos, 0, 1, 4,
            "scale must be logarithmic for an axis that ends at infinity, got "
            "square_root_of_complement",
            true);
}

TEST(CheckAxis, RefusesNamingTheAxisAndTheValue) {
    const auto refused = [](AxisScale scale, const std::vector<double>& values,
                            const char* message) {
        expect_refusal([&] { check_axis({scale, values}, "mu_in"); }, {message});
    };
    const AxisScale linear = AxisScale::linear, depths = AxisScale::logarithmic;
    refused(linear, {}, "check_axis: mu_in must be an axis of at least one sample, got none");
    refused(linear, {0, 1, 2.125, 3}, "uniform in the coordinate of scale linear, got 2.125");
    refused(AxisScale::arcsine_of_fourth_root, {0.25, 0.5, 0.75},
            "uniform in the coordinate of scale arcsine_of_fourth_root, got 0.5");
    refused(linear, {0, 2, 1}, "mu_in must be ascending, got 1");
    refused(linear, {0, 1, 1}, "mu_in must be ascending, got 1");
    refused(depths, {-1, 1}, "mu_in must be in (0, inf), got -1");
    refused(AxisScale::square_root, {-1, 1}, "mu_in must be in [0, inf), got -1");
    refused(linear, {0, NAN, 2}, "mu_in must be finite, got nan");
    refused(depths, {1, infinity, infinity}, "mu_in must be in (0, inf), got inf");
    refused(linear, {0, 1, infinity}, "mu_in must be finite unless logarithmic, got inf");
}

}  // namespace
}  // namespace stratus
