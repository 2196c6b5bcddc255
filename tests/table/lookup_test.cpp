#include <stratus/table/lookup.h>

#include <stratus/base/constants.h>

#include "small_table.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

constexpr double float_rounding = 1e-6;  // of samples, weights and 1024 products

Scattered look_up_reflection(const Table& table, const SamplePoint& p) {
    return scattering_at(table, Side::reflection, p);
}

Scattered look_up_transmission(const Table& table, const SamplePoint& p) {
    return scattering_at(table, Side::transmission, p);
}

/// Points at random within albedo [0.19, 1], depths [lowest, highest], cosines [0.01, 1], azimuth
/// [0, pi].
std::vector<SamplePoint> random_points(int count, double lowest, double highest) {
    Uniform share(2024);
    std::vector<SamplePoint> points;
    for (int i = 0; i < count; ++i)
        points.push_back({0.19 + 0.81 * share(), lowest * std::pow(highest / lowest, share()),
                          0.01 + 0.99 * share(), 0.01 + 0.99 * share(), pi * share()});
    return points;
}

/// A cubic in every coordinate but azimuth, between 1 and 10.
double cubic(const SamplePoint& p) {
    const double w = std::sqrt(1 - p.albedo);
    const double depth = p.optical_depth == infinity ? 0 : std::log2(p.optical_depth) / 4;
    const double in = cosine_coordinate(p.mu_in), out = cosine_coordinate(p.mu_out);
    return 3 + w * w * w + depth * (1 - depth * depth) + in * in * (2 - in) +
           out * (1 + out * out) - 0.5 * w * in * out;
}

double scaled_cubic(Side side, const SamplePoint& p) {
    return small_table_scale(side, p) * cubic(p);
}
double transmitted_cubic(const SamplePoint& p) { return scaled_cubic(Side::transmission, p); }

const Counts five_each = {5, 5, 5, 5, 5};
const Depths shallow = {0.5, 8, false};

Table of_cubics() {
    Table table = empty_table(five_each, shallow);
    fill(table, cubic);
    return table;
}

TEST(Lookup, ReproducesSamplesAtTheNodes) {
    const auto uneven = [](const SamplePoint& p) {
        return 1 + std::sin(40 * p.albedo + 9 * p.mu_in + 5 * p.mu_out + 3 * p.azimuth +
                            (p.optical_depth < infinity ? p.optical_depth : 11));
    };
    const Table table = filled({5, 4, 6, 3, 5}, {0.5, 8, true}, uneven, uneven);
    for (const SamplePoint& p : sample_points(table)) {
        EXPECT_NEAR(look_up_reflection(table, p).multiple, uneven(p), float_rounding);
        EXPECT_NEAR(look_up_transmission(table, p).multiple,
                    p.optical_depth < infinity ? uneven(p) : 0, float_rounding);
    }
}

TEST(Lookup, OverALowerBoundaryIsExactForCubicsThemselves) {
    const Table table = over(LowerBoundary::surface(0.3), filled(five_each, shallow, cubic, cubic));
    for (const SamplePoint& p : random_points(2000, 0.5, 8)) {
        const Scattered found = look_up_reflection(table, p);
        EXPECT_NEAR(found.multiple / cubic(p), 1, float_rounding);
        const double phase = table.phase_function(cos_scattering_angle_reflected(geometry(p)));
        EXPECT_DOUBLE_EQ(found.single,
                         single_reflection(phase, p.albedo, p.optical_depth, p.mu_in, p.mu_out) +
                             0.3 * direct_transmittance(p.optical_depth, p.mu_in) *
                                 direct_transmittance(p.optical_depth, p.mu_out));
        EXPECT_EQ(look_up_transmission(table, p).total(), 0);
    }
}

TEST(Lookup, OverALowerBoundaryFollowsTheLawOfDiffusionBeyondTheDeepestSample) {
    const auto nearing = [](const SamplePoint& p) {
        return 2 - reflection_deficit(p.optical_depth, small_table_exponent(p.albedo),
                                      small_table_length);
    };
    const Table table = over(LowerBoundary::layer(PhaseFunction::rayleigh(), 0.9),
                             filled({5, 5, 3, 3, 3}, {0.5, 8, true}, nearing, nearing));
    for (const double w : table.albedo.values)
        for (const double tau : {8.0, 10.0, 40.0, 1e3, infinity}) {
            const SamplePoint p{w, tau, 0.3, 0.8, 1};
            EXPECT_NEAR(look_up_reflection(table, p).multiple, nearing(p), 1e-6) << tau;
        }
}

