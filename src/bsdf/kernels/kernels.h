// Lookups of bound slices for every combination of effects, one light path at a time or many side
// by side, compiled once for each instruction set and chosen when the program runs (instruction_set.h).
//
// Files compiled for newer processors use no inline function of external linkage, so that none of
// their code can end up shared with the rest of the program.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/base/instruction_set.h>
#include <stratus/layer/effects.h>
#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_curve.h>

namespace stratus {

// ---- what lookups read, filled in when a slice is bound (slice.h)

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

/// How samples lie: see SliceSide::sample.
struct SampleShape {
    int columns, azimuths;
    bool symmetric, cubic;
    SlicePlaces places;  // of mu_in and mu_out the same where it is symmetric; of sin(azimuth / 2)
};

/// A layer of a stack, or a semi-infinite one that it lies on.
struct SliceLayer {
    PhaseCurveView phase;  // sampled
    float above, below;    // optical depths of the layers around it
    float optical_depth, quarter_albedo;
};

/// One side of a slice for `channels` colours.
template <int channels>
struct SliceSide : SampleShape {
    PhaseCurveView phase;
    OppositionTableView opposition;  // with_opposition_and_boundary
    static constexpr int padded = channels == 1 ? 1 : 4;
    float optical_depth[padded];            // at most 1e30
    float quarter_albedo[padded];           // w / 4
    float surface_albedo[padded];           // lower boundary: R of a Lambert surface; 0: none
    float boundary_quarter_albedo[padded];  // lower boundary: w / 4 of a layer; 0: none
    const SliceLayer* layer;                // of_stack: as many as `layers`, alike in all channels
    int layers;

    // Orders n >= 2 over (mu, mu', azimuth), channels innermost, with one number to spare at the
    // end. Where R and T are known for the same cosines on both ways they are symmetric in them:
    // row i over mu has mu' = 0 .. i + 1 alone, and a lookup takes the larger index for mu.
    // Elsewhere mu is that of the incident light, and every row has `columns`. Of `azimuths` the first
    // and the last lie one step beyond the ends, for cubics; of rows and columns, too, where those along
    // cosines are `cubic`. Every row is whole then.
    const float* sample;
    // The divisor of the samples: level + slope * (shares intercepted along both directions).
    float level, slope;
    // The least value of a lookup: 0, or -infinity while samples are made from differences to closed
    // forms.
    float least;

    PathSheetView path;  // with_azimuth_and_path
};

// ---- lookups

constexpr int paths_at_once = 256;
/// Any kernel looks up a divisor of this many paths side by side: `count` of them means those that
/// fill the last registers too.
constexpr int most_lanes = 16;
constexpr int path_room = paths_at_once + most_lanes;

// Light paths side by side; the numbers of each are mu_in, mu_out, forward, backward and half_azimuth.
constexpr int path_numbers = 5;
struct LightPaths {
    alignas(64) float number[path_numbers][path_room];
};

/// Light paths between vectors, parted by side.
struct PartedPaths {
    LightPaths paths[2];  // over Side
    int count[2];
    unsigned reflected[paths_at_once];    // a bit for each path of a register
    alignas(64) float factor[path_room];  // over all paths: 1 / pi, or 0 where nothing is seen
};

template <int channels>
struct ChannelValues {
    float of[channels];
};

/// A side of a layer: between two cosines and an azimuth, between two vectors, or at the first
/// `count` light paths: value[c * path_room + i].
template <int channels>
struct SideKernel {
    ChannelValues<channels> (*at_angles)(const SliceSide<channels>&, float mu_in, float mu_out,
                                         float azimuth);
    ChannelValues<channels> (*at_vectors)(const SliceSide<channels>&, const Vector& wi,
                                          const Vector& wo);
    void (*many)(const SliceSide<channels>&, const LightPaths&, int count, float* value);
};

constexpr int order_forms = 4;  // of Orders

template <int channels>
struct SideKernels {
    SideKernel<channels> kernel[phase_forms * order_forms];

    /// Null functions where nothing is asked for.
    const SideKernel<channels>& of(PhaseForm form, Orders orders) const {
        return kernel[static_cast<int>(form) * order_forms + static_cast<int>(orders)];
    }
};

struct Kernels {
    PerSide<SideKernels<1>> grey;
    PerSide<SideKernels<3>> rgb;
    void (*paths_of_angles[2])(const float* mu_in, const float* mu_out, const float* azimuth,
                               int count, LightPaths& paths);  // over Side
    void (*paths_of_vectors)(const float* const wi[3], const float* const wo[3], int count,
                             bool one_sided, PartedPaths& paths);
    /// Joins the values of either side at its own paths, in the order of all, times their factors.
    void (*joined)(const PartedPaths& paths, const float* reflected, const float* transmitted,
                   int count, float* value);
};

}  // namespace stratus
