#include "hdf5_structures.h"

#include "hdf5_file_region.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <initializer_list>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stratus::io {
namespace {

/// The product, or the largest number where it overflows.
std::uint64_t times(std::uint64_t a, std::uint64_t b) {
    return b != 0 && a > UINT64_MAX / b ? UINT64_MAX : a * b;
}

using Check = std::function<void(const FileRegion&)>;

/// Compares the checksum after the first `size` bytes, which the library does only halfway through
/// a tree, from where it cannot recover.
void check_checksum(const FileRegion& structure, std::uint64_t size) {
    expect(lookup3(structure.within(0, size).bytes()) == structure.within(size, 4).number(0, 4),
           "damaged structure");
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

// --- Attributes and links in a heap, and the B-trees that index them ---

/// What the records of a B-tree refer to.
enum class TreeKind { huge_objects = 1, link_names = 5, attribute_names = 8 };

/// The same by order of creation instead of name.
TreeKind by_creation(TreeKind names) { return TreeKind{static_cast<int>(names) + 1}; }

/// A B-tree with nodes of 512 bytes, the size that HDF5 chooses for attributes and links. One of
/// another kind would be read as if it were of this.
class BTree {
  public:
    BTree(const FileRegion& header, TreeKind kind)
        : header_(header), kind_(static_cast<std::uint64_t>(kind)) {}

    /// Checks the tree; `check_record` gets the part of each record that refers to the heap.
    void check(const Check& check_record) const {
        const std::uint64_t depth = header_.number(12, 2), merge = header_.number(15, 1);
        check_checksum(header_, 34);
        expect(header_.begins("BTHD") && header_.number(4, 1) == 0 && header_.number(6, 4) == 512 &&
                   depth <= 2 && header_.number(5, 1) == kind_ &&
                   records[kind_].size == header_.number(10, 2) && header_.number(14, 1) <= 100 &&
                   merge > 0 && 2 * merge < header_.number(14, 1),
               "malformed or unsupported B-tree");
        std::uint64_t left = max_records;
        check_node(header_.number(16, 8), header_.number(24, 2), depth, left, check_record);
    }

  private:
    static constexpr std::uint64_t max_records = 4096;

    struct Record {
        std::uint64_t size, key;  // bytes of the record, and of its part before the heap reference
    };
    /// By kind: 1 huge objects, 5 names and 6 creation order of links, 8 names and 9 creation order
    /// of attributes.
    static constexpr std::array<Record, 10> records{
        {{}, {24, 0}, {}, {}, {}, {11, 4}, {15, 8}, {}, {17, 0}, {13, 0}}};

    /// Checks a node and its descendants, which must not have more than `left` records.
    void check_node(std::uint64_t address, std::uint64_t count, std::uint64_t depth,
                    std::uint64_t& left, const Check& check_record) const {
        constexpr std::uint64_t room = 502, start = 6;
        const auto [size, key] = records[kind_];
        const std::uint64_t pointer = depth == 0 ? 0 : depth == 1 ? 9 : 11;
        expect(count <= (room - pointer) / (size + pointer), "a B-tree node has too many records");
        expect(count <= left, "a B-tree has too many records");
        left -= count;
        if (count == 0) return;
        const FileRegion node = header_.at_address(address);
        expect(node.begins(depth > 0 ? "BTIN" : "BTLF") && node.number(4, 1) == 0 &&
                   node.number(5, 1) == kind_,
               "malformed B-tree node");
        check_checksum(node, start + count * size + (depth > 0 ? (count + 1) * pointer : 0));
        for (std::uint64_t r = 0; r < count; ++r)
            check_record(node.within(start + r * size + key, size - key));
        for (std::uint64_t c = 0; depth > 0 && c <= count; ++c) {
            const FileRegion child = node.from(start + count * size + c * pointer);
            check_node(child.number(0, 8), child.number(8, 1), depth - 1, left, check_record);
        }
    }

    FileRegion header_;
    std::uint64_t kind_;
};

/// A heap of blocks in rows of four: the first two rows of the smallest size, then doubling.
class FractalHeap {
  public:
    FractalHeap(const FileRegion& file, std::uint64_t address)
        : address_(address), header_(file.at_address(address)) {}

    /// Checks the heap, and the huge objects that are stored outside it.
    void check(const Check& check_message) const {
        constexpr std::uint64_t largest_block = 65536;
        const char* const unsupported = "malformed or unsupported heap";
        const std::uint64_t managed = header_.number(10, 4), bits = header_.number(128, 2);
        check_checksum(header_, 142);
        expect(header_.begins("FRHP") && header_.number(4, 1) == 0 &&
                   header_.number(5, 2) == 3 + bits / 8 && header_.number(7, 2) == 0 &&
                   header_.number(9, 1) <= 3 && managed >= 256 && managed <= largest_block &&
                   header_.number(110, 2) == 4 && (first() == 512 || first() == 1024) &&
                   header_.number(120, 8) == largest_block && (bits == 32 || bits == 40),
               unsupported);
        const char* const larger = "a heap is too large";
        expect(rows() <= 16, larger);
        for_each_block([&](std::uint64_t offset, std::uint64_t size, const FileRegion& block) {
            if (block.size() == 0) return;
            expect(size <= largest_block, larger);  // larger ones are lists of further blocks
            check_block(block, "FHDB", offset, size);
        });
        if (rows() > 0) check_block(header_.at_address(header_.number(132, 8)), "FHIB", 0, 0);
        const std::uint64_t huge = header_.number(22, 8);
        if (huge == HADDR_UNDEF) return;
        expect(header_.number(86, 8) > 0, unsupported);  // 0: the library would delete their tree
        BTree(header_.at_address(huge), TreeKind::huge_objects)
            .check([&](const FileRegion& record) {
                check_message(
                    header_.at_address(0).within(record.number(0, 8), record.number(8, 8)));
            });
    }

    /// Checks the object that a B-tree record refers to.
    void check_object(const FileRegion& id, const Check& check_message) const {
        constexpr unsigned managed = 0x00, huge = 0x10;
        const std::uint64_t kind = id.number(0, 1), at = id.number(1, size_of_offset());
        expect(!(id.number(8, 1) & 2), "shared attributes are not supported");
        if (kind == huge) return;
        expect(kind == managed, "unsupported kind of heap object");
        bool found = false;
        for_each_block([&](std::uint64_t offset, std::uint64_t size, const FileRegion& block) {
            if (at < offset || at - offset >= size || block.size() == 0) return;
            const std::uint64_t length = id.number(1 + size_of_offset(), 2);
            check_message(block.within(0, size).within(at - offset, length));
            found = true;
        });
        expect(found, "an object is missing from a heap");
    }

  private:
    std::uint64_t first() const { return header_.number(112, 8); }
    std::uint64_t rows() const { return header_.number(140, 2); }
    std::uint64_t size_of_offset() const { return header_.number(128, 2) / 8; }
    std::uint64_t size_in_row(std::uint64_t row) const {
        return row < 2 ? first() : first() << (row - 1);
    }

    void check_block(const FileRegion& block, const char* name, std::uint64_t offset,
                     std::uint64_t size) const {
        const std::uint64_t sum_at = 13 + size_of_offset();
        expect(block.begins(name) && block.number(4, 1) == 0 && block.number(5, 8) == address_ &&
                   block.number(13, size_of_offset()) == offset,
               "misplaced heap block");
        if (size == 0) return check_checksum(block, sum_at + 32 * rows());  // a list of blocks
        if (!(header_.number(9, 1) & 2)) return;
        std::string bytes(block.within(0, size).bytes());
        bytes.replace(sum_at, 4, 4, '\0');
        expect(lookup3(bytes) == block.number(sum_at, 4), "damaged structure");
    }

    /// Calls `visit` with each block's offset in the heap, its size, and its bytes if it has any.
    template <class Visit>
    void for_each_block(const Visit& visit) const {
        const FileRegion root = header_.at_address(header_.number(132, 8));
        if (rows() == 0) return visit(std::uint64_t{0}, first(), root);
        std::uint64_t offset = 0;
        for (std::uint64_t n = 0; n < 4 * rows(); ++n) {
            const std::uint64_t size = size_in_row(n / 4);
            const FileRegion block = root.at_address(root.number(13 + size_of_offset() + 8 * n, 8));
            visit(offset, size, block);
            offset += size;
        }
    }

    std::uint64_t address_;
    FileRegion header_;
};

/// Checks the heap whose address an object header has at `at`, and the B-trees that index it: by
/// name, and where they are ordered by creation too.
void check_heap(const FileRegion& message, std::uint64_t at, TreeKind names,
                const Check& check_message) {
    const bool ordered = message.number(1, 1) & 2;
    message.from(at + (ordered ? 24 : 16));
    if (message.number(at, 8) == HADDR_UNDEF) return;
    const FractalHeap heap(message, message.number(at, 8));
    heap.check(check_message);
    const auto check_tree = [&](std::uint64_t tree_at, TreeKind kind) {
        const FileRegion tree = message.at_address(message.number(tree_at, 8));
        BTree(tree, kind).check([&](const FileRegion& record) {
            heap.check_object(record, check_message);
        });
    };
    check_tree(at + 8, names);
    if (ordered) check_tree(at + 16, by_creation(names));
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