TEST(Lookup, OverASurfaceFadesBelowTheFirstDepth) {
    const Table table = over(LowerBoundary::surface(0.3), filled(five_each, shallow, cubic, cubic));
    const auto multiple = [&](double tau) {
        return look_up_reflection(table, {0.5, tau, 0.3, 0.8, 1}).multiple;
    };
    const auto taken_out = [](double tau) {
        return intercepted_share(tau, 0.3) + intercepted_share(tau, 0.8);
    };
    EXPECT_EQ(multiple(0), 0);
    EXPECT_NEAR(multiple(0.01) / multiple(0.5), taken_out(0.01) / taken_out(0.5), 1e-6);
    EXPECT_NEAR(multiple(0.5 * (1 - 1e-9)) / multiple(0.5), 1, 1e-6);
}

TEST(Lookup, OverASemiInfiniteLayerStaysAtTheFirstDepthBelowIt) {
    const Table table = over(LowerBoundary::layer(PhaseFunction::rayleigh(), 0.9),
                             filled(five_each, shallow, cubic, cubic));
    EXPECT_EQ(look_up_reflection(table, {0.5, 0.01, 0.3, 0.8, 1}).multiple,
              look_up_reflection(table, {0.5, 0.5, 0.3, 0.8, 1}).multiple);
}

TEST(Lookup, TreatsANullBoundaryAsAbsent) {
    const Table table = of_cubics();
    TableView view = table.view();
    view.lower_boundary = nullptr;
    EXPECT_EQ(reflection(view, 0.5, 1, {0.3, 0.8, 1}).total(),
              look_up_reflection(table, {0.5, 1, 0.3, 0.8, 1}).total());
}

TEST(Lookup, IsExactForCubicsTimesTheDiffusionScale) {
    const Table table = of_cubics();
    for (const SamplePoint& p : random_points(2000, 0.5, 8))
        for (const Side side : both_sides)
            EXPECT_NEAR(scattering_at(table, side, p).multiple / scaled_cubic(side, p), 1,
                        3 * float_rounding);
}

TEST(Lookup, AddsTheClosedFormOfSingleScattering) {
    const Table table = of_cubics();
    for (const SamplePoint& p : random_points(50, 0.5, 8))
        for (const Side side : both_sides) {
            const double phase = table.phase_function(cos_scattering_angle(side, geometry(p)));
            const Scattered found = scattering_at(table, side, p);
            EXPECT_EQ(found.single,
                      single_scattering(side, phase, p.albedo, p.optical_depth, p.mu_in, p.mu_out));
            EXPECT_EQ(found.total(), found.single + found.multiple);
        }
}

TEST(Lookup, FollowsSmoothFunctionsToFourthOrder) {
    const auto smooth = [](const SamplePoint& p) {
        return std::exp(p.albedo / 2 - 0.3 * std::sqrt(p.mu_in)) * (1 + p.mu_out / (1 + p.mu_out)) *
               (1 + 0.3 * std::cos(p.azimuth) * (1 - p.mu_in) * (1 - p.mu_out)) /
               (1 + 0.2 * p.optical_depth);
    };
    const auto worst = [&](int count) {
        Table table = empty_table({count, count, count, count, count}, {0.25, 4, false});
        fill(table, smooth);
        double error = 0;
        for (const SamplePoint& p : random_points(3000, 0.25, 4))
            for (const Side side : both_sides) {
                const double expected = small_table_scale(side, p) * smooth(p);
                error = std::max(error,
                                 std::abs(scattering_at(table, side, p).multiple / expected - 1));
            }
        return error;
    };
    const double coarse = worst(9), fine = worst(17);
    EXPECT_LT(fine, 1e-3);
    EXPECT_GT(coarse / fine, 10);  // 16, were the worst points the same
}

TEST(Lookup, IsEvenAndPeriodicInAzimuth) {
    const auto wavy = [](const SamplePoint& p) { return 2 + std::cos(p.azimuth) + p.mu_in; };
    const Table table = filled({2, 2, 4, 4, 9}, shallow, wavy, wavy);
    SamplePoint p{0.9, 2, 0.4, 0.7, 1.1};
    const Scattered r = look_up_reflection(table, p);
    for (const double same : {-1.1, 2 * pi - 1.1, 2 * pi + 1.1, -4 * pi - 1.1}) {
        p.azimuth = same;
        EXPECT_NEAR(look_up_reflection(table, p).multiple, r.multiple, 1e-6);
        EXPECT_NEAR(look_up_reflection(table, p).single, r.single, 1e-14);
    }
}

