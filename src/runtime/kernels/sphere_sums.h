// The sum over Mie's series at many angles, where the time of mie_scattering.cpp goes: compiled once
// for each instruction set, with the same roundings in all, so that a phase function has the same
// bits on every machine.
#pragma once

#include <cstddef>

namespace stratus {

constexpr int spheres_at_once = 4;

/// A term of the series of `spheres_at_once` spheres: (2n+1) / (n(n+1)) times a_n + b_n and
/// a_n - b_n.
struct SphereTerm {
    double sum_re[spheres_at_once], sum_im[spheres_at_once];
    double difference_re[spheres_at_once], difference_im[spheres_at_once];
};

/// The same term at an angle: pi_n + tau_n and pi_n - tau_n. [BH83] 4.47
struct AngleTerm {
    double sum, difference;
};

/// S1 + S2 and S1 - S2.
struct SphereAmplitudes {
    double sum_re[spheres_at_once], sum_im[spheres_at_once];
    double difference_re[spheres_at_once], difference_im[spheres_at_once];
};

struct SphereSums {
    /// S at `angles` angles: `terms` of `count` in the series; the angle terms of the next angle
    /// begin `stride` further.
    void (*amplitudes)(const SphereTerm* terms, std::size_t count, const AngleTerm* angle,
                       std::size_t stride, std::size_t angles, SphereAmplitudes* S);
};

/// For this machine.
const SphereSums& sphere_sums() noexcept;

}  // namespace stratus
