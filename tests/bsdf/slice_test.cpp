#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/lookup.h>

#include "instruction_sets.h"
#include "bsdf/slice_parts.h"
#include "directions.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr double single_precision = 2e-6;  // of some thirty operations in float

const PhaseFunction& any_phase() {
    static const PhaseFunction phase = parse_phase_function(
        "0.3*rayleigh + 0.3*henyey_greenstein:g=0.7 + 0.4*henyey_greenstein:g=-0.3");
    return phase;
}

/// Largest difference of single scattering from the closed form in double precision, relative.
double single_error(const PhaseFunction& phase, double tau, double w) {
    const Slice slice(phase, {{tau}, {w}});
    double largest = 0;
    for (const Direction& at : random_directions(2000)) {
        const Geometry g = at.geometry();
        const double R =
            single_reflection(phase(cos_scattering_angle_reflected(g)), w, tau, g.mu_in, g.mu_out);
        const double T = single_transmission(phase(cos_scattering_angle_transmitted(g)), w, tau,
                                             g.mu_in, g.mu_out);
        largest = std::max(largest, std::abs(reflected(slice, at) - R) / R);
        // In single precision exp(-x) is only known to 1e-7 x.
        const double lost = 1e-7 * tau / std::max(g.mu_in, g.mu_out);
        if (lost < 5e-6 && T > 1e-30)
            largest = std::max(largest, std::abs(transmitted(slice, at) - T) / T - lost);
    }
    return largest;
}

TEST(Slice, IsSingleScatteringWithoutATable) {
    for (const double tau : {1e-12, 1e-3, 0.3, 2.0, 40.0})
        for (const char* const text :
             {"isotropic", "rayleigh", "henyey_greenstein:g=0.75",
              "0.6*henyey_greenstein:g=-0.5 + 0.4*henyey_greenstein:g=0.5"})
            EXPECT_LT(single_error(parse_phase_function(text), tau, 0.8), 4 * single_precision)
                << text << " tau " << tau;
    EXPECT_LT(single_error(any_phase(), 1, 1), 4 * single_precision);
    EXPECT_LT(single_error(parse_phase_function("0.5*lambert_sphere + 0.5*isotropic"), 1, 0.5),
              4 * single_precision);
}

TEST(Slice, IsRightAtTheLimitsOfDepthAndAlbedo) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
    const Slice empty(phase, {{0}, {1}}), black(phase, {{2}, {0}}),
        semi_infinite(phase, {{infinity}, {1}});
    for (const Direction& at : random_directions(100, 1e-6f)) {
        EXPECT_EQ(reflected(empty, at), 0);
        EXPECT_EQ(transmitted(empty, at), 0);
        EXPECT_EQ(reflected(black, at), 0);
        EXPECT_EQ(transmitted(black, at), 0);
        EXPECT_EQ(transmitted(semi_infinite, at), 0);
        const Geometry g = at.geometry();
        const double R = single_reflection(phase(cos_scattering_angle_reflected(g)), 1, infinity,
                                           g.mu_in, g.mu_out);
        EXPECT_NEAR(reflected(semi_infinite, at), R, 1e-5 * R);
    }
}

TEST(Slice, IsFiniteAtGrazingAndInvalidDirections) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, true});
    const Slice slice = bind(table.view(), 3, 0.9);
    for (const float mu : {0.0f, 1e-30f, 1e-7f, -1.0f, 1.0f, 2.0f, NAN})
        for (const float azimuth : {0.0f, -1.0f, 3.2f, 1e4f}) {
            EXPECT_TRUE(std::isfinite(slice.reflection(std::isnan(mu) ? 0.5f : mu, 0.5f, azimuth)))
                << mu;
            EXPECT_TRUE(
                std::isfinite(slice.transmission(0.5f, std::isnan(mu) ? 0.5f : mu, azimuth)))
                << mu;
            slice.reflection(mu, mu, azimuth);  // indices in range: checked by the sanitizers
        }
}

