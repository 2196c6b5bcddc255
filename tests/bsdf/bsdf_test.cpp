#include <stratus/bsdf/bsdf.h>

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>

#include "bsdf_estimate.h"
#include "row_name.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

constexpr float just_below_1 = 1 - 6e-8f;

Bsdf bsdf_of(const std::string& phase, double tau, double w, const Effects& effects = {}) {
    return Bsdf(Slice(parse_phase_function(phase), {{tau}, {w}}, effects));
}

/// Single scattering alone: its peaks are the sharpest, and nothing about it is tabulated.
struct Material {
    const char* name;
    const char* phase;
    double optical_depth;
    // Largest relative standard deviation of eval * cos / pdf, some 1.3 times what was measured:
    // from mu_in = 0.05 to 0.99, and anywhere.
    double deviation, deviation_anywhere;

    Bsdf bsdf() const { return bsdf_of(phase, optical_depth, 1); }
};

const Material materials[] = {
    {"Isotropic", "isotropic", 1, 0.05, 0.06},
    {"ThinRayleigh", "rayleigh", 0.1, 0.065, 0.08},
    {"Forward", "henyey_greenstein:g=0.85", 0.5, 0.07, 0.2},
    {"ForwardDeep", "henyey_greenstein:g=0.85", infinity, 0.06, 0.09},
    {"ForwardPeak", "henyey_greenstein:g=0.95", 0.1, 0.08, 0.32},
    {"Backward", "henyey_greenstein:g=-0.85", infinity, 0.06, 0.2},
    {"BackwardThin", "henyey_greenstein:g=-0.85", 0.1, 0.06, 0.2},
    {"BothPeaks", "0.5*henyey_greenstein:g=-0.8 + 0.5*henyey_greenstein:g=0.9", 0.5, 0.12, 0.2},
    {"Rings", "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5", 1, 0.045, 0.08},
};

class EveryMaterial : public testing::TestWithParam<Material> {};

INSTANTIATE_TEST_SUITE_P(Bsdf, EveryMaterial, testing::ValuesIn(materials), row_name);

/// The normal itself, beside it, and down to the horizon.
constexpr float bsdf_cosines[] = {1, 0.9995f, 0.99f, 0.8f, 0.45f, 0.2f, 0.05f, 0.01f, 0.001f};

/// Integral of the density over cosines between the places `from` and `to` in v = sqrt(1 -
/// sqrt(mu)) and over azimuths, by `n` x `n` midpoints. Azimuth / pi counts from 0 to 2.
double integral_of_pdf(const Bsdf& bsdf, const Vector& wi, bool up, double from, double to,
                       double azimuth_from, double azimuth_to, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double v = from + (to - from) * (i + 0.5) / n, mu = std::pow(1 - v * v, 2);
        for (int k = 0; k < n; ++k) {
            const double azimuth = azimuth_from + (azimuth_to - azimuth_from) * (k + 0.5) / n;
            sum += 4 * v * (1 - v * v) * double{bsdf.pdf(wi, direction(mu, pi * azimuth, up))};
        }
    }
    return sum * (to - from) * pi * (azimuth_to - azimuth_from) / (n * n);
}

/// Integral over half the azimuths and the cosines from v_in, where the density peaks, to an end of
/// v; midpoints lie closest around the peak and at both ends of the azimuth.
double integral_beside_peak(const Bsdf& bsdf, const Vector& wi, bool up, double v_in, double end) {
    constexpr int n = 160;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double x = (i + 0.5) / n, v = v_in + (end - v_in) * x * x,
                     mu = std::pow(1 - v * v, 2);
        const double d_mu = 4 * v * (1 - v * v) * std::abs(end - v_in) * 2 * x;
        for (int k = 0; k < n; ++k) {
            const double y = (k + 0.5) / n, y2 = y * y;
            const double azimuth = pi * y2 * y * (10 - 15 * y + 6 * y2);
            const double d_azimuth = pi * 30 * y2 * (1 - y) * (1 - y);
            sum += d_mu * d_azimuth * double{bsdf.pdf(wi, direction(mu, azimuth, up))};
        }
    }
    return sum / (n * n);
}

