// The free parameters of a fit as coordinates of a unit cube, within the model's range.
#pragma once

#include <stratus/fit/fit.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace stratus {

constexpr const char* fit_caller = "fit_layer";  // in refusals

/// Both albedos free are varied as w1 + w2 and w1 / (w1 + w2), which tables are made of; the depth
/// is varied by its log2.
enum class Coordinate { log_depth, albedo, mixture, w1, w2, g1, g2 };

class ParameterSpace {
  public:
    using Point = Eigen::VectorXd;  // each coordinate in [0, 1]

    /// Errors   std::invalid_argument for values held outside the model's range.
    ParameterSpace(const LayerModel& model, const FitOptions& options);

    int size() const { return static_cast<int>(ranges_.size()); }
    Coordinate coordinate(int of) const { return ranges_[static_cast<std::size_t>(of)].of; }

    /// Place of a coordinate; -1: not free.
    int place(Coordinate wanted) const;

    LayerParameters layer(const Point& at) const;

    /// Derivatives of (ln optical depth, w1, w2, g1, g2) with respect to the point.
    Eigen::MatrixXd derivatives(const Point& at) const;

    /// A coordinate's value with its name: "w1 + w2", 0.9.
    std::string name(int of) const;
    double value(int of, double at) const;

    /// The middle, at the asymmetries that the phase functions have.
    Point start() const;

  private:
    struct Range {
        Coordinate of;
        double low, high;
    };

    void add(Coordinate of, Interval range);
    void add_albedos(const LayerModel& model, const FitOptions& options);
    void add_asymmetry(const LayerModel& model, int kind, const std::optional<double>& held,
                       bool is_free);

    LayerParameters held_;
    double albedo_ = 0, mixture_ = 1;  // where both albedos are free, of a range of one value
    bool mixes_ = false;               // both albedos free
    bool one_kind_ = false;
    std::vector<Range> ranges_;
};

}  // namespace stratus
