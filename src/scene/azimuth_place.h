// Cubic interpolation between values at azimuths that go round.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/scene/layer_light.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace stratus {

/// Where a point is seen from the z axis among `count` azimuths, the first along x: four of them, and
/// their weights.
struct AzimuthPlace {
    std::array<std::size_t, 4> column{};
    std::array<double, 4> weight{};

    AzimuthPlace() = default;
    AzimuthPlace(const Vector3& point, std::size_t count) noexcept {
        const double turn = std::atan2(point.y, point.x) / (2 * pi),
                     along = (turn - std::floor(turn)) * static_cast<double>(count),
                     first = std::floor(along), t = along - first;
        for (std::size_t k = 0; k < 4; ++k)
            column[k] = (static_cast<std::size_t>(first) + k + count - 1) % count;
        weight = {-t * (t - 1) * (t - 2) / 6, (t * t - 1) * (t - 2) / 2, -t * (t + 1) * (t - 2) / 2,
                  t * (t * t - 1) / 6};
    }

    /// Interpolates values at all azimuths.
    Rgb3 interpolated(const Rgb3* values) const noexcept {
        Rgb3 sum{};
        for (std::size_t k = 0; k < 4; ++k) sum = sum + weight[k] * values[column[k]];
        return sum;
    }
};

}  // namespace stratus
