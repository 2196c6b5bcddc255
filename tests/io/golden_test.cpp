// Files written when formats 1.0 and 1.1 (with a mixture) were new, in tests/golden, with the
// values that h5py read from them then, one dataset a line. They must load to the same values
// forever.
#include <stratus/io/table_file.h>

#include "sample_table.h"
#include "table_axes.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <charconv>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

const fs::path golden_folder = STRATUS_GOLDEN_FOLDER;

/// The numbers of each dataset by its name.
template <class Number>
std::map<std::string, std::vector<Number>> read_values(const fs::path& path) {
    std::map<std::string, std::vector<Number>> values;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string name;
        words >> name;
        for (std::string word; words >> word;) {
            Number value{};
            const auto end = std::from_chars(word.data(), word.data() + word.size(), value);
            EXPECT_EQ(end.ptr, word.data() + word.size()) << name << ": " << word;
            values[name].push_back(value);
        }
    }
    return values;
}

class Golden : public testing::TestWithParam<const char*> {};

TEST_P(Golden, LoadsTheOriginalValues) {
    const fs::path path = golden_folder / GetParam();
    std::vector<std::string> notes;
    const Table table = read_table(path, {0, &notes});
    EXPECT_TRUE(notes.empty());

    const fs::path text = fs::path(path).replace_extension(".txt");
    auto numbers = read_values<double>(text);
    auto samples = read_values<float>(text);
    ASSERT_GE(numbers.size(), 9U);
    for (const FamilyAxis& axis : table.family)
        expect_same_bits(axis.axis.values, numbers[axis.name()], axis.name());
    expect_same_bits(table.diffusion_exponent, numbers["diffusion_exponent"], "exponent");
    for (const io::AxisField& field : io::axis_fields)
        expect_same_bits((table.*field.axis).values, numbers[field.name], field.name);
    for (const io::SampleField& field : io::sample_fields)
        expect_same_bits(table.*field.samples, samples[field.name], field.name);
}

TEST_P(Golden, LoadsTheOriginalAttributes) {
    const std::string name = fs::path(GetParam()).stem().string();
    const Table table = read_table(golden_folder / GetParam());
    EXPECT_EQ(table.attributes.at("title"), "Golden, " + (name == "ground" ? "over ground" : name));
    EXPECT_EQ(table.attributes.at("recipe"), content(golden_folder / (name + ".toml")));
    EXPECT_EQ(table.attributes.at("program_version"), "0.1.0");
    EXPECT_EQ(table.tolerance, 0.01);
    EXPECT_EQ(table.highest_order, 0);
    EXPECT_EQ(table.has_family(), name == "mixture");
    EXPECT_EQ(table.lower_boundary.kind,
              name == "ground" ? LowerBoundary::Kind::surface : LowerBoundary::Kind::none);
    EXPECT_EQ(table.lower_boundary.albedo, name == "ground" ? 0.3 : 0.0);
    EXPECT_NEAR(table.phase_function.asymmetry(), name == "mixture" ? 0.4 : 0.24, 1e-12);
    if (table.has_family()) {
        EXPECT_EQ(table.second_phase_function.asymmetry(), 0);
    }
}

INSTANTIATE_TEST_SUITE_P(Files, Golden,
                         testing::Values("plain.h5", "plain.exr", "ground.h5", "ground.exr",
                                         "mixture.h5", "mixture.exr"),
                         [](const auto& row) {
                             std::string name = row.param;
                             name[name.find('.')] = '_';
                             return name;
                         });

/// The golden plain table in a file that claims another version.
fs::path with_version(const fs::path& path, const char* major, const char* minor) {
    const Table table = read_table(golden_folder / "plain.h5");
    io::Metadata metadata = io::metadata_of(table);
    metadata["format_major"] = major;
    metadata["format_minor"] = minor;
    const auto encode = path.extension() == ".h5" ? io::encode_hdf5 : io::encode_exr;
    io::write_bytes(path, encode(table, metadata));
    return path;
}

TEST(Hdf5File, IsTheSameInMemoryAndOnTheDisk) {
    const TemporaryFolder folder;
    for (const char* name : {"plain.h5", "mixture.h5"}) {
        const Table table = read_table(golden_folder / name);
        const io::Bytes in_memory = io::encode_hdf5(table, io::metadata_of(table));
        write_table(table, folder / name);
        EXPECT_TRUE(content(folder / name) == std::string(in_memory.begin(), in_memory.end()))
            << name;
    }
}

class Versions : public testing::TestWithParam<const char*> {};

TEST_P(Versions, NewerMinorVersionsLoadWithANote) {
    const TemporaryFolder folder;
    const fs::path path = with_version(folder / GetParam(), "1", "9");
    std::vector<std::string> notes;
    expect_same(read_table(path, {0, &notes}), read_table(golden_folder / "plain.h5"));
    EXPECT_EQ(notes, std::vector<std::string>{
                         path.string() + ": format 1.9 is newer than 1.4, the newest that this "
                                         "program knows: what it adds is ignored"});
}

TEST_P(Versions, PathLawBelongsToFormat2) {
    const TemporaryFolder folder;
    const fs::path path = with_version(folder / GetParam(), "2", "0");
    EXPECT_EQ(refusal<std::runtime_error>([&] { read_table(path); }),
              path.string() + ": attribute path_law belongs to format 2.x alone");
}

TEST_P(Versions, NewerMajorVersionsAreRefused) {
    const TemporaryFolder folder;
    const fs::path path = with_version(folder / GetParam(), "5", "0");
    EXPECT_EQ(refusal<std::runtime_error>([&] { read_table(path); }),
              path.string() + ": format 5.0 is newer than this program reads (1.x to 4.x)");
}

INSTANTIATE_TEST_SUITE_P(Formats, Versions, testing::Values("table.h5", "table.exr"),
                         [](const auto& row) {
                             return fs::path(row.param).extension().string().substr(1);
                         });

}  // namespace
}  // namespace stratus::test
