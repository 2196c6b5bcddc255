// Numbers of 16 bits: IEEE binary16, 11 significant bits between 2^-14 and 65504.
//
// The bits of a half, moved to their places in a float, are its value times 2^-112, the difference
// of the exponents' biases. Multiplying by 2^112 is right for subnormal halves too.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace stratus {

struct Half {
    std::uint16_t bits;
};

constexpr float largest_half = 65504;
constexpr float half_unit = 5192296858534827628530496329220096.0f;  // 2^112
constexpr int half_shift = 13;                   // fraction bits of a float beyond those of a half
constexpr std::int32_t half_mask = ~0x70000000;  // the bits of a float that a half fills

/// The value of a finite half, exactly.
inline float to_float(Half half) noexcept {
    // Sign extension copies the sign to four bits; the mask keeps the one that is a float's.
    const std::int32_t bits = static_cast<std::int16_t>(half.bits) * (1 << half_shift) & half_mask;
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return half_unit * value;
}

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