TEST_P(EveryMaterial, DensityIntegratesToOne) {
    const Bsdf bsdf = GetParam().bsdf();
    for (const double mu : {1.0, 0.97, 0.6, 0.2, 0.02}) {
        const double v_in = std::sqrt(1 - std::sqrt(mu));
        double sum = 0;
        for (const bool up : {true, false})
            for (const double end : {0, 1})
                sum += 2 * integral_beside_peak(bsdf, direction(mu, pi, true), up, v_in, end);
        EXPECT_NEAR(sum, 1, 1e-4) << "mu_in " << mu;
    }
}

TEST_P(EveryMaterial, SamplesFollowTheDensity) {
    const Bsdf bsdf = GetParam().bsdf();
    constexpr int sides = 2, cosine_bins = 10, azimuth_bins = 12, draws = 100000;
    for (const float mu : {0.95f, 0.4f, 0.03f}) {
        SCOPED_TRACE(mu);
        const Vector wi = direction(mu, pi, true);
        std::vector<int> met(sides * cosine_bins * azimuth_bins);
        Uniform<float> share(11);
        for (int n = 0; n < draws; ++n) {
            const float u1 = share(), u2 = share(), u3 = share();
            const Vector wo = bsdf.sample(wi, u1, u2, u3).wo;
            const double v = std::sqrt(1 - std::sqrt(std::abs(double{wo.z})));
            const double turn = std::atan2(double{wo.y}, double{wo.x}) / (2 * pi);
            const int i = std::min(static_cast<int>(v * cosine_bins), cosine_bins - 1);
            const int k = std::min(static_cast<int>((turn - std::floor(turn)) * azimuth_bins),
                                   azimuth_bins - 1);
            ++met[static_cast<std::size_t>(((wo.z > 0 ? 0 : 1) * cosine_bins + i) * azimuth_bins +
                                           k)];
        }
        std::vector<double> shares;
        for (const bool up : {true, false})
            for (int i = 0; i < cosine_bins; ++i)
                for (int k = 0; k < azimuth_bins; ++k)
                    shares.push_back(integral_of_pdf(
                        bsdf, wi, up, i * 1.0 / cosine_bins, (i + 1.0) / cosine_bins,
                        k * 2.0 / azimuth_bins, (k + 1) * 2.0 / azimuth_bins, 24));
        expect_drawn(shares, met, draws, 20);
    }
}

TEST_P(EveryMaterial, SamplesCarryTheirValueAndDensity) {
    const Bsdf bsdf = GetParam().bsdf();
    for (const float mu : bsdf_cosines)
        for (const double azimuth : {0.0, 2.0, 5.0})
            expect_samples_carry_their_value(bsdf, direction(mu, azimuth, azimuth < 4), 1e-3);
}

TEST_P(EveryMaterial, HasLowVariance) {
    const Bsdf bsdf = GetParam().bsdf();
    for (const float mu : bsdf_cosines) {
        const Estimate estimate = estimated(bsdf, direction(mu, 0.3, true), 1 << 13);
        const bool usual = mu >= 0.05f && mu <= 0.99f;
        EXPECT_LT(estimate.deviation, usual ? GetParam().deviation : GetParam().deviation_anywhere)
            << "mu_in " << mu;
    }
}

TEST_P(EveryMaterial, EstimatesTheAlbedo) {
    const Bsdf bsdf = GetParam().bsdf();
    for (const float mu : bsdf_cosines)
        expect_albedo_estimated(bsdf, direction(mu, 0.3, true), 1 << 14);
}

