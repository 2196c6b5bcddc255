// BSDFs of phase functions with sharp peaks: the density is exact and follows the light, forward
// peak included.
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>

#include "bsdf_estimate.h"
#include "row_name.h"
#include "uniform.h"
#include "water_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

/// Scattering angles between which directions are counted, radians: the peak of the water cloud is
/// some 0.01 wide.
constexpr double ring_angles[] = {0,   0.003, 0.006, 0.01, 0.015, 0.025, 0.04, 0.07, 0.12,
                                  0.2, 0.35,  0.6,   1,    1.5,   2,     2.4,  2.6,  pi};
constexpr std::size_t rings = std::size(ring_angles) - 1, sectors = 8, sides = 2;

/// A number for each side, ring around the direction of unscattered light, and sector of it.
using Tallies = std::array<double, sides * rings * sectors>;

std::size_t place(const Vector& wi, const Vector& wo, std::size_t ring, std::size_t sector) {
    return ((wi.z * wo.z > 0 ? 0 : 1) * rings + ring) * sectors + sector;
}

/// Directions at a scattering angle and a turn around the direction of unscattered light.
struct Frame {
    double mu, sine;

    explicit Frame(double mu_in) : mu(mu_in), sine(std::sqrt((1 - mu) * (1 + mu))) {}

    Vector wi() const { return {static_cast<float>(-sine), 0, static_cast<float>(mu)}; }

    Vector direction(double angle, double turn) const {
        const double up = std::sin(angle) * std::cos(turn), c = std::cos(angle);
        return {static_cast<float>(c * sine + up * mu),
                static_cast<float>(std::sin(angle) * std::sin(turn)),
                static_cast<float>(up * sine - c * mu)};
    }
    /// The ring and sector that hold a direction.
    std::size_t place_of(const Vector& wo) const {
        const double x = double{wo.x}, z = double{wo.z};
        const double along = x * sine - z * mu, up = x * mu + z * sine;
        const double angle = std::atan2(std::hypot(up, double{wo.y}), along);
        const double turn = std::atan2(double{wo.y}, up) / (2 * pi);
        const auto ring = static_cast<std::size_t>(
            std::upper_bound(ring_angles + 1, ring_angles + rings, angle) - ring_angles - 1);
        const auto sector = static_cast<std::size_t>((turn - std::floor(turn)) * sectors);
        return place(wi(), wo, ring, std::min(sector, sectors - 1));
    }
};

/// Integrals of the density, by midpoints, `n` along either side of a ring's sector.
template <class AnyBsdf>
Tallies integrals_of_pdf(const AnyBsdf& bsdf, const Frame& frame, int n) {
    const double turn_width = 2 * pi / (static_cast<double>(sectors) * n);
    Tallies sum{};
    for (std::size_t ring = 0; ring < rings; ++ring)
        for (int i = 0; i < n; ++i) {
            const double width = (ring_angles[ring + 1] - ring_angles[ring]) / n;
            const double angle = ring_angles[ring] + (i + 0.5) * width;
            for (std::size_t sector = 0; sector < sectors; ++sector)
                for (int k = 0; k < n; ++k) {
                    const double turn = (static_cast<double>(sector) * n + k + 0.5) * turn_width;
                    const Vector wo = frame.direction(angle, turn);
                    sum[place(frame.wi(), wo, ring, sector)] +=
                        double{bsdf.pdf(frame.wi(), wo)} * std::sin(angle) * width * turn_width;
                }
        }
    return sum;
}

template <class AnyBsdf>
void expect_integral_of_one(const AnyBsdf& bsdf, double mu) {
    double sum = 0;
    for (const double each : integrals_of_pdf(bsdf, Frame(mu), 48)) sum += each;
    EXPECT_NEAR(sum, 1, 5e-4) << "mu_in " << mu;  // of midpoints
}

template <class AnyBsdf>
void expect_samples_follow_density(const AnyBsdf& bsdf, double mu) {
    constexpr int draws = 200000;
    const Frame frame(mu);
    Tallies met{};
    Uniform<float> share(5);
    for (int n = 0; n < draws; ++n) {
        const float u1 = share(), u2 = share(), u3 = share();
        ++met[frame.place_of(bsdf.sample(frame.wi(), u1, u2, u3).wo)];
    }
    SCOPED_TRACE(mu);
    expect_drawn(integrals_of_pdf(bsdf, frame, 24), met, draws, 30);
}

Bsdf cloud_bsdf(double tau, const Effects& effects = {}) {
    return Bsdf(Slice(water_cloud(), {{tau}, {1}}, effects));
}

RgbBsdf coloured_bsdf(const PhaseFunction& phase) {
    return RgbBsdf(RgbSlice(phase, {{0.02, 0.5, 8}, {1, 1, 1}}));
}

