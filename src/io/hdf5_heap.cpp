#include "hdf5_heap.h"

#include <hdf5.h>

#include <array>
#include <string>

namespace stratus::io {
namespace {

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

}  // namespace

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

}  // namespace stratus::io
