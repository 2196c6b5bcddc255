// Weighted least squares by Levenberg-Marquardt within a unit cube, whose coordinates are the free parameters of
// a fit within the model's range, and what a minimum is worth: the probability of its chi-square, and remarks on
// what its geometries leave open and what contradicts the model.
#pragma once

#include <stratus/base/size.h>
#include <stratus/fit/fit.h>

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

constexpr const char* fit_caller = "fit_layer";  // in refusals

constexpr Eigen::Index index(std::size_t n) { return static_cast<Eigen::Index>(n); }

/// A FitParameter, or one of two more: both albedos free are varied as w1 + w2 and w1 / (w1 + w2),
/// which tables are made of. The depth, radii, wavelengths and variances are varied by their log2.
using Coordinate = std::size_t;
constexpr Coordinate sum_of_albedos = fit_parameters, share_of_first = fit_parameters + 1;

/// The coordinates of phase functions.
inline constexpr std::array of_phase_functions{fit_g1, fit_g2, fit_radius, fit_wavelength,
                                               fit_variance};

class ParameterSpace {
  public:
    using Point = Eigen::VectorXd;  // each coordinate in [0, 1]

    /// Errors   std::invalid_argument for values held outside the model's range, and for parameters
    ///          that are neither held nor known of the observations though the model does not vary
    ///          them.
    ParameterSpace(const LayerModel& model, const Observations& observations,
                   const FitOptions& options);

    int size() const { return int_size(ranges_); }
    Coordinate coordinate(int of) const { return ranges_[stratus::size(of)].of; }

    /// Place of a coordinate; -1: not free.
    int place(Coordinate wanted) const;

    LayerParameters layer(const Point& at) const;

    /// Derivatives of the parameters with respect to the point: of the logarithms of some.
    Eigen::MatrixXd derivatives(const Point& at) const;

    /// True where it is that of the logarithm; not of a parameter that is held.
    bool is_logarithm(Coordinate coordinate) const;

    /// From one end of a coordinate's range to the other, or of its logarithm; 0: not varied itself.
    double extent(Coordinate coordinate) const;

    /// A coordinate's value with its name: "w1 + w2", 0.9.
    std::string name(int of) const;
    double value(int of, double at) const;

    /// The middle, at the asymmetries that phase functions have.
    Point start() const;

  private:
    struct Range {
        Coordinate of;
        double low, high;  // of log2 where that is varied

        bool is_logarithm() const {
            return of == fit_optical_depth || (of >= fit_radius && of <= fit_variance);
        }
        double extent() const;
    };

    void add(Coordinate of, Interval range);
    void add_albedos(const LayerModel& model, const FitOptions& options);
    void add_asymmetry(const LayerModel& model, int kind, const std::optional<double>& held,
                       bool is_free);
    void add_family(const LayerModel& model, const Observations& observations,
                    const FitOptions& options);

    const std::array<const char*, fit_parameters> names_;
    LayerParameters held_;
    double albedo_ = 0, mixture_ = 1;  // where both albedos are free, of a range of one value
    bool mixes_ = false;               // both albedos free
    bool one_kind_ = false;
    std::vector<Range> ranges_;
};

struct Problem {
    using Point = ParameterSpace::Point;

    const LayerModel& model;
    const ParameterSpace& space;
    const Observations& observations;
    const FitOptions& options;

    /// (model - observed) / sigma of all observations.
    Eigen::VectorXd residuals(const Point& at) const;

    /// Central differences of the residuals, within the cube; 0 for the coordinate that is held.
    Eigen::MatrixXd derivatives(const Point& at, std::optional<int> held = {}) const;
};

struct Minimum {
    Problem::Point at;
    double chi_square;
    bool is_reached;  // false: chi-square was still falling after `most_steps`
};

constexpr int most_steps = 1000;  // narrow curved valleys take hundreds

/// Levenberg-Marquardt: a coordinate at an edge stays there while chi-square falls outwards. `held`
/// is one that is not varied. Ends with a step that lowers chi-square by less than the share
/// `tolerance` and is shorter than the root of it.
Minimum descend(const Problem& problem, Problem::Point at, std::optional<int> held = {},
                double tolerance = 1e-8);

/// Local minima over the optical depth, and over a radius or wavelength that is free, the others fitted at each:
/// scans of all values. For that of the depth, parameters of phase functions that are free start from three values each.
std::vector<Minimum> scan_minima(const Problem& problem);

/// The probability of so large a chi-square or a larger one, Q(degrees / 2, chi_square / 2).
///
/// Range    chi_square [0, inf]; degrees_of_freedom above 0.
/// Accuracy 1e-13 relative: half-integer incomplete gamma functions are finite sums of positive
///          terms.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept;

}  // namespace stratus
