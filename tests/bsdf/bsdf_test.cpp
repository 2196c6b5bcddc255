#include <stratus/bsdf/bsdf.h>

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>

#include "bsdf_estimate.h"
#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

Bsdf bsdf_of(const std::string& phase, double tau, double w, const Effects& effects = {}) {
    return Bsdf(Slice(parse_phase_function(phase), {{tau}, {w}}, effects));
}

/// 2 integral R mu_out d mu_out of isotropic scattering, independent of azimuth, in double
/// precision.
template <class Single>
double isotropic_share(Single single, double tau, double mu_in) {
    constexpr int n = 4000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double x = (i + 0.5) / n, mu = x * x;  // near the horizon it varies fastest
        sum += 2 * single(1, 1, tau, mu_in, mu) * mu * 2 * x / n;
    }
    return sum;
}

TEST(Bsdf, HasTheAlbedoOfSingleScattering) {
    for (const double tau : {1e-6, 1e-3, 0.05, 1.0, 20.0, infinity}) {
        const Bsdf bsdf = bsdf_of("isotropic", tau, 1);
        for (double mu = 1; mu > 1e-3; mu *= 0.83) {
            const ScatteredShares<float> albedo = bsdf.albedo(static_cast<float>(mu));
            const double R = isotropic_share(single_reflection, tau, mu);
            const double T = isotropic_share(single_transmission, tau, mu);
            // Straight lines between 129 cosines, of what remains once the light intercepted is
            // divided out.
            EXPECT_NEAR(albedo.reflected, R, 1e-3 * (R + T)) << "tau " << tau << " mu " << mu;
            EXPECT_NEAR(albedo.transmitted, T, 1e-3 * (R + T)) << "tau " << tau << " mu " << mu;
        }
    }
}

TEST(Bsdf, AgreesBetweenAnglesAndVectors) {
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.6", 0.7, 0.9);
    for (const RandomNumbers& u : evenly_spread(200)) {
        const float mu_in = 0.01f + 0.98f * u.u1, mu_out = 0.01f + 0.98f * u.u3;
        const Vector wi = direction(mu_in, 0.4 + pi, true);
        for (const Side side : both_sides) {
            const Vector wo = direction(mu_out, 0.4 + double{u.u2}, side == Side::reflection);
            // Rounding of vectors beside a peak.
            EXPECT_NEAR(bsdf.pdf(side, mu_in, mu_out, u.u2) / bsdf.pdf(wi, wo), 1, 1e-4);
            EXPECT_NEAR(bsdf.eval(side, mu_in, mu_out, u.u2) / bsdf.eval(wi, wo), 1, 1e-4);
        }
        const Bsdf::SampleOfAngles angles = bsdf.sample(mu_in, u.u1, u.u2, u.u3);
        const Bsdf::Sample vectors = bsdf.sample(wi, u.u1, u.u2, u.u3);
        EXPECT_EQ(angles.side == Side::reflection, vectors.wo.z > 0);
        EXPECT_NEAR(angles.mu_out, std::abs(vectors.wo.z), 1e-6);
        EXPECT_NEAR(std::cos(angles.azimuth + 0.4f) * std::sqrt(1 - angles.mu_out * angles.mu_out),
                    vectors.wo.x, 1e-5);
        EXPECT_NEAR(angles.pdf / vectors.pdf, 1, 1e-4);
        EXPECT_NEAR(angles.value / vectors.value, 1, 1e-4);
        EXPECT_EQ(bsdf.albedo(mu_in).reflected, bsdf.albedo(wi).reflected);
    }
}

