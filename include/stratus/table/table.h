// A baked table in memory: `Table` owns it, `TableView` is what a lookup reads.
//
// The samples are the multiply scattered light only (orders n >= 2 of the Neumann series), R or T
// over (albedo, optical_depth, mu_in, mu_out, azimuth) with azimuth contiguous. Single scattering
// is never tabulated: the lookup adds the closed form with the exact phase function. Of phase
// functions with a narrow peak the path law (path_law.h) is not tabulated either.
//
// A table may hold a family of phase functions (phase_family.h): one or two of their parameters are
// then further axes, before all others, and all numbers lie once for each member. A view is of one
// point of the family at a time: what is known in closed form is that of the phase function at the
// very parameters, the samples of the members around it are joined by a cubic. Two kinds of
// scattering, w P = w1 P1 + w2 P2 with w = w1 + w2, mix with `mixture` = w1 / w. [Blinn82] 4.3
//
// A stack of unlike layers (stack_layers.h) is one material: its table has one sample of
// optical_depth and albedo, those of the mean layer, as is phase_function. It is lit from above.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_curve.h>
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace stratus {

class PackedTable;  // packed_table.h

/// A table as lookups read it: plain pointers into memory that the caller owns and keeps alive (a
/// Table, or a renderer's own).
struct TableView {
    const PhaseFunction* phase_function;
    const PhaseCurve* phase_curve;        // the same, for slices
    const LowerBoundary* lower_boundary;  // null: none
    AxisView albedo, optical_depth, mu_in, mu_out, azimuth;

    // The family. Until a point is chosen the weights of its members are not-a-number.
    const FamilyAxes* family = nullptr;                    // null: none
    const PhaseFunction* second_phase_function = nullptr;  // of one with a mixture axis
    FamilyPoint chosen;
    double chosen_mixture = std::numeric_limits<double>::quiet_NaN();  // the share in it
    FamilyStencil members;  // around the point; one of all without a family
    std::shared_ptr<const PhaseFunction> own_phase_function;  // what `phase_function` points to
    std::shared_ptr<const PathOrders> own_path_law;           // what `path_law` points to

    const StackLayers* layers = nullptr;  // of a stack; null: one layer

    const float* reflection_multiple = nullptr;  // null when the table has no such side
    const float* transmission_multiple = nullptr;

    // Factors of the samples before they are interpolated (lookup.h): over (member,
    // albedo, optical_depth) for either side, and over (optical_depth, mu); 1 over a boundary.
    const float* reflection_weight;
    const float* transmission_weight;
    const float* mu_in_weight;
    const float* mu_out_weight;
    const double* diffusion_exponent;  // over (member, albedo)

    // Path law (path_law.h) that the samples leave to lookups; null: none. Orders above
    // `highest_order` are left out there, too, if that is not 0.
    const PathOrders* path_law = nullptr;
    int highest_order = 0;

    // Over (member, albedo, optical_depth, mu_in); null where the table does not have it.
    const float* diffuse_transmittance = nullptr;

    double extrapolation_length;  // optical depth; of the phase function before any is chosen
    const double* extrapolation_lengths;  // over members
    double tolerance;                     // that the samples were baked for; 0: unknown

    // The packed table that takes the place of samples and weights; null: none.
    const PackedTable* packed = nullptr;
    bool packed_reflection = false, packed_transmission = false;

    bool has_reflection() const noexcept {
        return reflection_multiple != nullptr || packed_reflection;
    }
    bool has_transmission() const noexcept {
        return transmission_multiple != nullptr || packed_transmission;
    }
    bool has(Side side) const noexcept {
        return side == Side::reflection ? has_reflection() : has_transmission();
    }
    bool has_lower_boundary() const noexcept {
        return lower_boundary != nullptr && lower_boundary->is_present();
    }
    /// True over a boundary whose light in the samples stays as the layer vanishes: no law is known of
    /// layers thinner than the samples'.
    bool keeps_light() const noexcept {
        return has_lower_boundary() && !lower_boundary->is_surface();
    }
    /// True where the law of thin layers goes on below the samples; one depth tells none, nor do deep ones.
    bool knows_thinner_layers() const noexcept {
        constexpr double deepest_thin = 2;
        return !keeps_light() && !is_stack() && optical_depth.count > 1 &&
               optical_depth.lowest <= deepest_thin;
    }
    bool has_family() const noexcept { return family != nullptr; }
    bool is_stack() const noexcept { return layers != nullptr; }

    /// True where mu_in and mu_out are sampled alike.
    bool has_same_cosines() const noexcept {
        return mu_in.count == mu_out.count && mu_in.lowest == mu_out.lowest &&
               mu_in.highest == mu_out.highest;
    }

    /// True where besides R and T are known on both ways, and symmetric in them: the T of a stack
    /// is not.
    bool is_symmetric() const noexcept { return has_same_cosines() && !is_stack(); }

    /// True where nothing narrows the directions: cosines from 0.01 or less to 1, all azimuths.
    bool has_all_directions() const noexcept;

    /// Views the table at one point of its family: for any number of lookups, slices, BSDFs.
    /// Beyond their samples the orders n >= 2 are those of the axes' ends. Until a point is chosen
    /// a table of a family answers lookups by not-a-number and refuses to be bound.
    ///
    /// Range    a value for each axis of the family, in their order (none without a family), such
    ///          that there is a phase function; of a discrete axis one of its values. A mixture is
    ///          the share of the first phase function, [0, 1].
    /// Errors   std::invalid_argument naming the axis, what is allowed and what was met.
    /// Cost     allocates. Droplets (mie) are computed at the first lookup, or here where there is
    ///          a path law.
    TableView at(const FamilyPoint& point) const;

    /// phi at the chosen point.
    double phase(double cos_scattering_angle) const noexcept {
        const double first = (*phase_function)(cos_scattering_angle);
        if (second_phase_function == nullptr) return first;
        return chosen_mixture * first +
               (1 - chosen_mixture) * (*second_phase_function)(cos_scattering_angle);
    }

    /// Returns the phase function at the chosen point as a function of its own.
    ///
    /// Errors   std::invalid_argument when the table has a family and no point of it was chosen.
    PhaseFunction chosen_phase_function() const;
};

/// A whole table, as files hold it.
struct Table {
    PhaseFunction phase_function;
    PhaseFunction second_phase_function;  // of families with a mixture axis
    LowerBoundary lower_boundary;  // with one, reflection is that of both, and no transmission
    StackLayers layers;            // of a stack, top first; empty: one layer
    // At most two; empty: `phase_function` alone. Its own value of the parameters is not used.
    FamilyAxes family;
    Axis albedo{AxisScale::square_root_of_complement, {}};
    Axis optical_depth{AxisScale::logarithmic, {}};
    Axis mu_in{AxisScale::arcsine_of_fourth_root, {}};
    Axis mu_out{AxisScale::arcsine_of_fourth_root, {}};
    // Radians, within 0 to pi, linear or square_root; linear 0 alone when nothing depends on it.
    Axis azimuth{AxisScale::linear, {}};

    // Orders n >= 2 over (albedo, optical_depth, mu_in, mu_out, azimuth); empty when the side was
    // not asked for. These, and all below, lie once for each member, one after the other.
    std::vector<float> reflection_multiple;
    std::vector<float> transmission_multiple;

    // Fluxes of all orders over (albedo, optical_depth, mu_in); no transmittance without
    // transmission.
    std::vector<float> plane_albedo;
    std::vector<float> diffuse_transmittance;

    std::vector<float> spherical_albedo;  // over (albedo, optical_depth)
    double spherical_albedo_below = 0;    // of a stack, lit from below; 0 where that is opaque

    std::vector<double> diffusion_exponent;  // over albedo
    double extrapolation_length = 1;         // optical depth
    // Over members; without a family `prepare` works them out.
    std::vector<double> extrapolation_lengths;

    double tolerance = 0;       // relative error asked for at the bake
    double measured_error = 0;  // largest relative error met at the bake's own check
    int highest_order = 0;      // 0: all orders; n: the series stops at order n

    // Everything else worth keeping, as text: title, recipe, resolved_recipe, conventions,
    // program_version, ...
    std::map<std::string, std::string> attributes;

    // The path law that the samples leave to lookups; null: none. Files say whether there is one; it follows
    // from the phase function.
    std::shared_ptr<const PathOrders> path_law;

    // Computed by `prepare`, not stored in files: see TableView.
    std::vector<float> reflection_weight, transmission_weight;
    std::vector<float> mu_in_weight, mu_out_weight;
    PhaseCurve phase_curve;

    /// Number of layers: of members, albedos and optical depths.
    std::size_t layer_count() const noexcept;

    /// Number of samples of one side.
    std::size_t sample_count() const noexcept;

    bool has_family() const noexcept { return !family.empty(); }
    bool is_stack() const noexcept { return !layers.empty(); }

    /// True of a family that is more than the mixtures of two phase functions.
    bool varies_parameters() const noexcept;

    /// 1 in a table without a family.
    std::size_t member_count() const noexcept { return stratus::member_count(family); }

    /// View for lookups, valid while this table lives and is not changed. Call `prepare` first.
    TableView view() const noexcept;
};

/// Checks a table (axes, extents, finite samples) and works out what lookups need. Every reader and
/// the bake end with it. A side or a flux may be absent (empty), but not both sides; an azimuth
/// axis that does not span 0 to pi has one sample or four at least.
///
/// Errors   std::invalid_argument naming the dataset, what is required and what was met.
void prepare(Table& table);

/// Checks a table as `prepare` does.
///
/// Errors   those of `prepare`.
void check(const Table& table);

/// Prepares a table without its samples and its phase curve.
void prepare_header(Table& table);

/// True where the family is the mixtures of two phase functions and nothing else.
bool is_mixture(const FamilyAxes& family) noexcept;

/// The phase function of a member of a family, or the only one.
PhaseFunction phase_function_of_member(const Table& table, std::size_t member);

}  // namespace stratus
