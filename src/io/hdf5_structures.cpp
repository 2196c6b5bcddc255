#include "hdf5_structures.h"

#include "hdf5_file_region.h"
#include "hdf5_heap.h"

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <new>
#include <optional>
#include <utility>
#include <vector>

namespace stratus::io {
namespace {

/// The product, or the largest number where it overflows.
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
    return b != 0 && a > UINT64_MAX / b ? UINT64_MAX : a * b;
}

// --- Messages ---

/// Checks a datatype and returns the bytes of an element. Datatypes are nested one deep at most.
std::uint64_t check_datatype(const FileRegion& type, bool nested = false) {
    constexpr const char* unsupported = "unsupported datatype";
    constexpr unsigned integer = 0, floating = 1, text = 3, compound = 6, reference = 7, list = 9;
    const auto properties_end = [](std::uint64_t kind) {
        return kind == integer ? 12U : kind == floating ? 20U : 8U;
    };
    const std::uint64_t kind = type.number(0, 1) & 15, version = type.number(0, 1) >> 4;
    const std::uint64_t element = type.number(4, 4);
    expect(version >= 1 && version <= 3 && element > 0, unsupported);
    std::uint64_t at = properties_end(kind);
    type.from(at);
    if (kind == integer || kind == floating || kind == text || kind == reference) return element;
    expect((kind == compound || kind == list) && !nested, unsupported);
    if (kind == list) check_datatype(type.from(at), true);
    if (kind == list) return element;
    constexpr std::uint64_t max_members = 16;
    expect(type.number(1, 2) <= max_members, unsupported);
    for (std::uint64_t left = type.number(1, 2); left > 0; --left) {
        std::uint64_t name = 1;
        while (type.number(at + name - 1, 1) != 0) ++name;
        at += version < 3 ? (name + 7) / 8 * 8 : name;
        at += version == 1 ? 32U : version == 2 ? 4U : (std::bit_width(element) + 7U) / 8;
        expect(check_datatype(type.from(at), true) <= element, unsupported);
        at += properties_end(type.number(at, 1) & 15);
    }
    return element;
}

std::vector<std::uint64_t> check_dataspace(const FileRegion& space) {
    const std::uint64_t rank = space.number(1, 1), at = space.number(0, 1) == 1 ? 8 : 4;
    const bool limited = space.number(2, 1) & 1;
    expect(rank <= 32, "a dataspace has too many dimensions");
    space.within(0, at + 8 * rank * (limited ? 2 : 1));
    std::vector<std::uint64_t> extents;
    for (std::uint64_t d = 0; d < rank; ++d) extents.push_back(space.number(at + 8 * d, 8));
    return extents;
}

void check_attribute(const FileRegion& attribute) {
    const std::uint64_t version = attribute.number(0, 1);
    const auto padded = [&](std::uint64_t bytes) {
        return version == 1 ? (bytes + 7) / 8 * 8 : bytes;
    };
    const std::uint64_t name = attribute.number(2, 2), type_size = attribute.number(4, 2);
    const std::uint64_t name_at = version == 3 ? 9 : 8, type_at = name_at + padded(name);
    const std::uint64_t space_at = type_at + padded(type_size);
    const FileRegion values = attribute.from(space_at + padded(attribute.number(6, 2)));
    expect(version == 1 || attribute.number(1, 1) == 0, "shared datatypes are not supported");
    expect(name > 0 && attribute.number(name_at + name - 1, 1) == 0,
           "an attribute's name is not terminated");
    std::uint64_t bytes = check_datatype(attribute.within(type_at, type_size));
    for (const std::uint64_t extent :
         check_dataspace(attribute.within(space_at, attribute.number(6, 2))))
        bytes = times(bytes, extent);
    expect(bytes <= values.size(), "an attribute is larger than its message");
}

void check_link(const FileRegion& link) {
    const std::uint64_t flags = link.number(1, 1), size_of_length = 1U << (flags & 3);
    const std::uint64_t at = 2U + (flags & 8 ? 1 : 0) + (flags & 4 ? 8 : 0) + (flags & 16 ? 1 : 0);
    const bool hard = !(flags & 8) || link.number(2, 1) == 0;
    link.from(at + size_of_length).from(link.number(at, size_of_length)).from(hard ? 8 : 2);
}

void check_fill_value(const FileRegion& fill) {
    const std::uint64_t version = fill.number(0, 1), at = version < 3 ? 4 : 2;
    const bool given = version == 1 || fill.number(at - 1, 1) & (version < 3 ? 1 : 0x20);
    const std::uint64_t size = fill.number(at, 4);
    fill.from(at + (given ? 4 : 0));
    if (given && size <= INT32_MAX) fill.from(at + 4).from(size);  // a negative size: no value
}

/// Returns whether there are filters.
bool check_filters(const FileRegion& filters) {
    const std::uint64_t version = filters.number(0, 1), count = filters.number(1, 1);
    std::uint64_t at = version == 1 ? 8 : 2;
    for (std::uint64_t left = count; left > 0; --left) {
        const bool named = version == 1 || filters.number(at, 2) >= 256;
        const std::uint64_t name = named ? filters.number(at + 2, 2) : 0;
        const std::uint64_t values = filters.number(at + (named ? 6 : 4), 2);
        at += (named ? 8 : 6) + name;
        expect(name == 0 || filters.number(at - 1, 1) == 0, "a filter's name is not terminated");
        at += 4 * (version == 1 ? (values + 1) / 2 * 2 : values);
        filters.from(at);
    }
    return count > 0;
}

/// Where the samples of a dataset are: contiguous, or in chunks with an index of all of them.
void check_layout(const FileRegion& layout, const std::vector<std::uint64_t>& extents,
                  bool filtered) {
    constexpr unsigned compact = 0, contiguous = 1, chunked = 2, single = 1, fixed_array = 3;
    constexpr std::uint64_t max_chunks = 1 << 20;
    const std::uint64_t version = layout.number(0, 1), kind = layout.number(1, 1);
    expect(version == 3 || version == 4, "the data layout predates HDF5 1.6");
    if (kind == compact) layout.from(4).from(layout.number(2, 2));
    if (kind == contiguous) layout.from(18);
    if (kind == compact || kind == contiguous) return;
    expect(kind == chunked, "samples are stored in other files");
    expect(version == 4, "the chunk index predates HDF5 1.10");
    const std::uint64_t rank = layout.number(3, 1), size_of_extent = layout.number(4, 1);
    expect(rank == extents.size() + 1, "chunks have another rank than their dataset");
    expect(size_of_extent >= 1 && size_of_extent <= 8, "chunk extents must not be zero");
    std::uint64_t bytes = 1, chunks = 1;
    for (std::uint64_t d = 0; d < rank; ++d) {
        const std::uint64_t extent = layout.number(5 + d * size_of_extent, size_of_extent);
        expect(extent > 0, "chunk extents must not be zero");
        bytes = times(bytes, extent);
        if (d < extents.size())
            chunks = times(chunks, extents[d] / extent + (extents[d] % extent > 0));
    }
    expect(bytes <= UINT32_MAX, "chunks are larger than 4 GiB");
    const std::uint64_t at = 5 + rank * size_of_extent, index = layout.number(at, 1);
    if (index == single) {
        const bool filtered_here = layout.number(2, 1) & 2;
        layout.from(at + (filtered_here ? 21 : 9));
        return;
    }
    expect(index == fixed_array, "unsupported chunk index");
    layout.from(at + 10);
    const FileRegion chunk_index = layout.at_address(layout.number(at + 2, 8));
    if (layout.number(at + 2, 8) == HADDR_UNDEF) return;
    const std::uint64_t size_of_size = 1U + (std::bit_width(bytes) + 7U) / 8;
    expect(chunk_index.number(5, 1) == filtered && chunks <= max_chunks &&
               chunk_index.number(8, 8) == chunks &&
               chunk_index.number(6, 1) == (filtered ? 12 + size_of_size : 8) &&
               chunk_index.number(7, 1) == layout.number(at + 1, 1) &&
               chunk_index.number(7, 1) < 32,
           "the chunk index does not match its dataset");
    check_checksum(chunk_index, 24);
    const FileRegion entries = chunk_index.at_address(chunk_index.number(16, 8));
    const bool paged = chunks > std::uint64_t{1} << chunk_index.number(7, 1);
    if (!paged && chunk_index.number(16, 8) != HADDR_UNDEF)
        check_checksum(entries, 14 + chunks * chunk_index.number(6, 1));
}

// --- Object headers ---

class ObjectHeader {
  public:
    explicit ObjectHeader(const FileRegion& header) : header_(header) {}

