// Monte Carlo in a homogeneous spherical shell over a black globe: the reference for planets whose layer
// is a shell (docs/scenes.md).
//
// Paths are followed from the eye against the light; each of their collisions adds the sunlight that it
// scatters towards the eye, attenuated on the way through the shell, or none in the globe's shadow.
#pragma once

#include <stratus/transfer/reference/photons.h>

#include <array>
#include <cstdint>

namespace stratus {

/// The globe has radius 1. The eye is far away along z, the sun along `to_sun`, a unit vector.
struct ShellView {
    double impact;  // x of the ray, [0, 1 + height)
    std::array<double, 3> to_sun;
};

/// pi I / F0 of light scattered once and more than once.
struct ShellLight {
    Estimate single, multiple;
};

/// Light that a shell sends to the eye along one ray.
///
/// Range    albedo [0, 1]; optical_depth (0, inf), vertical; height > 0, in radii of the globe; photons >= 2.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy unbiased; standard errors as of solve_photons without backward collisions.
/// Cost     photons x collisions.
ShellLight shell_photons(const PhaseFunction& phase_function, double albedo, double optical_depth,
                         double height, const ShellView& view, std::uint64_t photons,
                         std::uint64_t seed = 1);

}  // namespace stratus