TEST(Lookup, IsReciprocalWhenItsSamplesAre) {
    const auto reciprocal = [](const SamplePoint& p) {
        return 1 + 1 / (p.mu_in + p.mu_out) + std::cos(p.azimuth) * p.mu_in * p.mu_out;
    };
    const Table table = filled({3, 3, 7, 7, 7}, shallow, reciprocal, reciprocal);
    for (const SamplePoint& p : random_points(200, 0.5, 8)) {
        const SamplePoint swapped{p.albedo, p.optical_depth, p.mu_out, p.mu_in, p.azimuth};
        const double one = look_up_reflection(table, p).total();
        EXPECT_NEAR(look_up_reflection(table, swapped).total() / one, 1, float_rounding);
    }
}

// ---- beyond the deepest sample

double limit_of(const SamplePoint& p) {
    return 1 + 0.3 * std::sqrt(1 - p.albedo) + 0.2 * cosine_coordinate(p.mu_in);
}
double distance_of(const SamplePoint& p) { return 0.5 + cosine_coordinate(p.mu_out); }

double diffusing(const SamplePoint& p) {
    const double deficit =
        reflection_deficit(p.optical_depth, small_table_exponent(p.albedo), small_table_length);
    return small_table_incidence(p) * (limit_of(p) - distance_of(p) * deficit);
}

TEST(Lookup, FollowsTheDiffusionLawFromTheDeepestSampleToInfinity) {
    // Albedo 0.19: the deficit at tau = 4 is 2.7e-4, just above what float samples can tell.
    const Table table = filled({5, 4, 4, 4, 1}, {0.5, 4, true}, diffusing, transmitted_cubic);
    for (const SamplePoint& p : random_points(2000, 4.0001, 4000))
        EXPECT_NEAR(look_up_reflection(table, p).multiple / diffusing(p), 1, 1e-5);
}

TEST(Lookup, ReachesTheSampleAtInfinity) {
    const Table table = filled({5, 4, 4, 4, 1}, {0.5, 4, true}, diffusing, transmitted_cubic);
    for (SamplePoint p : random_points(50, 1, 2)) {
        p.optical_depth = infinity;
        EXPECT_NEAR(look_up_reflection(table, p).multiple / diffusing(p), 1, float_rounding);
        EXPECT_EQ(look_up_transmission(table, p).total(), 0);
    }
}

TEST(Lookup, DoesNotMagnifyTheRoundingOfDeepSamples) {
    // From tau = 64 on, layers of all albedos but the highest equal their limit to float's last
    // bit.
    const Table table = filled({16, 8, 4, 4, 1}, {0.5, 64, true}, diffusing, transmitted_cubic);
    for (SamplePoint p : random_points(3000, 64.001, 1e6))
        for (const double below_one : {0.0, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2}) {
            p.albedo = 1 - below_one;
            EXPECT_NEAR(look_up_reflection(table, p).multiple / diffusing(p), 1, 3e-5)
                << "1 - albedo " << below_one << " tau " << p.optical_depth;
        }
}

TEST(Lookup, TransmitsThroughDeepLayersByTheDiffusionLaw) {
    const auto law = [](const SamplePoint& p) {
        return small_table_scale(Side::transmission, p) * distance_of(p);
    };
    const Table table = filled({16, 12, 7, 7, 1}, {0.5, 1024, true}, diffusing, law);
    for (const SamplePoint& p : random_points(3000, 0.5, 1e6)) {
        const double scale = small_table_scale(Side::transmission, p);
        if (scale < 1e-34) continue;  // below which it may be 0
        EXPECT_NEAR(look_up_transmission(table, p).multiple / law(p), 1, 1e-5)
            << "albedo " << p.albedo << " tau " << p.optical_depth;
    }
}

TEST(Lookup, ClampsToTheDeepestSampleWithoutOneAtInfinity) {
    const Table table = of_cubics();
    const SamplePoint last{0.7, 8, 0.4, 0.6, 1}, beyond{0.7, infinity, 0.4, 0.6, 1};
    for (const Side side : both_sides)
        EXPECT_EQ(scattering_at(table, side, beyond).multiple,
                  scattering_at(table, side, last).multiple);
}

TEST(Lookup, ReadsATableOfASemiInfiniteLayerAlone) {
    const Table table =
        filled({4, 0, 4, 4, 3}, {1, 1, true}, diffusing, [](const SamplePoint&) { return 0; });
    double before = 0;
    for (const double tau :
         {0.0, 0.5, 3.0, infinity}) {  // all it knows of finite ones is what they intercept
        const double r = look_up_reflection(table, {0.7, tau, 0.4, 0.6, 1}).multiple;
        EXPECT_TRUE(tau == 0 ? r == 0 : r > before) << tau;
        EXPECT_EQ(look_up_transmission(table, {0.7, tau, 0.4, 0.6, 1}).multiple, 0);
        before = r;
    }
    EXPECT_NEAR(before / diffusing({0.7, infinity, 0.4, 0.6, 1}), 1, float_rounding);
}

