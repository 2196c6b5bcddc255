// TABLE.h5: opens in h5py and xarray with named axes, without any code of ours.
//
// It follows netCDF-4: every axis is a 1-D dataset and a dimension scale, attached to each
// dimension that it samples; the root tracks creation order. Samples are chunked, shuffled and
// deflated. The rest is in attributes of the root, texts with a fixed length. Every dataset has the
// checksum of its numbers, the root that of its attributes. Equal tables make equal files. Files
// that other programs rewrote are read, whatever structures, chunks, filters and types these chose.
//
// Checksums are of numbers and texts as they are read, not of the file's bytes: a program that
// rewrites the file in its own way, copying datasets and attributes, keeps them valid. The structures
// are those of HDF5 1.10, whose own checksums the library compares.
#include <stratus/base/argument.h>

#include "hdf5_parts.h"

#include <hdf5_hl.h>

#include <stdexcept>
#include <type_traits>
#include <vector>

namespace stratus::io {
namespace {

using namespace hdf5;

/// Far more samples than any axis has, and few enough to be harmless.
constexpr std::size_t max_axis_samples = 1 << 20;

// --- Writing: tables, and grids that others read (write_options.h) ---

// The two element types of the format.

template <class Number>
hid_t stored_type() {
    return std::is_same_v<Number, float> ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
}

template <class Number>
hid_t memory_type() {
    return std::is_same_v<Number, float> ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
}

/// Writes a dataset whole.
template <class Number>
Handle write_values(hid_t file, const std::string& name, Extents extents,
                    std::span<const Number> values) {
    Handle dataset = new_dataset(file, name, stored_type<Number>(), extents);
    checked(H5Dwrite(dataset, memory_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
            "write dataset " + name);
    return dataset;
}

/// Writes a dataset over the first axes, with its attributes.
template <class Number>
Handle write_dataset(hid_t file, const std::string& name, const std::string& long_name,
                     const std::string& units, Extents extents, std::span<const Number> values,
                     const WriteOptions& options = {}) {
    // Only datasets over all axes are large enough to be worth chunks.
    const bool in_chunks = extents.size() >= axis_fields.size();
    Handle dataset = in_chunks ? new_dataset(file, name, stored_type<Number>(), extents, true)
                               : write_values(file, name, extents, values);
    if constexpr (std::is_same_v<Number, float>)
        if (in_chunks) write_chunks(dataset, name, extents, values, options);
    write_text(dataset, "long_name", long_name);
    write_text(dataset, "units", units);
    write_text(dataset, checksum_name,
               checksum(std::as_bytes(values), [&] { release_samples(options); }));
    return dataset;
}

void write_axis(hid_t file, const AxisField& field, const Table& table) {
    const Axis& axis = table_axis(table, field);
    const std::size_t count = axis.values.size();
    const Handle dataset = write_dataset(file, field.name, field.long_name, field.units,
                                         {&count, 1}, std::span(axis.values));
    write_text(dataset, "scale", stored_scale_name(field, table));
    checked(H5DSset_scale(dataset, field.name),
            std::string("make a dimension scale of ") + field.name);
}

/// Attaches one axis to each dimension of a dataset.
template <class Field>
void attach_axes(hid_t file, hid_t dataset, std::span<const Field> axes) {
    for (std::size_t d = 0; d < axes.size(); ++d) {
        const std::string name = axes[d].name, task = "attach axis " + name;
        const Handle axis(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, task);
        checked(H5DSattach_scale(dataset, axis, static_cast<unsigned>(d)), task);
    }
}

void write_grid(hid_t file, const NetcdfGrid& grid, Extents extents) {
    for (const NetcdfDimension& axis : grid.dimensions) {
        const std::size_t size = axis.values.size();
        const Handle dataset = write_values(file, axis.name, {&size, 1}, std::span(axis.values));
        checked(H5DSset_scale(dataset, axis.name.c_str()), "make a scale of " + axis.name);
        write_text(dataset, "units", axis.units);
        write_text(dataset, "long_name", axis.long_name);
    }
    const Handle variable = write_values(file, grid.name, extents, std::span(grid.values));
    write_text(variable, "units", grid.units);
    write_text(variable, "long_name", grid.long_name);
    attach_axes(file, variable, std::span(grid.dimensions));
    for (const auto& [name, text] : grid.attributes) write_text(file, name, text);
}

// --- Reading ---

Handle open_dataset(hid_t file, const std::string& name) {
    if (!checked(H5Lexists(file, name.c_str(), H5P_DEFAULT), "list the datasets"))
        throw std::runtime_error("dataset " + name + " is missing");
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

/// A file while it is read.
struct Source {
    hid_t file;
    std::size_t size;  // bytes
    bool ignore_checksums;
};

/// Reads a dataset whose extents the caller has checked.
template <class Number>
std::vector<Number> read_values(const Source& source, hid_t dataset, const std::string& name,
                                Extents extents) {
    std::vector<Number> values(checked_count(name, extents, sizeof(Number), source.size));
    checked(H5Dread(dataset, memory_type<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
            "read dataset " + name);
    if (!source.ignore_checksums)
        check_checksum(name, read_text(dataset, checksum_name),
                       checksum(std::as_bytes(std::span(values))));
    return values;
}

template <class Number>
std::vector<Number> read_over_axes(const Source& source, const std::string& name,
                                   const std::vector<std::size_t>& extents) {
    const Handle dataset = open_dataset(source.file, name);
    if (dataset_extents(dataset, name, extents.size()) != extents)
        throw std::runtime_error("extents of " + name + " do not match its axes");
    return read_values<Number>(source, dataset, name, extents);
}

void read_axis(const Source& source, const AxisField& field, Table& table) {
    const std::string name = field.name;
    const Handle dataset = open_dataset(source.file, name);
    const std::vector<std::size_t> extents = dataset_extents(dataset, name, 1);
    if (extents[0] > max_axis_samples)
        throw std::runtime_error(name + " has more than " + std::to_string(max_axis_samples) +
                                 " samples");
    const auto scale = read_text(dataset, "scale");
    if (!scale) throw std::runtime_error(name + " has no attribute scale");
    read_scale(field, table, *scale);
    table_axis(table, field).values = read_values<double>(source, dataset, name, extents);
}

std::span<const float> field_samples(const Table& table, const SampleField& field,
                                     const WriteOptions& options) {
    if (options.samples && field.samples == &Table::reflection_multiple)
        return options.samples->samples(Side::reflection);
    if (options.samples && field.samples == &Table::transmission_multiple)
        return options.samples->samples(Side::transmission);
    return table.*field.samples;
}

void fill(hid_t file, const Table& table, const Metadata& metadata, const WriteOptions& options) {
    const std::vector<AxisField> axes = all_axis_fields(table);
    for (const AxisField& field : axes) write_axis(file, field, table);
    const auto write_over_axes = [&](const char* name, const char* long_name, std::size_t rank,
                                     const auto& values) {
        const std::vector<std::size_t> sizes = extents(table, rank);
        attach_axes(file,
                    write_dataset(file, name, long_name, "1", sizes, std::span(values), options),
                    std::span(axes).first(sizes.size()));
    };
    write_over_axes(diffusion_exponent_name, diffusion_exponent_long_name, 1,
                    table.diffusion_exponent);
    for (const SampleField& field : listed_samples(metadata))
        write_over_axes(field.name, field.long_name, field.rank,
                        field_samples(table, field, options));
    write_metadata(file, metadata);
}

}  // namespace

void write_hdf5(const Table& table, const Metadata& metadata, const fs::path& path,
                const WriteOptions& options) {
    const QuietErrors quiet;
    write_file(path, [&](hid_t file) { fill(file, table, metadata, options); });
}

Table decode_hdf5(const Bytes& bytes, const ReadOptions& options) {
    MemoryLimit limit(options.max_memory);
    limit.take("the file", bytes.size());
    const QuietErrors quiet;
    const Handle file = open_file(bytes);
    const Source source{file, bytes.size(), options.ignore_checksums};
    const Metadata metadata = read_metadata(file, options.ignore_checksums);
    Table table = table_without_samples(metadata);
    for (const AxisField& field : all_axis_fields(table)) read_axis(source, field, table);
    table.diffusion_exponent =
        read_over_axes<double>(source, diffusion_exponent_name, extents(table, 1));
    read_samples(table, metadata, bytes.size(), limit, [&](const SampleField& field) {
        return read_over_axes<float>(source, field.name, extents(table, field.rank));
    });
    return table;
}

}  // namespace stratus::io

namespace stratus {

void write_netcdf(const NetcdfGrid& grid, const fs::path& path) {
    std::vector<std::size_t> extents;
    std::size_t count = 1;
    for (const NetcdfDimension& axis : grid.dimensions) {
        extents.push_back(axis.values.size());
        count *= axis.values.size();
    }
    require(count == grid.values.size(), "write_netcdf", "values", std::to_string(count),
            grid.values.size());
    const io::hdf5::QuietErrors quiet;
    io::hdf5::write_file(path, [&](hid_t file) { io::write_grid(file, grid, extents); });
}

}  // namespace stratus
