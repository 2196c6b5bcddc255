#include <stratus/runtime/slice.h>

#include <stratus/runtime/constants.h>
#include <stratus/runtime/lookup.h>

#include "refusal.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

namespace stratus {
namespace {

constexpr double single_precision = 2e-6;  // of some thirty operations in float

struct Direction {
    float mu_in, mu_out, azimuth;

    Geometry geometry() const { return {double{mu_in}, double{mu_out}, double{azimuth}}; }
};

std::vector<Direction> random_directions(int count, float min_cosine = 0.001f) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> share(0, 1);
    const auto cosine = [&] { return min_cosine + (1 - min_cosine) * share(random); };
    std::vector<Direction> directions{
        {1, 1, 0}, {1, 0.5f, 1}, {0.5f, 0.5f, 0}, {0.3f, 0.3f, 3.1415926f}};
    while (static_cast<int>(directions.size()) < count)
        directions.push_back({cosine(), cosine(), 3.1415926f * share(random)});
    return directions;
}

/// Both vectors above the layer, or wo beneath it.
struct Vectors {
    Vector wi, wo;
};

Vectors vectors_of(const Direction& at, bool same_side, double turned = 0.7) {
    const auto sine = [](float mu) { return std::sqrt((1 - double{mu}) * (1 + double{mu})); };
    // Light travels along -wi: its azimuth is that of wi and half a turn.
    const double phi_in = turned, phi_out = turned + pi + double{at.azimuth};
    return {{static_cast<float>(sine(at.mu_in) * std::cos(phi_in)),
             static_cast<float>(sine(at.mu_in) * std::sin(phi_in)), at.mu_in},
            {static_cast<float>(sine(at.mu_out) * std::cos(phi_out)),
             static_cast<float>(sine(at.mu_out) * std::sin(phi_out)),
             same_side ? at.mu_out : -at.mu_out}};
}

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
        largest =
            std::max(largest, std::abs(slice.reflection(at.mu_in, at.mu_out, at.azimuth) - R) / R);
        // In single precision exp(-x) is only known to 1e-7 x.
        const double lost = 1e-7 * tau / std::max(g.mu_in, g.mu_out);
        if (lost < 5e-6 && T > 1e-30)
            largest = std::max(
                largest,
                std::abs(slice.transmission(at.mu_in, at.mu_out, at.azimuth) - T) / T - lost);
    }
    return largest;
}

