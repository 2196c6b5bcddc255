// Remarks on a fit: what its geometries leave open, and what contradicts the model.
#pragma once

#include "least_squares.h"

#include <vector>

namespace stratus {

/// Adds the remarks of a fit whose estimates, covariance and chi-square are known. `covariance` is
/// in the terms of ParameterSpace::derivatives; `minima` are sorted, the best first.
void add_remarks(const Problem& problem, const LayerModel& model,
                 const std::vector<Minimum>& minima, const Eigen::MatrixXd& covariance, Fit& fit);

}  // namespace stratus
