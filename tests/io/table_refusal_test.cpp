// Files that are not tables, or are damaged, are refused with one sentence. Nothing crashes, and no
// other table than the one written is returned.
#include <stratus/io/hdf5_table.h>
#include <stratus/io/table_file.h>
#include <stratus/runtime/constants.h>

#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <ostream>
#include <random>
#include <string>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

std::string refusal_of_reading(const fs::path& path) {
    return refusal<std::runtime_error>([&] { read_table(path); });
}

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

TEST_P(BothFormats, RefuseAMissingFile) {
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": No such file or directory");
}

TEST_P(BothFormats, RefuseADirectory) {
    fs::create_directory(path);
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": is a directory");
}

TEST_P(BothFormats, RefuseAnEmptyFile) {
    EXPECT_EQ(refusal_of_content(""), path.string() + ": is empty");
}

TEST_P(BothFormats, RefuseADevice) {
    fs::create_symlink("/dev/zero", path);
    EXPECT_EQ(refusal_of_reading(path), path.string() + ": is not a regular file");
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
    const std::string magic(hdf5 ? io::hdf5_magic : io::exr_magic);
    expect_one_sentence(refusal_of_content(magic), path);
    expect_one_sentence(refusal_of_content(magic + std::string(1000, '\0')), path);
    expect_one_sentence(refusal_of_content(magic + std::string(1000, '\xff')), path);
}

TEST_P(BothFormats, RefuseTruncation) {
    constexpr std::size_t seal = 32;  // without it, an HDF5 table is still complete
    write_table(sample_table(), path);
    const std::string whole = content(path);
    for (std::size_t length = 1; length < whole.size() - seal; length += length < 512 ? 1 : 997)
        expect_one_sentence(refusal_of_content(whole.substr(0, length)), path);
    expect_one_sentence(refusal_of_content(whole.substr(0, whole.size() - seal)), path);
}

/// Reads damaged bytes; whatever is accepted must be the table that was written.
void expect_refused_or_same(const fs::path& path, const std::string& bytes, const Table& table) {
    set_content(path, bytes);
    try {
        expect_same(read_table(path), table);
    } catch (const std::runtime_error& error) {
        expect_one_sentence(error.what(), path);
    }
}

TEST_P(BothFormats, RefuseOrIgnoreDamage) {
    const Table table = sample_table();
    write_table(table, path);
    const std::string whole = content(path);
    std::mt19937 random(20);
    std::uniform_int_distribution<std::size_t> position(0, whole.size() - 1);
    std::uniform_int_distribution<int> value(1, 255);
    for (int i = 0; i < 500; ++i) {
        SCOPED_TRACE(i);
        std::string damaged = whole;
        char& byte = damaged[position(random)];
        byte = static_cast<char>(byte ^ value(random));
        expect_refused_or_same(path, damaged, table);
    }
}

TEST_P(BothFormats, RefuseOrIgnoreBytesCutOutAndAdded) {
    const Table table = sample_table();
    write_table(table, path);
    const std::string whole = content(path);
    for (std::size_t from = 0; from < whole.size(); from += 509) {
        SCOPED_TRACE(from);
        expect_refused_or_same(path, std::string(whole).erase(from, 7), table);
        expect_refused_or_same(path, std::string(whole).insert(from, 8, '\0'), table);
        expect_refused_or_same(path, std::string(whole).replace(from, 64, 64, '\xff'), table);
    }
    expect_refused_or_same(path, whole + "more", table);
    for (std::size_t missing = 1; missing < 32; ++missing)
        expect_refused_or_same(path, whole.substr(0, whole.size() - missing), table);
}

// --- Metadata ---

Table mixed_table() {
    Shape shape;
    shape.mixtures = 3;
    return sample_table(shape);
}

/// Writes a table whose metadata was changed, with the checksum that belongs to the changed one.
void write_changed(const fs::path& path, const std::function<void(io::Metadata&)>& change,
                   const Table& table = sample_table()) {
    io::Metadata metadata = io::metadata_of(table);
    change(metadata);
    const auto encode = path.extension() == ".h5" ? io::encode_hdf5 : io::encode_exr;
    io::write_bytes(path, encode(table, metadata));
}

