// HDF5 files in memory: written with the library's own driver, read with one of ours.
#pragma once

#include "file_bytes.h"
#include "hdf5_library.h"

namespace stratus::io::hdf5 {

/// A new file whose bytes are in `bytes` once it is closed; `bytes` must outlive it. Its root keeps
/// the order in which datasets and attributes are made, and no times.
Handle create_file(Bytes& bytes);

/// The driver that `open_file` needs; it must outlive the files opened with it.
Handle register_driver();

/// Opens the file in `bytes`, which must outlive it, for reading.
Handle open_file(hid_t driver, const Bytes& bytes);

}  // namespace stratus::io::hdf5
