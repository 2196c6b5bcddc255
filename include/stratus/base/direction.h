// Directions at a surface: as cosines and an azimuth between them, and as vectors.
#pragma once

namespace stratus {

/// Where light leaves a layer: on the side that is lit, or on the far side.
enum class Side { reflection, transmission };

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

/// A direction in the local frame of a surface, z along its normal; of unit length, to which no
/// lookup brings it, pointing away from the surface: towards the light, or towards the eye.
struct Vector {
    float x, y, z;
};

}  // namespace stratus
