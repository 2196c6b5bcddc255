// HDF5 files in memory, so that only the system can fail on the disk (file_bytes.h).
#pragma once

#include <stratus/io/file_bytes.h>

#include "hdf5_library.h"

namespace stratus::io::hdf5 {

/// A new file whose bytes are in `bytes` once it is closed; `bytes` must outlive it.
Handle create_file(Bytes& bytes);

/// Opens the file in `bytes`, which must outlive it, for reading.
Handle open_file(const Bytes& bytes);

}  // namespace stratus::io::hdf5
