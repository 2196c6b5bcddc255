// Tables as HDF5 files: datasets, their axes as dimension scales, and the seal.
//
// Damage is detected in three ways. A seal at the end of the file, where HDF5 does not look, covers
// all bytes before it. All structures are of the kinds introduced with HDF5 1.10, which have
// checksums: they are compared before the library follows a pointer, even in a file whose seal
// another program has removed. The checksums of samples and metadata are copied along with them.
//
// Forged structures, with valid checksums, are refused before the library decodes them: HDF5 1.10
// trusts what it reads and can crash on it (hdf5_structures.h).
#include "hdf5_attributes.h"
#include "hdf5_chunks.h"
#include "hdf5_library.h"
#include "hdf5_memory_file.h"
#include "hdf5_structures.h"
#include "table_content.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace stratus::io {
namespace {

using namespace hdf5;

/// Far more samples than any axis has, and few enough to be harmless.
constexpr std::size_t max_axis_samples = 1 << 20;

// --- The seal ---

// A damaged file with a seal never reaches the library. Opening a file for writing removes the
// seal, which does not count as damage.

constexpr std::string_view seal_start = "\nstratus-table ";

std::string seal_of(std::span<const char> bytes) {
    return std::string(seal_start) + checksum(bytes) + '\n';
}

void append_seal(Bytes& bytes) {
    const std::string seal = seal_of(bytes);
    bytes.insert(bytes.end(), seal.begin(), seal.end());
}

void check_seal(std::span<const char> bytes) {
    const std::size_t length = seal_of({}).size();
    if (bytes.size() < length) return;
    const auto found = bytes.last(length);
    const std::string_view seal(found.data(), found.size());
    if (seal.starts_with(seal_start) && seal != seal_of(bytes.first(bytes.size() - length)))
        throw std::runtime_error("is damaged: the checksum of the file does not match");
}

// --- Writing ---

/// The two element types of the format.
template <class Number>
struct Element;
template <>
struct Element<float> {
    static hid_t stored() { return H5T_IEEE_F32LE; }
    static hid_t memory() { return H5T_NATIVE_FLOAT; }
};
template <>
struct Element<double> {
    static hid_t stored() { return H5T_IEEE_F64LE; }
    static hid_t memory() { return H5T_NATIVE_DOUBLE; }
};

/// Only datasets over all axes are large enough to be worth chunks.
bool is_chunked(std::span<const std::size_t> extents) {
    return extents.size() >= axis_fields.size();
}

Handle creation_properties(std::span<const std::size_t> extents) {
    Handle creation = new_property_list(H5P_DATASET_CREATE);
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    checked(H5Pset_attr_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
            "track the order of attributes");
    if (is_chunked(extents)) set_chunks(creation, extents);
    return creation;
}

/// Writes a dataset over the first axes, with its attributes.
template <class Number>
Handle write_dataset(hid_t file, const std::string& name, const std::string& long_name,
                     const std::string& units, std::span<const std::size_t> extents,
                     const std::vector<Number>& values) {
    const std::string task = "write dataset " + name;
    const Handle space = new_dataspace(extents);
    const Handle creation = creation_properties(extents);
    Handle dataset(H5Dcreate2(file, name.c_str(), Element<Number>::stored(), space, H5P_DEFAULT,
                              creation, H5P_DEFAULT),
                   H5Dclose, task);
    if constexpr (std::is_same_v<Number, float>)
        if (is_chunked(extents))
            write_chunks(dataset, name, chunk_runs(creation, name, extents), values);
    if (!is_chunked(extents))
        checked(H5Dwrite(dataset, Element<Number>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                         values.data()),
                task);
    write_text(dataset, "long_name", long_name);
    write_text(dataset, "units", units);
    write_text(dataset, checksum_name, checksum(std::span(values)));
    return dataset;
}

void write_axis(hid_t file, const AxisField& field, const Axis& axis) {
    const std::size_t count = axis.values.size();
    const Handle dataset =
        write_dataset(file, field.name, field.long_name, field.units, {&count, 1}, axis.values);
    write_text(dataset, "scale", stored_scale_name(field, axis));
    checked(H5DSset_scale(dataset, field.name),
            std::string("make a dimension scale of ") + field.name);
}

/// Attaches one axis to each dimension of a dataset.
void attach_axes(hid_t file, hid_t dataset, std::span<const AxisField> axes) {
    for (std::size_t d = 0; d < axes.size(); ++d) {
        const std::string task = std::string("attach axis ") + axes[d].name;
        const Handle axis(H5Dopen2(file, axes[d].name, H5P_DEFAULT), H5Dclose, task);
        checked(H5DSattach_scale(dataset, axis, static_cast<unsigned>(d)), task);
    }
}

// --- Reading ---

/// Checks that the file holds nothing but datasets, each with one name: no groups, named types or
/// links to other files, and none is followed.
void check_objects(hid_t file) {
    for (const std::string& name : link_names(file)) {
        const std::string task = "inspect " + shown(name);
        H5L_info_t link;
        checked(H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT), task);
        if (link.type != H5L_TYPE_HARD)
            throw std::runtime_error(shown(name) + " is a soft or external link");
        H5O_info_t object;
        checked(H5Oget_info_by_name2(file, name.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT),
                task);
        if (object.type != H5O_TYPE_DATASET)
            throw std::runtime_error(shown(name) + " is not a dataset");
        if (object.rc != 1) throw std::runtime_error(shown(name) + " has two names");
    }
}