TEST_P(BothFormats, HaveTheVersionOfMixturesOnlyWithAMixture) {
    EXPECT_EQ(io::metadata_of(sample_table()).at("format_minor"), "0");
    EXPECT_EQ(io::metadata_of(mixed_table()).at("format_minor"), "1");
}

TEST_P(BothFormats, RefuseMixturesWithoutASecondPhaseFunction) {
    const auto refusal_without = [&](std::initializer_list<const char*> attributes) {
        write_changed(
            path,
            [&](io::Metadata& metadata) {
                for (const char* attribute : attributes) metadata.erase(attribute);
            },
            mixed_table());
        return refusal_of_reading(path);
    };
    const std::string missing = path.string() + ": attribute second_phase_function is missing";
    EXPECT_EQ(refusal_without({"second_phase_function"}), missing);
    EXPECT_EQ(refusal_without({"second_phase_function", "second_extrapolation_length"}), missing);
    EXPECT_EQ(refusal_without({"second_extrapolation_length"}),
              path.string() + ": attribute second_extrapolation_length is missing");
}

TEST_P(BothFormats, RefuseMixturesOutsideTheirRange) {
    const auto refusal_of = [&](std::vector<double> mixtures) {
        Table table = mixed_table();
        table.mixture.values = std::move(mixtures);
        write_changed(
            path, [](io::Metadata&) {}, table);
        return refusal_of_reading(path);
    };
    EXPECT_EQ(refusal_of({0, 0.75, 1.5}),
              path.string() + ": prepare: mixture must be within [0, 1], got 1.5");
    EXPECT_EQ(refusal_of({0, 1, 0.5}),
              path.string() + ": check_axis: mixture must be ascending, got 0.5");
    EXPECT_EQ(refusal_of({0, 0.5, std::nan("")}),
              path.string() + ": check_axis: mixture must be finite, got nan");
}

TEST_P(BothFormats, RefuseOrIgnoreDamageToMixtures) {
    const Table table = mixed_table();
    write_table(table, path);
    const std::string whole = content(path);
    for (std::size_t at = 0; at < whole.size(); at += 97) {
        SCOPED_TRACE(at);
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
        expect_refused_or_same(path, damaged, table);
    }
}

TEST_P(BothFormats, ReadANewerMinorVersion) {
    write_changed(path, [](io::Metadata& metadata) {
        metadata["format_minor"] = "9";
        metadata["news"] = "kept as text";
    });
    Table expected = sample_table();
    expected.attributes["news"] = "kept as text";
    expect_same(read_table(path), expected);
}

struct Change {
    const char* name;
    const char* attribute;
    const char* text;  // null: the attribute is removed
    std::string reason;
};

std::ostream& operator<<(std::ostream& stream, const Change& row) { return stream << row.name; }

const std::vector<Change> changes{
    {"NewerMajor", "format_major", "2", "format 2.0 is newer than this program reads (1.x)"},
    {"OlderMajor", "format_major", "0", "format 0.0 is not one that this program reads (1.x)"},
    {"NegativeMinor", "format_minor", "-1", "format 1.-1 is not one that this program reads (1.x)"},
    {"ForeignFormat", "format", "nimbus", "is not a stratus-table file: its format is \"nimbus\""},
    {"NoFormat", "format", nullptr, "is not a stratus-table file: it has no attribute format"},
    {"NoVersion", "format_major", nullptr, "attribute format_major is missing"},
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
     "attribute below must be \"lambert surface\" or \"semi-infinite layer\", got \"swamp\""},
    {"LowerBoundaryWithoutAlbedo", "below", "lambert surface", "attribute below_albedo is missing"},
    {"SecondPhaseFunctionAlone", "second_phase_function", "rayleigh",
     "attribute second_extrapolation_length is missing"},
    {"NoSide", "datasets", "plane_albedo",
     "prepare: table must be given reflection_multiple or transmission_multiple, got neither"},
};

