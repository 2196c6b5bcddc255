// Forged HDF5 files: changed on purpose, with all checksums recomputed. Each is refused with its
// own message.
#include "forged_hdf5.h"

#include <stratus/io/table_file.h>

#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// The file, without its seal, of a table with structures of all kinds: several chunks, and so many
/// attributes that their B-trees have two levels.
const std::string& unsealed() {
    static const std::string bytes = [] {
        constexpr std::ptrdiff_t seal_size = sizeof "\nstratus-table crc32:00000000";
        Shape shape;
        shape.albedos = 9;
        shape.finite_depths = 12;
        shape.cosines_in = shape.cosines_out = 11;
        shape.azimuths = 16;
        shape.transmission = false;
        Table table = sample_table(shape);
        table.reflection_multiple.assign(table.sample_count(), 0.5F);  // a small file
        for (int i = 10; i < 60; ++i) table.attributes["note " + std::to_string(i)] = "small";
        table.attributes["huge"] = std::string(5000, 'x');
        const io::Bytes whole = io::encode_hdf5(table, io::metadata_of(table));
        return std::string(whole.begin(), whole.end() - seal_size);
    }();
    return bytes;
}

Table decode(const std::string& bytes) {
    return io::decode_hdf5({bytes.begin(), bytes.end()}, io::MemoryLimit(64 << 20), nullptr);
}

std::string refusal_of(const std::string& bytes) {
    return refusal<std::runtime_error>([&] { decode(bytes); });
}

TEST(ForgedHdf5, StampingAnUnchangedFileChangesNothing) {
    const std::string& bytes = unsealed();
    for (const char* kind : {"OCHK", "BTIN", "BTLF", "FHIB", "FHDB", "FADB"})
        EXPECT_NE(bytes.find(kind), std::string::npos) << kind;
    ForgedHdf5 file(bytes);
    file.stamp();
    EXPECT_TRUE(file.bytes() == bytes);
}

TEST(ForgedHdf5, StampingCoversEveryStructure) {
    const std::string& bytes = unsealed();
    for (const std::size_t start : ForgedHdf5(bytes).starts()) {
        ForgedHdf5 file(bytes);
        char& version = file.bytes()[start + (start == 0 ? 8 : 4)];
        version = static_cast<char>(~version);
        const std::string changed = file.bytes();
        file.stamp();
        EXPECT_TRUE(file.bytes() != changed) << bytes.substr(start, 4) << " at " << start;
    }
}

TEST(ForgedHdf5, IsRefusedAsDamagedWithoutStamping) {
    std::string bytes = unsealed();
    bytes.replace(bytes.find("small"), 5, "smell");
    EXPECT_EQ(refusal_of(bytes), "HDF5 cannot list the attributes: damaged structure");
}

TEST(Hdf5Table, RefusesToWriteMoreAttributesThanItReads) {
    Table table = sample_table();
    for (int i = 0; i < 1000; ++i)
        table.attributes["note " + std::to_string(i)] = std::string(1000, 'x');
    const auto encode = [&] { io::encode_hdf5(table, io::metadata_of(table)); };
    const std::string message = refusal<std::runtime_error>(encode);
    EXPECT_TRUE(message.starts_with("cannot store all attributes: ")) << message;
    table.attributes.clear();
    for (int i = 0; i < 300; ++i)
        table.attributes["note " + std::to_string(i)] = std::string(1000, 'x');
    const io::Bytes bytes = io::encode_hdf5(table, io::metadata_of(table));
    EXPECT_EQ(io::decode_hdf5(bytes, io::MemoryLimit(), nullptr).attributes, table.attributes);
}

// --- Refusals ---

struct Forgery {
    const char* name;
    std::function<void(std::string& bytes)> work;
    std::string reason;
};

std::ostream& operator<<(std::ostream& stream, const Forgery& row) { return stream << row.name; }

/// Replaces every `other` with `text`, which is as long.
void replace_all(std::string& bytes, const std::string& other, const std::string& text) {
    for (std::size_t at = 0; (at = bytes.find(other, at)) != std::string::npos; at += text.size())
        bytes.replace(at, text.size(), text);
}

/// Sets a little-endian number `offset` bytes after the start of the first `name`.
void set(std::string& bytes, const std::string& name, int offset, std::uint64_t value,
         std::size_t size = 1) {
    const std::size_t start = bytes.find(name);
    ASSERT_NE(start, std::string::npos);
    for (std::size_t i = 0; i < size; ++i)
        bytes[start + static_cast<std::size_t>(offset) + i] = static_cast<char>(value >> (8 * i));
}

Forgery forgery(const char* name, const std::string& structure, int offset, std::uint64_t value,
                std::size_t size, const std::string& reason) {
    return {name, [=](std::string& bytes) { set(bytes, structure, offset, value, size); }, reason};
}

// Messages are found by their known content.
const std::string attribute = "note 30";  // nine bytes after the start of its message
const std::string chunks{4, 2, 0, 6};     // layout version 4: chunked, of rank 5
const std::string filters{2, 2, 2, 0};    // version 2: two filters, the first of them shuffle
const std::string truncated = "truncated structure";
const std::string bad_tree = "malformed or unsupported B-tree";
const std::string bad_heap = "malformed or unsupported heap";
const std::string bad_type = "unsupported datatype";
const std::string bad_superblock = "malformed or unsupported superblock";