bool has_dataset(hid_t file, const std::string& name) {
    return checked(H5Lexists(file, name.c_str(), H5P_DEFAULT), "list the datasets");
}

Handle open_dataset(hid_t file, const std::string& name) {
    if (!has_dataset(file, name)) throw std::runtime_error("dataset " + name + " is missing");
    return {H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, "open dataset " + name};
}

std::vector<std::size_t> dataset_extents(hid_t dataset, const std::string& name, std::size_t rank) {
    const Handle space(H5Dget_space(dataset), H5Sclose, "read the extents of " + name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE ||
        H5Sget_simple_extent_ndims(space) != static_cast<int>(rank))
        throw std::runtime_error(name + " must have " + std::to_string(rank) + " dimensions");
    std::vector<hsize_t> sizes(rank);
    checked(H5Sget_simple_extent_dims(space, sizes.data(), nullptr), "read the extents of " + name);
    return {sizes.begin(), sizes.end()};
}

/// Reads a dataset whose extents the caller has checked. Samples may be chunked; everything else is
/// contiguous, in the file itself (hdf5_structures.h refuses data in other files).
template <class Number>
std::vector<Number> read_values(hid_t dataset, const std::string& name,
                                std::span<const std::size_t> extents, const Bytes& file_bytes,
                                const MemoryLimit& limit) {
    const Handle type(H5Dget_type(dataset), H5Tclose, "read the type of " + name);
    if (H5Tequal(type, Element<Number>::stored()) <= 0)
        throw std::runtime_error(name + " must hold little-endian floating-point numbers of " +
                                 std::to_string(sizeof(Number)) + " bytes");
    const Handle creation(H5Dget_create_plist(dataset), H5Pclose, "read the layout of " + name);
    std::optional<ChunkRuns> chunks;
    if (checked(H5Pget_layout(creation), "read the layout of " + name) == H5D_CHUNKED) {
        if (!std::is_same_v<Number, float>) throw std::runtime_error(name + " must not be chunked");
        chunks = chunk_runs(creation, name, extents);
    }
    const std::uintmax_t stored =
        std::min<std::uintmax_t>(H5Dget_storage_size(dataset), file_bytes.size());
    const std::size_t count = checked_count(name, extents, sizeof(Number), stored);
    if (!chunks && count * sizeof(Number) > stored)
        throw std::runtime_error(name + " is larger than what the file holds");
    std::vector<Number> values(count);
    if constexpr (std::is_same_v<Number, float>)
        if (chunks) read_chunks(dataset, name, *chunks, file_bytes, limit, values);
    if (!chunks)
        checked(H5Dread(dataset, Element<Number>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                        values.data()),
                "read dataset " + name);
    check_checksum(name, read_text(dataset, name, checksum_name, file_bytes),
                   checksum(std::span<const Number>(values)));
    return values;
}