TEST(Slice, HasOnlyTheRequestedEffects) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    const auto bound = [&](bool single, bool multiple, bool reflection, bool transmission) {
        return bind(table.view(), 2, 0.9,
                    {.single = single,
                     .multiple = multiple,
                     .reflection = reflection,
                     .transmission = transmission});
    };
    const Slice all = bound(true, true, true, true), single = bound(true, false, true, true),
                multiple = bound(false, true, true, true), lit = bound(true, true, true, false),
                far = bound(true, true, false, true), none = bound(false, false, true, true);
    for (const Direction& at : random_directions(200)) {
        const auto R = [&](const Slice& slice) { return reflected(slice, at); };
        const auto T = [&](const Slice& slice) { return transmitted(slice, at); };
        EXPECT_NEAR(R(single) + R(multiple), R(all), single_precision * R(all));
        EXPECT_NEAR(T(single) + T(multiple), T(all), single_precision * T(all));
        EXPECT_GT(R(multiple), 0);
        EXPECT_GT(T(multiple), 0);
        EXPECT_EQ(R(lit), R(all));
        EXPECT_EQ(T(lit), 0);
        EXPECT_EQ(R(far), 0);
        EXPECT_EQ(T(far), T(all));
        EXPECT_EQ(R(none), 0);
        EXPECT_EQ(T(none), 0);
    }
    EXPECT_LT(single.bytes(), 1200u);  // itself
    EXPECT_LT(lit.bytes(), all.bytes());
}

TEST(Slice, WithDensityIsASliceOfTheEffectiveOpticalDepth) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    const Slice slice = bind(table.view(), 2, 0.9, {.density = 0.2}),
                effective = bind(table.view(), 2.5, 0.9);
    for (const Direction& at : random_directions(100)) {  // every order, both sides, the beam
        EXPECT_EQ(reflected(slice, at), reflected(effective, at));
        EXPECT_EQ(transmitted(slice, at), transmitted(effective, at));
        EXPECT_EQ(slice.direct(at.mu_in), effective.direct(at.mu_in));
    }
}

TEST(Slice, AppliesOppositionToSingleReflectionOnly) {
    const Table table = plain_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    const double tau = 2, w = 0.9;
    const Slice plain = bind(table.view(), tau, w);
    for (const Opposition& opposition : {Opposition::blinn(0.3), Opposition::hapke(0.8, 0.06)}) {
        const Slice bright = bind(table.view(), tau, w, {.opposition = opposition});
        for (const Direction& at : random_directions(500)) {
            const Geometry g = at.geometry();
            const double c = cos_scattering_angle_reflected(g);
            const double once =
                single_reflection(table.phase_function(c), w, tau, g.mu_in, g.mu_out);
            const double factor = opposition_factor(opposition, c, tau, g.mu_in, g.mu_out);
            const double expected = reflected(plain, at) + once * (factor - 1);
            // Straight lines between samples of the phase function with its bump, or of Blinn's law.
            const bool of_blinn = opposition.law == Opposition::Law::blinn;
            const double accuracy = c < -0.9999 || of_blinn ? 1e-3 : 2e-5;
            EXPECT_NEAR(reflected(bright, at), expected, accuracy * expected);
            EXPECT_EQ(transmitted(bright, at), transmitted(plain, at));
        }
    }
}

TEST(Slice, KeepsHigherOrdersWithoutAzimuthUnderOpposition) {
    const Table table = smooth_table(false);
    const double tau = 2, w = 0.9;
    Effects multiple, opposed, once;
    multiple.single = false;
    opposed.opposition = once.opposition = Opposition::blinn(0.3);
    once.multiple = false;
    const Slice plain = bind(table.view(), tau, w, multiple);
    const Slice bright = bind(table.view(), tau, w, opposed);
    const Slice bright_once = bind(table.view(), tau, w, once);
    const auto tolerance = static_cast<float>(table.tolerance);  // both are refined to it, unlike
    for (const Direction& at : random_directions(500)) {
        const float total = reflected(bright, at);
        EXPECT_NEAR(total - reflected(bright_once, at), reflected(plain, at), tolerance * total);
    }
}

TEST(Slice, TakesItsOppositionFromTheDensity) {
    const PhaseFunction phase = PhaseFunction::rayleigh();
    const Medium<1> medium{{3}, {0.9}};
    for (const Opposition& opposition : {Opposition::blinn(), Opposition::hapke(0.8)}) {
        Effects effects{.density = 0.2, .opposition = opposition};
        const Slice of_density(phase, medium, effects);
        effects.density = 0;
        effects.opposition = seen_opposition(opposition, 0.2);
        const Slice as_seen(phase, {{3 / 0.8}, {0.9}}, effects);
        for (const Direction& at : random_directions(100))
            EXPECT_EQ(reflected(of_density, at), reflected(as_seen, at));
    }
}

