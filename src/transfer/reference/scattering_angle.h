// Scattering angles of photons: fast values of a phase function, and directions drawn from it.
//
// Angles enter as v = (1 - cos Theta)/2 = sin^2(Theta/2), the share of the sphere within Theta.
#pragma once

#include <stratus/phase/phase_function.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace stratus {

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