class ChangedMetadata : public testing::TestWithParam<Change> {};

TEST_P(ChangedMetadata, IsRefusedInBothFormats) {
    const TemporaryFolder folder;
    for (const char* name : {"table.h5", "table.exr"}) {
        const fs::path path = folder / name;
        write_changed(path, [](io::Metadata& metadata) {
            if (GetParam().text)
                metadata[GetParam().attribute] = GetParam().text;
            else
                metadata.erase(GetParam().attribute);
        });
        EXPECT_EQ(refusal_of_reading(path), path.string() + ": " + GetParam().reason);
    }
}

INSTANTIATE_TEST_SUITE_P(Changes, ChangedMetadata, testing::ValuesIn(changes),
                         [](const auto& row) { return row.param.name; });

TEST_P(BothFormats, RefuseFilesThatNeedMoreMemoryThanAllowed) {
    write_table(sample_table(), path);
    const std::uintmax_t file_size = fs::file_size(path);
    const auto refusal_of = [&](std::uintmax_t max_memory) {
        return refusal<std::runtime_error>([&] { read_table(path, {max_memory}); });
    };
    const auto starts = [&](const std::string& message, const std::string& reason) {
        EXPECT_TRUE(message.starts_with(path.string() + ": " + reason)) << message;
        EXPECT_NE(message.find("more than the limit of "), std::string::npos) << message;
    };
    starts(refusal_of(file_size - 1), "reading the file needs ");
    if (hdf5) starts(refusal_of(file_size), "reading the samples needs ");
    if (!hdf5) starts(refusal_of(file_size), "reading a part needs ");
    expect_same(read_table(path, {1 << 20}), sample_table());
}

// --- Invalid content with valid checksums ---

struct InvalidContent {
    const char* name;
    std::function<void(Table&)> change;
    std::string reason;
};