const std::vector<Forgery> forgeries{
    {"DuplicateAttribute", [](std::string& bytes) { replace_all(bytes, "note 20", "note 21"); },
     "duplicate attribute \"note 21\""},
    forgery("SmallAddresses", "HDF", 8, 4, 1, bad_superblock),
    forgery("ShiftedAddresses", "HDF", 11, 8, 8, bad_superblock),
    forgery("HugeMessage", "OHDR", 8, 0xffff, 2, truncated),
    forgery("SharedMessage", "OHDR", 10, 2, 1, "shared object header messages are not supported"),
    forgery("UnsupportedMessage", "OHDR", 7, 0x0f, 1, "unsupported object header message"),
    forgery("DuplicateMessage", "OHDR", 47, 0x02, 1, "duplicate object header message"),
    forgery("HugeObjectHeader", "OHDR", 6, 0xff, 1, truncated),
    forgery("UnsupportedTree", "BTHD", 5, 10, 1, bad_tree),
    {"TreeOfAnotherKind",  // of links: by order of creation in place of by name
     [](std::string& bytes) {
         const std::size_t header = bytes.find("OHDR");
         bytes.replace(header + 31, 8, bytes.substr(header + 39, 8));
     },
     bad_tree},
    forgery("EmptyRecords", "BTHD", 10, 0, 2, bad_tree),
    forgery("EmptyNodes", "BTHD", 6, 0, 4, bad_tree),
    forgery("DeepTree", "BTHD", 12, 0xffff, 2, bad_tree),
    forgery("OverfullNode", "BTHD", 24, 0xffff, 2, "a B-tree node has too many records"),
    forgery("OverfullInnerNode", std::string("BTIN\0\x09", 6), 27, 255, 1,
            "a B-tree node has too many records"),
    forgery("HeapOfWidthZero", "FRHP", 110, 0, 2, bad_heap),
    forgery("HeapOfSmallBlocks", "FRHP", 112, 1, 8, bad_heap),
    forgery("HeapOfHugeBlocks", "FRHP", 120, std::uint64_t{1} << 40, 8, bad_heap),
    forgery("HeapOfHugeOffsets", "FRHP", 128, 0xffff, 2, bad_heap),
    forgery("FilteredHeap", "FRHP", 7, 8, 2, bad_heap),
    forgery("HeapWithATreeOfNoHugeObjects", std::string("FRHP\0\x08", 6), 86, 0, 8, bad_heap),
    forgery("HeapOfManyRows", "FRHP", 140, 17, 2, "a heap is too large"),
    forgery("MisplacedBlock", "FHDB", 13, 0xffff, 2, "misplaced heap block"),
    forgery("TinyObject", std::string("BTLF\0\x08", 6), 6, 0x20, 1,
            "unsupported kind of heap object"),
    forgery("ObjectBeyondItsBlock", std::string("BTLF\0\x08", 6), 12, 0xffff, 2, truncated),
    forgery("MissingObject", std::string("BTLF\0\x08", 6), 7, 0xffffff, 4,
            "an object is missing from a heap"),
    forgery("SharedAttribute", std::string("BTLF\0\x08", 6), 14, 2, 1,
            "shared attributes are not supported"),
    forgery("AttributeWithASharedType", attribute, -8, 1, 1, "shared datatypes are not supported"),
    forgery("AttributeWithAnUnterminatedName", attribute, -7, 5, 2,
            "an attribute's name is not terminated"),
    forgery("AttributeOfAnUnsupportedType", attribute, 8, 0x18, 1, bad_type),
    forgery("AttributeOfSizeZero", attribute, 12, 0, 4, bad_type),
    forgery("HugeAttribute", attribute, 12, 0x7fffffff, 4,
            "an attribute is larger than its message"),
    forgery("AttributeOfManyMembers", attribute, 8, 0x1116, 2, bad_type),
    forgery("AttributeOfManyDimensions", attribute, 17, 200, 1,
            "a dataspace has too many dimensions"),
    forgery("ChunksOfAnotherRank", chunks, 3, 33, 1, "chunks have another rank than their dataset"),
    forgery("ChunksWithoutExtents", chunks, 4, 0, 1, "chunk extents must not be zero"),
    forgery("EmptyChunks", chunks, 5, 0, 1, "chunk extents must not be zero"),
    forgery("UnsupportedChunkIndex", chunks, 11, 4, 1, "unsupported chunk index"),
    forgery("ChunkIndexOfAnotherCount", "FAHD", 8, 1, 8,
            "the chunk index does not match its dataset"),
    forgery("ChunkIndexOfOtherFilters", "FAHD", 5, 0, 1,
            "the chunk index does not match its dataset"),
    forgery("SamplesInOtherFiles", chunks, 1, 3, 1, "samples are stored in other files"),
    forgery("OldChunkIndex", chunks, 0, 3, 1, "the chunk index predates HDF5 1.10"),
    forgery("FilterWithAnUnterminatedName", filters, 2, 0x0003'0102, 8,
            "a filter's name is not terminated"),
};

class Forged : public testing::TestWithParam<Forgery> {};

TEST_P(Forged, IsRefused) {
    ForgedHdf5 file(unsealed());
    GetParam().work(file.bytes());
    ASSERT_FALSE(file.bytes() == unsealed());
    file.stamp();
    const std::string message = refusal_of(file.bytes());
    EXPECT_NE(message.find(GetParam().reason), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL), 0) << "still open";
}

INSTANTIATE_TEST_SUITE_P(Files, Forged, testing::ValuesIn(forgeries),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace stratus::test
