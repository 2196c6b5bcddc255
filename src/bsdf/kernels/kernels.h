// Lookups of bound slices for every combination of effects, one light path at a time or many side
// by side, compiled once for each instruction set and chosen when the program runs (dispatch.cpp).
//
// Files compiled for newer processors use no inline function of external linkage, so that none of
// their code can end up shared with the rest of the program.
#pragma once

#include <stratus/base/direction.h>

#include "slice_side.h"

namespace stratus {

constexpr int paths_at_once = 256;
/// Any kernel looks up a divisor of this many paths side by side: `count` of them means those that
/// fill the last registers too.
constexpr int most_lanes = 16;
constexpr int path_room = paths_at_once + most_lanes;

/// Light paths side by side.
struct LightPaths {
    alignas(64) float mu_in[path_room], mu_out[path_room];
    alignas(64) float forward[path_room], backward[path_room];
    alignas(64) float half_azimuth[path_room];
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

/// For chosen_instruction_set().
const Kernels& kernels() noexcept;

}  // namespace stratus
