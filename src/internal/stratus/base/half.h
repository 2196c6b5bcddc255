// Numbers of 16 bits: IEEE binary16, 11 significant bits between 2^-14 and 65504.
//
// The bits of a half, moved to their places in a float, lack the difference of the exponents' biases, 112.
// A subnormal half comes out too large by 2^-14 when it is given that exponent. No float on the way is
// subnormal, as a program may have the processor take those for 0 (-ffast-math, some renderers).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

namespace stratus {

struct Half {
    std::uint16_t bits;
};

constexpr float largest_half = 65504;
constexpr float least_normal_half = 0x1p-14f;
constexpr int half_shift = 13;        // fraction bits of a float beyond those of a half
constexpr int half_bias = 112 << 23;  // the difference of the exponents' biases, in a float's bits

/// The value of a finite half, exactly.
inline float to_float(Half half) noexcept {
    const bool subnormal = (half.bits & 0x7c00) == 0;
    const std::int32_t bits =
        ((half.bits & 0x7fff) << half_shift) + half_bias + (subnormal ? 1 << 23 : 0);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    value -= subnormal ? least_normal_half : 0;
    return half.bits < 0x8000 ? value : -value;
}

/// The half nearest to a number, of two equally near the even one.
///
/// Range    [-65504, 65504]; magnitudes beyond are clamped. 0 for less than 2^-25.
inline Half to_half(float number) noexcept {
    const float magnitude = std::fmin(std::fabs(number), largest_half);
    const auto bits_of = [](float value) {
        std::uint32_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        return bits;
    };
    std::uint32_t rounded;
    if (magnitude < least_normal_half) {
        constexpr float unit_of_fraction = 0.5f;  // one step of a float here is 2^-24
        rounded = bits_of(magnitude + unit_of_fraction) - bits_of(unit_of_fraction);
    } else {
        const std::uint32_t bits = bits_of(magnitude) - half_bias, even = bits >> half_shift & 1u;
        rounded = (bits + ((1u << (half_shift - 1)) - 1u + even)) >> half_shift;
    }
    return {static_cast<std::uint16_t>(rounded | (std::signbit(number) ? 0x8000u : 0u))};
}

}  // namespace stratus
