// The distribution of chi-square, which tells whether a model explains its observations.
#pragma once

namespace stratus {

/// The probability of so large a chi-square or a larger one, Q(degrees / 2, chi_square / 2).
///
/// Range    chi_square [0, inf]; degrees_of_freedom above 0.
/// Accuracy 1e-13 relative: half-integer incomplete gamma functions are finite sums of positive
///          terms.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept;

}  // namespace stratus
