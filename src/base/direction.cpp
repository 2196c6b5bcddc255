#include <stratus/base/direction.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

double sine(double cosine) noexcept {
    return std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
}

double sine_deg(double angle) noexcept { return std::sin(radians(angle)); }

}  // namespace

double cos_scattering_angle(Side side, const Geometry& geometry) noexcept {
    const auto [mu_in, mu_out, azimuth] = geometry;
    const double horizontal = sine(mu_in) * sine(mu_out) * std::cos(azimuth),
                 vertical = mu_in * mu_out;
    return std::clamp(side == Side::reflection ? horizontal - vertical : horizontal + vertical,
                      -1.0, 1.0);
}

double cos_scattering_angle_reflected(const Geometry& geometry) noexcept {
    return cos_scattering_angle(Side::reflection, geometry);
}

double cos_scattering_angle_transmitted(const Geometry& geometry) noexcept {
    return cos_scattering_angle(Side::transmission, geometry);
}

// i, e and the phase g are the sides of a spherical triangle whose corners are the normal, the light
// and the eye. With s half their sum, the half of its angle at the normal has the tangent
// sqrt(sin(s - i) sin(s - e) / (sin s sin(s - g))); the azimuth, between directions of propagation, is
// 180 degrees less that angle.
SidedGeometry observed_geometry(const ObservedAngles& angles, const char* caller) {
    const auto [i, e, given] = angles;
    require_in("[0, 90)", caller, "incidence_deg", i);
    require(e >= 0 && e <= 180 && e != 90, caller, "emission_deg",
            "in [0, 180] without 90 (beyond 90 is the unlit side)", e);
    constexpr double rounding = 0.02;
    const double least = std::abs(i - e), most = std::min(i + e, 360 - (i + e));
    require(given >= least - rounding && given <= most + rounding, caller, "phase_deg",
            "in [" + short_number(least, 10) + ", " + short_number(most, 10) +
                "] at incidence_deg " + shortest_text(i) + " and emission_deg " + shortest_text(e) +
                ", or no directions have these three",
            given);
    const double g = std::min(std::max(given, least), most);
    // In each difference of two sides the one that is 0 at an end of the range is exactly 0 there.
    const double forward =
        std::sqrt(std::max(0.0, sine_deg((i + e + g) / 2) * sine_deg((i + e - g) / 2)));
    const double backward =
        std::sqrt(std::max(0.0, sine_deg((g + (e - i)) / 2) * sine_deg((g + (i - e)) / 2)));
    const bool is_lit = e < 90;
    return {{sine_deg(90 - i), sine_deg(std::abs(90 - e)), 2 * std::atan2(forward, backward)},
            is_lit ? Side::reflection : Side::transmission};
}

}  // namespace stratus
