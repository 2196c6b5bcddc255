#include "crc32.h"

#include <cstddef>

#include <zlib.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define STRATUS_FOLDS 1
#include <immintrin.h>
#endif

namespace stratus::io {
namespace {

/// Goes on from the checksum `crc` of the bytes before.
std::uint32_t table_driven(std::uint32_t crc, std::span<const char> bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

#ifdef STRATUS_FOLDS

// A checksum is the remainder of the message, as a polynomial over the field of two elements, on
// division by P. Bytes that lie n bits before others may be replaced by a multiple of x^n mod P
// added to these: "Fast CRC computation for generic polynomials using PCLMULQDQ", V. Gopal et al.,
// Intel 2009. Bits are reflected, the highest power lowest.

/// x^n mod P, reflected, and shifted as a product of reflected factors needs it.
constexpr std::int64_t power_of_x(int n) {
    constexpr std::uint32_t reflected_polynomial = 0xedb88320;
    std::uint32_t power = 0x80000000;  // 1
    for (int i = 0; i < n; ++i)
        power = (power >> 1) ^ ((power & 1) != 0 ? reflected_polynomial : 0);
    return std::int64_t{power} << 1;
}

constexpr std::size_t block_bytes = 16;
constexpr int block_bits = 8 * block_bytes;
constexpr std::size_t blocks_at_once = 4;

/// What a block becomes where it is added `blocks` later.
template <int blocks>
[[gnu::target("pclmul")]] __m128i moved(__m128i block) {
    const __m128i powers =
        _mm_set_epi64x(power_of_x(blocks * block_bits - 32), power_of_x(blocks * block_bits + 32));
    return _mm_xor_si128(_mm_clmulepi64_si128(block, powers, 0x00),
                         _mm_clmulepi64_si128(block, powers, 0x11));
}

__m128i block_at(const char* bytes) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

/// Needs at least four blocks.
[[gnu::target("pclmul")]] std::uint32_t folded(std::span<const char> bytes) {
    constexpr std::size_t stride = blocks_at_once * block_bytes;
    __m128i sums[blocks_at_once];
    for (std::size_t i = 0; i < blocks_at_once; ++i)
        sums[i] = block_at(bytes.data() + i * block_bytes);
    sums[0] = _mm_xor_si128(sums[0], _mm_cvtsi32_si128(-1));  // what every checksum begins with
    bytes = bytes.subspan(stride);
    for (; bytes.size() >= stride; bytes = bytes.subspan(stride))
        for (std::size_t i = 0; i < blocks_at_once; ++i)
            sums[i] = _mm_xor_si128(moved<blocks_at_once>(sums[i]),
                                    block_at(bytes.data() + i * block_bytes));
    __m128i sum = sums[0];
    for (std::size_t i = 1; i < blocks_at_once; ++i) sum = _mm_xor_si128(moved<1>(sum), sums[i]);
    for (; bytes.size() >= block_bytes; bytes = bytes.subspan(block_bytes))
        sum = _mm_xor_si128(moved<1>(sum), block_at(bytes.data()));

    char last[block_bytes];
    _mm_storeu_si128(reinterpret_cast<__m128i*>(last), sum);
    constexpr std::uint32_t begun = 0xffffffff;  // with nothing added: that is in `sum`
    return table_driven(table_driven(begun, last), bytes);
}

#endif

}  // namespace

std::uint32_t crc32(std::span<const char> bytes) {
#ifdef STRATUS_FOLDS
    if (bytes.size() >= blocks_at_once * block_bytes && __builtin_cpu_supports("pclmul"))
        return folded(bytes);
#endif
    return table_driven(0, bytes);
}

}  // namespace stratus::io
