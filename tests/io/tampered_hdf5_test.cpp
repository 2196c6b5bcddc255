// HDF5 tables changed by other programs through HDF5 itself are refused with the reason.
#include <stratus/io/table_file.h>

#include "refusal_of_reading.h"
#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

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

void change_scale(hid_t file, const char* axis, const char* text) {
    H5Adelete_by_name(file, axis, "scale", H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, axis, H5P_DEFAULT);
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
    {"OtherScale", [](hid_t f) { change_scale(f, "albedo", "linear"); },
     "scale of axis albedo must be square_root_of_complement or fourth_root_of_complement, got "
     "\"linear\""},
    {"SquareRootOfAnotherAxis", [](hid_t f) { change_scale(f, "mu_in", "square_root"); },
     "scale of axis mu_in must be arcsine_of_fourth_root, got \"square_root\""},
    {"ScaleThatIsNotTheAzimuths", [](hid_t f) { change_scale(f, "azimuth", "square_root"); },
     "check_axis: azimuth must be uniform in the coordinate of scale square_root"},
    {"UnknownScale", [](hid_t f) { change_scale(f, "azimuth", "logarithmic"); },
     "scale of axis azimuth must be linear or square_root, got \"logarithmic\""},
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

TEST(Hdf5Table, ReadsALinearScaleByEitherName) {
    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
    write_table(sample_table(), path);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    change_scale(file, "azimuth", "identity");
    ASSERT_GE(H5Fclose(file), 0);
    EXPECT_EQ(read_table(path).azimuth.scale, AxisScale::linear);
}

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

}  // namespace
}  // namespace stratus::test
