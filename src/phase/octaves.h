// Samples evenly spaced within each octave of a number, 2^bits to an octave: the leading bits of a
// float are its place among them, with no logarithm. base/lanes.h finds places.
#pragma once

#include <cstdint>
#include <cstring>

namespace stratus {

constexpr int mantissa_bits = 23;

inline std::int32_t to_bits(float x) {
    std::int32_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}

/// The sample at an index; that at 0 is `lowest`, a power of 2.
inline double octave_sample(float lowest, int bits, int index) {
    const std::int32_t moved = to_bits(lowest) + index * (1 << (mantissa_bits - bits));
    float sample;
    std::memcpy(&sample, &moved, sizeof sample);
    return double{sample};
}

/// Index of the sample at or below x >= lowest.
inline int octave_index(float lowest, int bits, float x) {
    return (to_bits(x) - to_bits(lowest)) >> (mantissa_bits - bits);
}

}  // namespace stratus