template <class Number>
std::vector<Number> read_over_axes(hid_t file, const std::string& name,
                                   const std::vector<std::size_t>& extents, const Bytes& file_bytes,
                                   const MemoryLimit& limit) {
    const Handle dataset = open_dataset(file, name);
    if (dataset_extents(dataset, name, extents.size()) != extents)
        throw std::runtime_error("extents of " + name + " do not match its axes");
    return read_values<Number>(dataset, name, extents, file_bytes, limit);
}

void read_axis(hid_t file, const AxisField& field, Axis& axis, const Bytes& file_bytes,
               const MemoryLimit& limit) {
    const Handle dataset = open_dataset(file, field.name);
    const std::vector<std::size_t> extents = dataset_extents(dataset, field.name, 1);
    if (extents[0] > max_axis_samples)
        throw std::runtime_error(std::string(field.name) + " has more than " +
                                 std::to_string(max_axis_samples) + " samples");
    read_scale(field, axis, read_text(dataset, field.name, "scale", file_bytes));
    axis.values = read_values<double>(dataset, field.name, extents, file_bytes, limit);
}

}  // namespace

Bytes encode_hdf5(const Table& table, const Metadata& metadata) {
    constexpr std::uint64_t root_at = 48;  // after the superblock
    const QuietErrors quiet;
    Bytes bytes;
    Handle file = create_file(bytes);
    const std::vector<AxisField> axes = axis_fields_of(table);
    for (const AxisField& field : axes) write_axis(file, field, table.*field.axis);
    const auto write_over_axes = [&](const char* name, const char* long_name, std::size_t rank,
                                     const auto& values) {
        const std::vector<std::size_t> sizes = extents(table, rank);
        attach_axes(file, write_dataset(file, name, long_name, "1", sizes, values),
                    std::span(axes).first(sizes.size()));
    };
    write_over_axes(diffusion_exponent_name, diffusion_exponent_long_name, 1,
                    table.diffusion_exponent);
    for (const SampleField& field : listed_samples(metadata))
        write_over_axes(field.name, field.long_name, field.rank, table.*field.samples);
    write_metadata(file, metadata);
    file.close("finish the file");
    if (const char* const reason =
            Hdf5Structures(bytes).refusal(H5FD_MEM_OHDR, root_at, bytes.size()))
        throw std::runtime_error(std::string("cannot store all attributes: ") + reason);
    append_seal(bytes);
    return bytes;
}

Table decode_hdf5(const Bytes& bytes, MemoryLimit limit, std::vector<std::string>* notes) {
    check_seal(bytes);
    const QuietErrors quiet;
    const Handle driver = register_driver();
    const Handle file = open_file(driver, bytes);
    const Metadata metadata = read_metadata(file, bytes);
    check_objects(file);
    Table table = table_without_samples(metadata, notes);
    for (const AxisField& field : axis_fields_of(metadata, has_dataset(file, mixture_field.name)))
        read_axis(file, field, table.*field.axis, bytes, limit);
    check_azimuths(metadata, table);
    table.diffusion_exponent =
        read_over_axes<double>(file, diffusion_exponent_name, extents(table, 1), bytes, limit);
    const std::vector<SampleField> listed = listed_samples(metadata);
    take_memory(table, listed, bytes.size(), limit);
    for (const SampleField& field : listed)
        table.*field.samples =
            read_over_axes<float>(file, field.name, extents(table, field.rank), bytes, limit);
    prepare(table);
    return table;
}

}  // namespace stratus::io
