// Angles in their two units. Functions take radians unless a name ends in `_deg`.
#pragma once

#include <stratus/base/constants.h>

namespace stratus {

constexpr double radians(double degrees) noexcept { return degrees * (pi / 180); }
constexpr double degrees(double radians) noexcept { return radians * (180 / pi); }

}  // namespace stratus
