// Random numbers, directions and running sums, which all solvers by photons share.
#pragma once

#include <stratus/transfer/reference/photons.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace stratus {

/// Uniform numbers straight from the engine: standard distributions differ between libraries.
class Random {
  public:
    Random(std::uint64_t seed, std::uint64_t beam, std::uint64_t batch) {
        std::vector<std::uint32_t> words;
        for (const std::uint64_t part : {seed, beam, batch})
            for (const int shift : {0, 32})
                words.push_back(static_cast<std::uint32_t>(part >> shift));
        std::seed_seq sequence(words.begin(), words.end());
        engine_.seed(sequence);
    }

    /// In [0, 1).
    double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  private:
    std::mt19937_64 engine_;
};

/// A unit vector; over a plane layer z points up, out of the lit side.
struct Direction {
    double x, y, z;
};

inline double dot(const Direction& a, const Direction& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// A direction turned by a scattering angle of cosine 1 - 2 v.
inline Direction scattered(const Direction& from, double v, double azimuth) {
    const double cosine = 1 - 2 * v, sine = 2 * std::sqrt(v * (1 - v));
    const double a = sine * std::cos(azimuth), b = sine * std::sin(azimuth);
    const double flat = std::sqrt(from.x * from.x + from.y * from.y);
    const double ex = flat > 0 ? -from.y / flat : 1, ey = flat > 0 ? from.x / flat : 0;  // across
    Direction to{cosine * from.x + a * ex - b * from.z * ey,
                 cosine * from.y + a * ey + b * from.z * ex,
                 cosine * from.z + b * (from.x * ey - from.y * ex)};
    const double length = std::sqrt(dot(to, to));  // keeps rounding from accumulating along a path
    return {to.x / length, to.y / length, to.z / length};
}

/// Running sums of one quantity over photons.
struct Tally {
    double sum = 0, squares = 0;

    void add(double value) {
        sum += value;
        squares += value * value;
    }
    void add(const Tally& other) {
        sum += other.sum;
        squares += other.squares;
    }
    Estimate estimate(std::uint64_t photons) const {
        const auto n = static_cast<double>(photons);
        const double mean = sum / n;
        return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1))};
    }
};

}  // namespace stratus
