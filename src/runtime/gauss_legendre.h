// Gauss-Legendre quadrature of any number of nodes.
#pragma once

#include <cstddef>
#include <vector>

namespace stratus {

/// On [-1, 1], x descending from near 1.
struct GaussLegendre {
    std::vector<double> x, weight;

    /// Zeros of P_count by Newton's method from their asymptotic places.
    ///
    /// Range    count at least 1.
    explicit GaussLegendre(std::size_t count);
};

}  // namespace stratus
