// Weighted least squares within a unit cube, by Levenberg-Marquardt, and what a minimum is worth: the probability
// of its chi-square, and remarks on what its geometries leave open and what contradicts the model.
#pragma once

#include "parameter_space.h"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace stratus {

class Problem {
  public:
    using Point = ParameterSpace::Point;

    Problem(const LayerModel& model, const ParameterSpace& space,
            const std::vector<Observation>& observations, const FitOptions& options)
        : model_(model), space_(space), observations_(observations), options_(options) {}

    const LayerModel& model() const { return model_; }
    const ParameterSpace& space() const { return space_; }

    /// (model - observed) / sigma of all observations.
    Eigen::VectorXd residuals(const Point& at) const;

    /// Central differences of the residuals, within the cube; 0 for the coordinate that is held.
    Eigen::MatrixXd derivatives(const Point& at, std::optional<int> held = {}) const;

  private:
    const LayerModel& model_;
    const ParameterSpace& space_;
    const std::vector<Observation>& observations_;
    const FitOptions& options_;
};

struct Minimum {
    Problem::Point at;
    double chi_square;
};

/// Levenberg-Marquardt: a coordinate at an edge stays there while chi-square falls outwards. `held`
/// is one that is not varied. Ends with a step that lowers chi-square by less than the share
/// `tolerance` and is shorter than the root of it.
Minimum descend(const Problem& problem, Problem::Point at, std::optional<int> held = {},
                double tolerance = 1e-8);

/// Local minima over the optical depth, the others fitted at each: a scan of all depths.
/// Parameters of phase functions that are free start from three values each.
std::vector<Minimum> scan_minima(const Problem& problem);

/// The probability of so large a chi-square or a larger one, Q(degrees / 2, chi_square / 2).
///
/// Range    chi_square [0, inf]; degrees_of_freedom above 0.
/// Accuracy 1e-13 relative: half-integer incomplete gamma functions are finite sums of positive
///          terms.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept;

/// Adds the remarks of a fit whose estimates, covariance and chi-square are known. `covariance` is
/// in the terms of ParameterSpace::derivatives; `minima` are sorted, the best first.
void add_remarks(const Problem& problem, const LayerModel& model,
                 const std::vector<Minimum>& minima, const Eigen::MatrixXd& covariance, Fit& fit);

}  // namespace stratus
