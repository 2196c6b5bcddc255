// HDF5 tables changed by other programs through HDF5 itself are refused with the reason; what does
// not concern the table may change.
#include <stratus/io/table_file.h>

#include "refusal_of_reading.h"
#include "row_name.h"
#include "sample_table.h"
#include "table_content.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

struct Tampering {
    const char* name;
    std::function<void(hid_t file)> work;
    std::string reason;
};

/// Replaces the dataset `name` by a new one over `sizes`.
void replace_dataset(hid_t file, const char* name, std::vector<hsize_t> sizes,
                     hid_t type = H5T_IEEE_F32LE) {
    H5Ldelete(file, name, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    ASSERT_GE(dataset, 0);
    H5Dclose(dataset);
    H5Sclose(space);
}

void change_tolerance(hid_t file) {
    const double tolerance = 0.5;
    const hid_t attribute = H5Aopen(file, "tolerance", H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, &tolerance);
    H5Aclose(attribute);
}

void write_attribute(hid_t object, const char* name, hid_t type, const void* value) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (value) H5Awrite(attribute, type, value);
    H5Aclose(attribute);
    H5Sclose(space);
}

void write_text(hid_t file, const char* dataset_name, const char* name, const char* text) {
    const hid_t dataset = H5Dopen2(file, dataset_name, H5P_DEFAULT);
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, std::strlen(text));
    write_attribute(dataset, name, type, text);
    H5Tclose(type);
    H5Dclose(dataset);
}

void change_scale(hid_t file, const char* axis, const char* text) {
    H5Adelete_by_name(file, axis, "scale", H5P_DEFAULT);
    write_text(file, axis, "scale", text);
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

const std::vector<Tampering> tamperings{
    {"MissingDataset", [](hid_t f) { H5Ldelete(f, "plane_albedo", H5P_DEFAULT); },
     "dataset plane_albedo is missing"},
    {"MissingAxis", [](hid_t f) { H5Ldelete(f, "mu_in", H5P_DEFAULT); },
     "dataset mu_in is missing"},
    {"Group", replace_by_group, "HDF5 cannot open dataset spherical_albedo: not a dataset"},
    {"OtherRank", [](hid_t f) { replace_dataset(f, "spherical_albedo", {15}); },
     "spherical_albedo must have 2 dimensions"},
    {"OtherExtents",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {5, 3});
     },
     "extents of spherical_albedo do not match its axes"},
    {"NoSamples",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {3, 5});
     },
     "spherical_albedo has no checksum"},
    {"Texts",
     [](hid_t f) {
         replace_dataset(f, "spherical_albedo", {3, 5}, H5T_C_S1);
     },
     "HDF5 cannot read dataset spherical_albedo: "},
    {"HugeAxis", [](hid_t f) { replace_dataset(f, "albedo", {1 << 21}); },
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
    {"ChangedAttribute", change_tolerance,
     "the metadata was changed or damaged since it was sealed"},
    {"RemovedAttribute", [](hid_t f) { H5Adelete(f, "title"); },
     "the metadata was changed or damaged since it was sealed"},
    {"AddedAttributeWithAMeaning",
     [](hid_t f) {
         const double albedo = 0.5;
         write_attribute(f, "below_albedo", H5T_NATIVE_DOUBLE, &albedo);
     },
     "the metadata was changed or damaged since it was sealed"},
    {"RemovedChecksum", [](hid_t f) { H5Adelete(f, "checksum"); }, "the metadata has no checksum"},
    {"AttributeOfReferences",
     [](hid_t f) {
         H5Adelete(f, "tolerance");
         write_attribute(f, "tolerance", H5T_STD_REF_OBJ, nullptr);
     },
     "the metadata was changed or damaged since it was sealed"},
    {"ChangedSample", change_sample,
     "spherical_albedo was changed or damaged since it was sealed (checksum crc32:"},
};

/// The sample table in a file, after `work` on it through HDF5.
class Hdf5Table : public testing::Test {
  protected:
    void tamper(const std::function<void(hid_t)>& work) {
        write_table(sample_table(), path);
        const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
        ASSERT_GE(file, 0);
        work(file);
        ASSERT_GE(H5Fclose(file), 0);
    }

