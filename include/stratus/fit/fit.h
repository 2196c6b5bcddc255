// Properties of a layer from its observed brightness: the inversion of [Blinn82] 4.3.
//
// The unknowns are the albedos w1 and w2 of two kinds of particles, w P = w1 P1 + w2 P2 (or w of
// one), the optical depth and, when asked for, the asymmetries g1 and g2 of Henyey-Greenstein phase
// functions. Of a table of a family they are its parameters, too: g1, or radius, wavelength and
// variance of droplets. Any of them may be held, and observations may bring the values of a family's
// parameters themselves. Levenberg-Marquardt minimises chi-square within the model's range, starting
// from every local minimum of a scan over the optical depth.
#pragma once

#include <stratus/fit/layer_model.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

struct FitOptions {
    // Held at this value; without one they are free. Of particles of one kind w1 is w.
    std::optional<double> optical_depth, w1, w2;

    // Parameters of a table's family, lengths in um. Where it holds just some values of a parameter,
    // that must be held or known of each observation.
    std::optional<double> radius, wavelength, variance;

    // Asymmetries are those of the phase functions, or held at this value, or free when asked; free
    // unless held where they are an axis of a table.
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

/// Values held, in the order of FitParameter.
inline constexpr std::array<std::optional<double> FitOptions::*, fit_parameters> held_fields{
    &FitOptions::optical_depth,
    &FitOptions::w1,
    &FitOptions::w2,
    &FitOptions::g1,
    &FitOptions::g2,
    &FitOptions::radius,
    &FitOptions::wavelength,
    &FitOptions::variance};

struct Fit {
    std::array<FittedValue, fit_parameters> estimate;

    /// Symmetric; rows of parameters that were held are 0.
    std::array<std::array<double, fit_parameters>, fit_parameters> covariance{};

    /// The correlation of two parameters that were fitted, in [-1, 1]; 0 with one that was held.
    double correlation(std::size_t one, std::size_t other) const {
        const double sigmas = estimate[one].sigma * estimate[other].sigma;
        return sigmas > 0 ? std::clamp(covariance[one][other] / sigmas, -1.0, 1.0) : 0;
    }

    /// Brightness of each observation by the model; the residual is the observed one less this.
    std::vector<double> brightness;

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
    const FittedValue& radius() const { return estimate[fit_radius]; }
};

/// The remark that chi-square refuses the model is made below this probability.
constexpr double refusing_probability = 1e-3;

/// Names of the parameters, in the order of a covariance matrix: optical_depth; w1, w2, g1, g2 or, of
/// particles of one kind, w and g; radius, wavelength, variance.
std::array<const char*, fit_parameters> fit_parameter_names(const LayerModel& model);

/// Parameters that the model has: albedos, the optical depth, asymmetries, and what its family varies.
std::vector<FitParameter> model_parameters(const LayerModel& model);

/// True for parameters that the model has, and that are neither held nor known of the observations.
std::array<bool, fit_parameters> free_parameters(const LayerModel& model,
                                                 const std::vector<Observation>& observations,
                                                 const FitOptions& options);

/// The number of parameters that are fitted.
std::size_t free_parameter_count(const LayerModel& model,
                                 const std::vector<Observation>& observations,
                                 const FitOptions& options);

/// Fits what is free to at least as many observations.
///
/// Errors   std::invalid_argument for fewer; for an observation out of range or of light that the
///          model does not know; for options out of range, for an asymmetry of a phase function
///          that is not Henyey-Greenstein, and for parameters that no family of a table varies.
/// Threads  safe; the same bits every time.
Fit fit_layer(const LayerModel& model, const std::vector<Observation>& observations,
              const FitOptions& options = {});

/// Fits a table.
Fit fit_layer(const TableView& table, const std::vector<Observation>& observations,
              const FitOptions& options = {});

}  // namespace stratus
