// Random numbers, directions and running sums, which all solvers by photons share.
#pragma once

#include <stratus/transfer/reference/solvers.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
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

// Scattering angles of photons: fast values of a phase function, and directions drawn from it.
//
// Angles enter as v = (1 - cos Theta)/2 = sin^2(Theta/2), the share of the sphere within Theta.

/// A phase function whose Legendre series are summed once, on a grid of Theta.
///
/// The grid is uniform over x = (1 + sin(Theta/2) - cos(Theta/2)) / 2, nearly the angle itself, with
/// 32 intervals for each moment, at least 4096: 50 points to an oscillation of the last one. Cubics
/// join them.
///
/// Accuracy exact without Legendre series; 1e-7 of the value with one that has fallen off at its
///          last moment, otherwise 1e-6 of that moment's share (2 l + 1) chi_l more.
/// Cost     32 multiplications for each pair of moments once; 10 ns a value.
class PhaseValues {
  public:
    explicit PhaseValues(const PhaseFunction& phase_function);

    double operator()(double cos_scattering_angle) const noexcept;

  private:
    double series(double cos_scattering_angle) const noexcept;

    PhaseFunction closed_;  // all but Legendre series, scaled to mean 1
    double closed_share_ = 1;
    std::vector<double> sample_;  // of the series: at x = -h, 0, h, ..., 1, 1 + h
    double intervals_ = 0;        // 1/h
};

/// Draws scattering angles from |phi| tabulated on a grid of Theta and linear in v between. The
/// density is known exactly, so that weights phi/density leave no bias.
class AngleSampler {
  public:
    explicit AngleSampler(const PhaseValues& phase);

    struct Sample {
        double v;
        double density;  // relative to a uniform one over the sphere; never 0
    };

    /// Draws by two uniform numbers in [0, 1).
    Sample sample(double bin_number, double place) const noexcept;

    double density(double v) const noexcept;

  private:
    /// Floor of the density (mean 1): angles where phi is 0 or changes sign are sampled too.
    static constexpr double min_height = 1e-3;

    std::vector<double> v_, height_;  // at the grid points; height_ has mean 1
    std::vector<double> cumulative_;  // the density's integral up to each bin's end
    std::vector<std::size_t> first_;  // bin of the cumulative values i/first_.size()
};

}  // namespace stratus
