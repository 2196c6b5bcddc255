// Numbers of 16 bits: IEEE binary16, 11 significant bits between 2^-14 and 65504.
//
// A half's bits, moved to where float keeps them, are its value times 2^-112: both formats differ
// by that bias of their exponents alone. The multiplication that undoes it makes subnormal halves
// right too.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace stratus {

struct Half {
    std::uint16_t bits;
};

constexpr float largest_half = 65504;
constexpr float min_normal_half = 6.103515625e-5f;                  // 2^-14
constexpr float half_unit = 5192296858534827628530496329220096.0f;  // 2^112
constexpr int half_shift = 13;                   // bits of a float's fraction that a half has not
constexpr std::int32_t half_mask = ~0x70000000;  // the bits of a float that a half fills

/// The float whose value is that of a finite half times 2^-112.
inline float shifted(Half half) noexcept {
    // The sign comes along as four bits, of which the mask leaves the one where float has it.
    const std::int32_t bits = static_cast<std::int16_t>(half.bits) * (1 << half_shift) & half_mask;
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

/// The value of a finite half, exactly.
inline float to_float(Half half) noexcept { return half_unit * shifted(half); }

/// The half nearest to a number, of two equally near the even one.
///
/// Range    [-65504, 65504]; magnitudes beyond are clamped. 0 for less than 2^-25.
inline Half to_half(float number) noexcept {
    const float magnitude = std::fmin(std::fabs(number), largest_half) / half_unit;
    std::uint32_t bits;
    std::memcpy(&bits, &magnitude, sizeof bits);
    const std::uint32_t even = (bits >> half_shift) & 1u;
    const std::uint32_t rounded = (bits + ((1u << (half_shift - 1)) - 1u + even)) >> half_shift;
    return {static_cast<std::uint16_t>(rounded | (std::signbit(number) ? 0x8000u : 0u))};
}

}  // namespace stratus