TEST(Slice, HasTheFullOppositionPeakAtEqualVectors) {
    Effects effects;
    effects.opposition = Opposition::hapke(1, 0.05);
    const PhaseFunction phase = PhaseFunction::isotropic();
    const Slice bright(phase, {{2}, {0.9}}, effects), plain(phase, {{2}, {0.9}});
    const Vectors v = vectors_of({0.3f, 0.3f, 0}, true);
    EXPECT_NEAR(bright.eval(v.wi, v.wi), 2 * plain.eval(v.wi, v.wi), 1e-4 * plain.eval(v.wi, v.wi));
    effects.opposition = Opposition::blinn(0.01);
    const double once = 1 + std::tanh(2 / (2 * double{v.wi.z}));  // [Blinn82] 5.2
    EXPECT_NEAR(Slice(phase, {{2}, {0.9}}, effects).eval(v.wi, v.wi) / plain.eval(v.wi, v.wi), once,
                single_precision);
}

TEST(Slice, KnowsPhaseAnglesNearZeroFromAnAzimuth) {
    const PhaseFunction phase = PhaseFunction::isotropic();
    const Slice plain(phase, {{2}, {0.9}});
    for (const Opposition& opposition : {Opposition::hapke(1, 1e-3), Opposition::blinn(1e-3)}) {
        const Slice bright(phase, {{2}, {0.9}}, {.opposition = opposition});
        for (const double from_pi : {0.0, 5e-4, 2e-3, 0.01})
            for (int n = 1; n < 40; ++n) {
                const double mu = n / 40.0;
                const auto cosine = static_cast<float>(mu),
                           azimuth = static_cast<float>(pi - from_pi);
                const Geometry at{double{cosine}, double{cosine}, pi - from_pi};
                EXPECT_NEAR(bright.reflection(cosine, cosine, azimuth) /
                                plain.reflection(cosine, cosine, azimuth),
                            opposition_factor(opposition, cos_scattering_angle_reflected(at), 2,
                                              at.mu_in, at.mu_out),
                            2e-3)
                    << "mu " << mu << ", " << from_pi << " from straight back";
            }
    }
}

TEST(Slice, OverALowerBoundaryOnlyReflects) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.3);
    Table table = empty_table({3, 4, 6, 6, 13}, {0.5, 8, false});
    table.reflection_multiple =
        tabulate(table, [](const SamplePoint& p) { return 0.1 + 0.05 * std::cos(p.azimuth); });
    for (const LowerBoundary& boundary :
         {LowerBoundary::surface(0.4), LowerBoundary::layer(PhaseFunction::rayleigh(), 0.7)}) {
        table.lower_boundary = boundary;
        prepare(table);
        for (const double tau : {0.5, 2.0}) {
            const Slice slice = bind(table.view(), tau, 0.9);
            for (const Direction& at : random_directions(300, 0.02f)) {
                const double expected = reflection(table.view(), 0.9, tau, at.geometry()).total();
                EXPECT_NEAR(reflected(slice, at), expected, 1e-3 * expected);
                EXPECT_EQ(transmitted(slice, at), 0);
                EXPECT_EQ(slice.direct(at.mu_in), 0);
            }
            const Vectors up = vectors_of({0.4f, 0.6f, 1}, true);
            EXPECT_GT(slice.eval(up.wi, up.wo), 0);
            EXPECT_EQ(slice.eval({up.wi.x, up.wi.y, -up.wi.z}, {up.wo.x, up.wo.y, -up.wo.z}), 0);
        }
    }
}

/// A smooth table of such a tolerance that a slice interpolates cosines by cubics.
Table fine_table(bool with_azimuth) {
    Table table = smooth_table(with_azimuth);
    table.tolerance = 1e-5;
    return table;
}

