// Numbers that every room needs.
#pragma once

#include <limits>

namespace stratus {

inline constexpr double pi = 3.14159265358979323846;

/// The optical depth of a semi-infinite layer, among others.
inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace stratus
