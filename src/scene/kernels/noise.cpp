#include "noise.h"

#include <cstdint>

namespace stratus {
namespace {

#define STRATUS_INLINE [[gnu::always_inline]] inline

/// One number for each octave.
using Reals = double __attribute__((vector_size(8 * noise_octaves)));
using Longs = std::uint64_t __attribute__((vector_size(8 * noise_octaves)));
using Words = std::uint32_t __attribute__((vector_size(4 * noise_octaves)));

STRATUS_INLINE Longs as_bits(Reals x) { return reinterpret_cast<Longs>(x); }
STRATUS_INLINE Reals as_reals(Longs bits) { return reinterpret_cast<Reals>(bits); }

STRATUS_INLINE Reals rounded_down(Reals x) {
    for (int o = 0; o < noise_octaves; ++o) x[o] = __builtin_floor(x[o]);
    return x;
}

/// An integer modulo 2^32.
STRATUS_INLINE Words as_word(Reals whole) {
    const Reals rest = whole - 0x1p32 * rounded_down(0x1p-32 * whole);
    return __builtin_convertvector(as_bits(rest + 0x1p52), Words);
}

STRATUS_INLINE Reals eased(Reals t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

STRATUS_INLINE Reals between(Reals a, Reals b, Reals share) { return a + share * (b - a); }

/// Dot product of an offset from a lattice point with that point's gradient: one of the twelve
/// directions to a cube's edges, by the point's hash modulo 12.
STRATUS_INLINE Reals slope_at(Words hash, Reals x, Reals y, Reals z) {
    // A third modulo 2^32 sorts the multiples of 3 below those that leave 2, and these below 1.
    const Words third = (hash >> 2) * 0xaaaaaaabu;
    const auto wide = [](auto mask) { return __builtin_convertvector(mask, Longs); };
    const Longs multiple = wide(third < 0x55555556u),
                leaves_2 = wide(third < 0xaaaaaaabu) & ~multiple;
    const auto choose = [](Longs where, Reals yes, Reals no) {
        return (where & as_bits(yes)) | (~where & as_bits(no));
    };
    const Longs signs = __builtin_convertvector(hash, Longs);
    const Longs first = choose(leaves_2, y, x) ^ (signs << 63),
                second = choose(multiple, y, z) ^ ((signs >> 1) << 63);
    return as_reals(first) + as_reals(second);
}

STRATUS_INLINE Reals gradient_noise(Reals px, Reals py, Reals pz, Words seed) {
    const Reals fx = rounded_down(px), fy = rounded_down(py), fz = rounded_down(pz);
    const Words i = as_word(fx), j = as_word(fy), k = as_word(fz);
    const Reals x = px - fx, y = py - fy, z = pz - fz;
    const Reals u = eased(x), v = eased(y), w = eased(z);
    const Words start = seed_hash(seed);
    const Words left = chained_hash(start, i), right = chained_hash(start, i + 1u);
    const auto row = [&](unsigned dj, unsigned dk) {
        const Reals ry = y - static_cast<double>(dj), rz = z - static_cast<double>(dk);
        return between(slope_at(chained_hash(chained_hash(left, j + dj), k + dk), x, ry, rz),
                       slope_at(chained_hash(chained_hash(right, j + dj), k + dk), x - 1.0, ry, rz),
                       u);
    };
    return between(between(row(0, 0), row(1, 0), v), between(row(0, 1), row(1, 1), v), w);
}

double noise(double x, double y, double z, unsigned seed) {
    Reals along_x, along_y, along_z, share;
    Words seeds;
    double size = 1;
    for (int o = 0; o < noise_octaves; ++o, size /= 2) {
        along_x[o] = x, along_y[o] = y, along_z[o] = z;
        share[o] = size;
        seeds[o] = seed + static_cast<unsigned>(o);
        // Rotated and shifted, so that the lattices of two octaves do not line up.
        const double before = x;
        x = 1.6 * x + 1.2 * y + 17.3;
        y = 1.6 * y - 1.2 * before + 5.1;
        z = 2 * z + 11.7;
    }
    const Reals shares = share * gradient_noise(along_x, along_y, along_z, seeds);
    double sum = 0;
    for (int o = 0; o < noise_octaves; ++o) sum += shares[o];
    return sum;
}

}  // namespace

template <>
const NoiseKernel& functions_for<NoiseKernel, InstructionSet::STRATUS_ISA>() noexcept {
    static constexpr NoiseKernel kernel{noise};
    return kernel;
}

}  // namespace stratus
