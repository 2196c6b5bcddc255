// How lobes are drawn, in figures and portraits alike.
#pragma once

#include <stratus/base/constants.h>

#include "page.h"

#include <cmath>
#include <cstddef>
#include <vector>

namespace stratus {

/// The curve of radii at even angles from one horizon to the other, about the origin. Light comes
/// from the right and goes on to the left; `up` is 1 above the layer and -1 below.
inline std::vector<Point> lobe_outline(const std::vector<double>& radii, double scale, double up) {
    const double steps = static_cast<double>(radii.size()) - 1;
    std::vector<Point> outline;
    for (std::size_t k = 0; k < radii.size(); ++k) {
        const double angle = pi * (static_cast<double>(k) / steps - 0.5);
        outline.push_back(
            {-scale * radii[k] * std::sin(angle), -up * scale * radii[k] * std::cos(angle)});
    }
    return outline;
}

}  // namespace stratus
