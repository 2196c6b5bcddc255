// The coordinate along which fast lookups sample cosines evenly (base/interpolation.h):
// v = sqrt(1 - mu) (1 - mu^(1/4) / 2), which falls from 1 at grazing to 0 at the normal.
#pragma once

#include <cmath>

namespace stratus {

inline double v_at(double mu) { return std::sqrt(1 - mu) * (1 - std::sqrt(std::sqrt(mu)) / 2); }

/// The inverse of `v_at`.
inline double mu_at(double v) {
    // v = s g(q) of s = sqrt(1 - q), q = mu^(1/4), nearly s itself: Newton's method doubles the
    // digits of each step, two to begin with.
    double s = v;
    for (int i = 0; i < 5; ++i) {
        const double q = 1 - s * s, p = (1 + q) * (1 + q * q), root = std::sqrt(p);
        const double g = root * (1 - q / 2);
        const double slope = (1 + 2 * q + 3 * q * q) / (2 * root) * (1 - q / 2) - root / 2;
        s -= (s * g - v) / (g - 2 * s * s * slope);
    }
    const double root = 1 - s * s;
    return root * root * root * root;
}

}  // namespace stratus
