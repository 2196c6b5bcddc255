#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>

#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

TEST(Background, OfASmallSourceIsAsBlinnStates) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.6);
    const Slice slice(phase, {{0.7}, {0.8}});
    const Slice beam(phase, {{0.7}, {0.8}}, {.single = false});
    for (const double mu : {0.1, 0.5, 1.0}) {
        const auto cosine = static_cast<float>(mu);
        EXPECT_NEAR(slice.source_behind(cosine), source_seen_through(phase(1), 0.8, 0.7, mu), 1e-6);
        EXPECT_NEAR(slice.direct(cosine), std::exp(-0.7 / mu), 1e-7);
        EXPECT_NEAR(beam.source_behind(cosine), std::exp(-0.7 / mu), 1e-7);
        EXPECT_NEAR(beam.background(cosine), std::exp(-0.7 / mu), 1e-7);
    }
}

/// The beam and the hemispherical integral of single transmission, by the midpoint rule in azimuth
/// and cosine.
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

TEST(Background, IsTheBeamAndSingleTransmissionWithoutATable) {
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

TEST(Background, IsTheBeamAloneWhereItIsNotAskedFor) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.85);
    Effects effects;
    ASSERT_TRUE(effects.background);
    effects.background = false;
    const Slice with(phase, {{0.7}, {0.8}}), without(phase, {{0.7}, {0.8}}, effects);
    for (const float mu : {0.1f, 0.5f, 1.0f}) {
        EXPECT_EQ(without.background(mu), without.direct(mu));
        EXPECT_GT(with.background(mu), without.background(mu));
        EXPECT_EQ(without.source_behind(mu), with.source_behind(mu));
        EXPECT_EQ(without.transmission(mu, 0.3f, 1), with.transmission(mu, 0.3f, 1));
    }
    EXPECT_LT(without.bytes(), with.bytes());
}

TEST(Background, IsBetweenZeroAndOne) {
    for (const double g : {0.0, 0.85, 0.99})
        for (const double tau : {1e-6, 0.01, 1.0, 30.0, infinity}) {
            const Slice slice(PhaseFunction::henyey_greenstein(g), {{tau}, {1}});
            for (float mu = 0.001f; mu < 1; mu += 0.01f) {
                EXPECT_GE(slice.background(mu), 0);
                EXPECT_LE(slice.background(mu), 1) << "g " << g << " tau " << tau << " mu " << mu;
            }
        }
}

TEST(Background, UsesTheDiffuseTransmittanceOfItsTable) {
    Table table = plain_table({4, 10, 20, 20, 5}, {0.1, 8, false});
    table.albedo = make_axis(AxisScale::square_root_of_complement, 0, 1, 4);
    std::transform(table.albedo.values.begin(), table.albedo.values.end(),
                   table.diffusion_exponent.begin(), small_table_exponent);
    const SingleDiffuseTransmittance order_1(table.phase_function);
    const auto diffuse = [&](double w, double tau, double mu) {
        const double scale = transmission_scale(tau, small_table_exponent(w), small_table_length);
        return w * (order_1(tau, mu) + w * intercepted_share(tau, mu) * 0.5 * scale);
    };
    for (const double w : table.albedo.values)
        for (const double tau : table.optical_depth.values)
            for (const double mu : table.mu_in.values)
                table.diffuse_transmittance.push_back(static_cast<float>(diffuse(w, tau, mu)));
    prepare(table);
    for (const double w : {1e-3, 0.05, 0.3, 0.9, 1.0})
        for (const double tau : {0.15, 0.7, 8.0}) {
            const Slice slice = bind(table.view(), tau, w);
            const Slice without_single = bind(table.view(), tau, w, {.single = false});
            const Slice beam_alone = bind(table.view(), tau, w, {.background = false});
            for (const double mu : {0.02, 0.3, 1.0}) {
                const auto cosine = static_cast<float>(mu);
                const double beam = std::exp(-tau / mu);
                EXPECT_NEAR(slice.background(cosine), beam + diffuse(w, tau, mu), 2e-3 * w)
                    << "w " << w << " tau " << tau << " mu " << mu;
                const double once = background_once(table.phase_function, w, tau, mu) - beam;
                EXPECT_NEAR(beam_alone.background(cosine), beam, 1e-6);
                EXPECT_NEAR(without_single.background(cosine),
                            beam + std::max(0.0, diffuse(w, tau, mu) - once), 2e-3);
            }
        }
}

}  // namespace
}  // namespace stratus