TEST_P(EveryMaterial, IsReciprocal) {
    const Bsdf bsdf = GetParam().bsdf();
    for (const RandomNumbers& u : evenly_spread(500)) {
        const Vector wi = direction(u.u1, 7 * u.u2, true);
        const Vector wo = direction(u.u3, 9 * u.u1, u.u2 < 0.5f);
        const float there = bsdf.eval(wi, wo), back = bsdf.eval(wo, wi);
        EXPECT_NEAR(there, back, 2e-6 * there);  // some thirty operations in float
    }
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
        for (const Side side : {Side::reflection, Side::transmission}) {
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
                                  Effects{.reflection = reflection, .transmission = !reflection});
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
    for (const float mu : bsdf_cosines) {
        EXPECT_EQ(bsdf.albedo(mu).transmitted, 0);
        EXPECT_NEAR(bsdf.albedo(mu).reflected, endless.albedo(mu).reflected, 1e-6);
        for (const RandomNumbers& u : evenly_spread(100))
            EXPECT_GT(bsdf.sample(direction(mu, 0, true), u.u1, u.u2, u.u3).wo.z, 0);
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

TEST(Bsdf, AcceptsAnyRandomNumberAndDirection) {
    for (const Material& material : materials) {
        const Bsdf bsdf = material.bsdf();
        for (const float mu : {1.0f, 1.0000001f, 1e-7f, 1e-30f})
            for (const float u1 : {0.0f, 0.5f, just_below_1, 1.0f})
                for (const float u2 : {0.0f, 0.5f, just_below_1, 1.0f})
                    for (const float u3 : {0.0f, just_below_1, 1.0f}) {
                        const float sine = mu < 0.5f ? 1.0f : 0.0f;
                        const Bsdf::Sample drawn = bsdf.sample({0, sine, mu}, u1, u2, u3);
                        EXPECT_TRUE(std::isfinite(drawn.pdf) && drawn.pdf >= 0);
                        EXPECT_TRUE(std::isfinite(drawn.value));
                        EXPECT_NEAR(length(drawn.wo), 1, 1e-6);
                        EXPECT_NE(drawn.wo.z, 0);
                    }
        for (const float u : {-1.0f, 2.0f, 1e30f}) {
            const Vector wo = bsdf.sample(direction(0.5, 1, true), u, u, u).wo;
            EXPECT_NEAR(length(wo), 1, 1e-6);
        }
    }
}

TEST(Bsdf, HasDensityWhereverItScatters) {
    for (const Material& material : materials) {
        const Bsdf bsdf = material.bsdf();
        for (const RandomNumbers& u : evenly_spread(1000)) {
            const Vector wi = direction(u.u1, 0, true);
            const Vector wo = direction(u.u2, 6 * u.u3, u.u3 < 0.5f);
            EXPECT_TRUE(bsdf.pdf(wi, wo) > 0 || bsdf.eval(wi, wo) == 0);
        }
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
    for (const RandomNumbers& u : evenly_spread(count)) {
        const RgbBsdf::Sample drawn = rgb.sample(wi, u.u1, u.u2, u.u3);
        const float value[3] = {drawn.value.r, drawn.value.g, drawn.value.b};
        const float weight = std::abs(drawn.wo.z) / drawn.pdf;
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(value[c], of_channel[c].eval(wi, drawn.wo), 3e-6 * value[c]);
            sum[c] += double{value[c] * weight} / count;
        }
    }
    const ScatteredShares<Rgb> shares = rgb.albedo(wi);
    // 8,192 points of a deviation of one, evenly spread.
    EXPECT_NEAR(sum[0], shares.reflected.r + shares.transmitted.r, 1e-3);
    EXPECT_NEAR(sum[1], shares.reflected.g + shares.transmitted.g, 1e-3);
    EXPECT_NEAR(sum[2], shares.reflected.b + shares.transmitted.b, 1e-3);
    for (std::size_t c = 0; c < 3; ++c) {
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

TEST(Bsdf, FitsTheSecondLevelCache) {
    const Bsdf bsdf = bsdf_of("isotropic", 1, 1);
    EXPECT_GT(bsdf.bytes(), bsdf.slice().bytes());
    EXPECT_LT(bsdf.bytes() - bsdf.slice().bytes(), 150000u);
}

}  // namespace
}  // namespace stratus
