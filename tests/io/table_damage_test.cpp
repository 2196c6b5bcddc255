// Randomly damaged files are refused with one sentence or read as the table that was written,
// without crashes or endless reads, also under the sanitizers.
//
// Runs 1000 mutations of each kind; with STRATUS_ALL_DAMAGE in the environment, 5000.
#include <stratus/io/table_file.h>

#include "row_name.h"
#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <random>
#include <unistd.h>

/// HDF5 itself leaks memory on damaged files; of all tests of the program.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace stratus::test {
namespace {

constexpr std::uintmax_t max_memory = 64 << 20;

int mutations() { return std::getenv("STRATUS_ALL_DAMAGE") ? 5000 : 1000; }

/// Changes a bit, a byte, a run of bytes, or a field of 4 or 8 bytes, which is set to an extreme
/// size or address, at a random position in the first `size` bytes; or takes bytes out there, or
/// puts some in.
void damage(io::Bytes& bytes, std::size_t size, std::mt19937& random) {
    constexpr std::array<std::uint64_t, 12> extremes{
        0,          1,           0x7f,        0xff,       0x7fff,     0xffff,
        0x7fffffff, 0x80000000U, 0xffffffffU, UINT64_MAX, 1ULL << 63, UINT64_MAX >> 1};
    const auto below = [&](std::size_t count) {
        return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
    };
    const std::size_t at = below(size), room = size - at;
    const std::size_t length = 1 + below(std::min<std::size_t>(room, 64));
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (below(7)) {
        case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8))); return;
        case 1: bytes[at] = static_cast<char>(below(256)); return;
        case 2:
            for (std::size_t i = 0; i < length; ++i) bytes[at + i] = static_cast<char>(below(256));
            return;
        case 3: {
            const std::size_t from = below(size - length + 1);
            std::memmove(bytes.data() + at, bytes.data() + from, length);
            return;
        }
        case 4: bytes.erase(begin, begin + static_cast<std::ptrdiff_t>(length)); return;
        case 5: bytes.insert(begin, length, static_cast<char>(below(256))); return;
        default: {
            const std::uint64_t value = extremes[below(extremes.size())];
            std::memcpy(bytes.data() + at, &value, std::min<std::size_t>(room, below(2) ? 8 : 4));
        }
    }
}

Table small_table() {
    Shape shape;
    shape.finite_depths = 2;
    shape.azimuths = 3;
    shape.mixtures = 2;
    return sample_table(shape);
}

struct Format {
    const char* name;
    Table (*decode)(const io::Bytes&, const ReadOptions&);
};

class Damaged : public testing::TestWithParam<Format> {
  protected:
    /// Ends the program by SIGALRM if reading takes hundreds of times longer than usual.
    void expect_refused_or_same(const io::Bytes& bytes) {
        ::alarm(5);
        try {
            const Table read = GetParam().decode(bytes, {max_memory});
            ::alarm(0);
            expect_same(read, table);
        } catch (const std::exception& error) {
            ::alarm(0);
            EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
            EXPECT_STRNE(error.what(), "");
        }
    }

    static io::Bytes written(const Table& table) {
        const TemporaryFolder folder;
        const auto path = folder / (std::string("table.") + GetParam().name);
        write_table(table, path);
        const std::string text = content(path);
        return {text.begin(), text.end()};
    }

    const Table table = small_table();
    const io::Bytes whole = written(table);
    const bool hdf5 = std::string_view(GetParam().name) == "h5";
};

INSTANTIATE_TEST_SUITE_P(Formats, Damaged,
                         testing::Values(Format{"h5", io::decode_hdf5},
                                         Format{"exr", io::decode_exr}),
                         row_name);

TEST_P(Damaged, IsRefusedOrSame) {
    io::Bytes longer = whole;
    longer.push_back('x');
    expect_refused_or_same(longer);
    std::mt19937 random(6);
    for (int i = 0; i < mutations() && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        io::Bytes bytes = whole;
        for (int n = i % 3; n >= 0; --n) damage(bytes, bytes.size(), random);
        expect_refused_or_same(bytes);
    }
}

/// Headers hold the sizes, and are a small part of a file.
TEST_P(Damaged, IsRefusedOrSameWithDamagedHeaders) {
    std::mt19937 random(66);
    for (int i = 0; i < mutations() && !HasFailure(); ++i) {
        SCOPED_TRACE(i);
        io::Bytes bytes = whole;
        for (int n = i % 3; n >= 0; --n)
            damage(bytes, std::min<std::size_t>(bytes.size(), hdf5 ? 512 : 8192), random);
        expect_refused_or_same(bytes);
    }
}

}  // namespace
}  // namespace stratus::test
