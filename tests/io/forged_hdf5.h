// Forged HDF5 files: changed anywhere, with the checksums of their structures recomputed, so that
// the library decodes them.
//
// Covers the structures of table files: superblock, object headers, B-trees of up to two levels,
// fractal heaps with one level of blocks, and fixed arrays of one page.
#pragma once

#include "hdf5_file_region.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stratus::test {

/// The bytes of a file, in which it finds structures and their lengths.
class ForgedHdf5 {
  public:
    explicit ForgedHdf5(std::string bytes) : bytes_(std::move(bytes)) {}

    std::string& bytes() { return bytes_; }

    /// Addresses at which structures with a checksum may begin, ascending.
    std::vector<std::size_t> starts() const {
        std::vector<std::size_t> starts{0};
        for (std::size_t at = 0; (at = bytes_.find_first_of("BFO", at + 1)) != std::string::npos;)
            for (const std::string_view magic :
                 {"OHDR", "OCHK", "BTHD", "BTIN", "BTLF", "FRHP", "FHIB", "FHDB", "FAHD", "FADB"})
                if (is(magic, at)) starts.push_back(at);
        return starts;
    }

    /// Recomputes the checksum of every structure.
    void stamp() {
        for (const std::size_t start : starts()) {
            const std::optional<std::size_t> length = checked_length(start);
            if (!length || *length > bytes_.size() || start > bytes_.size() - *length) continue;
            const bool within = is("FHDB", start);  // in all other structures it is at the end
            const std::size_t at = within ? start + 13 + heap_offset_size(start) : start + *length;
            if (at + 4 > bytes_.size()) continue;
            if (within) put(at, 0);
            put(at, io::lookup3(std::string_view(bytes_).substr(start, *length)));
        }
    }

  private:
    bool is(std::string_view magic, std::size_t at) const {
        return std::string_view(bytes_).substr(std::min(at, bytes_.size()), 4) == magic;
    }

    /// A number of up to eight bytes; bytes beyond the end of the file count as zero.
    std::size_t number(std::size_t at, std::size_t size) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < size && at + i >= at && at + i < bytes_.size(); ++i)
            value |= std::uint64_t{static_cast<unsigned char>(bytes_[at + i])} << (8 * i);
        return value;
    }

    void put(std::size_t at, std::uint32_t value) {
        for (std::size_t i = 0; i < 4; ++i) bytes_[at + i] = static_cast<char>(value >> (8 * i));
    }

    /// Where the file refers to the address of a structure.
    std::optional<std::size_t> reference_to(std::size_t start) const {
        const std::uint64_t address = start;
        const std::string_view wanted(reinterpret_cast<const char*>(&address), sizeof address);
        const std::size_t at = bytes_.find(wanted, 1);
        return at == std::string::npos ? std::nullopt : std::optional(at);
    }

    std::size_t heap_of(std::size_t block) const { return number(block + 5, 8); }

    /// Bytes of an offset into the heap that a block belongs to.
    std::size_t heap_offset_size(std::size_t block) const {
        return (number(heap_of(block) + 128, 2) % 65 + 7) / 8;
    }

    /// The number of bytes that the checksum of a structure covers; none without a checksum.
    std::optional<std::size_t> checked_length(std::size_t start) const {
        if (start == 0) return 44;
        if (is("BTHD", start)) return 34;
        if (is("FRHP", start)) return 142;
        if (is("FAHD", start)) return 24;
        if (is("OHDR", start)) {
            const std::size_t flags = number(start + 5, 1);
            const std::size_t size_at =
                start + 6 + (flags & 0x20 ? 16 : 0) + (flags & 0x10 ? 4 : 0);
            const std::size_t size_of_size = std::size_t{1} << (flags & 3);
            return size_at - start + size_of_size + number(size_at, size_of_size);
        }
        if (is("FADB", start)) {
            const std::size_t header = number(start + 6, 8);
            return 14 + number(header + 6, 1) * number(header + 8, 8);
        }
        if (is("FHIB", start)) {
            const std::size_t heap = heap_of(start);
            return 13 + heap_offset_size(start) + 8 * number(heap + 110, 2) * number(heap + 140, 2);
        }
        if (is("FHDB", start)) {
            const std::size_t heap = heap_of(start);
            if (!(number(heap + 9, 1) & 2)) return std::nullopt;
            const std::size_t first_row = number(heap + 112, 8);
            const std::size_t width = std::max<std::size_t>(number(heap + 110, 2), 1);
            const std::size_t offset = number(start + 13, heap_offset_size(start));
            return std::max(first_row, std::bit_floor(offset / width));
        }
        const std::optional<std::size_t> reference = reference_to(start);
        if (!reference) return std::nullopt;
        if (is("OCHK", start)) return number(*reference + 8, 8) - 4;
        // A B-tree node: its number of records is beside the reference to it, in a header or node.
        constexpr std::array<std::size_t, 10> record_sizes{0, 24, 0, 0, 0, 11, 15, 0, 17, 13};
        const bool root = *reference >= 16 && is("BTHD", *reference - 16);
        const std::size_t count = number(*reference + 8, root ? 2 : 1);
        return 6 + count * record_sizes[number(start + 5, 1) % 10] +
               (is("BTIN", start) ? 9 * (count + 1) : 0);
    }

    std::string bytes_;
};

}  // namespace stratus::test
