// HDF5 files on the disk, through a driver of our own: what fills them can be larger than memory, and where the system fails it
// says why, not HDF5.
#pragma once

#include "hdf5_library.h"

#include <filesystem>
#include <functional>

namespace stratus::io::hdf5 {

/// Makes `path` an HDF5 file with what fill(file) puts into it; the same bytes as in memory
/// (hdf5_memory_file.h).
///
/// Errors   std::system_error from the system; what `fill` throws.
void write_file(const std::filesystem::path& path, const std::function<void(hid_t file)>& fill);

}  // namespace stratus::io::hdf5
