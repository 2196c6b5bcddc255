// Numbers that every room needs, and angles in their two units: functions take radians unless a name ends
// in `_deg`.
#pragma once

#include <limits>

namespace stratus {

inline constexpr double pi = 3.14159265358979323846;

/// The optical depth of a semi-infinite layer, among others.
inline constexpr double infinity = std::numeric_limits<double>::infinity();

constexpr double radians(double degrees) noexcept { return degrees * (pi / 180); }
constexpr double degrees(double radians) noexcept { return radians * (180 / pi); }

}  // namespace stratus
