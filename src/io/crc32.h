// The CRC-32 of zlib, PNG and Ethernet, several times as fast as zlib's own where the processor
// multiplies without carry.
#pragma once

#include <cstdint>
#include <span>

namespace stratus::io {

/// The same as zlib's crc32 of all bytes, begun with 0.
std::uint32_t crc32(std::span<const char> bytes);

}  // namespace stratus::io
