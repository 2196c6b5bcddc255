// Directions and vectors at which tests evaluate slices.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/base/direction.h>

#include "../base/uniform.h"

#include <cmath>
#include <vector>

namespace stratus {

struct Direction {
    float mu_in, mu_out, azimuth;

    Geometry geometry() const { return {double{mu_in}, double{mu_out}, double{azimuth}}; }
};

/// R and T of a slice.
template <class Slice>
auto reflected(const Slice& slice, const Direction& at) {
    return slice.reflection(at.mu_in, at.mu_out, at.azimuth);
}
template <class Slice>
auto transmitted(const Slice& slice, const Direction& at) {
    return slice.transmission(at.mu_in, at.mu_out, at.azimuth);
}

inline std::vector<Direction> random_directions(int count, float min_cosine = 0.001f) {
    Uniform<float> share(7);
    const auto cosine = [&] { return min_cosine + (1 - min_cosine) * share(); };
    std::vector<Direction> directions{
        {1, 1, 0}, {1, 0.5f, 1}, {0.5f, 0.5f, 0}, {0.3f, 0.3f, 3.1415926f}};
    while (static_cast<int>(directions.size()) < count)
        directions.push_back({cosine(), cosine(), 3.1415926f * share()});
    return directions;
}

/// Both vectors on the upper side of the layer, or wo on the lower side.
struct Vectors {
    Vector wi, wo;
};

inline Vectors vectors_of(const Direction& at, bool same_side, double turned = 0.7) {
    const auto sine = [](float mu) { return std::sqrt((1 - double{mu}) * (1 + double{mu})); };
    // Light travels along -wi: its azimuth is that of wi and half a turn.
    const double phi_in = turned, phi_out = turned + pi + double{at.azimuth};
    return {{static_cast<float>(sine(at.mu_in) * std::cos(phi_in)),
             static_cast<float>(sine(at.mu_in) * std::sin(phi_in)), at.mu_in},
            {static_cast<float>(sine(at.mu_out) * std::cos(phi_out)),
             static_cast<float>(sine(at.mu_out) * std::sin(phi_out)),
             same_side ? at.mu_out : -at.mu_out}};
}

}  // namespace stratus
