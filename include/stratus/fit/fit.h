// Observations of a layer, and the models that predict them: a table, single scattering alone
// [Blinn82] 2.4, the solver, or the beam alone.
//
// Particles are of one kind or of two, w P = w1 P1 + w2 P2 [Blinn82] 4.3; with one kind w1 is w and
// w2 is 0. Parameters that a table's family varies (phase_family.h) are those of the first kind; each
// observation may bring its own value of one, a spectrum its wavelengths.
#pragma once

#include <stratus/layer/effects.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>
#include <stratus/table/lookup.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// The part of the light that is observed.
enum class Light {
    reflected,    // I/F = mu_in R
    transmitted,  // I/F = mu_in T, diffuse, on the unlit side
    beam,         // I/F0 = exp(-tau / mu_out): an occultation of a star or the sun
};

struct Observation {
    Geometry geometry;  // of a beam mu_out alone counts
    Light light;
    double brightness;  // I/F, of a beam I/F0
    double sigma;       // its standard deviation

    // Values known of this observation alone: parameters of a table's family, in the order of its axes;
    // not-a-number, and `mixture`: that of the layer.
    FamilyPoint known{};
};
using Observations = std::vector<Observation>;

/// Places of the parameters in a covariance matrix.
enum FitParameter {
    fit_optical_depth,
    fit_w1,
    fit_w2,
    fit_g1,
    fit_g2,
    fit_radius,
    fit_wavelength,
    fit_variance,
    fit_parameters
};

struct LayerParameters {
    double optical_depth = 0, w1 = 0, w2 = 0;
    double g1 = 0, g2 = 0;                            // of Henyey-Greenstein phase functions
    double radius = 0, wavelength = 0, variance = 0;  // of droplets (mie), um

    double albedo() const { return w1 + w2; }
    double mixture() const { return albedo() > 0 ? w1 / albedo() : 1; }
};

/// Its numbers in the order of FitParameter.
inline constexpr std::array<double LayerParameters::*, fit_parameters> layer_fields{
    &LayerParameters::optical_depth,
    &LayerParameters::w1,
    &LayerParameters::w2,
    &LayerParameters::g1,
    &LayerParameters::g2,
    &LayerParameters::radius,
    &LayerParameters::wavelength,
    &LayerParameters::variance};

/// The parameter that an axis of a family varies; none for `mixture`, which w1 and w2 determine.
std::optional<FitParameter> to_fit_parameter(PhaseParameter parameter) noexcept;

struct Interval {
    double low, high;

    bool contains(double value) const { return value >= low && value <= high; }
};

/// Where a model is fitted; an interval of one value is one that the model knows alone.
struct ParameterRanges {
    Interval optical_depth;  // that light meets, with the effect of density
    Interval albedo;         // w1 + w2
    Interval mixture;        // w1 / (w1 + w2); {1, 1} for particles of one kind
    Interval g;
};

/// Predicts R and T of a layer.
class LayerModel {
  public:
    virtual ~LayerModel() = default;

    /// How many kinds of particles there are; 0 for a model of the beam alone.
    virtual int kinds() const = 0;
    virtual ParameterRanges ranges() const = 0;
    virtual bool has_depth(double effective_optical_depth) const {
        return effective_optical_depth >= 0;
    }
    virtual bool has(Light light) const = 0;

    /// Refuses, as `caller`, light that the model has but not in the directions of an observation.
    virtual void check_directions(const char* /*caller*/, const Observation&) const {}

    virtual bool has_lower_boundary() const { return false; }

    /// Axes over parameters of the first phase function that the model has sampled; none: it has not.
    virtual FamilyAxes family() const { return {}; }

    /// Asymmetry of a kind of particles, 1 or 2, if it may be varied without an axis.
    virtual std::optional<double> asymmetry(int /*kind*/) const { return {}; }

    /// R or T by origin; anything for a beam. `optical_depth` is the effective one.
    virtual std::vector<Scattered> scattered(const LayerParameters& layer,
                                             const Observations& observations) const = 0;