// ---- outside the other ends

TEST(Lookup, FollowsItsScalesBelowTheFirstDepth) {
    const Table table = of_cubics();
    const SamplePoint first{0.7, 0.5, 0.4, 0.6, 1};
    for (const double ratio : {0.5, 1e-3, 1e-100}) {
        SamplePoint p = first;
        p.optical_depth *= ratio;
        SamplePoint deeper = first;
        deeper.optical_depth *= 2;
        const double line = thin_line(table, p.optical_depth, cubic(first), cubic(deeper));
        for (const Side side : both_sides)
            EXPECT_NEAR(
                scattering_at(table, side, p).multiple / (small_table_scale(side, p) * line), 1,
                3 * float_rounding);  // weights of up to 2 and -1
    }
}

TEST(Lookup, FallsAsTheSquareOfDepthTimesItsLogarithmInThinLayers) {
    const Table table = of_cubics();
    const SamplePoint thin{0.7, 1e-9, 0.4, 0.6, 1}, thinner{0.7, 1e-12, 0.4, 0.6, 1};
    for (const Side side : both_sides) {
        const double thick = scattering_at(table, side, thin).multiple;
        const double growth = thin_growth(1e-12) / thin_growth(1e-9);
        EXPECT_NEAR(scattering_at(table, side, thinner).multiple / thick, 1e-6 * growth, 1e-12);
        EXPECT_EQ(scattering_at(table, side, {0.7, 0, 0.4, 0.6, 1}).total(), 0);
    }
}

TEST(Lookup, ClampsCosinesAndAlbedoOfTheMultiplePartAlone) {
    const Table table = of_cubics();
    const SamplePoint edge{0.19, 2, 0.01, 0.6, 1}, outside{0.05, 2, 0.001, 0.6, 1};
    for (const Side side : both_sides)
        EXPECT_EQ(scattering_at(table, side, edge).multiple,
                  scattering_at(table, side, outside).multiple);
    EXPECT_NE(look_up_reflection(table, edge).single, look_up_reflection(table, outside).single);
}

TEST(Lookup, OfASideThatIsMissingIsSingleScattering) {
    const SamplePoint p{0.7, 2, 0.4, 0.6, 1};
    Table transmits = of_cubics(), reflects = transmits;
    transmits.reflection_multiple.clear();
    EXPECT_EQ(look_up_reflection(transmits, p).multiple, 0);
    EXPECT_GT(look_up_reflection(transmits, p).single, 0);
    EXPECT_GT(look_up_transmission(transmits, p).multiple, 0);
    reflects.transmission_multiple.clear();
    EXPECT_GT(look_up_reflection(reflects, p).multiple, 0);
    EXPECT_EQ(look_up_transmission(reflects, p).multiple, 0);
}

TEST(Lookup, StaysWithinTheTableForAnyArgument) {
    const Table table = plain_table({4, 4, 4, 4, 4}, {0.5, 4, true});
    const double odd[] = {NAN, -infinity, -1, 0, 1e-300, 0.5, 1, 2, 1e300, infinity};
    for (const double w : odd)
        for (const double tau : odd)
            for (const double mu : odd)
                for (const double azimuth : odd) {  // the address sanitizer watches
                    look_up_reflection(table, {w, tau, mu, 0.5, azimuth});
                    look_up_transmission(table, {w, tau, 0.5, mu, azimuth});
                }
}

TEST(Lookup, ReadsShortAxesAndNothingBeyondThem) {
    // Samples equal to their scale: the weights of every stencil must sum to 1 and stay inside.
    const std::vector<SamplePoint> points = random_points(12, 0.1, 30);
    for (int shape = 0; shape < 5 * 5 * 5 * 5 * 5; ++shape) {
        const Counts counts{1 + shape % 5, 1 + shape / 5 % 5, 1 + shape / 25 % 5,
                            1 + shape / 125 % 5, 1 + shape / 625};
        const Table table = plain_table(counts, {0.5, 8, shape % 2 == 0});
        for (const SamplePoint& p : points) {
            SamplePoint inside = p;
            if (counts.albedo == 1) inside.albedo = 1;
            if (counts.mu_in == 1) inside.mu_in = 1;
            if (counts.mu_out == 1) inside.mu_out = 1;
            inside.optical_depth =
                std::clamp(p.optical_depth, counts.optical_depth == 1 ? 8 : 0.5, 8.0);
            for (const Side side : both_sides) {
                const double found = scattering_at(table, side, inside).multiple;
                ASSERT_NEAR(found / small_table_scale(side, inside), 1, 1e-5);
                scattering_at(table, side, p);
            }
        }
    }
}

}  // namespace
}  // namespace stratus
