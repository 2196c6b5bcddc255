// Round numbers, for scales and samples that a reader sees.
#pragma once

#include <cmath>

namespace stratus {

/// The nearest number of so many significant digits.
inline double rounded(double value, int digits = 1) {
    if (!(value > 0) || !std::isfinite(value)) return value;
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - (digits - 1));
    return std::round(value / unit) * unit;
}

/// 1, 2 or 5 times a power of ten: the largest up to `value`, which is above 0.
inline double round_below(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)));
    return unit * (value >= 5 * unit ? 5 : value >= 2 * unit ? 2 : 1);
}

}  // namespace stratus
