// TABLE.h5: opens in h5py and xarray with named axes, without any code of ours.
//
// It follows netCDF-4: every axis is a 1-D dataset and a dimension scale, attached to each
// dimension that it samples; the root tracks creation order. Samples are chunked, shuffled and
// deflated. The rest is in attributes of the root, texts with a fixed length. Every dataset has the
// checksum of its numbers, the root that of its attributes. Equal tables make equal files. Files
// that other programs rewrote are read, whatever structures, chunks, filters and types these chose.
#pragma once

#include <stratus/io/table_file.h>
#include <stratus/table/table.h>

#include <filesystem>

namespace stratus {

/// Like `read_table` and `write_table` (table_file.h), for any name; `write_hdf5_table` writes to
/// `path` directly, not atomically.
///
/// Threads  one call at a time, unless the HDF5 library was built to be thread-safe.
Table read_hdf5_table(const std::filesystem::path& path, const ReadOptions& options = {});
void write_hdf5_table(const Table& table, const std::filesystem::path& path);

}  // namespace stratus