TEST(Slice, HasNothingOfASideThatTheTableLacks) {
    Table table = smooth_table(true);
    table.transmission_multiple.clear();
    const Slice slice(table.view(), {{0.7}, {0.9}});
    EXPECT_EQ(slice.transmission(0.4f, 0.7f, 1), 0);
    EXPECT_GT(slice.reflection(0.4f, 0.7f, 1), 0);
    EXPECT_GT(bind(table.view(), 0.7, 0.9, {.multiple = false}).transmission(0.4f, 0.7f, 1), 0);
}

TEST(Slice, OfAStackWithoutEndTransmitsNothing) {
    const StackLayers stack{{any_phase(), 0.9, 0.3}, {PhaseFunction::rayleigh(), 0.5, infinity}};
    const Slice slice(stack, Effects{});
    EXPECT_EQ(slice.transmission(1, 1, 0), 0);
    EXPECT_EQ(slice.transmission(0.4f, 0.7f, 1), 0);
    EXPECT_NEAR(slice.reflection(0.4f, 0.7f, 1),
                stack_single_scattering(Side::reflection, stack, {0.4, 0.7, 1}), 1e-6);
}

TEST(Slice, IsSymmetricToTheLastBit) {
    for (const Table& table : {smooth_table(true), fine_table(true)}) {
        const Slice slice = bind(table.view(), 1, 0.9);
        for (const Direction& at : random_directions(500)) {
            for (const bool same_side : {true, false}) {
                const Vectors v = vectors_of(at, same_side);
                EXPECT_FLOAT_EQ(slice.eval(v.wi, v.wo), slice.eval(v.wo, v.wi));
            }
        }
    }
}

/// The share of random directions at which a slice of (depth 1, albedo 0.9) misses its table by more than the
/// tolerance.
double missed_share(const TableView& view, double tolerance) {
    const Slice slice = bind(view, 1, 0.9);
    constexpr int count = 4000;
    int missed = 0;
    for (const Direction& at : random_directions(count)) {
        const double R = reflection(view, 0.9, 1, at.geometry()).total(),
                     T = transmission(view, 0.9, 1, at.geometry()).total();
        missed += std::abs(double{reflected(slice, at)} - R) > tolerance * R ? 1 : 0;
        missed += std::abs(double{transmitted(slice, at)} - T) > tolerance * T ? 1 : 0;
    }
    return missed / (2.0 * count);
}

TEST(Slice, MeetsTheToleranceOfAnyTable) {
    for (const bool with_azimuth : {true, false})
        for (const double tolerance : {1e-2, 1e-3, 3e-4, 1e-4, 3e-5}) {
            Table table = smooth_table(with_azimuth);
            table.tolerance = tolerance;
            EXPECT_LE(missed_share(table.view(), tolerance), 2e-3) << tolerance;
        }
}

TEST(Slice, HoldsArcsNarrowerThanTheAzimuthsFirstProbed) {
    for (const double centre : {2.2, 2.5, 2.7}) {
        Table table = empty_table({2, 2, 8, 8, 129}, {0.5, 2, false});
        table.tolerance = 1e-3;
        fill(table, [&](const SamplePoint& p) {
            const double x = (p.azimuth - centre) / 0.1;
            return 1 + 0.05 * std::exp(-x * x);
        });
        EXPECT_LE(missed_share(table.view(), table.tolerance), 2e-3) << centre;
    }
}

TEST(Slice, AgreesBetweenVectorsAndAngles) {
    const Table table = smooth_table(true);
    const Slice slice = bind(table.view(), 1, 0.9);
    for (const Direction& at : random_directions(500, 0.02f)) {
        const Vectors above = vectors_of(at, true), through = vectors_of(at, false);
        const double R = double{reflected(slice, at)} / pi;
        const double T = double{transmitted(slice, at)} / pi;
        // The azimuth of nearly upright vectors is known to 1e-7 over their sines.
        EXPECT_NEAR(slice.eval(above.wi, above.wo), R, 2e-4 * R);
        EXPECT_NEAR(slice.eval(through.wi, through.wo), T, 2e-4 * T);
        const auto flipped = [](Vector v) { return Vector{v.x, v.y, -v.z}; };
        EXPECT_EQ(slice.eval(flipped(above.wi), flipped(above.wo)), slice.eval(above.wi, above.wo));
    }
    EXPECT_EQ(slice.eval({1, 0, 0}, {0, 0, 1}), 0);  // along the surface
}