std::ostream& operator<<(std::ostream& stream, const InvalidContent& row) {
    return stream << row.name;
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

const std::vector<InvalidContent> invalid_contents{
    {"NanOnAnAxis", [](Table& t) { t.albedo.values[1] = nan; },
     "albedo must be finite and at most 1, got nan"},
    {"InfiniteCosine", [](Table& t) { t.mu_in.values.back() = infinity; },
     "mu_in must be finite unless logarithmic, got inf"},
    {"CosineAboveOne", [](Table& t) { t.mu_out.values.back() = 1.5; },
     "mu_out must be in [0, 1], got 1.5"},
    {"InfiniteAzimuth", [](Table& t) { t.azimuth.values.back() = infinity; },
     "azimuth must be finite unless logarithmic, got inf"},
    {"InfinityBeforeTheEnd", [](Table& t) { t.optical_depth.values[2] = infinity; },
     "optical_depth must be in (0, inf), got inf"},
    {"UnsortedAxis", [](Table& t) { std::swap(t.mu_in.values[0], t.mu_in.values[1]); },
     "mu_in must be ascending, got 0.03"},
    {"RepeatedSample", [](Table& t) { t.albedo.values[1] = t.albedo.values[0]; },
     "albedo must be ascending, got 0"},
    {"NegativeDepth", [](Table& t) { t.optical_depth.values[0] = -1; },
     "optical_depth must be in (0, inf), got -1"},
    {"NanSample",
     [](Table& t) { t.reflection_multiple[7] = std::numeric_limits<float>::quiet_NaN(); },
     "reflection_multiple (sample 7) must be finite, got nan"},
    {"InfiniteSample",
     [](Table& t) { t.spherical_albedo[3] = std::numeric_limits<float>::infinity(); },
     "spherical_albedo (sample 3) must be finite, got inf"},
    {"NanExponent", [](Table& t) { t.diffusion_exponent[0] = nan; },
     "diffusion_exponent (sample 0) must be finite, got nan"},
};

class InvalidTable : public testing::TestWithParam<InvalidContent> {};

TEST_P(InvalidTable, IsRefusedDespiteValidChecksums) {
    const TemporaryFolder folder;
    Table table = sample_table();
    GetParam().change(table);
    const io::Metadata metadata = io::metadata_of(table);
    for (const char* name : {"table.h5", "table.exr"}) {
        const fs::path path = folder / name;
        const auto encode = path.extension() == ".h5" ? io::encode_hdf5 : io::encode_exr;
        io::write_bytes(path, encode(table, metadata));
        const std::string message = refusal_of_reading(path);
        expect_one_sentence(message, path);
        EXPECT_NE(message.find(GetParam().reason), std::string::npos) << message;
    }
}

INSTANTIATE_TEST_SUITE_P(Tables, InvalidTable, testing::ValuesIn(invalid_contents),
                         [](const auto& row) { return row.param.name; });

// --- HDF5 files changed by other programs ---

struct Tampering {
    const char* name;
    std::function<void(hid_t file)> work;
    std::string reason;
};

std::ostream& operator<<(std::ostream& stream, const Tampering& row) { return stream << row.name; }

/// Replaces the dataset `name` by a new one over `sizes`.
void replace_dataset(hid_t file, const char* name, std::vector<hsize_t> sizes,
                     hid_t type = H5T_IEEE_F32LE, hid_t creation = H5P_DEFAULT) {
    H5Ldelete(file, name, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr);
    const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    ASSERT_GE(dataset, 0);
    H5Dclose(dataset);
    H5Sclose(space);
}

const std::vector<H5Z_filter_t> table_filters{H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE};

void replace_chunked(hid_t file, const char* name, std::vector<hsize_t> sizes,
                     std::vector<hsize_t> chunk, const std::vector<H5Z_filter_t>& filters) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
    for (const H5Z_filter_t filter : filters)
        H5Pset_filter(creation, filter, H5Z_FLAG_OPTIONAL, 0, nullptr);
    replace_dataset(file, name, std::move(sizes), H5T_IEEE_F32LE, creation);
    H5Pclose(creation);
}

void replace_external(hid_t file) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(creation, "/etc/passwd", 0, 3 * 5 * sizeof(float));
    replace_dataset(file, "spherical_albedo", {3, 5}, H5T_IEEE_F32LE, creation);
    H5Pclose(creation);
}

