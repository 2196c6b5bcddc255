// Lookups of bound slices for every combination of effects, one light path at a time or many side
// by side, compiled once for each instruction set and chosen when the program runs (dispatch.cpp).
//
// Files compiled for newer processors use no inline function of external linkage, so that none of
// their code can end up shared with the rest of the program.
#pragma once

#include <stratus/runtime/direction.h>

#include "slice_side.h"

#include <cstddef>

namespace stratus {

constexpr int paths_at_once = 64;

/// Light paths side by side.
struct LightPaths {
    alignas(64) float mu_in[paths_at_once], mu_out[paths_at_once];
    alignas(64) float forward[paths_at_once], backward[paths_at_once];
    alignas(64) float half_azimuth[paths_at_once];
};

/// A side of a layer: between two cosines and an azimuth, between two vectors, or at
/// `paths_at_once` light paths: value[c * paths_at_once + i].
template <int channels>
struct SideKernel {
    void (*at_angles)(const SliceSide<channels>&, float mu_in, float mu_out, float azimuth,
                      float* value);
    void (*at_vectors)(const SliceSide<channels>&, const Vector& wi, const Vector& wo,
                       float* value);
    void (*many)(const SliceSide<channels>&, const LightPaths&, float* value);
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

struct PackedKernels;  // packed.h

/// Rows of numbers over orders, each number twice: `columns` of them, 64 or more.
struct OrderRows {
    const float* value;
    std::size_t columns, orders;
};

struct Kernels {
    SideKernels<1> reflected, transmitted;
    SideKernels<3> reflected_rgb, transmitted_rgb;
    void (*paths_of_angles[2])(const float* mu_in, const float* mu_out, const float* azimuth,
                               LightPaths& paths);  // over Side
    void (*paths_of_vectors)(const float* const wi[3], const float* const wo[3], LightPaths& paths);
    const PackedKernels* packed;
    /// Weighted sums over the orders, of `rows` pairs of weights for each order: of the numbers in
    /// even columns with the first of each pair, in odd ones with the second; used[row] orders.
    void (*path_sums)(const OrderRows&, const float* weight, const int* used, std::size_t rows,
                      float* to);
};

/// For chosen_instruction_set().
const Kernels& kernels() noexcept;

}  // namespace stratus