TEST(RgbSlice, IsThreeSlices) {
    const Table smooth = smooth_table(true), fine = fine_table(true);
    const std::pair<const Table*, Opposition> cases[] = {
        {&smooth, {}}, {&smooth, Opposition::blinn(0.2)}, {&fine, {}}};
    for (const auto& [each, opposition] : cases) {
        const Table& table = *each;
        const Effects effects{.opposition = opposition};
        const RgbSlice rgb = bind_rgb(table.view(), {0.1, 2, 5}, {0.6, 0.9, 1}, effects);
        const Slice channel[3] = {bind(table.view(), 0.1, 0.6, effects),
                                  bind(table.view(), 2, 0.9, effects),
                                  bind(table.view(), 5, 1, effects)};
        for (const Direction& at : random_directions(300, 0.02f)) {
            const Rgb R = reflected(rgb, at);
            const Rgb T = transmitted(rgb, at);
            const float found[3][2] = {{R.r, T.r}, {R.g, T.g}, {R.b, T.b}};
            for (int c = 0; c < 3; ++c) {  // channels share the finest of their axes
                const float expected[2] = {reflected(channel[c], at), transmitted(channel[c], at)};
                for (int side = 0; side < 2; ++side)
                    EXPECT_NEAR(found[c][side], expected[side], table.tolerance * expected[side]);
            }
        }
    }
}

/// The rounding of x in exp(-x), which faint light is in proportion to.
float rounding_of_exponent(float light) {
    return light > 0 ? std::max(0.0f, -std::log(light)) * std::numeric_limits<float>::epsilon() : 0;
}

template <int channels>
void expect_batches_to_agree(const SliceOf<channels>& slice) {
    const std::vector<Direction> directions = random_directions(1003);  // no multiple of any width
    const std::size_t count = directions.size();
    std::vector<float> in, out, azimuth, found(channels * count), xyz[6];
    std::vector<Vectors> vectors;
    for (std::size_t i = 0; i < count; ++i) {
        in.push_back(directions[i].mu_in);
        out.push_back(directions[i].mu_out);
        azimuth.push_back(directions[i].azimuth);
        vectors.push_back(vectors_of(directions[i], i % 3 != 0));
        Vectors& v = vectors.back();
        if (i % 5 == 0) {  // from below
            v.wi.z = -v.wi.z;
            v.wo.z = -v.wo.z;
        }
        if (i % 29 == 0) v.wo.z = 0;
        const float numbers[6] = {v.wi.x, v.wi.y, v.wi.z, v.wo.x, v.wo.y, v.wo.z};
        for (int d = 0; d < 6; ++d) xyz[d].push_back(numbers[d]);
    }
    const auto expect_equal_first = [&](std::size_t some, const auto& one_by_one,
                                        float at_ends = 1e-6f) {
        for (std::size_t i = 0; i < some; ++i) {
            const bool at_end = directions[i].azimuth == 0 || directions[i].azimuth > 3.14159f;
            const float within = at_end ? at_ends : 1e-6f;
            const auto expected = one_by_one(i);
            float channel[channels];
            std::memcpy(channel, &expected, sizeof channel);
            for (std::size_t c = 0; c < channels; ++c)
                EXPECT_NEAR(found[c * some + i], channel[c],
                            (within + rounding_of_exponent(channel[c])) * channel[c])
                    << i;
        }
    };
    const auto expect_equal = [&](const auto& one_by_one) {
        expect_equal_first(count, one_by_one);
    };
    slice.reflection(count, in.data(), out.data(), azimuth.data(), found.data());
    expect_equal([&](std::size_t i) { return slice.reflection(in[i], out[i], azimuth[i]); });
    slice.transmission(count, in.data(), out.data(), azimuth.data(), found.data());
    expect_equal([&](std::size_t i) { return slice.transmission(in[i], out[i], azimuth[i]); });
    const float* const wi[3] = {xyz[0].data(), xyz[1].data(), xyz[2].data()};
    const float* const wo[3] = {xyz[3].data(), xyz[4].data(), xyz[5].data()};
    // Where vectors have the azimuth 0 or pi, it is known to 5e-4 alone: its cosine is rounded, by
    // how much is up to the processor. R and T may then differ by 1 % of the tolerance.
    constexpr float of_rounded_azimuth = 0.01f * 1e-3f;
    for (const std::size_t some : {1u, 15u, 16u, 17u, 255u, 257u, 1003u}) {
        slice.eval(some, wi, wo, found.data());
        expect_equal_first(
            some, [&](std::size_t i) { return slice.eval(vectors[i].wi, vectors[i].wo); },
            of_rounded_azimuth);
    }
    slice.eval(0, wi, wo, nullptr);  // an empty batch
}

