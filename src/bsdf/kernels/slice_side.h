// The data that lookups of a bound slice read (slice.h): filled in when it is bound, evaluated by
// kernels.cpp.
#pragma once

#include <stratus/layer/opposition.h>
#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_curve.h>

#include "layer/kernels/slice_layer.h"

namespace stratus {

/// How orders n >= 2 are stored.
enum class Orders {
    none,
    without_azimuth,
    with_azimuth,
    with_azimuth_and_path,  // the path law is added to what is stored
};

/// Whether slices are looked up with kernels of their own for both. Other pairs, which are rare, are
/// bound as one of these (slice.cpp).
constexpr bool has_kernel(PhaseForm form, Orders orders) {
    switch (orders) {
        case Orders::without_azimuth: return form == PhaseForm::none || form == PhaseForm::constant;
        case Orders::with_azimuth: return form != PhaseForm::constant;
        case Orders::with_azimuth_and_path:
            return form != PhaseForm::constant && form != PhaseForm::polynomial &&
                   form != PhaseForm::of_stack;  // no stack has a path law
        default: return form != PhaseForm::none;
    }
}

/// Places along the coordinates that samples lie evenly in, of mu_in, mu_out and azimuth, and one
/// to spare: coordinate * scale + offset, from 0 to `last`.
struct SlicePlaces {
    float scale[4], offset[4];
    float last[4];  // a little below the last sample, so that there is a next one
};

/// One side of a slice for `channels` colours.
template <int channels>
struct SliceSide {
    PhaseCurveView phase;
    OppositionTableView opposition;  // with_opposition_and_boundary
    static constexpr int padded = channels == 1 ? 1 : 4;
    float optical_depth[padded];            // at most 1e30
    float quarter_albedo[padded];           // w / 4
    float surface_albedo[padded];           // lower boundary: R of a Lambert surface; 0: none
    float boundary_quarter_albedo[padded];  // lower boundary: w / 4 of a layer; 0: none
    const SliceLayer* layer;                // of_stack: as many as `layers`, alike in all channels

    // Orders n >= 2 over (mu, mu', azimuth), channels innermost, with one number to spare at the
    // end. Where R and T are known for the same cosines on both ways they are symmetric in them:
    // row i over mu has mu' = 0 .. i + 1 alone, and a lookup takes the larger index for mu.
    // Elsewhere mu is that of the incident light, and every row has `columns`. Of `azimuths` the first
    // and the last lie one step beyond the ends, for cubics.
    const float* sample;
    int layers, columns, azimuths;
    bool symmetric;
    SlicePlaces places;  // of mu_in and mu_out the same where it is symmetric; of sin(azimuth / 2)
    // The divisor of the samples: level + slope * (shares intercepted along both directions).
    float level, slope;
    // The least value of a lookup: 0, or -infinity while samples are made from differences to closed
    // forms.
    float least;

    PathSheetView path;  // with_azimuth_and_path
};

}  // namespace stratus
