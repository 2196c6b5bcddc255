// Angles: pi, and the two units. Functions take radians unless a name ends in `_deg`.
#pragma once

namespace stratus {

inline constexpr double pi = 3.14159265358979323846;

constexpr double radians(double degrees) noexcept { return degrees * (pi / 180); }
constexpr double degrees(double radians) noexcept { return radians * (180 / pi); }

}  // namespace stratus