    const TemporaryFolder folder;
    const fs::path path = folder / "table.h5";
};

class TamperedHdf5 : public Hdf5Table, public testing::WithParamInterface<Tampering> {};

TEST_P(TamperedHdf5, IsRefused) {
    tamper(GetParam().work);
    const std::string message = refusal_of_reading(path);
    EXPECT_TRUE(message.starts_with(path.string() + ": " + GetParam().reason)) << message;
}

INSTANTIATE_TEST_SUITE_P(Files, TamperedHdf5, testing::ValuesIn(tamperings), row_name);

TEST_F(Hdf5Table, SaysHowToSealWhatWasChangedOnPurpose) {
    tamper(change_sample);
    EXPECT_TRUE(refusal_of_reading(path).ends_with("; if on purpose, `stratus seal " +
                                                   path.string() + "`"));
    ReadOptions options;
    options.ignore_checksums = true;
    Table expected = sample_table();
    expected.spherical_albedo.assign(expected.spherical_albedo.size(), 0.0F);
    expect_same(read_table(path, options), expected);
    write_table(read_table(path, options), path);
    expect_same(read_table(path), expected);
}

TEST_F(Hdf5Table, LeavesAttributesAndObjectsOfOthersAlone) {
    tamper([](hid_t file) {
        const int number = 7;
        write_attribute(file, "of mine", H5T_NATIVE_INT, &number);
        write_attribute(file, "reference", H5T_STD_REF_OBJ, nullptr);
        H5Gclose(H5Gcreate2(file, "notes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Lcreate_soft("/nowhere", file, "link", H5P_DEFAULT, H5P_DEFAULT);
    });
    Table expected = sample_table();
    expected.attributes["of mine"] = "7";
    expect_same(read_table(path), expected);
}

TEST_F(Hdf5Table, ReadsTheSameNumbersInAnyFloatingPointType) {
    const Table table = sample_table();
    tamper([&](hid_t file) {
        const std::string sum = io::checksum(std::as_bytes(std::span(table.spherical_albedo)));
        replace_dataset(file, "spherical_albedo", {3, 5}, H5T_IEEE_F64BE);
        const hid_t dataset = H5Dopen2(file, "spherical_albedo", H5P_DEFAULT);
        H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                 table.spherical_albedo.data());
        H5Dclose(dataset);
        write_text(file, "spherical_albedo", "checksum", sum.c_str());
    });
    expect_same(read_table(path), table);
}

TEST_F(Hdf5Table, ReadsALinearScaleByEitherName) {
    tamper([](hid_t file) { change_scale(file, "azimuth", "identity"); });
    EXPECT_EQ(read_table(path).azimuth.scale, AxisScale::linear);
}

TEST_F(Hdf5Table, KeepsAnyNumberOfAttributes) {
    Table table = sample_table();
    for (int i = 0; i < 1000; ++i)
        table.attributes["note " + std::to_string(i)] = std::string(1000, 'x');
    write_table(table, path);
    expect_same(read_table(path), table);
}

/// Other programs write the earliest version unless told otherwise.
TEST_F(Hdf5Table, RefusesHdf5FilesThatAreNotTables) {
    for (const H5F_libver_t version : {H5F_LIBVER_EARLIEST, H5F_LIBVER_V110}) {
        const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
        H5Pset_libver_bounds(access, version, H5F_LIBVER_V110);
        H5Fclose(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access));
        H5Pclose(access);
        EXPECT_EQ(refusal_of_reading(path),
                  path.string() + ": is not a stratus-table file: it has no attribute format");
    }
}

TEST_F(Hdf5Table, RestoresTheErrorPrintingOfTheLibrary) {
    set_content(path, std::string(hdf5_magic) + "nothing");
    H5E_auto2_t before = nullptr;
    H5E_auto2_t after = nullptr;
    void* data = nullptr;
    H5Eget_auto2(H5E_DEFAULT, &before, &data);
    testing::internal::CaptureStderr();
    refusal_of_reading(path);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    H5Eget_auto2(H5E_DEFAULT, &after, &data);
    EXPECT_EQ(before, after);
}

}  // namespace
}  // namespace stratus::test