    /// Bytes of its first chunk, which is read at once.
    std::uint64_t size() const { return start() + header_.number(size_at(), size_of_size()) + 4; }

    void check() {
        expect(header_.number(4, 1) == 2, "unsupported object header version");
        check_checksum(header_, size() - 4);
        check_messages(header_.within(start(), size() - 4 - start()));
        for (std::size_t c = 0; c < continued_.size(); ++c) {
            const std::uint64_t size = continued_[c].number(8, 8);
            expect(c < 100 && size >= 8, "malformed object header continuation");
            const FileRegion chunk = header_.at_address(0).within(continued_[c].number(0, 8), size);
            expect(chunk.begins("OCHK"), "malformed object header continuation");
            check_checksum(chunk, size - 4);
            check_messages(chunk.within(4, size - 8));
        }
        if (layout_) check_layout(*layout_, extents_, filtered_);
    }

  private:
    std::uint64_t flags() const { return header_.number(5, 1); }
    std::uint64_t size_at() const {
        return 6U + (flags() & 0x20 ? 16 : 0) + (flags() & 0x10 ? 4 : 0);
    }
    std::uint64_t size_of_size() const { return 1U << (flags() & 3); }
    std::uint64_t start() const { return size_at() + size_of_size(); }

    void check_messages(const FileRegion& chunk) {
        const std::uint64_t prefix = flags() & 4 ? 6 : 4;
        for (std::uint64_t at = 0; at + prefix <= chunk.size();) {
            const std::uint64_t size = chunk.number(at + 1, 2);
            expect(!(chunk.number(at + 3, 1) & 2),
                   "shared object header messages are not supported");
            check_message(chunk.number(at, 1), chunk.within(at + prefix, size));
            at += prefix + size;
        }
    }