TEST(Slice, GivesSingleScatteringWithNoTable) {
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

TEST(Slice, ReachesTheLimitsOfDepthAndAlbedo) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
    const Slice empty(phase, {{0}, {1}}), black(phase, {{2}, {0}}),
        endless(phase, {{infinity}, {1}});
    for (const Direction& at : random_directions(100, 1e-6f)) {
        EXPECT_EQ(empty.reflection(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_EQ(empty.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_EQ(black.reflection(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_EQ(black.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_EQ(endless.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
        const Geometry g = at.geometry();
        const double R = single_reflection(phase(cos_scattering_angle_reflected(g)), 1, infinity,
                                           g.mu_in, g.mu_out);
        EXPECT_NEAR(endless.reflection(at.mu_in, at.mu_out, at.azimuth), R, 1e-5 * R);
    }
}

TEST(Slice, StaysFiniteAtGrazingAndAtNonsense) {
    Table table = empty_table({4, 4, 6, 6, 5}, {0.5, 8, true});
    table.reflection_multiple = samples_of(table, small_table_reflection_scale);
    table.transmission_multiple = samples_of(table, small_table_transmission_scale);
    prepare(table);
    const Slice slice = bind(table.view(), 3, 0.9);
    for (const float mu : {0.0f, 1e-30f, 1e-7f, -1.0f, 1.0f, 2.0f, std::nanf("")})
        for (const float azimuth : {0.0f, -1.0f, 3.2f, 1e4f}) {
            EXPECT_TRUE(std::isfinite(slice.reflection(std::isnan(mu) ? 0.5f : mu, 0.5f, azimuth)))
                << mu;
            EXPECT_TRUE(
                std::isfinite(slice.transmission(0.5f, std::isnan(mu) ? 0.5f : mu, azimuth)))
                << mu;
            slice.reflection(mu, mu, azimuth);  // and no index leaves the table: sanitizers look on
        }
}

// ---- effects

TEST(Slice, GivesOnlyWhatIsAskedFor) {
    Table table = empty_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    table.reflection_multiple = samples_of(table, small_table_reflection_scale);
    table.transmission_multiple = samples_of(table, small_table_transmission_scale);
    prepare(table);
    const auto bound = [&](bool single, bool multiple, bool reflection, bool transmission) {
        Effects effects;
        effects.single = single;
        effects.multiple = multiple;
        effects.reflection = reflection;
        effects.transmission = transmission;
        return bind(table.view(), 2, 0.9, effects);
    };
    const Slice all = bound(true, true, true, true), single = bound(true, false, true, true),
                multiple = bound(false, true, true, true), lit = bound(true, true, true, false),
                far = bound(true, true, false, true), none = bound(false, false, true, true);
    for (const Direction& at : random_directions(200)) {
        const auto R = [&](const Slice& slice) {
            return slice.reflection(at.mu_in, at.mu_out, at.azimuth);
        };
        const auto T = [&](const Slice& slice) {
            return slice.transmission(at.mu_in, at.mu_out, at.azimuth);
        };
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
    EXPECT_LT(single.bytes(), 1000u);
    EXPECT_LT(lit.bytes(), all.bytes());
}

TEST(Slice, WithDensityIsADeeperSlice) {
    Table table = empty_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    table.reflection_multiple = samples_of(table, small_table_reflection_scale);
    table.transmission_multiple = samples_of(table, small_table_transmission_scale);
    prepare(table);
    Effects dense;
    dense.density = 0.2;
    const Slice slice = bind(table.view(), 2, 0.9, dense), deeper = bind(table.view(), 2.5, 0.9);
    for (const Direction& at : random_directions(100)) {  // every order, both sides, the beam
        EXPECT_EQ(slice.reflection(at.mu_in, at.mu_out, at.azimuth),
                  deeper.reflection(at.mu_in, at.mu_out, at.azimuth));
        EXPECT_EQ(slice.transmission(at.mu_in, at.mu_out, at.azimuth),
                  deeper.transmission(at.mu_in, at.mu_out, at.azimuth));
        EXPECT_EQ(slice.direct(at.mu_in), deeper.direct(at.mu_in));
    }
}

TEST(Slice, LetsOppositionActOnSingleReflectionAlone) {
    Table table = empty_table({4, 4, 6, 6, 5}, {0.5, 8, false});
    table.reflection_multiple = samples_of(table, small_table_reflection_scale);
    table.transmission_multiple = samples_of(table, small_table_transmission_scale);
    prepare(table);
    const double tau = 2, w = 0.9;
    const Slice plain = bind(table.view(), tau, w);
    for (const Opposition& opposition : {Opposition::blinn(0.3), Opposition::hapke(0.8, 0.06)}) {
        Effects effects;
        effects.opposition = opposition;
        const Slice bright = bind(table.view(), tau, w, effects);
        for (const Direction& at : random_directions(500)) {
            const Geometry g = at.geometry();
            const double c = cos_scattering_angle_reflected(g);
            const double once =
                single_reflection(table.phase_function(c), w, tau, g.mu_in, g.mu_out);
            const double factor = opposition_factor(opposition, c, tau, g.mu_in, g.mu_out);
            const double expected =
                plain.reflection(at.mu_in, at.mu_out, at.azimuth) + once * (factor - 1);
            // Straight lines between samples of the phase function with its bump; and from an
            // azimuth in single precision the phase angle is known to 0.03 degrees only.
            const double accuracy = c < -0.9999 ? 1e-3 : 2e-5;
            EXPECT_NEAR(bright.reflection(at.mu_in, at.mu_out, at.azimuth), expected,
                        accuracy * expected);
            EXPECT_EQ(bright.transmission(at.mu_in, at.mu_out, at.azimuth),
                      plain.transmission(at.mu_in, at.mu_out, at.azimuth));
        }
    }
}

TEST(Slice, MeetsOppositionExactlyBetweenVectors) {
    Effects effects;
    effects.opposition = Opposition::hapke(1, 0.05);
    const PhaseFunction phase = PhaseFunction::isotropic();
    const Slice bright(phase, {{2}, {0.9}}, effects), plain(phase, {{2}, {0.9}});
    const Vectors v = vectors_of({0.3f, 0.3f, 0}, true);
    EXPECT_NEAR(bright.eval(v.wi, v.wi), 2 * plain.eval(v.wi, v.wi), 1e-4 * plain.eval(v.wi, v.wi));
}

TEST(Slice, SeesASmallSourceBehindAsBlinnStates) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.6);
    const Slice slice(phase, {{0.7}, {0.8}});
    Effects beam_alone;
    beam_alone.single = false;
    const Slice beam(phase, {{0.7}, {0.8}}, beam_alone);
    for (const double mu : {0.1, 0.5, 1.0}) {
        const auto cosine = static_cast<float>(mu);
        EXPECT_NEAR(slice.source_behind(cosine), source_seen_through(phase(1), 0.8, 0.7, mu), 1e-6);
        EXPECT_NEAR(slice.direct(cosine), std::exp(-0.7 / mu), 1e-7);
        EXPECT_NEAR(beam.source_behind(cosine), std::exp(-0.7 / mu), 1e-7);
        EXPECT_NEAR(beam.background(cosine), std::exp(-0.7 / mu), 1e-7);
    }
}

/// The beam, and T of order 1 over the hemisphere: by the trapezoidal rule over azimuth and Gauss's
/// midpoints over the cosine.
double background_once(const PhaseFunction& phase, double w, double tau, double mu) {
    constexpr int cosines = 2000, azimuths = 200;
    double sum = 0;
    for (int i = 0; i < cosines; ++i)
        for (int k = 0; k < azimuths; ++k) {
            const Geometry at{mu, (i + 0.5) / cosines, pi * (k + 0.5) / azimuths};
            sum += at.mu_out * single_transmission(phase(cos_scattering_angle_transmitted(at)), w,
                                                   tau, at.mu_in, at.mu_out);
        }
    return std::exp(-tau / mu) + 2 * sum / (cosines * azimuths);
}

TEST(Slice, SeesABackgroundByTheBeamAndWhatIsScatteredOnce) {
    for (const double g : {0.0, 0.85, -0.5})
        for (const double tau : {0.01, 1.0, 5.0}) {
            const PhaseFunction phase = PhaseFunction::henyey_greenstein(g);
            const Slice slice(phase, {{tau}, {0.9}});
            for (const double mu : {0.05, 0.2, 0.5, 1.0})
                EXPECT_NEAR(slice.background(static_cast<float>(mu)),
                            background_once(phase, 0.9, tau, mu), 2e-4)
                    << "g " << g << " tau " << tau << " mu " << mu;
        }
}

TEST(Slice, SeesNoMoreThanABackground) {
    for (const double g : {0.0, 0.85, 0.99})
        for (const double tau : {1e-6, 0.01, 1.0, 30.0, infinity}) {
            const Slice slice(PhaseFunction::henyey_greenstein(g), {{tau}, {1}});
            for (float mu = 0.001f; mu < 1; mu += 0.01f) {
                EXPECT_GE(slice.background(mu), 0);
                EXPECT_LE(slice.background(mu), 1) << "g " << g << " tau " << tau << " mu " << mu;
            }
        }
}

TEST(Slice, SeesABackgroundByTheDiffuseTransmittanceOfItsTable) {
    Table table = empty_table({4, 8, 8, 8, 5}, {0.1, 8, false});
    table.reflection_multiple = samples_of(table, small_table_reflection_scale);
    table.transmission_multiple = samples_of(table, small_table_transmission_scale);
    const auto diffuse = [](double w, double tau, double mu) {
        return w * intercepted_share(tau, mu) * 0.5 *
               transmission_scale(tau, small_table_exponent(w), small_table_length);
    };
    for (const double w : table.albedo.values)
        for (const double tau : table.optical_depth.values)
            for (const double mu : table.mu_in.values)
                table.diffuse_transmittance.push_back(static_cast<float>(diffuse(w, tau, mu)));
    prepare(table);
    for (const double w : {0.3, 0.9, 1.0})
        for (const double tau : {0.01, 0.7, 8.0}) {
            const Slice slice = bind(table.view(), tau, w);
            Effects multiple_alone;
            multiple_alone.single = false;
            const Slice without_single = bind(table.view(), tau, w, multiple_alone);
            for (const double mu : {0.02, 0.3, 1.0}) {
                const auto cosine = static_cast<float>(mu);
                const double beam = std::exp(-tau / mu);
                EXPECT_NEAR(slice.background(cosine), beam + diffuse(w, tau, mu), 1e-3);
                const double once = background_once(table.phase_function, w, tau, mu) - beam;
                EXPECT_NEAR(without_single.background(cosine),
                            beam + std::max(0.0, diffuse(w, tau, mu) - once), 2e-3);  // 8 cosines
            }
        }
}

TEST(Slice, SeesTheGroundThroughTheLayer) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.3);
    Table table = empty_table({3, 4, 6, 6, 13}, {0.5, 8, false});
    table.reflection_multiple =
        samples_of(table, [](const Point& p) { return 0.1 + 0.05 * std::cos(p.azimuth); });
    for (const LowerBoundary& boundary :
         {LowerBoundary::surface(0.4), LowerBoundary::layer(PhaseFunction::rayleigh(), 0.7)}) {
        table.lower_boundary = boundary;
        prepare(table);
        for (const double tau : {0.5, 2.0}) {
            const Slice slice = bind(table.view(), tau, 0.9);
            for (const Direction& at : random_directions(300, 0.02f)) {
                const double expected = reflection(table.view(), 0.9, tau, at.geometry()).total();
                EXPECT_NEAR(slice.reflection(at.mu_in, at.mu_out, at.azimuth), expected,
                            1e-3 * expected);
                EXPECT_EQ(slice.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
                EXPECT_EQ(slice.direct(at.mu_in), 0);
            }
            const Vectors up = vectors_of({0.4f, 0.6f, 1}, true);
            EXPECT_GT(slice.eval(up.wi, up.wo), 0);
            EXPECT_EQ(slice.eval({up.wi.x, up.wi.y, -up.wi.z}, {up.wo.x, up.wo.y, -up.wo.z}), 0);
        }
    }
}

// ---- binding

/// A table that is smooth along every axis, as solved ones are.
Table smooth_table(bool with_azimuth) {
    Table table = empty_table({5, 8, 20, 20, with_azimuth ? 13 : 1}, {0.1, 8, true});
    const auto varied = [](const Point& p) {
        return 1 + 0.3 * p.albedo + 0.2 * std::sqrt(p.mu_in + p.mu_out) +
               0.3 * std::sqrt((1 - p.mu_in * p.mu_in) * (1 - p.mu_out * p.mu_out)) *
                   std::cos(p.azimuth);
    };
    table.reflection_multiple = samples_of(
        table, [&](const Point& p) { return small_table_reflection_scale(p) * varied(p); });
    table.transmission_multiple = samples_of(table, [&](const Point& p) {
        return std::isinf(p.optical_depth) ? 0.0 : small_table_transmission_scale(p) * varied(p);
    });
    if (!with_azimuth) table.phase_function = PhaseFunction::isotropic();
    table.tolerance = 1e-3;
    prepare(table);
    return table;
}

class BoundSlice : public testing::TestWithParam<bool> {};

TEST_P(BoundSlice, MeetsTheToleranceOfItsTable) {
    const Table table = smooth_table(GetParam());
    for (const double tau : {0.02, 0.3, 5.0, 100.0, infinity})
        for (const double w : {0.2, 0.9, 1.0}) {
            const Slice slice = bind(table.view(), tau, w);
            for (const Direction& at : random_directions(500, 0.02f)) {
                const double R = reflection(table.view(), w, tau, at.geometry()).total();
                const double T = transmission(table.view(), w, tau, at.geometry()).total();
                EXPECT_NEAR(slice.reflection(at.mu_in, at.mu_out, at.azimuth), R,
                            table.tolerance * R);
                EXPECT_NEAR(slice.transmission(at.mu_in, at.mu_out, at.azimuth), T,
                            table.tolerance * std::max(T, 1e-6));
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Of, BoundSlice, testing::Bool(), [](const auto& info) {
    return std::string(info.param ? "an_anisotropic_table" : "an_isotropic_table");
});

TEST(Slice, GrowsWithTheToleranceItHasToMeet) {
    Table table = smooth_table(true);
    const std::size_t usual = bind(table.view(), 1, 0.9).bytes();
    table.tolerance = 1e-2;
    EXPECT_LT(bind(table.view(), 1, 0.9).bytes(), usual / 3);
}

TEST(Slice, OutlivesItsTable) {
    Slice slice = [] {
        const Table table = smooth_table(true);
        return bind(table.view(), 1, 0.9);
    }();
    const float before = slice.reflection(0.4f, 0.6f, 1);
    const Slice moved = std::move(slice);
    EXPECT_EQ(moved.reflection(0.4f, 0.6f, 1), before);
    EXPECT_GT(before, 0);
}

TEST(Slice, IsSymmetricToTheLastBit) {
    const Table table = smooth_table(true);
    const Slice slice = bind(table.view(), 1, 0.9);
    for (const Direction& at : random_directions(500)) {
        for (const bool same_side : {true, false}) {
            const Vectors v = vectors_of(at, same_side);
            EXPECT_FLOAT_EQ(slice.eval(v.wi, v.wo), slice.eval(v.wo, v.wi));
        }
    }
}

TEST(Slice, EvaluatesVectorsAsItDoesAngles) {
    const Table table = smooth_table(true);
    const Slice slice = bind(table.view(), 1, 0.9);
    for (const Direction& at : random_directions(500, 0.02f)) {
        const Vectors above = vectors_of(at, true), through = vectors_of(at, false);
        const double R = double{slice.reflection(at.mu_in, at.mu_out, at.azimuth)} / pi;
        const double T = double{slice.transmission(at.mu_in, at.mu_out, at.azimuth)} / pi;
        // The azimuth of nearly upright vectors is known to 1e-7 over their sines.
        EXPECT_NEAR(slice.eval(above.wi, above.wo), R, 2e-4 * R);
        EXPECT_NEAR(slice.eval(through.wi, through.wo), T, 2e-4 * T);
        const auto flipped = [](Vector v) { return Vector{v.x, v.y, -v.z}; };
        EXPECT_EQ(slice.eval(flipped(above.wi), flipped(above.wo)), slice.eval(above.wi, above.wo));
    }
    EXPECT_EQ(slice.eval({1, 0, 0}, {0, 0, 1}), 0);  // along the surface
}

TEST(RgbSlice, IsThreeSlicesAtOnce) {
    const Table table = smooth_table(true);
    const RgbSlice rgb = bind_rgb(table.view(), {0.5, 2, 5}, {0.6, 0.9, 1});
    const Slice channel[3] = {bind(table.view(), 0.5, 0.6), bind(table.view(), 2, 0.9),
                              bind(table.view(), 5, 1)};
    for (const Direction& at : random_directions(300, 0.02f)) {
        const Rgb R = rgb.reflection(at.mu_in, at.mu_out, at.azimuth);
        const Rgb T = rgb.transmission(at.mu_in, at.mu_out, at.azimuth);
        const float found[3][2] = {{R.r, T.r}, {R.g, T.g}, {R.b, T.b}};
        for (int c = 0; c < 3; ++c) {  // channels share the finest of their axes
            const float expected[2] = {channel[c].reflection(at.mu_in, at.mu_out, at.azimuth),
                                       channel[c].transmission(at.mu_in, at.mu_out, at.azimuth)};
            for (int side = 0; side < 2; ++side)
                EXPECT_NEAR(found[c][side], expected[side], table.tolerance * expected[side]);
        }
    }
}

// ---- many at once

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
        const Vectors& v = vectors.back();
        const float numbers[6] = {v.wi.x, v.wi.y, v.wi.z, v.wo.x, v.wo.y, v.wo.z};
        for (int d = 0; d < 6; ++d) xyz[d].push_back(numbers[d]);
    }
    const auto expect_equal = [&](const auto& one_by_one) {
        for (std::size_t i = 0; i < count; ++i) {
            const auto expected = one_by_one(i);
            float channel[channels];
            std::memcpy(channel, &expected, sizeof channel);
            for (std::size_t c = 0; c < channels; ++c)
                EXPECT_NEAR(found[c * count + i], channel[c], 1e-6f * channel[c]) << i;
        }
    };
    slice.reflection(count, in.data(), out.data(), azimuth.data(), found.data());
    expect_equal([&](std::size_t i) { return slice.reflection(in[i], out[i], azimuth[i]); });
    slice.transmission(count, in.data(), out.data(), azimuth.data(), found.data());
    expect_equal([&](std::size_t i) { return slice.transmission(in[i], out[i], azimuth[i]); });
    const float* const wi[3] = {xyz[0].data(), xyz[1].data(), xyz[2].data()};
    const float* const wo[3] = {xyz[3].data(), xyz[4].data(), xyz[5].data()};
    slice.eval(count, wi, wo, found.data());
    expect_equal([&](std::size_t i) { return slice.eval(vectors[i].wi, vectors[i].wo); });
    slice.eval(0, wi, wo, nullptr);  // nothing of nothing
}

TEST(Slice, GivesManyTheSameAsOneByOne) {
    const Table table = smooth_table(true), isotropic = smooth_table(false);
    expect_batches_to_agree(bind(table.view(), 1, 0.9));
    expect_batches_to_agree(bind(isotropic.view(), 1, 0.9));
    expect_batches_to_agree(bind_rgb(table.view(), {0.5, 2, 5}, {0.6, 0.9, 1}));
    expect_batches_to_agree(Slice(any_phase(), {{2}, {0.9}}));
    Effects effects;
    effects.opposition = Opposition::blinn(0.2);
    expect_batches_to_agree(bind(table.view(), 1, 0.9, effects));
    effects.reflection = false;
    expect_batches_to_agree(bind(table.view(), 1, 0.9, effects));
}

TEST(Binding, RefusesLayersThatTheTableDoesNotKnow) {
    using Error = std::invalid_argument;
    const Table table = filled({4, 4, 6, 6, 5}, {0.5, 8, false}, small_table_reflection_scale,
                               small_table_transmission_scale);
    const TableView view = table.view();
    expect_refusal<Error>([&] { bind(view, 1, 0.1); },
                          {"bind", "albedo", "0 or in [0.19, 1]", "0.1"});
    expect_refusal<Error>([&] { bind(view, 9, 1); }, {"bind", "optical_depth", "[0, 8]", "9"});
    expect_refusal<Error>([&] { bind(view, infinity, 1); }, {"optical_depth", "inf"});
    expect_refusal<Error>([&] { bind_rgb(view, {1, 1, 9}, {1, 1, 1}); }, {"optical_depth", "9"});
    Effects effects;
    effects.density = 0.5;
    expect_refusal<Error>([&] { bind(view, 5, 1, effects); }, {"optical_depth", "10"});
    effects.multiple = false;
    EXPECT_NO_THROW(bind(view, 5, 1, effects));
    const Table both = mixed(table, table);
    Table part = both;
    part.mixture = make_axis(part.mixture.scale, 0.25, 0.75, 2);
    prepare(part);
    expect_refusal<Error>([&] { bind(part.view().at_mixture(0.1), 1, 1); },
                          {"bind", "mixture", "[0.25, 0.75]", "0.1"});
    Table endless = table;
    endless.optical_depth.values = {infinity};
    endless.reflection_multiple.resize(endless.sample_count());
    endless.transmission_multiple.clear();
    prepare(endless);
    expect_refusal<Error>([&] { bind(endless.view(), 1, 1); }, {"optical_depth", "inf", "1"});
}

TEST(Binding, ClampsToTheNearestLayerOnRequest) {
    const Table table = filled({4, 4, 6, 6, 5}, {0.5, 8, false}, small_table_reflection_scale,
                               small_table_transmission_scale);
    Effects multiple;
    multiple.single = false;
    const Slice edge = bind(table.view(), 8, 1, multiple);
    EXPECT_FALSE(edge.clamped());
    for (const double tau : {100.0, infinity}) {
        const Slice slice = bind(table.view(), tau, 1, multiple, OutsideTable::clamp);
        EXPECT_TRUE(slice.clamped());
        constexpr double refinement = 1e-4;  // is relative to totals, which differ
        EXPECT_NEAR(slice.reflection(0.5f, 0.7f, 1), edge.reflection(0.5f, 0.7f, 1), refinement);
        // A semi-infinite layer transmits nothing.
        EXPECT_NEAR(slice.transmission(0.5f, 0.7f, 1),
                    tau == infinity ? 0 : edge.transmission(0.5f, 0.7f, 1), refinement);
    }
    EXPECT_TRUE(bind(table.view(), 1, 0.1, {}, OutsideTable::clamp).clamped());
    EXPECT_FALSE(bind(table.view(), 1, 0.2, {}, OutsideTable::clamp).clamped());
}

TEST(Binding, ExtendsATableByTheLawsItHas) {
    const Table table = filled({4, 6, 6, 6, 5}, {0.5, 32, false}, small_table_reflection_scale,
                               small_table_transmission_scale);
    const TableView view = table.view();
    for (const Direction& at : random_directions(100, 0.02f)) {
        const Geometry g = at.geometry();
        // Nothing in the layer scatters.
        const Slice black = bind(view, 1, 0);
        EXPECT_EQ(black.reflection(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_EQ(black.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
        EXPECT_FALSE(black.clamped());
        // Thinner than its thinnest.
        const double thin = reflection(view, 0.9, 0.01, g).total();
        EXPECT_NEAR(bind(view, 0.01, 0.9).reflection(at.mu_in, at.mu_out, at.azimuth), thin,
                    1e-3 * thin);
        // Deeper than its deepest, where the law of diffusion is spent.
        const Slice endless = bind(view, infinity, 0.5);
        EXPECT_FALSE(endless.clamped());
        EXPECT_EQ(endless.transmission(at.mu_in, at.mu_out, at.azimuth), 0);
        const double deep = reflection(view, 0.5, 32, g).total();
        EXPECT_NEAR(endless.reflection(at.mu_in, at.mu_out, at.azimuth), deep, 1e-3 * deep);
        const double T = small_table_transmission_scale({0.5, 40, g.mu_in, g.mu_out, g.azimuth});
        EXPECT_NEAR(bind(view, 40, 0.5).transmission(at.mu_in, at.mu_out, at.azimuth), T,
                    1e-2 * T + 1e-12);
    }
    Effects transmission_alone;
    transmission_alone.reflection = false;
    EXPECT_EQ(bind(view, infinity, 1, transmission_alone).transmission(1, 1, 0), 0);
}

TEST(Binding, RefusesWhatIsOutOfRange) {
    using Error = std::invalid_argument;
    Table table = smooth_table(true);
    const TableView view = table.view();
    expect_refusal<Error>([&] { bind(view, -1, 0.5); },
                          {"bind", "optical_depth", "[0, inf]", "-1"});
    expect_refusal<Error>([&] { bind(view, std::nan(""), 0.5); }, {"optical_depth", "nan"});
    expect_refusal<Error>([&] { bind(view, 1, 1.1); }, {"bind", "albedo", "[0, 1]", "1.1"});
    expect_refusal<Error>([&] { bind_rgb(view, {1, 1, 1}, {0.5, -0.1, 0.5}); }, {"albedo", "-0.1"});
    Effects effects;
    effects.density = 1;
    expect_refusal<Error>([&] { bind(view, 1, 0.5, effects); }, {"density", "[0, 1)"});
    Table lopsided = empty_table({3, 3, 6, 5, 5}, {0.5, 8, false});
    lopsided.reflection_multiple = samples_of(lopsided, small_table_reflection_scale);
    prepare(lopsided);
    expect_refusal<Error>([&] { bind(lopsided.view(), 1, 0.5); }, {"mu_out", "mu_in"});
}

}  // namespace
}  // namespace stratus
