// Properties of a layer from its observed brightness: the inversion of [Blinn82] 4.3.
//
// The unknowns are the albedos w1 and w2 of two kinds of particles, w P = w1 P1 + w2 P2 (or w of
// one), the optical depth and, when asked for, the asymmetries g1 and g2 of Henyey-Greenstein phase
// functions. Any of them may be held. Levenberg-Marquardt minimises chi-square within the model's
// range, starting from every local minimum of a scan over the optical depth.
#pragma once

#include <stratus/fit/layer_model.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

struct FitOptions {
    // Held at this value; without one they are free. Of particles of one kind w1 is w.
    std::optional<double> optical_depth, w1, w2;

    // Asymmetries are those of the phase functions, or held at this value, or free when asked.
    std::optional<double> g1, g2;
    bool free_g1 = false, free_g2 = false;

    // Known of the layer beforehand. The optical depth is that of the layer, not the effective one.
    double density = 0;
    Opposition opposition;
};

/// A fitted parameter and its standard deviation, from the model linearised at the best fit; 0 for
/// one that was held.
struct FittedValue {
    double value = 0, sigma = 0;
};

/// Places of the parameters in a covariance matrix.
enum FitParameter { fit_optical_depth, fit_w1, fit_w2, fit_g1, fit_g2, fit_parameters };

struct Fit {
    std::array<FittedValue, fit_parameters> estimate;

    /// Symmetric; rows of parameters that were held are 0.
    std::array<std::array<double, fit_parameters>, fit_parameters> covariance{};

    double chi_square = 0;
    int degrees_of_freedom = 0;  // observations less free parameters

    /// That errors as stated give so large a chi-square or a larger one; 1 without degrees of
    /// freedom.
    double probability = 1;

    /// Caveats: a chi-square that refuses the model, a parameter that the geometries do not
    /// determine, one at the edge of its range, another layer that fits as well.
    std::vector<std::string> remarks;

    const FittedValue& optical_depth() const { return estimate[fit_optical_depth]; }
    const FittedValue& w1() const { return estimate[fit_w1]; }
    const FittedValue& w2() const { return estimate[fit_w2]; }
    const FittedValue& g1() const { return estimate[fit_g1]; }
    const FittedValue& g2() const { return estimate[fit_g2]; }
};

/// The remark that chi-square refuses the model is made below this probability.
constexpr double refusing_probability = 1e-3;

/// Names of the parameters, in the order of a covariance matrix: optical_depth, then w1, w2, g1, g2
/// or, of particles of one kind, w and g.
std::array<const char*, fit_parameters> fit_parameter_names(const LayerModel& model);

/// True for parameters that the model has and that are not held.
std::array<bool, fit_parameters> free_parameters(const LayerModel& model,
                                                 const FitOptions& options);

/// The number of parameters that are fitted.
std::size_t free_parameter_count(const LayerModel& model, const FitOptions& options);

/// Fits what is free to at least as many observations.
///
/// Errors   std::invalid_argument for fewer; for an observation out of range or of light that the
///          model does not know; for options out of range, and for an asymmetry of a phase function
///          that is not Henyey-Greenstein.
/// Threads  safe; the same bits every time.
Fit fit_layer(const LayerModel& model, const std::vector<Observation>& observations,
              const FitOptions& options = {});

/// The same for a table.
Fit fit_layer(const TableView& table, const std::vector<Observation>& observations,
              const FitOptions& options = {});

}  // namespace stratus
