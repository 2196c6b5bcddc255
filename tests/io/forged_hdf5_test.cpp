// HDF5 files that only an adversary would make: changed, all checksums right again. Each is refused
// with its own sentence.
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

/// The file, without the seal that covers its bytes, of a table that has everything: several
/// chunks, and so many attributes that their trees have two levels.
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

TEST(ForgedHdf5, StampsOfAFileAsItWasWrittenAreThoseThatItHas) {
    const std::string& bytes = unsealed();
    for (const char* kind : {"OCHK", "BTIN", "BTLF", "FHIB", "FHDB", "FADB"})
        EXPECT_NE(bytes.find(kind), std::string::npos) << kind;
    ForgedHdf5 file(bytes);
    file.stamp();
    EXPECT_TRUE(file.bytes() == bytes);
}

TEST(ForgedHdf5, EveryStructureIsStamped) {
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

TEST(ForgedHdf5, IsDamagedWithoutStamps) {
    std::string bytes = unsealed();
    bytes.replace(bytes.find("small"), 5, "smell");
    EXPECT_EQ(refusal_of(bytes), "HDF5 cannot list the attributes: a structure is damaged");
}

TEST(Hdf5Table, IsNotWrittenWithMoreAttributesThanAreRead) {
    Table table = sample_table();
    for (int i = 0; i < 1000; ++i)
        table.attributes["note " + std::to_string(i)] = std::string(1000, 'x');
    const auto encode = [&] { io::encode_hdf5(table, io::metadata_of(table)); };
    const std::string message = refusal<std::runtime_error>(encode);
    EXPECT_TRUE(message.starts_with("cannot keep all attributes: ")) << message;
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

/// Puts `text` in place of every `other`, which is as long.
void replace_all(std::string& bytes, const std::string& other, const std::string& text) {
    for (std::size_t at = 0; (at = bytes.find(other, at)) != std::string::npos; at += text.size())
        bytes.replace(at, text.size(), text);
}

/// Sets a little-endian number, `offset` bytes behind the start of the first `name`.
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

// Where messages lie is told by what they are known to hold.
const std::string attribute = "note 30";  // nine bytes behind its message's start
const std::string chunks{4, 2, 0, 6};     // layout of the fourth version: in chunks, of rank 5
const std::string filters{2, 2, 2, 0};    // of the second version: two, the first one to shuffle
const std::string end = "a structure ends before its content";
const std::string other_tree = "a tree is none that a table has";
const std::string other_heap = "a heap is none that a table has";
const std::string other_type = "a datatype is none that a table has";
const std::string other_superblock = "its superblock is none that a table has";

const std::vector<Forgery> forgeries{
    {"AttributeThatIsThereTwice",
     [](std::string& bytes) { replace_all(bytes, "note 20", "note 21"); },
     "attribute \"note 21\" is there twice"},
    forgery("SmallAddresses", "HDF", 8, 4, 1, other_superblock),
    forgery("ShiftedAddresses", "HDF", 11, 8, 8, other_superblock),
    forgery("HugeMessage", "OHDR", 8, 0xffff, 2, end),
    forgery("SharedMessage", "OHDR", 10, 2, 1, "an object header shares a message"),
    forgery("OtherMessage", "OHDR", 7, 0x0f, 1, "an object has a message that no table has"),
    forgery("MessageThatIsThereTwice", "OHDR", 47, 0x02, 1, "an object has a message twice"),
    forgery("HugeObjectHeader", "OHDR", 6, 0xff, 1, end),
    forgery("OtherTree", "BTHD", 5, 10, 1, other_tree),
    forgery("RecordsOfNoSize", "BTHD", 10, 0, 2, other_tree),
    forgery("NodesOfNoSize", "BTHD", 6, 0, 4, other_tree),
    forgery("DeepTree", "BTHD", 12, 0xffff, 2, other_tree),
    forgery("FullNode", "BTHD", 24, 0xffff, 2, "a tree has a node that is too full"),
    forgery("FullNodeBelow", std::string("BTIN\0\x09", 6), 27, 255, 1,
            "a tree has a node that is too full"),
    forgery("HeapOfNoWidth", "FRHP", 110, 0, 2, other_heap),
    forgery("HeapOfSmallBlocks", "FRHP", 112, 1, 8, other_heap),
    forgery("HeapOfHugeBlocks", "FRHP", 120, std::uint64_t{1} << 40, 8, other_heap),
    forgery("HeapWithoutBounds", "FRHP", 128, 0xffff, 2, other_heap),
    forgery("FilteredHeap", "FRHP", 7, 8, 2, other_heap),
    forgery("HeapOfNoHugeObjectsButTheirTree", std::string("FRHP\0\x08", 6), 86, 0, 8, other_heap),
    forgery("HeapOfManyRows", "FRHP", 140, 17, 2, "a heap is larger than any table's"),
    forgery("BlockInAnothersPlace", "FHDB", 13, 0xffff, 2,
            "a heap has a block that is not in its place"),
    forgery("TinyObject", std::string("BTLF\0\x08", 6), 6, 0x20, 1,
            "a heap has an object of a kind that no table has"),
    forgery("ObjectBeyondItsBlock", std::string("BTLF\0\x08", 6), 12, 0xffff, 2, end),
    forgery("ObjectThatIsNowhere", std::string("BTLF\0\x08", 6), 7, 0xffffff, 4,
            "a heap lacks an object"),
    forgery("SharedAttribute", std::string("BTLF\0\x08", 6), 14, 2, 1, "an attribute is shared"),
    forgery("AttributeOfASharedType", attribute, -8, 1, 1, "an attribute shares its type"),
    forgery("AttributeWhoseNameGoesOn", attribute, -7, 5, 2, "an attribute's name goes on"),
    forgery("AttributeOfManyTypes", attribute, 8, 0x18, 1, other_type),
    forgery("AttributeOfNoSize", attribute, 12, 0, 4, other_type),
    forgery("HugeAttribute", attribute, 12, 0x7fffffff, 4,
            "an attribute is larger than its message"),
    forgery("AttributeOfManyMembers", attribute, 8, 0x1116, 2, other_type),
    forgery("AttributeOfManyDimensions", attribute, 17, 200, 1,
            "a dataspace has too many dimensions"),
    forgery("ChunksOfAnotherRank", chunks, 3, 33, 1, "chunks are of another rank"),
    forgery("ChunksWithoutExtents", chunks, 4, 0, 1, "chunks have no extents"),
    forgery("EmptyChunks", chunks, 5, 0, 1, "chunks have no extents"),
    forgery("ChunksListedOtherwise", chunks, 11, 4, 1, "chunks are listed as no table's are"),
    forgery("ChunksOfAnotherNumber", "FAHD", 8, 1, 8,
            "a list of chunks is not that of its dataset"),
    forgery("ChunksOfOtherFilters", "FAHD", 5, 0, 1, "a list of chunks is not that of its dataset"),
    forgery("SamplesInOtherFiles", chunks, 1, 3, 1, "samples lie in other files"),
    forgery("OldChunks", chunks, 0, 3, 1, "chunks are listed as before HDF5 1.10"),
    forgery("FilterWhoseNameGoesOn", filters, 2, 0x0003'0102, 8, "a filter's name goes on"),
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