TEST(Slice, AgreesBetweenBatchesAndSingleCalls) {
    const Table table = smooth_table(true), isotropic = smooth_table(false),
                fine = fine_table(true), fine_isotropic = fine_table(false);
    for (const auto widest : instruction_sets) {
        const InstructionSetLimit limit(widest);
        expect_batches_to_agree(bind(table.view(), 1, 0.9));
        expect_batches_to_agree(bind(isotropic.view(), 1, 0.9));
        expect_batches_to_agree(bind(fine.view(), 1, 0.9));
        expect_batches_to_agree(bind(fine_isotropic.view(), 1, 0.9));
        expect_batches_to_agree(bind_rgb(fine.view(), {0.5, 2, 5}, {0.6, 0.9, 1}));
    }
    expect_batches_to_agree(bind_rgb(table.view(), {0.5, 2, 5}, {0.6, 0.9, 1}));
    expect_batches_to_agree(Slice(any_phase(), {{2}, {0.9}}));
    Effects effects;
    effects.opposition = Opposition::blinn(0.2);
    expect_batches_to_agree(bind_rgb(table.view(), {0.5, 2, 5}, {0.6, 0.9, 1}, effects));
    effects.reflection = false;
    expect_batches_to_agree(bind(table.view(), 1, 0.9, effects));
}

// What docs/runtime.md says of the samples of a slice, read from them.

/// The coordinate of cosines, and its inverse by bisection.
double v_of(double mu) { return std::sqrt(1 - mu) * (1 - std::pow(mu, 0.25) / 2); }

double mu_of(double v) {
    double low = 0, high = 1;
    for (int i = 0; i < 100; ++i) {
        const double middle = (low + high) / 2;
        (v_of(middle) > v ? low : high) = middle;
    }
    return (low + high) / 2;
}

TEST(SliceLayout, IsAsDocumented) {
    constexpr double albedo = 0.9, depth = 1.3;
    const Table table = smooth_table(true);
    const TableView view = table.view();
    const RefinedSamples slice =
        refine(view, {{layer_blend(view, Side::reflection, albedo, depth), {}}},
               [](int, double, double, double) { return 0.1; });
    ASSERT_TRUE(slice.symmetric && !slice.cubic);
    ASSERT_GE(slice.columns, 17);
    ASSERT_LE(slice.columns, 145);
    ASSERT_GE(slice.azimuths, 7);
    ASSERT_LE(slice.azimuths, 515);
    const int last = slice.columns - 1, last_azimuth = slice.azimuths - 3;
    const double first_v = v_of(view.mu_in.highest), last_v = v_of(view.mu_in.lowest);
    std::size_t row = 0;  // where it starts
    for (int i = 0; i <= last; ++i) {
        const double mu = mu_of(first_v + (last_v - first_v) * i / last);
        for (int j = 0; j <= i; j += std::max(1, i / 3)) {
            const double other = mu_of(first_v + (last_v - first_v) * j / last);
            for (int k = -1; k <= last_azimuth; ++k) {  // -1: before azimuth 0, as after it
                const double azimuth =
                    2 * std::asin(std::min(1.0, static_cast<double>(std::abs(k)) / last_azimuth));
                const std::size_t at =
                    (row + static_cast<std::size_t>(j)) * static_cast<std::size_t>(slice.azimuths) +
                    static_cast<std::size_t>(k + 1);
                const double R = static_cast<double>(slice.sample.at(at)) *
                                 intercepted_share(depth, mu) * intercepted_share(depth, other);
                const double expected =
                    reflection(view, albedo, depth, {mu, other, azimuth}).multiple;
                EXPECT_NEAR(R, expected, 2e-5 * expected) << mu << ' ' << other << ' ' << azimuth;
            }
        }
        row += static_cast<std::size_t>(i + 2);  // columns 0 to i + 1
    }
}

}  // namespace
}  // namespace stratus