TEST(PeakedBsdf, DensityIntegratesToOne) {
    for (const double tau : {0.02, 1.0, 8.0}) {
        const Bsdf bsdf = cloud_bsdf(tau);
        for (const double mu : {0.05, 0.3, 0.7, 1.0}) expect_integral_of_one(bsdf, mu);
    }
    expect_integral_of_one(coloured_bsdf(water_cloud()), 0.4);
}

TEST(PeakedBsdf, SamplesFollowTheDensity) {
    for (const double tau : {0.1, 1.0, 8.0}) {
        const Bsdf bsdf = cloud_bsdf(tau);
        for (const double mu : {0.05, 0.35, 0.97}) expect_samples_follow_density(bsdf, mu);
    }
    const RgbBsdf coloured = coloured_bsdf(water_cloud());
    for (const double mu : {0.05, 0.35, 0.97}) expect_samples_follow_density(coloured, mu);
    for (const bool reflection : {true, false}) {
        const Bsdf bsdf =
            cloud_bsdf(0.5, Effects{.reflection = reflection, .transmission = !reflection});
        for (const double mu : {0.1, 0.8}) expect_samples_follow_density(bsdf, mu);
    }
}

TEST(PeakedBsdf, SamplesCarryTheirValueAndDensity) {
    const Bsdf bsdf = cloud_bsdf(0.5);
    for (const double mu : {0.9999, 0.99, 0.8, 0.3, 0.05, 0.002})
        expect_samples_carry_their_value(bsdf, direction(mu, 2, true), 2e-3);
}

TEST(PeakedBsdf, HasLowVariance) {
    for (const double tau : {0.02, 0.3, 1.0, 8.0, infinity}) {
        const Bsdf bsdf = cloud_bsdf(tau);
        for (const double mu :
             {0.05, 0.07, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 0.95, 0.99, 0.998, 0.9995, 1.0})
            EXPECT_LT(estimated(bsdf, direction(mu, 0.3, true), 1 << 13).deviation, 0.15)
                << "tau " << tau << " mu_in " << mu;
    }
}

TEST(PeakedBsdf, EstimatesTheAlbedo) {
    for (const double tau : {0.02, 1.0, 8.0}) {
        SCOPED_TRACE(tau);
        const Bsdf bsdf = cloud_bsdf(tau);
        for (const double mu : {1.0, 0.8, 0.3, 0.05})
            expect_albedo_estimated(bsdf, direction(mu, 0.3, true), 1 << 15);
    }
}

TEST(PeakedBsdf, TakesTheMemoryOfItsSamples) {
    const auto bytes = [](const Bsdf& bsdf) { return bsdf.bytes() - bsdf.slice().bytes(); };
    const Bsdf lobe(Slice(PhaseFunction::henyey_greenstein(0.85), {{1}, {1}}));
    EXPECT_GT(bytes(cloud_bsdf(1)), 4 * bytes(lobe));
    EXPECT_LT(bytes(cloud_bsdf(1)), 900000u);
}

struct Colours {
    const char* name;
    PhaseFunction (*phase)();  // takes long: that of its own test alone is made
};

class EveryPhaseOfColours : public testing::TestWithParam<Colours> {};

INSTANTIATE_TEST_SUITE_P(
    RgbBsdf, EveryPhaseOfColours,
    testing::Values(Colours{"Isotropic", [] { return PhaseFunction::isotropic(); }},
                    Colours{"Forward", [] { return PhaseFunction::henyey_greenstein(0.75); }},
                    Colours{
                        "Rings",
                        [] {
                            return parse_phase_function(
                                "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
                        }},
                    Colours{"WaterCloud", water_cloud}),
    row_name);

TEST_P(EveryPhaseOfColours, KeepsWeightsInBounds) {
    const RgbBsdf bsdf = coloured_bsdf(GetParam().phase());
    for (const double mu : {0.05, 0.1, 0.3, 0.6, 1.0}) {
        const Vector wi = direction(mu, 0.3, true);
        constexpr int count = 1 << 13;
        double mean[3] = {}, squares[3] = {}, largest[3] = {};
        for (const RandomNumbers& u : evenly_spread(count)) {
            const RgbBsdf::Sample drawn = bsdf.sample(wi, u.u1, u.u2, u.u3);
            const float value[3] = {drawn.value.r, drawn.value.g, drawn.value.b};
            for (std::size_t c = 0; c < 3; ++c) {
                const double weight =
                    double{value[c]} * double{std::abs(drawn.wo.z)} / double{drawn.pdf};
                mean[c] += weight / count;
                squares[c] += weight * weight / count;
                largest[c] = std::max(largest[c], weight);
            }
        }
        const auto brightest = static_cast<std::size_t>(std::max_element(mean, mean + 3) - mean);
        const double variance = squares[brightest] - mean[brightest] * mean[brightest];
        EXPECT_LT(std::sqrt(variance) / mean[brightest], 0.5) << "mu_in " << mu;
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_LT(largest[c] / mean[c], 5) << "mu_in " << mu << " channel " << c;
    }
}

}  // namespace
}  // namespace stratus
