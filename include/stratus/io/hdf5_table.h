// TABLE.h5: opens in h5py and xarray with named axes and no code of ours.
//
// netCDF-4 rules: every axis is a 1-D dataset, a dimension scale attached to each dimension that it
// samples; the root tracks creation order. Samples are chunked, shuffled and deflated. The root's
// attributes hold the rest, texts with a fixed length. Every dataset has the checksum of its
// samples, the root that of its attributes, and the file ends, behind what HDF5 sees, with that of
// all its bytes. Equal tables make equal files. Files that other programs laid out anew are read
// where they did so with the structures of HDF5 1.10 (h5repack --latest).
#pragma once

#include <stratus/io/table_file.h>
#include <stratus/runtime/table.h>

#include <filesystem>

namespace stratus {

/// See table_file.h, which picks the format. `write_` writes to `path` directly; `write_table`
/// makes it atomic.
///
/// Threads  one call at a time, unless the HDF5 library was built to be thread-safe.
Table read_hdf5_table(const std::filesystem::path& path, const ReadOptions& options = {});
void write_hdf5_table(const Table& table, const std::filesystem::path& path);

}  // namespace stratus
