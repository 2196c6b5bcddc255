// HDF5 files in memory, so that only the system can fail on the disk (file_bytes.h), and on the disk
// through a driver of our own: what fills these can be larger than memory, and where the system fails
// it says why, not HDF5.
#pragma once

#include <stratus/io/file_bytes.h>

#include "hdf5_library.h"

#include <filesystem>
#include <functional>

namespace stratus::io::hdf5 {

/// A new file whose bytes are in `bytes` once it is closed; `bytes` must outlive it.
Handle create_file(Bytes& bytes);

/// Opens the file in `bytes`, which must outlive it, for reading.
Handle open_file(const Bytes& bytes);

/// Makes `path` an HDF5 file with what fill(file) puts into it; the same bytes as in memory.
///
/// Errors   std::system_error from the system; what `fill` throws.
void write_file(const std::filesystem::path& path, const std::function<void(hid_t file)>& fill);

}  // namespace stratus::io::hdf5
