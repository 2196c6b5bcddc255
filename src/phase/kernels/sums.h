// Sums where the time of a room goes, compiled once for each instruction set: Mie's series of many spheres
// (mie_scattering.h), with the same roundings in all, so that a phase function has the same bits on every
// machine; and orders of the path law (path_law.h), of many layers at once.
#pragma once

#include <stratus/base/instruction_set.h>

#include <cstddef>

namespace stratus {

constexpr std::size_t mie_lanes = 8;  // spheres or angles side by side

/// The terms with which the coefficients of spheres begin.
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

    // Terms of several spheres lie as [n / mie_lanes][row][n % mie_lanes], `rows` of them; matrices
    // row by row, `size` numbers each, a multiple of mie_lanes.

    /// Adds row^T row of each row to a matrix, up to the terms n < `used`, a multiple of mie_lanes.
    /// Only its diagonal and what is right of that are complete.
    void (*add_products)(const double* term, std::size_t rows, std::size_t used, std::size_t size,
                         double* matrix);

    /// Sums over the terms of the two rows from `first` on: of `sum` times the sums of the angles'
    /// terms, then of `difference` times their differences.
    void (*amplitudes)(const double* sum, const double* difference, std::size_t first,
                       std::size_t rows, std::size_t size, const AngleLanes* angle,
                       double (*value)[mie_lanes]);

    /// Adds v^T matrix v at `groups` times mie_lanes angles, v the sums or the differences of their
    /// terms, `size` of each group; the matrix is 0 left of its diagonal.
    void (*add_form)(double (AngleLanes::*part)[mie_lanes], const double* matrix, std::size_t size,
                     const AngleLanes* angle, std::size_t groups, double (*value)[mie_lanes]);
};

/// Rows of numbers over orders, each number twice: `columns` of them, 64 or more.
struct OrderRows {
    const float* value;
    std::size_t columns, orders;
};

struct PathSums {
    /// Weighted sums over the orders, of `rows` pairs of weights for each order: of the numbers in
    /// even columns with the first of each pair, in odd ones with the second; used[row] orders.
    void (*sums)(const OrderRows&, const float* weight, const int* used, std::size_t rows,
                 float* to);
};

}  // namespace stratus
