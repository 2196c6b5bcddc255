// Gauss-Legendre quadrature of any number of nodes, and the polynomial through values at any places.
#pragma once

#include <cstddef>
#include <vector>

namespace stratus {

/// The positive half of the 8-point rule on [-1, 1].
inline constexpr double gauss_8_node[4] = {0.18343464249564980494, 0.52553240991632898582,
                                           0.79666647741362673959, 0.96028985649753623168};
inline constexpr double gauss_8_weight[4] = {0.36268378337836198297, 0.31370664587788728734,
                                             0.22238103445337447054, 0.10122853629037625915};

/// On [-1, 1], x descending from near 1.
struct GaussLegendre {
    std::vector<double> x, weight;

    /// Zeros of P_count by Newton's method from their asymptotic places.
    ///
    /// Range    count at least 1.
    explicit GaussLegendre(std::size_t count);
};

/// Returns the weights that values at `x` have in the polynomial through them, at `at` (Lagrange).
std::vector<double> lagrange_weights(const std::vector<double>& x, double at);

}  // namespace stratus
