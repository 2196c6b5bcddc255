// Files that are not tables, or are damaged, are refused with one sentence. Nothing crashes, and no
// other table than the one written is returned.
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>

#include "refusal.h"
#include "refusal_of_reading.h"
#include "row_name.h"
#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <utility>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

/// One line that begins with the file's name.
void expect_one_sentence(const std::string& message, const fs::path& path) {
    EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

// --- Any file, both formats ---

class BothFormats : public testing::TestWithParam<const char*> {
  protected:
    std::string refusal_of_content(const std::string& bytes) {
        set_content(path, bytes);
        return refusal_of_reading(path);
    }

    TemporaryFolder folder;
    const fs::path path = folder / GetParam();
    const bool hdf5 = path.extension() == ".h5";
    const std::string no_file =
        path.string() + (hdf5 ? ": is not an HDF5 file" : ": is not an OpenEXR file");
};

INSTANTIATE_TEST_SUITE_P(Formats, BothFormats, testing::Values("table.h5", "table.exr"),
                         [](const auto& row) {
                             return fs::path(row.param).extension().string().substr(1);
                         });

TEST_P(BothFormats, RefuseWhatIsNoFile) {
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": No such file or directory");
    fs::create_directory(path);
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": is a directory");
    fs::remove(path);
    fs::create_symlink("/dev/zero", path);
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": is not a regular file");
    fs::remove(path);
    EXPECT_EQ(refusal_of_content(""), path.string() + ": is empty");
}

TEST_P(BothFormats, RefuseForeignFiles) {
    EXPECT_EQ(refusal_of_content("x"), no_file);
    EXPECT_EQ(refusal_of_content("mu_in,mu_out,azimuth_deg\n0.5,0.5,0\n"), no_file);
    EXPECT_EQ(refusal_of_content(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)), no_file);
    write_table(sample_table(), folder / "a.h5");
    write_table(sample_table(), folder / "a.exr");
    EXPECT_EQ(refusal_of_content(content(folder / (hdf5 ? "a.exr" : "a.h5"))), no_file);
}

TEST_P(BothFormats, RefuseFilesThatEndAfterTheirFirstBytes) {
    const std::string magic(hdf5 ? hdf5_magic : exr_magic);
    expect_one_sentence(refusal_of_content(magic), path);
    expect_one_sentence(refusal_of_content(magic + std::string(1000, '\0')), path);
    expect_one_sentence(refusal_of_content(magic + std::string(1000, '\xff')), path);
}

TEST_P(BothFormats, RefuseTruncation) {
    write_table(sample_table(), path);
    const std::string whole = content(path);
    for (std::size_t length = 1; length < whole.size(); length += length < 512 ? 1 : 997)
        expect_one_sentence(refusal_of_content(whole.substr(0, length)), path);
    expect_one_sentence(refusal_of_content(whole.substr(0, whole.size() - 1)), path);
}

// --- Metadata ---

Table mixed_table() {
    Shape shape;
    shape.mixtures = 3;
    return sample_table(shape);
}

/// Writes a table as it is, without checks.
void write_unchecked(const fs::path& path, const Table& table, const Metadata& metadata) {
    const auto write = path.extension() == ".h5" ? io::write_hdf5 : io::write_exr;
    write(table, metadata, path, {});
}

/// Writes a table whose metadata was changed, with the checksum that belongs to the changed one.
void write_changed(const fs::path& path, const std::function<void(Metadata&)>& change,
                   const Table& table = sample_table()) {
    Metadata metadata = io::make_metadata(table);
    change(metadata);
    write_unchecked(path, table, metadata);
}

TEST_P(BothFormats, KeepAttributesThatTheyDoNotKnow) {
    write_changed(path, [](Metadata& metadata) { metadata["news"] = "kept as text"; });
    Table expected = sample_table();
    expected.attributes["news"] = "kept as text";
    expect_same(read_table(path), expected);
}

struct Change {
    const char* name;
    const char* attribute;
    const char* text;  // null: the attribute is removed
    std::string reason;
    bool is_mixed = false;
};

