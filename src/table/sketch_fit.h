// Coefficients of functions by weighted least squares at the directions of a sketch (layer_sums.h).
#pragma once

#include <vector>

namespace stratus {

/// P v are the coefficients of values v, with P = R^-1 Q^T W of W F = Q R: F the functions, W the
/// weights of the directions, Q by Gram-Schmidt, twice for the sake of rounding.
class SketchFit {
  public:
    SketchFit() = default;

    /// `function`: at the directions; `weight`: of each direction.
    SketchFit(const std::vector<std::vector<float>>& function, const std::vector<float>& weight);

    std::vector<float> coefficients(const std::vector<float>& values) const;

  private:
    std::vector<std::vector<float>> rows_;  // P
};

}  // namespace stratus