void replace_virtual(hid_t file) {
    const hsize_t sizes[] = {3, 5};
    const hid_t space = H5Screate_simple(2, sizes, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_virtual(creation, space, "other.h5", "/x", space);
    replace_dataset(file, "spherical_albedo", {3, 5}, H5T_IEEE_F32LE, creation);
    H5Pclose(creation);
    H5Sclose(space);
}

void change_tolerance(hid_t file) {
    const double tolerance = 0.5;
    const hid_t attribute = H5Aopen(file, "tolerance", H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, &tolerance);
    H5Aclose(attribute);
}

void change_scale(hid_t file, const char* text) {
    H5Adelete_by_name(file, "albedo", "scale", H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, "albedo", H5P_DEFAULT);
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, std::strlen(text));
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(dataset, "scale", type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(dataset);
}

void write_attribute_of_references(hid_t file) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate2(file, "reference", H5T_STD_REF_OBJ, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Aclose(attribute);
    H5Sclose(space);
}

void change_sample(hid_t file) {
    const float sample[3 * 5] = {};
    const hid_t dataset = H5Dopen2(file, "spherical_albedo", H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, sample);
    H5Dclose(dataset);
}

void replace_by_group(hid_t file) {
    H5Ldelete(file, "spherical_albedo", H5P_DEFAULT);
    H5Gclose(H5Gcreate2(file, "spherical_albedo", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

constexpr hsize_t huge = hsize_t{1} << 40;

const std::vector<Tampering> tamperings{
    {"MissingDataset", [](hid_t f) { H5Ldelete(f, "plane_albedo", H5P_DEFAULT); },
     "dataset plane_albedo is missing"},
    {"MissingAxis", [](hid_t f) { H5Ldelete(f, "mu_in", H5P_DEFAULT); },
     "dataset mu_in is missing"},
    {"SoftLink",
     [](hid_t f) {
         H5Ldelete(f, "plane_albedo", H5P_DEFAULT);
         H5Lcreate_soft("/diffuse_transmittance", f, "plane_albedo", H5P_DEFAULT, H5P_DEFAULT);
     },
     "\"plane_albedo\" is a soft or external link"},
    {"ExternalLink",
     [](hid_t f) {
         H5Ldelete(f, "plane_albedo", H5P_DEFAULT);
         H5Lcreate_external("other.h5", "/x", f, "plane_albedo", H5P_DEFAULT, H5P_DEFAULT);
     },
     "\"plane_albedo\" is a soft or external link"},
    {"ExternalLinkBesideTheTable",
     [](hid_t f) { H5Lcreate_external("other.h5", "/x", f, "more", H5P_DEFAULT, H5P_DEFAULT); },
     "\"more\" is a soft or external link"},
    {"Group", replace_by_group, "\"spherical_albedo\" is not a dataset"},
    {"NamedType",
     [](hid_t f) {
         const hid_t type = H5Tcopy(H5T_IEEE_F32LE);
         H5Tcommit2(f, "more", type, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
         H5Tclose(type);
     },
     "\"more\" is not a dataset"},
    {"SecondName",
     [](hid_t f) { H5Lcreate_hard(f, "plane_albedo", f, "more", H5P_DEFAULT, H5P_DEFAULT); },
     "\"plane_albedo\" has two names"},
    {"VirtualDataset", replace_virtual,
     "HDF5 cannot inspect \"spherical_albedo\": samples are stored in other files"},
    {"ExternalStorage", replace_external,
     "HDF5 cannot inspect \"spherical_albedo\": samples are stored in other files"},
    {"OtherFilter",
     [](hid_t f) {
         replace_chunked(f, "spherical_albedo", {3, 5}, {3, 5}, {H5Z_FILTER_FLETCHER32});
     },
     "spherical_albedo uses a filter other than shuffle and deflate"},
    {"OtherRank", [](hid_t f) { replace_dataset(f, "spherical_albedo", {15}); },
     "spherical_albedo must have 2 dimensions"},
    {"OtherExtents",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {5, 3});
     },
     "extents of spherical_albedo do not match its axes"},
    {"OtherType",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {3, 5}, H5T_STD_I32LE);
     },
     "spherical_albedo must hold little-endian floating-point numbers of 4 bytes"},
    {"BigEndian",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {3, 5}, H5T_IEEE_F32BE);
     },
     "spherical_albedo must hold little-endian floating-point numbers of 4 bytes"},
    {"NoFilter",
     [](hid_t f) {
         replace_chunked(f, "spherical_albedo", {3, 5}, {3, 5}, {});
     },
     "spherical_albedo must be shuffled and deflated, once each"},
    {"DeflatedTwice",
     [](hid_t f) {
         replace_chunked(f, "spherical_albedo", {3, 5}, {3, 5},
                         {H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE, H5Z_FILTER_DEFLATE});
     },
     "spherical_albedo must be shuffled and deflated, once each"},
    {"ChunksThatAreNotRuns",
     [](hid_t f) {
         replace_chunked(f, "spherical_albedo", {3, 5}, {2, 2}, table_filters);
     },
     "spherical_albedo has chunks that are not runs of consecutive samples"},
    {"MissingChunk",
     [](hid_t f) {
         replace_chunked(f, "spherical_albedo", {3, 5}, {3, 5}, table_filters);
     },
     "spherical_albedo is missing a chunk"},
    {"HugeDataset",
     [](hid_t f) {
         replace_chunked(f, "plane_albedo", {huge, huge, huge}, {1, 1, 1}, {});
     },
     "extents of plane_albedo do not match its axes"},
    {"HugeAxis", [](hid_t f) { replace_chunked(f, "albedo", {huge}, {1}, {}); },
     "albedo has more than 1048576 samples"},
    {"LongAxis", [](hid_t f) { replace_dataset(f, "albedo", {1000000}, H5T_IEEE_F64LE); },
     "albedo has no attribute scale"},
    {"OtherScale", [](hid_t f) { change_scale(f, "linear"); },
     "scale of axis albedo must be square_root_of_complement, got \"linear\""},
    {"ChangedAttribute", change_tolerance, "the metadata is damaged"},
    {"RemovedAttribute", [](hid_t f) { H5Adelete(f, "title"); }, "the metadata is damaged"},
    {"RemovedChecksum", [](hid_t f) { H5Adelete(f, "checksum"); }, "attribute checksum is missing"},
    {"AttributeOfReferences", write_attribute_of_references,
     "attribute reference is of a type that the format does not use"},
    {"ChangedSample", change_sample, "spherical_albedo is damaged"},
};