    /// Estimated error at a layer: the largest of the observations', in their standard deviations.
    /// `optical_depth` is the effective one here, too, and in `refined`.
    virtual double error(const LayerParameters&, const Observations&) const { return 0; }

    /// Names that error in a remark.
    virtual const char* error_name() const { return "the solver's error"; }

    /// The model with its error at a layer within `tolerance` standard deviations; null where it
    /// cannot be lower.
    virtual std::unique_ptr<LayerModel> refined(const LayerParameters&, const Observations&,
                                                double /*tolerance*/) const {
        return nullptr;
    }

    /// How many depths are worth a start of their own.
    virtual int scanned_depths() const { return 24; }

    /// Predicts the brightness, with density and opposition.
    std::vector<double> brightness(const LayerParameters& layer, const Observations& observations,
                                   double density = 0, const Opposition& opposition = {}) const;
};

/// A table of one phase function or of a family; it must outlive the model.
///
/// Range    up to the largest finite depth; where the table holds one depth, albedo or mixture
///          alone, that one. A depth that is held may be less than the first where the law of thin
///          layers is known.
/// Errors   std::invalid_argument for a family that holds just some mixtures; a fit refuses
///          observations in directions that the table leaves out.
/// Accuracy lookups of droplets are joined by cubics over radii, wavelengths and variances of steps of
///          5 %: 1e-4 of them or so where the variance is 0.02 or more, up to 2e-3 straight back. So are those
///          of narrow peaks.
/// Cost     of a table of droplets that of their phase function (mie.h) at every such step that is
///          tried, once for all fits.
std::unique_ptr<LayerModel> table_model(const TableView& table);

/// Light scattered once, in closed form; the paper's own. Depths 1e-4 to 64, every albedo, and
/// asymmetries from -0.95 to 0.95 of what is Henyey-Greenstein.
std::unique_ptr<LayerModel> single_scattering_model(const PhaseFunction& first,
                                                    const std::optional<PhaseFunction>& second);

/// All orders from the solver, at the observed geometries: some milliseconds a layer. The same
/// ranges, but asymmetries from -0.9 to 0.9. `nodes`: Gauss nodes at first; refined, up to 164.
std::unique_ptr<LayerModel> solver_model(const PhaseFunction& first,
                                         const std::optional<PhaseFunction>& second,
                                         int nodes = 24);

/// Occultations alone: nothing but the optical depth.
std::unique_ptr<LayerModel> beam_model();

// Properties of a layer from its observed brightness: the inversion of [Blinn82] 4.3.
//
// The unknowns are the albedos w1 and w2 of two kinds of particles, w P = w1 P1 + w2 P2 (or w of
// one), the optical depth and, when asked for, the asymmetries g1 and g2 of Henyey-Greenstein phase
// functions. Of a table of a family they are its parameters, too: g1, or radius, wavelength and
// variance of droplets. Any of them may be held, and observations may bring the values of a family's
// parameters themselves. Levenberg-Marquardt minimises chi-square within the model's range, starting
// from every local minimum of scans over the optical depth and, where it is free, the radius or wavelength.

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

    /// That errors as stated give so large a chi-square or a larger one. Without degrees of freedom it is
    /// for as many as there are parameters at an edge of their range, which fit no more, or for one.
    double probability = 1;

    /// Caveats: a chi-square that refuses the model, or that was still falling, a parameter that the
    /// geometries do not determine, one at the edge of its range, another layer that fits as well.
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
                                                 const Observations& observations,
                                                 const FitOptions& options);

/// The number of parameters that are fitted.
std::size_t free_parameter_count(const LayerModel& model, const Observations& observations,
                                 const FitOptions& options);

/// Fits what is free to at least as many observations.
///
/// Errors   std::invalid_argument for fewer; for an observation out of range or of light that the
///          model does not know; for options out of range, for an asymmetry of a phase function
///          that is not Henyey-Greenstein, and for parameters that no family of a table varies.
/// Threads  safe; the same bits every time.
Fit fit_layer(const LayerModel& model, const Observations& observations,
              const FitOptions& options = {});

/// Fits a table.
Fit fit_layer(const TableView& table, const Observations& observations,
              const FitOptions& options = {});

}  // namespace stratus
