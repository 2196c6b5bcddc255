// Many lookups of a bound slice: blocks of them as the kernels take them (kernels/kernels.h).
#pragma once

#include "kernels/kernels.h"

#include <cstddef>

namespace stratus {

/// One side of a slice; nothing comes this way where `many` is null.
template <int channels>
struct BatchSide {
    const SliceSide<channels>& view;
    decltype(SideKernel<channels>::many) many;
};

/// R or T at cosines and azimuths: channel c of lookup i in value[c * count + i].
template <int channels>
void look_up_angles(Side which, const BatchSide<channels>& side, std::size_t count,
                    const float* mu_in, const float* mu_out, const float* azimuth,
                    float* value) noexcept;

/// R / pi or T / pi between vectors, each by its own side alone.
template <int channels>
void look_up_vectors(const BatchSide<channels>& reflection, const BatchSide<channels>& transmission,
                     bool one_sided, std::size_t count, const float* const wi[3],
                     const float* const wo[3], float* value) noexcept;

}  // namespace stratus