class TamperedHdf5 : public testing::TestWithParam<Tampering> {};

TEST_P(TamperedHdf5, IsRefused) {
    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
    write_table(sample_table(), path);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    GetParam().work(file);
    ASSERT_GE(H5Fclose(file), 0);
    const std::string message = refusal_of_reading(path);
    EXPECT_TRUE(message.starts_with(path.string() + ": " + GetParam().reason)) << message;
}

INSTANTIATE_TEST_SUITE_P(Files, TamperedHdf5, testing::ValuesIn(tamperings),
                         [](const auto& row) { return row.param.name; });

TEST(Hdf5Table, RefusesTooManyChunks) {
    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
    Shape shape;
    shape.albedos = 2;
    shape.finite_depths = 15;
    shape.cosines_in = shape.cosines_out = shape.azimuths = 11;
    shape.transmission = false;
    ASSERT_GT(sample_table(shape).reflection_multiple.size(), 32768U);  // one sample each
    write_table(sample_table(shape), path);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    replace_chunked(file, "reflection_multiple", {2, 16, 11, 11, 11}, {1, 1, 1, 1, 1},
                    table_filters);
    H5Fclose(file);
    EXPECT_EQ(refusal_of_reading(path),
              path.string() + ": reflection_multiple has more than 32768 chunks");
}

/// An empty HDF5 file.
void create_empty(const fs::path& path, H5F_libver_t version) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_libver_bounds(access, version, H5F_LIBVER_V110);
    H5Fclose(H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, access));
    H5Pclose(access);
}

TEST(Hdf5Table, RefusesHdf5FilesThatAreNotTables) {
    const TemporaryFolder folder;
    const fs::path path = folder / "other.h5";
    create_empty(path, H5F_LIBVER_V110);
    EXPECT_EQ(refusal_of_reading(path),
              path.string() + ": is not a stratus-table file: it has no attribute format");
}

/// Other programs write this version unless told to use the latest one.
TEST(Hdf5Table, RefusesStructuresFromBeforeHdf5Version110) {
    const TemporaryFolder folder;
    const fs::path path = folder / "older.h5";
    create_empty(path, H5F_LIBVER_EARLIEST);
    EXPECT_EQ(refusal_of_reading(path),
              path.string() +
                  ": HDF5 cannot open the file: its structures predate HDF5 1.10; "
                  "h5repack --latest converts it");
}

TEST(Hdf5Table, RestoresTheErrorPrintingOfTheLibrary) {
    const TemporaryFolder folder;
    set_content(folder / "a.h5", std::string(io::hdf5_magic) + "nothing");
    H5E_auto2_t before = nullptr;
    H5E_auto2_t after = nullptr;
    void* data = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &before, &data);
    testing::internal::CaptureStderr();
    refusal_of_reading(folder / "a.h5");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    H5Eget_auto2(H5E_DEFAULT, &after, &data);
    EXPECT_EQ(before, after);
}