const std::vector<Change> changes{
    {"NewerVersion", "format_version", "2", "attribute format_version must be 1, got 2"},
    {"OlderVersion", "format_version", "0", "attribute format_version must be 1, got 0"},
    {"UnknownFeature", "features", "polarisation",
     "attribute features must be of family, stack, path_law, which this program knows, got "
     "\"polarisation\""},
    {"FeatureThatItHasNot", "features", "path_law",
     "attribute features must be \"\", as the other attributes say, got \"path_law\""},
    {"ForeignFormat", "format", "nimbus", "is not a stratus-table file: its format is \"nimbus\""},
    {"NoFormat", "format", nullptr, "is not a stratus-table file: it has no attribute format"},
    {"NoVersion", "format_version", nullptr, "attribute format_version is missing"},
    {"NoTolerance", "tolerance", nullptr, "attribute tolerance is missing"},
    {"NegativeTolerance", "tolerance", "-1", "prepare: tolerance must be in [0, inf), got -1"},
    {"ToleranceNotANumber", "tolerance", "nan", "prepare: tolerance must be in [0, inf), got nan"},
    {"NegativeOrder", "highest_order", "-1", "prepare: highest_order must be at least 0, got -1"},
    {"ZeroLength", "extrapolation_length", "0",
     "prepare: extrapolation_length must be in (0, inf), got 0"},
    {"OtherMoments", "asymmetry", "0.5",
     "attributes moments and asymmetry are not those of the phase function"},
    {"FewerMoments", "moments", "1 0",
     "attributes moments and asymmetry are not those of the phase function"},
    {"PhaseFunctionInAFile", "phase_function", "tabulated:file=/etc/passwd",
     "attribute phase_function must be complete, not name a file: \"tabulated:file=/etc/passwd\""},
    {"UnknownLowerBoundary", "below", "swamp",
     "attribute below must be \"lambert surface\", \"ground\" or \"semi-infinite layer\", got "
     "\"swamp\""},
    {"LowerBoundaryWithoutAlbedo", "below", "lambert surface", "attribute below_albedo is missing"},
    {"SecondPhaseFunctionAlone", "second_phase_function", "rayleigh",
     "attribute second_phase_function needs mixture in attribute family"},
    {"NoSide", "datasets", "plane_albedo",
     "prepare: table must be given reflection_multiple or transmission_multiple, got neither"},
    {"NoSecondPhaseFunction", "second_phase_function", nullptr,
     "attribute second_phase_function is missing", true},
    {"NoLengthsOfMixtures", "extrapolation_lengths", nullptr,
     "attribute extrapolation_lengths is missing", true},
    {"FamilyThatTheFeaturesDoNotName", "features", nullptr,
     "attribute features must be \"family\", as the other attributes say, got \"\"", true},
};

class ChangedMetadata : public testing::TestWithParam<Change> {};

TEST_P(ChangedMetadata, IsRefusedInBothFormats) {
    const TemporaryFolder folder;
    for (const char* name : {"table.h5", "table.exr"}) {
        const fs::path path = folder / name;
        write_changed(
            path,
            [](Metadata& metadata) {
                if (GetParam().text)
                    metadata[GetParam().attribute] = GetParam().text;
                else
                    metadata.erase(GetParam().attribute);
            },
            GetParam().is_mixed ? mixed_table() : sample_table());
        EXPECT_EQ(refusal_of_reading(path), path.string() + ": " + GetParam().reason);
    }
}

INSTANTIATE_TEST_SUITE_P(Changes, ChangedMetadata, testing::ValuesIn(changes), row_name);

TEST_P(BothFormats, RefuseFilesThatNeedMoreMemoryThanAllowed) {
    write_table(sample_table(), path);
    const std::uintmax_t file_size = fs::file_size(path);
    const auto refusal_of = [&](std::uintmax_t max_memory) {
        return refusal<std::runtime_error>([&] { read_table(path, {max_memory}); });
    };
    const auto starts = [&](const std::string& message, const std::string& reason) {
        EXPECT_TRUE(message.starts_with(path.string() + ": " + reason)) << message;
        expect_holds(message, "more than the limit of ");
    };
    starts(refusal_of(file_size - 1), "reading the file needs ");
    if (hdf5) starts(refusal_of(file_size), "reading the samples needs ");
    if (!hdf5) starts(refusal_of(file_size), "reading a part needs ");
    expect_same(read_table(path, {1 << 20}), sample_table());
}

// --- Invalid content with valid checksums ---

/// A table as it must not be.
struct WrongTable {
    const char* name;
    void (*change)(Table&);
    std::string reason;
};

