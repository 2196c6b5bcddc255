// Mie's series of many spheres, where the time of mie_scattering.cpp goes: compiled once for each
// instruction set, with the same roundings in all, so that a phase function has the same bits on
// every machine.
#pragma once

#include <cstddef>

namespace stratus {

constexpr std::size_t mie_lanes = 8;  // spheres or angles side by side

/// What the coefficients of spheres begin with.
struct SphereLanes {
    double x[mie_lanes], sine[mie_lanes], cosine[mie_lanes];  // of x
    double terms[mie_lanes];                                  // in the series of each
};

/// a_n and b_n of spheres.
struct CoefficientLanes {
    double a_re[mie_lanes], a_im[mie_lanes], b_re[mie_lanes], b_im[mie_lanes];
};

/// A term of the series at angles: pi_n + tau_n and pi_n - tau_n. [BH83] 4.47
struct AngleLanes {
    double sum[mie_lanes], difference[mie_lanes];
};

/// Where the recurrences of a series of `count` terms begin.
struct SeriesLength {
    std::size_t count;       // terms of the longest
    std::size_t derivative;  // of the logarithmic derivatives
    std::size_t ratio;       // of the ratios of Riccati-Bessel functions
};

struct SphereSums {
    /// `count` coefficients of spheres whose index is m_re + i m_im, 0 beyond the terms of each.
    /// `scratch` holds 3 (count + 1) mie_lanes numbers.
    void (*coefficients)(const SphereLanes& spheres, double m_re, double m_im,
                         const SeriesLength& length, double* scratch,
                         CoefficientLanes* coefficients);

    /// Adds row^T row of each of `rows` rows of `size` numbers, a multiple of mie_lanes, to a square
    /// matrix; rows of both lie `stride` apart. Only what is right of its diagonal, and that, is
    /// complete.
    void (*add_products)(const double* row, std::size_t rows, std::size_t size, std::size_t stride,
                         double* matrix);

    /// Sums over the real and over the imaginary numbers of a sphere, two rows `stride` apart: of
    /// `sum` times the sums of the angles' terms, then of `difference` times their differences.
    void (*amplitudes)(const double* sum, const double* difference, std::size_t size,
                       std::size_t stride, const AngleLanes* angle, double (*value)[mie_lanes]);

    /// v^T matrix v at the angles, v the sums or the differences of their terms, of a matrix whose
    /// left lower half is 0; `size` is a multiple of mie_lanes.
    void (*sum_form)(const double* matrix, std::size_t size, std::size_t stride,
                     const AngleLanes* angle, double* value);
    void (*difference_form)(const double* matrix, std::size_t size, std::size_t stride,
                            const AngleLanes* angle, double* value);
};

/// For this machine.
const SphereSums& sphere_sums() noexcept;

}  // namespace stratus
