#include <stratus/table/table.h>

#include <stratus/base/constants.h>

#include "refusal.h"
#include "row_name.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stratus {
namespace {

Table good_table() {
    Table table = plain_table({3, 4, 2, 5, 6}, {0.5, 32, true});
    table.plane_albedo.assign(3 * 5 * 2, 0.5f);
    table.diffuse_transmittance.assign(3 * 5 * 2, 0.25f);
    table.spherical_albedo.assign(3 * 5, 0.5f);
    return table;
}

TEST(Prepare, ComputesTheWeightsOfEveryLayer) {
    Table table = good_table();
    prepare(table);
    ASSERT_EQ(table.reflection_weight.size(), 15u);
    ASSERT_EQ(table.transmission_weight.size(), 15u);
    for (std::size_t w = 0; w < 3; ++w)
        for (std::size_t t = 0; t < 5; ++t) {
            const double albedo = table.albedo.values[w], depth = table.optical_depth.values[t];
            const double exponent = small_table_exponent(albedo);
            const double reflected = reflection_scale(depth, exponent, small_table_length);
            const double transmitted = transmission_scale(depth, exponent, small_table_length);
            EXPECT_NEAR(table.reflection_weight[w * 5 + t] * albedo * reflected, 1, 1e-7);
            EXPECT_NEAR(table.transmission_weight[w * 5 + t] * albedo * transmitted, t == 4 ? 0 : 1,
                        1e-7);  // no transmission at infinity
        }
}

TEST(Prepare, ComputesCosineWeightsAtEveryDepth) {
    Table table = good_table();
    prepare(table);
    ASSERT_EQ(table.mu_in_weight.size(), 5u * 2u);
    ASSERT_EQ(table.mu_out_weight.size(), 5u * 5u);
    for (std::size_t t = 0; t < 5; ++t)
        for (std::size_t m = 0; m < 5; ++m) {
            const double depth = table.optical_depth.values[t], mu = table.mu_out.values[m];
            EXPECT_NEAR(table.mu_out_weight[t * 5 + m] * intercepted_share(depth, mu), 1, 1e-7);
        }
}

TEST(Prepare, DropsSamplesBelowTheRangeOfFloat) {
    Table table = empty_table({2, 3, 1, 1, 1}, {1, 1024, false});
    table.albedo.values[0] = 0;
    table.transmission_multiple = tabulate(
        table, [](const SamplePoint& p) { return small_table_scale(Side::transmission, p); });
    prepare(table);
    EXPECT_GT(table.reflection_weight[0], 1);    // albedo 0 scatters nothing, but weighs
    EXPECT_GT(table.transmission_weight[5], 1);  // albedo 1: 0.7 / 1024.7
    table.albedo.values[0] = 0.19;
    prepare(table);
    EXPECT_EQ(table.transmission_weight[2], 0);  // exp(-0.99 * 1024)
    EXPECT_GT(table.transmission_weight[1], 1);  // exp(-0.99 * 32)
}

TEST(Prepare, MayBeDoneAgain) {
    Table table = good_table();
    prepare(table);
    const std::vector<float> once = table.reflection_weight, cosines = table.mu_in_weight;
    prepare(table);
    EXPECT_EQ(table.reflection_weight, once);
    EXPECT_EQ(table.mu_in_weight, cosines);
}

TEST(Prepare, AcceptsOneSideWithoutFluxes) {
    Table table = good_table();
    table.transmission_multiple.clear();
    table.plane_albedo.clear();
    table.diffuse_transmittance.clear();
    table.spherical_albedo.clear();
    EXPECT_NO_THROW(prepare(table));
    EXPECT_TRUE(table.view().has_reflection());
    EXPECT_FALSE(table.view().has_transmission());
}

TEST(Table, IsSeenByItsViewWithoutCopies) {
    Table table = good_table();
    prepare(table);
    const TableView view = table.view();
    EXPECT_EQ(view.phase_function, &table.phase_function);
    EXPECT_EQ(view.reflection_multiple, table.reflection_multiple.data());
    EXPECT_EQ(view.transmission_multiple, table.transmission_multiple.data());
    EXPECT_EQ(view.optical_depth.size(), 5);
    EXPECT_EQ(view.optical_depth.count, 4);
    EXPECT_EQ(view.extrapolation_length, small_table_length);
}

/// What spoils a table so that preparing it is refused.
struct Refused {
    const char* name;
    void (*spoil)(Table&);
    Fragments fragments;
};

class PrepareRefuses : public testing::TestWithParam<Refused> {};

TEST_P(PrepareRefuses, NamingTheDatasetAndWhatWasMet) {
    Table table = good_table();
    GetParam().spoil(table);
    expect_refusal([&] { prepare(table); }, GetParam().fragments);
}

const float float_infinity = std::numeric_limits<float>::infinity();

INSTANTIATE_TEST_SUITE_P(
    Axes, PrepareRefuses,
    testing::ValuesIn<Refused>(
        {{"NoAlbedo", [](Table& t) { t.albedo.values.clear(); },
          "albedo must be an axis of at least one sample, got none"},
         {"AlbedoBelowZero", [](Table& t) { t.albedo = make_axis(t.albedo.scale, -0.1, 1, 3); },
          "albedo must be within [0, 1], got -0.1"},
         {"AlbedoInAnotherScale",
          [](Table& t) { t.albedo.scale = AxisScale::linear; },
          {"scale of axis albedo", "square_root_of_complement", "linear"}},
         {"UnevenDepths", [](Table& t) { t.optical_depth.values[1] *= 1.01; },
          "optical_depth must be uniform"},
         {"CosineInAnotherScale", [](Table& t) { t.mu_in.scale = AxisScale::logarithmic; },
          "scale of axis mu_in must be arcsine_of_fourth_root, got logarithmic"},
         {"CosineZero",
          [](Table& t) { t.mu_in = make_axis(t.mu_in.scale, 0, 1, 2); },
          {"mu_in", "(0, 1]", "got 0"}},
         {"CosineAboveOne", [](Table& t) { t.mu_out.values.back() = 1.125; },
          "mu_out must be in [0, 1], got 1.125"},
         {"CosineToInfinity", [](Table& t) { t.mu_out.values.back() = infinity; },
          "mu_out must be finite unless logarithmic, got inf"},
         {"AzimuthBeyondPi", [](Table& t) { t.azimuth = make_axis(t.azimuth.scale, 0, 4, 6); },
          "azimuth must be within [0, 3.1415926535897931], got 3.2"},
         {"FewAzimuthsShortOfPi", [](Table& t) { t.azimuth = make_axis(t.azimuth.scale, 0, 3, 3); },
          "samples of azimuth must be 1, or 4 at least, where they do not span 0 to pi, got 3"},
         {"FewAzimuthsNotFromZero",
          [](Table& t) { t.azimuth = make_axis(t.azimuth.scale, 0.5, pi, 2); },
          "samples of azimuth must be 1, or 4 at least, where they do not span 0 to pi, got 2"}}),
    row_name);

INSTANTIATE_TEST_SUITE_P(
    Mixtures, PrepareRefuses,
    testing::ValuesIn<Refused>(
        {{"AboveOne", [](Table& t) { set_mixture(t, make_axis(AxisScale::linear, 0, 1.5, 2)); },
          "mixture must be within [0, 1], got 1.5"},
         {"BelowZero", [](Table& t) { set_mixture(t, make_axis(AxisScale::linear, -0.5, 1, 2)); },
          "mixture must be within [0, 1], got -0.5"},
         {"Descending",
          [](Table& t) {
              set_mixture(t, {AxisScale::linear, {0.5, 0.25}});
          },
          "mixture must be ascending, got 0.25"},
         {"InAnotherScale",
          [](Table& t) { set_mixture(t, make_axis(AxisScale::logarithmic, 0.5, 1, 2)); },
          "scale of axis mixture must be linear, got logarithmic"},
         {"Alone",
          [](Table& t) {
              set_mixture(t, {AxisScale::linear, {0.5}});
          },
          "mixture must be of two samples at least, got 1"},
         {"WithoutSamplesOfTheirOwn",
          [](Table& t) {
              set_mixture(t, make_axis(AxisScale::linear, 0, 1, 2));
              t.extrapolation_lengths = {1, 2};
          },
          "length of plane_albedo must be 60, got 30"},
         {"WithoutALengthOfEachMember",
          [](Table& t) {
              set_mixture(t, make_axis(AxisScale::linear, 0, 1, 2));
              t.extrapolation_lengths = {1};
          },
          "extrapolation_lengths must be as many as members, 2, got 1"},
         {"WithALengthOfZero",
          [](Table& t) {
              set_mixture(t, make_axis(AxisScale::linear, 0, 1, 2));
              t.extrapolation_lengths = {1, 0};
          },
          "extrapolation_lengths must be in (0, inf), got 0"}}),
    row_name);

INSTANTIATE_TEST_SUITE_P(
    Datasets, PrepareRefuses,
    testing::ValuesIn<Refused>(
        {{"NoSide",
          [](Table& t) {
              t.reflection_multiple.clear();
              t.transmission_multiple.clear();
          },
          "reflection_multiple or transmission_multiple, got neither"},
         {"ShortReflection", [](Table& t) { t.reflection_multiple.pop_back(); },
          "length of reflection_multiple must be 900, got 899"},
         {"LongTransmission", [](Table& t) { t.transmission_multiple.push_back(0); },
          "length of transmission_multiple must be 900, got 901"},
         {"ShortPlaneAlbedo", [](Table& t) { t.plane_albedo.pop_back(); },
          "plane_albedo must be 30, got 29"},
         {"ShortTransmittance", [](Table& t) { t.diffuse_transmittance.pop_back(); },
          "diffuse_transmittance must be 30, got 29"},
         {"ShortSphericalAlbedo", [](Table& t) { t.spherical_albedo.pop_back(); },
          "spherical_albedo must be 15, got 14"},
         {"ShortExponents", [](Table& t) { t.diffusion_exponent.pop_back(); },
          "diffusion_exponent must be 3, got 2"},
         {"NoExponents", [](Table& t) { t.diffusion_exponent.clear(); },
          "diffusion_exponent must be 3, got 0"},
         {"ReflectionNotANumber", [](Table& t) { t.reflection_multiple[17] = NAN; },
          "reflection_multiple (sample 17) must be finite, got nan"},
         {"TransmissionInfinite", [](Table& t) { t.transmission_multiple[3] = -float_infinity; },
          "transmission_multiple (sample 3) must be finite, got -inf"},
         {"FluxNotANumber", [](Table& t) { t.spherical_albedo[2] = NAN; },
          "spherical_albedo (sample 2) must be finite, got nan"}}),
    row_name);

INSTANTIATE_TEST_SUITE_P(
    Numbers, PrepareRefuses,
    testing::ValuesIn<Refused>(
        {{"NegativeExponent", [](Table& t) { t.diffusion_exponent[1] = -1e-9; },
          "diffusion_exponent must be in [0, 1000], got -1e-09"},
         {"HugeExponent", [](Table& t) { t.diffusion_exponent[1] = 1001; },
          "diffusion_exponent must be in [0, 1000], got 1001"},
         {"NoLength", [](Table& t) { t.extrapolation_length = 0; },
          "extrapolation_length must be in (0, inf), got 0"},
         {"LengthNotANumber", [](Table& t) { t.extrapolation_length = NAN; },
          "extrapolation_length must be in (0, inf), got nan"},
         {"NegativeTolerance", [](Table& t) { t.tolerance = -1; },
          "tolerance must be in [0, inf), got -1"},
         {"ErrorNotANumber", [](Table& t) { t.measured_error = NAN; },
          "measured_error must be in [0, inf), got nan"},
         {"WhiterThanWhite",
          [](Table& t) {
              t.transmission_multiple.clear();
              t.lower_boundary = LowerBoundary::surface(1.01);
          },
          "lower boundary must be in [0, 1], got 1.01"},
         {"TransmissionThroughGround",
          [](Table& t) { t.lower_boundary = LowerBoundary::surface(0.5); },
          "transmission_multiple must be absent over a lower boundary, got given"},
         {"NegativeOrder", [](Table& t) { t.highest_order = -2; },
          "highest_order must be at least 0, got -2"}}),
    row_name);

}  // namespace
}  // namespace stratus
