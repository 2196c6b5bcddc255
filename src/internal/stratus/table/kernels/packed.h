// Lookups in a PackedTable: single scattering in closed form, and sixteen or more functions of the
// directions times the coefficients of an albedo and optical depth; one lookup at a time or many
// side by side, compiled once for each instruction set (base/lanes.h says how that is kept apart).
#pragma once

#include <stratus/base/half.h>
#include <stratus/base/instruction_set.h>
#include <stratus/layer/diffusion.h>
#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_curve.h>
#include <stratus/table/packed_table.h>

#include <cstddef>

namespace stratus {

// Functions that a lookup sums: all sides have a multiple of the fewest, floats of which are a cache line.
constexpr int fewest_functions = 16, most_functions = 32;

/// The layers between two albedos and two optical depths.
struct LayerBlock {
    /// Rows of functions over (mu, mu', azimuth). Where R and T are known for the same cosines on
    /// both ways they are symmetric in them: row i over mu has mu' = 0 .. i + 3 alone, and mu is
    /// the one whose cubic starts at the higher sample. Elsewhere it is that of the incident light.
    /// Where there are azimuths, a mirrored sample lies beyond either end.
    const void* function;
    const float* coefficient;       // over (albedo, optical depth, function)
    int first_albedo, first_depth;  // of the coefficients: samples of the table
    int albedos, depths;            // of the coefficients, infinity included
};

/// An axis of four samples at least, or one of a single sample that stands for four.
struct PackedAxis {
    float first, inverse_step;
    float last;  // index
};

constexpr float path_onset = 8;  // slant depth from which T of the path law grows with w

/// One side of a packed table.
struct PackedSide {
    PhaseCurveView phase;

    PackedAxis albedo;         // over -sqrt(1 - w) or the fourth root
    PackedAxis optical_depth;  // over log2(tau), finite samples
    float min_albedo, max_albedo;
    float min_depth;         // finite samples; a surface is seen as it is through less
    ThinLayers thin;         // those thinner than these
    float thin_place;        // of the deeper of the two layers by which they are extrapolated
    float max_finite_depth;  // finite samples; beyond it reflection follows the law of diffusion
    float max_depth;         // depths are clamped to it
    bool ends_at_infinity;   // reflection alone
    bool divided;            // by albedo, shares and diffusion scales; not over a lower boundary
    bool over_surface;
    float surface_albedo;           // of a surface that is the lower boundary
    float boundary_quarter_albedo;  // w / 4 of a layer that is

    float extrapolation_length;
    const float* diffusion_exponent;  // over albedo
    // Over albedo, for reflection beyond the deepest finite sample: 1 / its deficit, 0 where it is
    // below min_deficit, and the scale of its samples.
    const float* inverse_deficit;
    const float* deepest_scale;

    const LayerBlock* block;
    const float* block_of_cell;  // over (albedo, optical depth), whole numbers
    int functions;               // in a row
    bool halves;                 // rows of functions: else floats
    bool symmetric;              // in the cosines, which are then the same on both ways
    PackedAxis mu_in, mu_out;    // over -acos(mu^(1/4))
    int row_step, column_step;   // rows of functions from one mu to the next where R and T are not
                                 // symmetric, from one mu' to the next; 0: one cosine
    int azimuths;                // samples of the table; 1: nothing depends on azimuth
    float azimuth_first, azimuth_step_inverse;  // azimuth / pi or its square root
    float azimuth_window, last_azimuth_window;  // first sample of the first and the last cubic
    bool square_root_of_azimuth;                // what they lie evenly in
    bool fourth_root_of_albedo;                 // of 1 - albedo, in place of its square root

    PathSheetView path;    // divided by w^2, over (w + w^2) / 2; null samples: none
    float path_steps = 0;  // from w = 0 to 1
    float path_first = 0;  // of these, that `path` begins with
    float path_growth = 0;
};

/// One lookup; co_albedo is 1 - albedo, accurate where it is small.
template <class F>
struct PackedPointOf {
    F albedo, co_albedo, optical_depth, mu_in, mu_out, azimuth;
};
using PackedPoint = PackedPointOf<float>;

constexpr int points_at_once = 16;

/// A side of a layer: single and multiple at one point, or totals at `count` of them, a multiple of
/// `points_at_once`; orders n >= 2 at three points that differ in albedo and optical depth alone; or,
/// at the point's albedo and optical depth, orders n >= 2 without what depends
/// on the cosines, at each of a block's `rows`.
struct PackedKernel {
    void (*one)(const PackedSide&, const PackedPoint&, float* single_multiple);
    void (*many)(const PackedSide&, const PackedPoints&, std::size_t count, float* total);
    void (*layers)(const PackedSide&, const PackedPoint (&)[3], float (&multiple)[3]);
    void (*rows)(const PackedSide&, const PackedPoint&, std::size_t rows, float* multiple);
};

/// The form that a packed lookup evaluates: beside its sums, coefficients of 0 cost next to nothing.
constexpr PhaseForm packed_form(PhaseForm form) {
    if (form == PhaseForm::constant) return PhaseForm::polynomial;
    if (form == PhaseForm::one_lobe) return PhaseForm::two_lobes;
    return form;
}

struct PackedSideKernels {
    PackedKernel kernel[2 * phase_forms];

    const PackedKernel& of(PhaseForm form, bool azimuthal) const {
        return kernel[2 * static_cast<int>(packed_form(form)) + (azimuthal ? 1 : 0)];
    }
};

using PackedKernels = PerSide<PackedSideKernels>;

}  // namespace stratus
