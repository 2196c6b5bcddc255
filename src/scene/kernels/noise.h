// Gradient noise, where the time of pictures of clouds goes: all octaves side by side, compiled once
// for each instruction set, with the same roundings in all, so that a scene has the same clouds on
// every machine.
#pragma once

#include <stratus/base/instruction_set.h>

namespace stratus {

constexpr int noise_octaves = 8;

struct NoiseKernel {
    /// See texture.h.
    double (*noise)(double x, double y, double z, unsigned seed);
};

namespace {  // copies that were compiled for different processors stay apart

/// Mueller's 32-bit integer hash: every bit of the result depends on every bit of n. Of one number,
/// or of several side by side.
template <class Words>
[[gnu::always_inline]] inline Words scrambled(Words n) {
    n = (n ^ (n >> 16)) * 0x45d9f3bu;
    n = (n ^ (n >> 16)) * 0x45d9f3bu;
    return n ^ (n >> 16);
}

/// Hash of a place along one axis, after that of the axes before it; of the seed, for the first.
template <class Words>
[[gnu::always_inline]] inline Words chained_hash(Words before, Words cell) {
    return scrambled(before ^ cell);
}

template <class Words>
[[gnu::always_inline]] inline Words seed_hash(Words seed) {
    return scrambled(seed + 0x9e3779b9u);
}

}  // namespace
}  // namespace stratus
