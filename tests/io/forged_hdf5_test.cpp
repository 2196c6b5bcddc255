// HDF5 files that only an adversary would make: changed, all checksums right again. Each is refused
// with its own sentence.
#include "forged_hdf5.h"

#include <stratus/io/table_file.h>

#include <functional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <hdf5.h>

#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

namespace stratus::test {
namespace {

/// A table's file without the seal that covers its bytes.
std::string unsealed(const Table& table) {
    constexpr std::ptrdiff_t seal_size = sizeof "\nstratus-table crc32:00000000";
    const io::Bytes bytes = io::encode_hdf5(table, io::metadata_of(table));
    return {bytes.begin(), bytes.end() - seal_size};
}

Table decode(const std::string& bytes) {
    return io::decode_hdf5({bytes.begin(), bytes.end()}, io::MemoryLimit(64 << 20), nullptr);
}

std::string refusal_of(const std::string& bytes) {
    return refusal<std::runtime_error>([&] { decode(bytes); });
}

TEST(ForgedHdf5, StampsOfAFileAsItWasWrittenAreThoseThatItHas) {
    const std::string bytes = unsealed(sample_table());
    ForgedHdf5 file(bytes);
    EXPECT_GT(file.starts().size(), 30U);
    file.stamp();
    EXPECT_TRUE(file.bytes() == bytes);
}

TEST(ForgedHdf5, EveryStructureIsStamped) {
    const std::string bytes = unsealed(sample_table());
    for (const std::size_t start : ForgedHdf5(bytes).starts()) {
        ForgedHdf5 file(bytes);
        char& version = file.bytes()[start + (start == 0 ? 8 : 4)];
        version = static_cast<char>(~version);
        const std::string changed = file.bytes();
        file.stamp();
        EXPECT_TRUE(file.bytes() != changed) << bytes.substr(start, 4) << " at " << start;
    }
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

const std::vector<Forgery> forgeries{
    {"AttributeThatIsThereTwice",
     [](std::string& bytes) { replace_all(bytes, "note two", "note one"); },
     "attribute \"note one\" is there twice"},
};

class Forged : public testing::TestWithParam<Forgery> {};

TEST_P(Forged, IsRefused) {
    Table table = sample_table();
    table.attributes["note one"] = "1";
    table.attributes["note two"] = "2";
    const std::string bytes = unsealed(table);
    ForgedHdf5 file(bytes);
    GetParam().work(file.bytes());
    ASSERT_FALSE(file.bytes() == bytes);
    file.stamp();
    const std::string message = refusal_of(file.bytes());
    EXPECT_TRUE(message.starts_with(GetParam().reason)) << message;
}

INSTANTIATE_TEST_SUITE_P(Files, Forged, testing::ValuesIn(forgeries),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace stratus::test
