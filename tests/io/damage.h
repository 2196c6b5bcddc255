// Damage as an adversary does it: random changes to a file's bytes, and for HDF5 changes behind
// which the library's own checksums are put right.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <random>
#include <span>
#include <string_view>
#include <vector>

namespace stratus::test {

using FileBytes = std::vector<char>;

/// Part of a file.
struct Block {
    std::size_t start, size;
};

/// One change somewhere within `block`: a bit, a byte, a run, or a field of 4 or 8 bytes set to
/// what sizes and addresses break at. Keeps the file's size.
inline void damage(FileBytes& bytes, const Block& block, std::mt19937& random) {
    constexpr std::array<std::uint64_t, 12> extremes{
        0,          1,           0x7f,        0xff,       0x7fff,     0xffff,
        0x7fffffff, 0x80000000U, 0xffffffffU, UINT64_MAX, 1ULL << 63, UINT64_MAX >> 1};
    const auto below = [&](std::size_t count) {
        return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
    };
    const std::size_t at = block.start + below(block.size);
    const std::size_t room = block.start + block.size - at;
    switch (below(5)) {
        case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8))); return;
        case 1: bytes[at] = static_cast<char>(below(256)); return;
        case 2: {
            const std::size_t length = 1 + below(std::min<std::size_t>(room, 64));
            for (std::size_t i = 0; i < length; ++i) bytes[at + i] = static_cast<char>(below(256));
            return;
        }
        case 3: {
            const std::size_t length = 1 + below(std::min<std::size_t>(room, 64));
            const std::size_t from = block.start + below(block.size - length + 1);
            std::memmove(bytes.data() + at, bytes.data() + from, length);
            return;
        }
        default: {
            const std::uint64_t value = extremes[below(extremes.size())];
            std::memcpy(bytes.data() + at, &value, std::min<std::size_t>(room, below(2) ? 8 : 4));
        }
    }
}

/// Bob Jenkins's hash "lookup3" of bytes, with which HDF5 protects its structures.
inline std::uint32_t lookup3(std::span<const char> bytes) {
    const auto rotated = [](std::uint32_t x, int by) { return (x << by) | (x >> (32 - by)); };
    std::uint32_t a = 0xdeadbeef + static_cast<std::uint32_t>(bytes.size());
    std::uint32_t b = a;
    std::uint32_t c = a;
    while (true) {
        std::array<std::uint32_t, 3> words{};
        const std::size_t taken = std::min<std::size_t>(bytes.size(), 12);
        std::memcpy(words.data(), bytes.data(), taken);
        if (taken == 0) return c;
        a += words[0];
        b += words[1];
        c += words[2];
        if (bytes.size() <= 12) break;
        bytes = bytes.subspan(12);
        a = (a - c) ^ rotated(c, 4), c += b;
        b = (b - a) ^ rotated(a, 6), a += c;
        c = (c - b) ^ rotated(b, 8), b += a;
        a = (a - c) ^ rotated(c, 16), c += b;
        b = (b - a) ^ rotated(a, 19), a += c;
        c = (c - b) ^ rotated(b, 4), b += a;
    }
    c = (c ^ b) - rotated(b, 14);
    a = (a ^ c) - rotated(c, 11);
    b = (b ^ a) - rotated(a, 25);
    c = (c ^ b) - rotated(b, 16);
    a = (a ^ c) - rotated(c, 4);
    b = (b ^ a) - rotated(a, 14);
    return (c ^ b) - rotated(b, 24);
}

inline std::uint32_t stored_checksum(const FileBytes& bytes, const Block& block) {
    std::uint32_t stored;
    std::memcpy(&stored, bytes.data() + block.start + block.size, sizeof stored);
    return stored;
}

/// Structures of a whole HDF5 file that end with their checksum: found by their signatures, and
/// their size by the checksum that follows.
inline std::vector<Block> structures(const FileBytes& bytes) {
    constexpr std::size_t largest = 1024;
    constexpr std::array<std::string_view, 14> signatures{"\x89HDF", "OHDR", "OCHK", "FRHP", "FHIB",
                                                          "BTHD",    "BTIN", "BTLF", "FAHD", "FADB",
                                                          "EAHD",    "FSHD", "FSSE", "SMTB"};
    std::vector<Block> found;
    for (std::size_t at = 0; at + 8 < bytes.size(); ++at) {
        const std::string_view signature(bytes.data() + at, 4);
        if (std::find(signatures.begin(), signatures.end(), signature) == signatures.end())
            continue;
        for (std::size_t size = 8; size <= largest && at + size + 4 <= bytes.size(); ++size) {
            const Block block{at, size};
            if (lookup3(std::span(bytes).subspan(at, size)) != stored_checksum(bytes, block))
                continue;
            found.push_back(block);
            break;
        }
    }
    return found;
}

/// Puts the checksum of a structure right.
inline void mend(FileBytes& bytes, const Block& block) {
    const std::uint32_t sum = lookup3(std::span(bytes).subspan(block.start, block.size));
    std::memcpy(bytes.data() + block.start + block.size, &sum, sizeof sum);
}

}  // namespace stratus::test
