#include "hdf5_file_region.h"

#include <array>
#include <bit>

namespace stratus::io {

std::uint32_t lookup3(std::string_view bytes) {
    std::array<std::uint32_t, 3> s;
    s.fill(0xdeadbeef + static_cast<std::uint32_t>(bytes.size()));
    const auto add = [&](std::string_view block) {  // up to twelve bytes, then zeros
        for (std::size_t i = 0; i < block.size(); ++i)
            s[i / 4] += std::uint32_t{static_cast<unsigned char>(block[i])} << (8 * (i % 4));
    };
    for (; bytes.size() > 12; bytes.remove_prefix(12)) {
        add(bytes.substr(0, 12));
        for (std::size_t i = 0; const int turn : {4, 6, 8, 16, 19, 4}) {
            std::uint32_t &a = s[i % 3], &b = s[(i + 1) % 3], &c = s[(i + 2) % 3];
            a = (a - c) ^ std::rotl(c, turn);
            c += b;
            ++i;
        }
    }
    if (bytes.empty()) return s[2];
    add(bytes);
    for (std::size_t i = 2; const int turn : {14, 11, 25, 16, 4, 14, 24}) {
        std::uint32_t &a = s[i % 3], &b = s[(i + 2) % 3];
        a = (a ^ b) - std::rotl(b, turn);
        ++i;
    }
    return s[2];
}

void check_checksum(const FileRegion& structure, std::uint64_t size) {
    expect(lookup3(structure.within(0, size).bytes()) == structure.within(size, 4).number(0, 4),
           "damaged structure");
}

}  // namespace stratus::io