const std::vector<WrongTable> invalid_contents{
    {"NanOnAnAxis", [](Table& t) { t.albedo.values[1] = NAN; },
     "albedo must be finite and at most 1, got nan"},
    {"UnsortedAxis", [](Table& t) { std::swap(t.mu_in.values[0], t.mu_in.values[1]); },
     "mu_in must be ascending, got 0.03"},
    {"InfinityBeforeTheEnd", [](Table& t) { t.optical_depth.values[2] = infinity; },
     "optical_depth must be in (0, inf), got inf"},
    {"MixtureAboveOne",
     [](Table& t) {
         t.family[0].axis.values = {0, 0.75, 1.5};
     },
     "mixture must be within [0, 1], got 1.5"},
    {"MixtureNotANumber", [](Table& t) { t.family[0].axis.values.back() = NAN; },
     "mixture must be finite, got nan"},
    {"NanSample", [](Table& t) { t.reflection_multiple[7] = NAN; },
     "reflection_multiple (sample 7) must be finite, got nan"},
    {"NanExponent", [](Table& t) { t.diffusion_exponent[0] = NAN; },
     "diffusion_exponent (sample 0) must be finite, got nan"},
};

class InvalidTable : public testing::TestWithParam<WrongTable> {};

TEST_P(InvalidTable, IsRefusedDespiteValidChecksums) {
    const TemporaryFolder folder;
    Table table = mixed_table();
    GetParam().change(table);
    const Metadata metadata = io::make_metadata(table);
    for (const char* name : {"table.h5", "table.exr"}) {
        const fs::path path = folder / name;
        write_unchecked(path, table, metadata);
        const std::string message = refusal_of_reading(path);
        expect_one_sentence(message, path);
        expect_holds(message, {GetParam().reason});
    }
}

INSTANTIATE_TEST_SUITE_P(Tables, InvalidTable, testing::ValuesIn(invalid_contents), row_name);

// --- Tables that are not written ---

const std::vector<WrongTable> refused{
    {"NotANumber", [](Table& t) { t.reflection_multiple[3] = NAN; },
     "prepare: reflection_multiple (sample 3) must be finite, got nan"},
    {"WrongLength", [](Table& t) { t.plane_albedo.pop_back(); },
     "prepare: length of plane_albedo must be 45, got 44"},
    {"AttributeOfTheFormat", [](Table& t) { t.attributes["format"] = "mine"; },
     "write_table: an attribute's name must be one that the format does not reserve, got "
     "\"format\""},
    {"AttributeCalledChecksum", [](Table& t) { t.attributes["checksum"] = "mine"; },
     "write_table: an attribute's name must be one that the format does not reserve, got "
     "\"checksum\""},
    {"AttributeCalledAsWhatChecksumsCover", [](Table& t) { t.attributes["checksum_covers"] = "x"; },
     "write_table: an attribute's name must be one that the format does not reserve, got "
     "\"checksum_covers\""},
    {"AttributeWithALineBreak", [](Table& t) { t.attributes["two\nlines"] = "x"; },
     "write_table: an attribute's name must be free of line breaks, got \"two?lines\""},
    {"AttributeWithoutName", [](Table& t) { t.attributes[""] = "x"; },
     "write_table: an attribute's name must be 1 to 200 bytes long, got \"\""},
    {"AttributeWithLongName", [](Table& t) { t.attributes[std::string(201, 'n')] = "x"; },
     "write_table: an attribute's name must be 1 to 200 bytes long, got \"" + std::string(60, 'n') +
         "...\""},
    {"AttributeWithZeroByte", [](Table& t) { t.attributes["title"] = std::string("a\0b", 3); },
     "write_table: attribute \"title\" must be free of zero bytes, got \"a?b\""},
};

class RefusedTable : public testing::TestWithParam<WrongTable> {};

TEST_P(RefusedTable, IsNotWritten) {
    const TemporaryFolder folder;
    Table table = sample_table();
    GetParam().change(table);
    for (const char* name : {"table.h5", "table.exr"}) {
        const auto write = [&] { write_table(table, folder / name); };
        EXPECT_EQ(refusal(write), GetParam().reason);
    }
    EXPECT_EQ(folder.size(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Tables, RefusedTable, testing::ValuesIn(refused), row_name);

TEST(TableFile, RefusesOtherEndings) {
    const std::string read = refusal([] { read_table("table.nc"); });
    EXPECT_EQ(read, "table: file must be a name ending in .h5 or .exr, got table.nc");
    const std::string written = refusal([] { write_table(sample_table(), "table"); });
    EXPECT_EQ(written, "table: file must be a name ending in .h5 or .exr, got table");
}

}  // namespace
}  // namespace stratus::test
