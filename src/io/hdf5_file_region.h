// Reading numbers from the bytes of a forged file, and the checksums in it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace stratus::io {

/// Thrown for structures that the library must not decode.
struct RefusedStructure {
    const char* reason;
};

inline void expect(bool holds, const char* reason) {
    if (!holds) throw RefusedStructure{reason};
}

/// The bytes of a file from some address on, or fewer.
class FileRegion {
  public:
    /// All bytes from `start` on; none if that is beyond the end.
    FileRegion(std::span<const char> file, std::uint64_t start)
        : file_(file), content_(file.subspan(std::min<std::uint64_t>(start, file.size()))) {}

    std::uint64_t size() const { return content_.size(); }

    /// The little-endian number of up to eight bytes at `at`; bytes beyond the end count as zero.
    std::uint64_t number(std::uint64_t at, std::uint64_t bytes) const {
        std::uint64_t value = 0;
        for (std::uint64_t i = 0; i < bytes && at < size() && i < size() - at; ++i)
            value |= std::uint64_t{static_cast<unsigned char>(content_[at + i])} << (8 * i);
        return value;
    }

    bool begins(std::string_view name) const {
        return size() >= name.size() && std::memcmp(content_.data(), name.data(), name.size()) == 0;
    }

    std::string_view bytes() const { return {content_.data(), content_.size()}; }

    /// The `size` bytes at `at`, all of which must lie within this region.
    FileRegion within(std::uint64_t at, std::uint64_t size) const {
        expect(at <= content_.size() && size <= content_.size() - at, "truncated structure");
        FileRegion region = *this;
        region.content_ = content_.subspan(at, size);
        return region;
    }

    /// All bytes from `at` on, which must not be beyond the end of this region.
    FileRegion from(std::uint64_t at) const { return within(at, size() - std::min(at, size())); }

    /// All bytes of the file from another address on.
    FileRegion at_address(std::uint64_t address) const { return {file_, address}; }

  private:
    std::span<const char> file_, content_;
};

/// The checksum of HDF5's structures. [B. Jenkins 2006, lookup3, hashlittle]
std::uint32_t lookup3(std::string_view bytes);

/// Compares the checksum after the first `size` bytes, which the library does only halfway through
/// a tree, from where it cannot recover.
void check_checksum(const FileRegion& structure, std::uint64_t size);

}  // namespace stratus::io
