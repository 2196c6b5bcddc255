// Weighted least squares within a unit cube, by Levenberg-Marquardt.
#pragma once

#include "parameter_space.h"

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

}  // namespace stratus
