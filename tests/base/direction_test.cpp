// Directions as observers give them, there and back.
#include <stratus/base/constants.h>
#include <stratus/base/direction.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stratus {
namespace {

SidedGeometry seen(double incidence, double emission, double phase) {
    return observed_geometry({incidence, emission, phase}, "test");
}

double phase_deg(const SidedGeometry& at) {
    const double c = at.side == Side::reflection ? cos_scattering_angle_reflected(at.geometry)
                                                 : cos_scattering_angle_transmitted(at.geometry);
    return 180 - degrees(std::acos(c));
}

/// The angle between the directions towards the light and towards the eye, from their vectors.
double angle_between_deg(const Geometry& at, Side side) {
    const double s_in = std::sqrt(1 - at.mu_in * at.mu_in),
                 s_out = std::sqrt(1 - at.mu_out * at.mu_out);
    const double light[3] = {-s_in, 0, at.mu_in};  // light travels along x, down
    const double eye[3] = {s_out * std::cos(at.azimuth), s_out * std::sin(at.azimuth),
                           side == Side::reflection ? at.mu_out : -at.mu_out};
    const double dot = light[0] * eye[0] + light[1] * eye[1] + light[2] * eye[2];
    const double cross[3] = {light[1] * eye[2] - light[2] * eye[1],
                             light[2] * eye[0] - light[0] * eye[2],
                             light[0] * eye[1] - light[1] * eye[0]};
    return degrees(std::atan2(std::hypot(cross[0], cross[1], cross[2]), dot));
}

TEST(ObservedAngles, ComeBackFromEveryGeometry) {
    std::mt19937_64 random(1982);
    std::uniform_real_distribution<double> cosine(0.001, 1), angle(0, pi);
    for (int n = 0; n < 2000; ++n) {
        const Geometry at{cosine(random), cosine(random), angle(random)};
        const Side side = n % 2 == 0 ? Side::reflection : Side::transmission;
        const double e = degrees(std::acos(at.mu_out));
        const SidedGeometry found =
            seen(degrees(std::acos(at.mu_in)), side == Side::reflection ? e : 180 - e,
                 angle_between_deg(at, side));
        ASSERT_EQ(found.side, side);
        ASSERT_NEAR(found.geometry.mu_in, at.mu_in, 1e-14);
        ASSERT_NEAR(found.geometry.mu_out, at.mu_out, 1e-14);
        // Where both directions are near the normal, their azimuths hang on the last digits.
        const double sines = std::sqrt((1 - at.mu_in * at.mu_in) * (1 - at.mu_out * at.mu_out));
        ASSERT_NEAR(sines * std::cos(found.geometry.azimuth), sines * std::cos(at.azimuth), 1e-13);
    }
}

TEST(ObservedAngles, MeetTheEndsOfTheirRanges) {
    const auto expect = [](const SidedGeometry& at, double mu_in, double mu_out, double azimuth) {
        EXPECT_NEAR(at.geometry.mu_in, mu_in, 1e-15);
        EXPECT_NEAR(at.geometry.mu_out, mu_out, 1e-15);
        EXPECT_NEAR(at.geometry.azimuth, azimuth, 1e-14);
    };
    expect(seen(60, 60, 0), 0.5, 0.5, pi);    // opposition: back along the beam
    expect(seen(60, 60, 120), 0.5, 0.5, 0);   // the direction of a mirror
    expect(seen(60, 120, 180), 0.5, 0.5, 0);  // straight on, through the layer
    expect(seen(60, 120, 60), 0.5, 0.5, pi);  // through, to the side of the light
    expect(seen(0, 60, 60), 1, 0.5, 0);       // no azimuth
    expect(seen(60, 0, 60), 0.5, 1, 0);
    expect(seen(0, 0, 0), 1, 1, 0);
    expect(seen(0, 180, 180), 1, 1, 0);
    expect(seen(60, 60, degrees(std::acos(0.25))), 0.5, 0.5, pi / 2);
    for (const double grazing : {89.999, 90 - 1e-9}) {
        const double mu = radians(90 - grazing);
        EXPECT_NEAR(seen(grazing, grazing, 0).geometry.mu_in, std::sin(mu), 1e-12 * mu);
        EXPECT_NEAR(phase_deg(seen(grazing, 180 - grazing, 180)), 180, 1e-5);
        EXPECT_NEAR(phase_deg(seen(grazing, 30, 75)), 75, 1e-10);
    }
}

TEST(ObservedAngles, MayBeRoundedToPrintedDigits) {
    EXPECT_DOUBLE_EQ(seen(12.35, 47.12, 34.76).geometry.azimuth, pi);  // 34.77
    EXPECT_DOUBLE_EQ(seen(12.35, 47.12, 59.48).geometry.azimuth, 0);   // 59.47
    EXPECT_DOUBLE_EQ(seen(30, 30, 0).geometry.azimuth, pi);
    EXPECT_NEAR(phase_deg(seen(12.35, 47.12, 34.78)), 34.78, 1e-9);
}

TEST(ObservedAngles, AreRefusedWhereNoDirectionsHaveThem) {
    const auto refused = [](double i, double e, double g, Fragments fragments) {
        expect_refusal([&] { seen(i, e, g); }, fragments);
    };
    refused(90, 30, 60, "test: incidence_deg must be in [0, 90), got 90");
    refused(-0.5, 30, 30, "incidence_deg must be in [0, 90), got -0.5");
    refused(30, 90, 60,
            "emission_deg must be in [0, 180] without 90 (beyond 90 is the unlit side), got 90");
    refused(30, 181, 151,
            "emission_deg must be in [0, 180] without 90 (beyond 90 is the unlit side), got 181");
    refused(30, 50, 19, "phase_deg must be in [20, 80] at incidence_deg 30 and emission_deg 50");
    refused(30, 50, 80.03, {"phase_deg", "[20, 80]", "got 80.03"});
    refused(80, 130, 151, {"phase_deg must be in [50, 150] at", "got 151"});
    refused(30, 50, NAN, {"phase_deg", "got nan"});
}

}  // namespace
}  // namespace stratus
