// The coordinate along which fast lookups sample cosines evenly (kernels/interpolation.h):
// v = sqrt(1 - mu) (1 - mu^(1/4) / 2), which falls from 1 at grazing to 0 at the normal.
#pragma once

#include <cmath>

namespace stratus {

inline double v_at(double mu) { return std::sqrt(1 - mu) * (1 - std::sqrt(std::sqrt(mu)) / 2); }

/// The inverse of `v_at`.
inline double mu_at(double v) {
    double low = 0, high = 1;  // of mu^(1/4), by bisection to the last bit
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (v_at(middle * middle * middle * middle) > v ? low : high) = middle;
    }
    return std::pow((low + high) / 2, 4);
}

}  // namespace stratus
