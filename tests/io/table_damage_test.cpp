// Tens of thousands of damaged files: each is refused in one sentence or read as the table that was
// written; never a crash, never a read that does not end, under the sanitizers too.
//
// A share runs always; STRATUS_ALL_DAMAGE in the environment asks for all.
#include <stratus/io/table_file.h>

#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "damage.h"
#include "sample_table.h"
#include "table_content.h"

namespace stratus::test {
namespace {

constexpr std::size_t seal_size = sizeof "\nstratus-table crc32:00000000";
constexpr std::uintmax_t max_memory = 64 << 20;

int mutations() { return std::getenv("STRATUS_ALL_DAMAGE") ? 20000 : 1000; }

Table small_table() {
    Shape shape;
    shape.finite_depths = 2;
    shape.azimuths = 3;
    return sample_table(shape);
}

struct Format {
    const char* name;
    io::Bytes (*encode)(const Table&, const io::Metadata&);
    Table (*decode)(const io::Bytes&, io::MemoryLimit);
};

std::ostream& operator<<(std::ostream& stream, const Format& format) {
    return stream << format.name;
}

class Damaged : public testing::TestWithParam<Format> {
  protected:
    /// SIGALRM ends the program when a read takes longer than any does, by a factor of hundreds.
    void expect_refused_or_same(const io::Bytes& bytes) {
        ::alarm(5);
        try {
            const Table read = GetParam().decode(bytes, io::MemoryLimit(max_memory));
            ::alarm(0);
            ++accepted;
            expect_same(read, table);
        } catch (const std::exception& error) {
            ::alarm(0);
            EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
            EXPECT_STRNE(error.what(), "");
        }
    }

    const Table table = small_table();
    const io::Bytes whole = GetParam().encode(table, io::metadata_of(table));
    const bool hdf5 = std::string_view(GetParam().name) == "h5";
    const io::Bytes without_seal{whole.begin(), whole.end() - (hdf5 ? seal_size : 0)};
    int accepted = 0;
};

INSTANTIATE_TEST_SUITE_P(Formats, Damaged,
                         testing::Values(Format{"h5", io::encode_hdf5, io::decode_hdf5},
                                         Format{"exr", io::encode_exr, io::decode_exr}),
                         [](const auto& row) { return row.param.name; });

TEST_P(Damaged, IsRefusedWhereverItIsCut) {
    for (std::size_t length = 0; length < without_seal.size(); length += 512)
        expect_refused_or_same(
            {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
    EXPECT_EQ(accepted, 0);
}

TEST_P(Damaged, IsRefusedOrSame) {
    std::mt19937 random(6);
    for (int i = 0; i < mutations() && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        io::Bytes bytes = i % 4 == 0 ? whole : without_seal;
        const Block all{0, bytes.size()};
        for (int n = i % 3; n >= 0; --n) damage(bytes, all, random);
        expect_refused_or_same(bytes);
    }
}

/// Headers, where sizes are, are a small part of a file.
TEST_P(Damaged, IsRefusedOrSameWhereSizesAre) {
    std::mt19937 random(66);
    for (int i = 0; i < mutations() && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        io::Bytes bytes = without_seal;
        for (int n = i % 3; n >= 0; --n)
            damage(bytes, {0, std::min<std::size_t>(bytes.size(), hdf5 ? 512 : 8192)}, random);
        expect_refused_or_same(bytes);
    }
}

TEST_P(Damaged, IsRefusedOrSameWhenTheLibrarysChecksumsHold) {
    if (!hdf5) GTEST_SKIP() << "OpenEXR has none";
    const std::vector<Block> blocks = structures(without_seal);
    ASSERT_GT(blocks.size(), 20U);
    std::mt19937 random(666);
    std::uniform_int_distribution<std::size_t> any(0, blocks.size() - 1);
    for (int i = 0; i < mutations() && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        io::Bytes bytes = without_seal;
        const Block& block = blocks[any(random)];
        for (int n = i % 3; n >= 0; --n) damage(bytes, block, random);
        mend(bytes, block);
        expect_refused_or_same(bytes);
    }
}

}  // namespace
}  // namespace stratus::test
