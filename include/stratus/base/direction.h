// Directions at a surface: as cosines and an azimuth between them, as angles that observers give, and
// as vectors.
#pragma once

namespace stratus {

/// Where light leaves a layer: on the side that is lit, or on the far side.
enum class Side { reflection, transmission };

inline constexpr Side both_sides[] = {Side::reflection, Side::transmission};

/// One of each for the two sides.
template <class T>
struct PerSide {
    T reflection{}, transmission{};

    T& operator[](Side side) noexcept {
        return side == Side::reflection ? reflection : transmission;
    }
    const T& operator[](Side side) const noexcept {
        return side == Side::reflection ? reflection : transmission;
    }
};

/// Directions of one scattering: cosines to the normal in (0, 1] and the azimuth between them in
/// radians.
struct Geometry {
    double mu_in;
    double mu_out;
    double azimuth;
};

/// Cosine of the scattering angle for light that leaves on the lit side:
/// -mu mu0 + s s0 cos(azimuth).
double cos_scattering_angle_reflected(const Geometry& geometry) noexcept;

/// Cosine of the scattering angle of light that leaves on the far side: +mu mu0 + s s0 cos(azimuth).
double cos_scattering_angle_transmitted(const Geometry& geometry) noexcept;

/// Cosine of the scattering angle of light that leaves on that side.
double cos_scattering_angle(Side side, const Geometry& geometry) noexcept;

/// Angles as observers give them, in degrees: of the light and of the eye from the normal of the lit
/// side, and between the two.
struct ObservedAngles {
    double incidence, emission, phase;
};

struct SidedGeometry {
    Geometry geometry;
    Side side;
};

/// The geometry of observed angles. Of the two azimuths that have them, which are mirror images, it
/// is that in [0, pi].
///
/// Range    incidence [0, 90); emission [0, 180] without 90, beyond which it is on the far side; phase
///          from |i - e| to i + e, or to 360 - i - e where that is less, or up to 0.02 beyond either,
///          which the rounding of printed angles explains; it then counts as the end of the range.
/// Sign     the phase angle is 180 degrees less the scattering angle: 0 with the light in the back.
/// Errors   std::invalid_argument naming `caller`, argument, range and value.
SidedGeometry observed_geometry(const ObservedAngles& angles, const char* caller);

/// A direction in the local frame of a surface, z along its normal; of unit length, to which no
/// lookup brings it, pointing away from the surface: towards the light, or towards the eye.
struct Vector {
    float x, y, z;
};

}  // namespace stratus