TEST(Hdf5Table, SealDetectsDamageBeforeTheLibraryReadsIt) {
    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
    write_table(sample_table(), path);
    std::string bytes = content(path);
    bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
    set_content(path, bytes);
    EXPECT_EQ(refusal_of_reading(path),
              path.string() + ": is damaged: the checksum of the file does not match");
}

TEST(Hdf5Table, LoadsWithoutTheSealThatAnotherProgramRemoved) {
    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
    write_table(sample_table(), path);
    const auto size = fs::file_size(path);
    H5Fclose(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    EXPECT_LT(fs::file_size(path), size);
    expect_same(read_table(path), sample_table());
}

// --- OpenEXR files changed by other programs ---

/// Overwrites the value of the n-th attribute of this name, counted from 0.
std::string with_attribute(std::string bytes, const std::string& name, const std::string& type,
                           const std::string& value, int n = 0) {
    const std::string start = name + '\0' + type + '\0';
    std::size_t at = bytes.find(start);
    while (n-- > 0) at = bytes.find(start, at + 1);
    return bytes.replace(at + start.size() + sizeof(std::int32_t), value.size(), value);
}

std::string integers(std::initializer_list<std::int32_t> values) {
    std::string bytes;
    for (const std::int32_t value : values)
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return bytes;
}

class TamperedExr : public testing::Test {
  protected:
    void SetUp() override {
        write_table(sample_table(), path);
        whole = content(path);
    }

    void expect_refusal(const std::string& bytes, const std::string& reason) {
        ASSERT_NE(bytes, whole);
        set_content(path, bytes);
        EXPECT_EQ(refusal_of_reading(path), path.string() + ": " + reason);
    }

    TemporaryFolder folder;
    const fs::path path = folder / "table.exr";
    std::string whole;
};

TEST_F(TamperedExr, RefusesHugeDataWindows) {
    const auto window = [&](std::int32_t x, std::int32_t y) {
        return with_attribute(whole, "dataWindow", "box2i", integers({0, 0, x, y}));
    };
    constexpr std::int32_t largest = std::numeric_limits<std::int32_t>::max();
    expect_refusal(window(largest, largest),
                   "a data window must not be larger than 16777216 on a side");
    expect_refusal(window(1 << 20, 1 << 20), "a data window is larger than 8 GiB");
    expect_refusal(window(1 << 15, 1 << 13), "a data window is larger than what the file holds");
    expect_refusal(window(-1, 3), "a data window must begin at 0, 0");
}

TEST_F(TamperedExr, RefusesADataWindowThatDoesNotMatchTheAxes) {
    expect_refusal(with_attribute(whole, "dataWindow", "box2i", integers({0, 0, 49, 7})),
                   "data window of reflection_multiple does not match its axes");
}

TEST_F(TamperedExr, RefusesAnotherCompression) {
    expect_refusal(with_attribute(whole, "compression", "compression", "\x03"),
                   "reflection_multiple must have PIZ compression");
}

TEST_F(TamperedExr, RefusesOtherChannels) {
    const std::string reason = "reflection_multiple must have one channel, Y, of 32-bit floats";
    expect_refusal(with_attribute(whole, "channels", "chlist", "Z"), reason);
}

TEST_F(TamperedExr, RefusesDuplicateAttributes) {
    const std::string twice = "stratus:format_major";
    std::string doubled = whole;
    doubled.replace(doubled.find("stratus:format_minor"), twice.size(), twice);
    expect_refusal(doubled, "duplicate attribute \"stratus:format_major\"");
}

TEST_F(TamperedExr, RefusesARenamedPart) {
    expect_refusal(with_attribute(whole, "name", "string", "plane_albed0", 2),
                   "part plane_albedo is missing");
}

TEST_F(TamperedExr, RefusesAttributesOfOtherTypes) {
    std::string bytes = whole;
    bytes.replace(bytes.find("v2f"), 3, "m33");
    expect_refusal(bytes, "a header has an attribute of an unsupported type");
}

TEST_F(TamperedExr, RefusesAttributesOfTheWrongLength) {
    std::string bytes = whole;
    const std::string start("screenWindowCenter\0v2f\0", 23);
    bytes.replace(bytes.find(start) + start.size(), 4, integers({30}));
    expect_refusal(bytes, "a header has an attribute of the wrong length");
}

TEST_F(TamperedExr, RefusesSeveralChannels) {
    expect_refusal(with_attribute(whole, "channels", "chlist", "YY"),
                   "a part must have one channel, Y, of 32-bit floats");
}

TEST_F(TamperedExr, RefusesAttributesBeyondTheEndOfTheFile) {
    std::string bytes = whole;
    const std::string start("stratus:title\0string\0", 21);
    bytes.replace(bytes.find(start) + start.size(), 4, integers({1 << 30}));
    expect_refusal(bytes, "a header is truncated or damaged");
}

TEST_F(TamperedExr, RefusesChangedAxes) {
    std::string bytes = whole;
    const std::string start("dataset:diffusion_exponent\0string\0", 34);
    bytes[bytes.find(start) + start.size() + 8] = '4';
    set_content(path, bytes);
    EXPECT_TRUE(refusal_of_reading(path).starts_with(path.string() + ": the metadata is damaged"));
}

// --- Tables that are not written ---

struct Refused {
    const char* name;
    std::function<void(Table&)> change;
    std::string reason;
};

std::ostream& operator<<(std::ostream& stream, const Refused& row) { return stream << row.name; }

const std::vector<Refused> refused{
    {"NotANumber",
     [](Table& t) { t.reflection_multiple[3] = std::numeric_limits<float>::quiet_NaN(); },
     "prepare: reflection_multiple (sample 3) must be finite, got nan"},
    {"WrongLength", [](Table& t) { t.plane_albedo.pop_back(); },
     "prepare: length of plane_albedo must be 45, got 44"},
    {"AttributeOfTheFormat", [](Table& t) { t.attributes["format"] = "mine"; },
     "write_table: an attribute's name must be one that the format does not reserve, got "
     "\"format\""},
    {"AttributeCalledChecksum", [](Table& t) { t.attributes["checksum"] = "mine"; },
     "write_table: an attribute's name must be one that the format does not reserve, got "
     "\"checksum\""},
    {"AttributeWithoutName", [](Table& t) { t.attributes[""] = "x"; },
     "write_table: an attribute's name must be 1 to 200 bytes long, got \"\""},
    {"AttributeWithLongName", [](Table& t) { t.attributes[std::string(201, 'n')] = "x"; },
     "write_table: an attribute's name must be 1 to 200 bytes long, got \"" + std::string(60, 'n') +
         "...\""},
    {"AttributeWithZeroByte", [](Table& t) { t.attributes["title"] = std::string("a\0b", 3); },
     "write_table: attribute \"title\" must be free of zero bytes, got \"a?b\""},
};

class RefusedTable : public testing::TestWithParam<Refused> {};

TEST_P(RefusedTable, IsNotWritten) {
    const TemporaryFolder folder;
    Table table = sample_table();
    GetParam().change(table);
    for (const char* name : {"table.h5", "table.exr"}) {
        const auto write = [&] { write_table(table, folder / name); };
        EXPECT_EQ(refusal<std::invalid_argument>(write), GetParam().reason);
    }
    EXPECT_EQ(folder.size(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Tables, RefusedTable, testing::ValuesIn(refused),
                         [](const auto& row) { return row.param.name; });

TEST(TableFile, RefusesOtherEndings) {
    const std::string read = refusal<std::invalid_argument>([] { read_table("table.nc"); });
    EXPECT_EQ(read, "read_table: path must be a name ending in .h5 or .exr, got table.nc");
    const std::string written =
        refusal<std::invalid_argument>([] { write_table(sample_table(), "table"); });
    EXPECT_EQ(written, "write_table: path must be a name ending in .h5 or .exr, got table");
}

}  // namespace
}  // namespace stratus::test