    void check_message(std::uint64_t kind, const FileRegion& message) {
        constexpr std::size_t max_messages = 4096;
        const bool repeats = kind == 0x00 || kind == 0x06 || kind == 0x0c || kind == 0x10;
        expect(repeats || std::count(kinds_.begin(), kinds_.end(), kind) == 0,
               "duplicate object header message");
        expect(kinds_.size() < max_messages, "too many object header messages");
        kinds_.push_back(kind);
        const bool counts = message.number(1, 1) & 1;  // has a creation counter
        switch (kind) {
            case 0x00: break;
            case 0x01: extents_ = check_dataspace(message); break;
            case 0x02:
                check_heap(message, counts ? 10 : 2, TreeKind::link_names, check_link);
                break;
            case 0x03: check_datatype(message); break;
            case 0x04: message.from(4).from(message.number(0, 4)); break;
            case 0x05: check_fill_value(message); break;
            case 0x06: check_link(message); break;
            case 0x07: expect(false, "samples are stored in other files"); break;
            case 0x08: layout_ = message; break;
            case 0x0a: message.from(2); break;
            case 0x0b: filtered_ = check_filters(message); break;
            case 0x0c: check_attribute(message); break;
            case 0x10: continued_.push_back(message.within(0, 16)); break;
            case 0x12: message.from(8); break;
            case 0x15:
                check_heap(message, counts ? 4 : 2, TreeKind::attribute_names, check_attribute);
                break;
            case 0x16: message.from(5); break;
            default: expect(false, "unsupported object header message");
        }
    }

    FileRegion header_;
    std::vector<std::uint64_t> kinds_;  // of the messages so far
    std::vector<FileRegion> continued_;
    std::vector<std::uint64_t> extents_;
    bool filtered_ = false;
    std::optional<FileRegion> layout_;
};

void check_superblock(const FileRegion& file) {
    const std::uint64_t version = file.number(8, 1);
    expect(version >= 2, "its structures predate HDF5 1.10; h5repack --latest converts it");
    expect(version <= 3 && file.number(9, 1) == 8 && file.number(10, 1) == 8 &&
               file.number(12, 8) == 0 && file.number(20, 8) == HADDR_UNDEF,
           "malformed or unsupported superblock");
}

}  // namespace

const char* Hdf5Structures::refusal(H5FD_mem_t kind, std::uint64_t address,
                                    std::uint64_t size) noexcept {
    constexpr const char* unsupported = "unsupported structure";
    const std::uint64_t rest = std::exchange(rest_, HADDR_UNDEF);
    if (kind == H5FD_MEM_DRAW || (kind == H5FD_MEM_OHDR && address == rest)) return nullptr;
    try {
        const FileRegion structure(file_, address);
        const auto is_one_of = [&](std::initializer_list<const char*> names) {
            return std::any_of(names.begin(), names.end(),
                               [&](const char* name) { return structure.begins(name); });
        };
        expect(size >= 8, "truncated structure");
        if (kind == H5FD_MEM_SUPER) {
            check_superblock(structure.at_address(0));
        } else if (kind == H5FD_MEM_OHDR && structure.begins("OHDR")) {
            ObjectHeader header(structure);
            header.check();
            if (header.size() > size) rest_ = address + size;
        } else if (kind == H5FD_MEM_OHDR) {
            expect(is_one_of({"OCHK", "FRHP", "FHIB", "FAHD"}), unsupported);
        } else if (kind == H5FD_MEM_BTREE) {
            expect(is_one_of({"BTHD", "BTIN", "BTLF"}), unsupported);
        } else {
            expect(kind == H5FD_MEM_LHEAP && !structure.begins("HEAP"), unsupported);
        }
        return nullptr;
    } catch (const RefusedStructure& refused) {
        return refused.reason;
    } catch (const std::bad_alloc&) {
        return "not enough memory to check it";
    }
}

}  // namespace stratus::io