TEST(Bsdf, HasTheDensityOfSamplesAboutTheNormal) {
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=-0.9", 1, 0.9);
    for (const Vector& wi : {Vector{0, 0, 1}, direction(1, 0.4, true), Vector{-1e-9f, 0, 1}})
        for (const Bsdf::Sample& drawn : evenly_drawn(bsdf, wi, 100'000))
            ASSERT_NEAR(bsdf.pdf(wi, drawn.wo) / drawn.pdf, 1, 1e-3) << drawn.wo.x;
}

TEST(Bsdf, IsInvariantUnderRotation) {
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.6", 0.7, 0.9);
    for (const RandomNumbers& u : evenly_spread(100)) {
        const auto pdf = [&](double turned) {
            return bsdf.pdf(direction(u.u1, turned, true),
                            direction(u.u3, 6 * u.u2 + turned, u.u2 < 0.5f));
        };
        EXPECT_NEAR(pdf(1.9) / pdf(0), 1, 1e-4);  // rounding of vectors
    }
}

TEST(Bsdf, IsSymmetricBetweenAboveAndBelow) {
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.6", 0.7, 0.9);
    for (const RandomNumbers& u : evenly_spread(100)) {
        const Vector above = direction(u.u1, 1, true), below{above.x, above.y, -above.z};
        const Bsdf::Sample from_above = bsdf.sample(above, u.u2, u.u3, u.u1);
        const Bsdf::Sample from_below = bsdf.sample(below, u.u2, u.u3, u.u1);
        EXPECT_EQ(from_below.wo.z, -from_above.wo.z);
        EXPECT_EQ(from_below.wo.x, from_above.wo.x);
        EXPECT_EQ(from_below.pdf, from_above.pdf);
        EXPECT_EQ(bsdf.albedo(below).transmitted, bsdf.albedo(above).transmitted);
    }
}

void expect_nothing(const Bsdf& bsdf, const Vector& wi) {
    for (const RandomNumbers& u : evenly_spread(20)) {
        const Bsdf::Sample drawn = bsdf.sample(wi, u.u1, u.u2, u.u3);
        EXPECT_EQ(drawn.pdf, 0);
        EXPECT_EQ(drawn.value, 0);
        EXPECT_EQ(bsdf.pdf(wi, direction(u.u1, u.u2, true)), 0);
    }
    EXPECT_EQ(bsdf.albedo(wi).reflected, 0);
    EXPECT_EQ(bsdf.albedo(wi).transmitted, 0);
}

TEST(Bsdf, ScattersNothingWithoutScatterers) {
    const Vector wi = direction(0.5, 1, true);
    expect_nothing(bsdf_of("rayleigh", 0, 1), wi);
    expect_nothing(bsdf_of("rayleigh", 1, 0), wi);
    Effects neither_side;
    neither_side.reflection = neither_side.transmission = false;
    expect_nothing(bsdf_of("rayleigh", 1, 1, neither_side), wi);
    expect_nothing(bsdf_of("rayleigh", 1, 1), {0.6f, 0.8f, 0});  // light along the layer
}

TEST(Bsdf, ScattersToTheRequestedSideAlone) {
    for (const bool reflection : {true, false}) {
        const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.5", 1, 1,
                                  {.reflection = reflection, .transmission = !reflection});
        const Vector wi = direction(0.5, 1, true);
        for (const RandomNumbers& u : evenly_spread(200)) {
            const Bsdf::Sample drawn = bsdf.sample(wi, u.u1, u.u2, u.u3);
            EXPECT_EQ(drawn.wo.z > 0, reflection);
            EXPECT_GT(drawn.value, 0);
            EXPECT_EQ(bsdf.pdf(wi, direction(u.u1, u.u2, !reflection)), 0);
        }
    }
}

TEST(Bsdf, TransmitsNothingThroughOpticalDepth1000) {
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.85", 1000, 1);
    const Bsdf endless = bsdf_of("henyey_greenstein:g=0.85", infinity, 1);
    for (const float mu : {1.0f, 0.8f, 0.2f, 0.01f}) {
        EXPECT_EQ(bsdf.albedo(mu).transmitted, 0);
        EXPECT_NEAR(bsdf.albedo(mu).reflected, endless.albedo(mu).reflected, 1e-6);
        for (const Bsdf::Sample& drawn : evenly_drawn(bsdf, direction(mu, 0, true), 100))
            EXPECT_GT(drawn.wo.z, 0);
    }
}

TEST(Bsdf, IsAccurateInVeryThinLayers) {
    constexpr double tau = 1e-6;
    const Bsdf bsdf = bsdf_of("henyey_greenstein:g=0.5", tau, 1);
    for (const float mu : {1.0f, 0.3f, 0.01f}) {
        const Estimate estimate = estimated(bsdf, direction(mu, 0, true), 1 << 13);
        // What is intercepted is scattered, and hardly ever a second time.
        EXPECT_NEAR((estimate.reflected + estimate.transmitted) * double{mu} / tau, 1, 2e-3);
        EXPECT_LT(estimate.deviation, 0.09);
    }
}

TEST(RgbBsdf, HasTheValueAndAlbedoOfItsChannels) {
    const PhaseFunction phase = parse_phase_function("henyey_greenstein:g=0.5");
    const Medium<3> medium{{0.2, 1, 5}, {1, 0.8, 0.5}};
    const RgbBsdf rgb(RgbSlice(phase, medium));
    std::vector<Bsdf> of_channel;
    for (int c = 0; c < 3; ++c)
        of_channel.push_back(Bsdf(Slice(phase, {{medium.optical_depth[c]}, {medium.albedo[c]}})));
    const Vector wi = direction(0.4, 2, true);
    double sum[3] = {};
    constexpr int count = 1 << 13;
    for (const RgbBsdf::Sample& drawn : evenly_drawn(rgb, wi, count)) {
        const float value[3] = {drawn.value.r, drawn.value.g, drawn.value.b};
        const float weight = std::abs(drawn.wo.z) / drawn.pdf;
        for (const auto c : three_channels) {
            EXPECT_NEAR(value[c], of_channel[c].eval(wi, drawn.wo), 3e-6 * value[c]);
            sum[c] += double{value[c] * weight} / count;
        }
    }
    const ScatteredShares<Rgb> shares = rgb.albedo(wi);
    // 8,192 points of a deviation of one, evenly spread.
    EXPECT_NEAR(sum[0], shares.reflected.r + shares.transmitted.r, 1e-3);
    EXPECT_NEAR(sum[1], shares.reflected.g + shares.transmitted.g, 1e-3);
    EXPECT_NEAR(sum[2], shares.reflected.b + shares.transmitted.b, 1e-3);
    for (const auto c : three_channels) {
        const float of_rgb[3] = {shares.reflected.r, shares.reflected.g, shares.reflected.b};
        EXPECT_NEAR(of_rgb[c], of_channel[c].albedo(wi).reflected, 1e-5);
    }
}

TEST(RgbBsdf, SamplesEqualChannelsLikeOneAndLeavesBlackOnesOut) {
    const PhaseFunction phase = parse_phase_function("henyey_greenstein:g=0.5");
    const Bsdf one(Slice(phase, {{0.7}, {0.8}}));
    for (const Medium<3>& medium :
         {Medium<3>{{0.7, 0.7, 0.7}, {0.8, 0.8, 0.8}}, Medium<3>{{0.7, 2, 0}, {0.8, 0, 1}}}) {
        const RgbBsdf three(RgbSlice(phase, medium));
        for (const RandomNumbers& u : evenly_spread(500)) {
            const Vector wi = direction(u.u1, 1, true), wo = direction(u.u2, 7 * u.u3, u.u1 < 0.5f);
            EXPECT_NEAR(three.pdf(wi, wo) / one.pdf(wi, wo), 1, 1e-4);
        }
    }
}

}  // namespace
}  // namespace stratus
