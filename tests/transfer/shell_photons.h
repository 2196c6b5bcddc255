// Monte Carlo in a homogeneous spherical shell over a black globe: the reference for planets whose layer
// is a shell (docs/scenes.md).
//
// Paths are followed from the eye against the light; each of their collisions adds the sunlight that it
// scatters towards the eye, attenuated on the way through the shell, or none in the globe's shadow.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/transfer/reference/solvers.h>

#include "reference/photon_path.h"

#include <algorithm>
#include <array>
#include <cmath>
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

/// Distance along a direction, of cosine c to the vertical, from radius r to the sphere of radius `to`,
/// which is above or, with c < 0, below; NaN: the direction misses it.
inline double distance_to(double to, double r, double c, bool above) {
    const double root = std::sqrt(to * to - r * r * (1 - c * c));
    return above ? root - r * c : -root - r * c;
}

/// Light that a shell sends to the eye along one ray.
///
/// Range    albedo [0, 1]; optical_depth (0, inf), vertical; height > 0, in radii of the globe; photons >= 2.
/// Accuracy unbiased; standard errors as of solve_photons without backward collisions.
/// Cost     photons x collisions.
inline ShellLight shell_photons(const PhaseFunction& phase_function, double albedo,
                                double optical_depth, double height, const ShellView& view,
                                std::uint64_t photons, std::uint64_t seed = 1) {
    constexpr double roulette = 0.3;
    const double top = 1 + height, extinction = optical_depth / height;
    const PhaseValues phase(phase_function);
    const AngleSampler angles(phase);
    const Direction sun{view.to_sun[0], view.to_sun[1], view.to_sun[2]};
    Random random(seed, 0, 0);
    Tally single, multiple;
    for (std::uint64_t n = 0; n < photons; ++n) {
        Direction at{view.impact, 0, std::sqrt(top * top - view.impact * view.impact)},
            along{0, 0, -1};
        double weight = 1, light[2] = {0, 0};
        for (bool first = true; weight > 0; first = false) {
            const double r = std::sqrt(dot(at, at)), c = dot(at, along) / r;
            const bool hits = c < 0 && r * r * (1 - c * c) < 1;
            const double slant =
                extinction * std::max(0.0, distance_to(hits ? 1 : top, r, c, !hits));
            // The flight is forced to end in the shell.
            const double hit = -std::expm1(-slant);
            weight *= albedo * hit;
            if (weight < roulette) weight = random() * roulette < weight ? roulette : 0;
            if (weight == 0) break;
            const double length = -std::log1p(-random() * hit) / extinction;
            at = {at.x + length * along.x, at.y + length * along.y, at.z + length * along.z};
            const double height_now = std::sqrt(dot(at, at)), up = dot(at, sun) / height_now;
            if (up >= 0 || height_now * height_now * (1 - up * up) > 1)
                light[first ? 0 : 1] +=
                    weight / 4 * phase(dot(along, sun)) *
                    std::exp(-extinction *
                             std::max(0.0, distance_to(top, std::min(height_now, top), up, true)));
            const double bin_number = random(), place = random();
            const AngleSampler::Sample angle = angles.sample(bin_number, place);
            weight *= phase(1 - 2 * angle.v) / angle.density;
            along = scattered(along, angle.v, 2 * pi * random());
        }
        single.add(light[0]);
        multiple.add(light[1]);
    }
    return {single.estimate(photons), multiple.estimate(photons)};
}

}  // namespace stratus
