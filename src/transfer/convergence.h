// Values solved with more and more nodes, and the errors that their changes tell.
//
// Let d_k be the change of a value from level k - 1 to level k, relative to it, and D_k the mean of
// d_k over all values, as the square of the mean root: a few large changes, near forward, do not make
// up all of it. With the decay q = sqrt(D_k / D_k-2), the mean error that is left after level k is
// D_k (q + q^2 + ...) = D_k q / (1 - q); at the third level, q = D_k / D_k-1. One value's share of it
// is the largest of d / D at the last three levels: a single change may be small by chance, all three
// hardly. For the same reason q is kept between bounds, and no share is below 1.
#pragma once

#include <cstddef>
#include <vector>

namespace stratus {

class Convergence {
  public:
    /// Values at the next level, as many and in the same order as at all levels.
    void add(std::vector<double> values);

    /// True from the third level on.
    bool can_tell() const noexcept { return values_.size() >= 3; }

    /// Estimated errors of the values last added, absolute. Needs can_tell().
    std::vector<double> errors() const;

    /// By what factor the changes have decayed from level to level, not bounded. Needs can_tell().
    double decay() const;

  private:
    static constexpr std::size_t most_levels = 4;  // that are kept

    std::vector<double> changes(std::size_t level) const;  // d
    double mean_change(std::size_t level) const;           // D

    std::vector<std::vector<double>> values_;
};

}  // namespace stratus
