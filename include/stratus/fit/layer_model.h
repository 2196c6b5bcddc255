// What is observed of a layer, and the models that predict it: a table, single scattering alone
// [Blinn82] 2.4, the solver, or the beam alone.
//
// Particles are of one kind or of two, w P = w1 P1 + w2 P2 [Blinn82] 4.3; with one kind w1 is w and
// w2 is 0.
#pragma once

#include <stratus/runtime/effects.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/runtime/table.h>
#include <stratus/transfer/solver_options.h>

#include <memory>
#include <optional>
#include <vector>

namespace stratus {

/// What of the light is observed.
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
};

struct LayerParameters {
    double optical_depth = 0, w1 = 0, w2 = 0;
    double g1 = 0, g2 = 0;  // of Henyey-Greenstein phase functions

    double albedo() const { return w1 + w2; }
    double mixture() const { return albedo() > 0 ? w1 / albedo() : 1; }
};

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

    /// Of particles; 0: of a model that knows the beam alone.
    virtual int kinds() const = 0;
    virtual ParameterRanges ranges() const = 0;
    virtual bool has_depth(double effective_optical_depth) const = 0;
    virtual bool has(Light light) const = 0;
    virtual bool has_lower_boundary() const { return false; }

    /// Asymmetry of a kind of particles, 1 or 2, if it may be varied.
    virtual std::optional<double> asymmetry(int kind) const = 0;

    /// R or T by origin; anything for a beam. `optical_depth` is the effective one.
    virtual std::vector<Scattered> scattered(
        const LayerParameters& layer, const std::vector<Observation>& observations) const = 0;

    /// How many depths are worth a start of their own.
    virtual int scanned_depths() const { return 24; }

    /// What is observed, with density and opposition.
    std::vector<double> brightness(const LayerParameters& layer,
                                   const std::vector<Observation>& observations, double density = 0,
                                   const Opposition& opposition = {}) const;
};

/// A table, with or without a mixture axis; it must outlive the model.
///
/// Range    up to the largest finite depth; where the table holds one depth, albedo or mixture
///          alone, that one.
std::unique_ptr<LayerModel> table_model(const TableView& table);

/// Light scattered once, in closed form; the paper's own. Depths 1e-4 to 64, every albedo, and
/// asymmetries from -0.95 to 0.95 of what is Henyey-Greenstein.
std::unique_ptr<LayerModel> single_scattering_model(const PhaseFunction& first,
                                                    const std::optional<PhaseFunction>& second);

/// All orders from the solver, at the observed geometries: some milliseconds a layer. The same
/// ranges, but asymmetries from -0.9 to 0.9.
std::unique_ptr<LayerModel> solver_model(const PhaseFunction& first,
                                         const std::optional<PhaseFunction>& second,
                                         const SolverOptions& options);

/// Occultations alone: nothing but the optical depth.
std::unique_ptr<LayerModel> beam_model();

}  // namespace stratus
