// Chunks of datasets: shuffled and deflated here, with libdeflate, which takes half the time of HDF5's own filters and makes
// smaller files. Any HDF5 reads them.
#pragma once

#include "hdf5_library.h"

#include <stratus/io/write_options.h>

#include <span>
#include <string>

namespace stratus::io::hdf5 {

/// Makes a dataset over `extents` chunked, shuffled and deflated.
void set_chunks(hid_t creation, std::span<const std::size_t> extents);

/// Lets go of samples on the disk that have been brought into memory.
void release_samples(const WriteOptions& options);

/// Writes all chunks of a dataset from `values`, which has the size of its extents.
///
/// Threads  as many deflate as `options` say; one at a time calls HDF5; the file is the same for any
///          number of them.
/// Errors   std::runtime_error for a chunk that HDF5 cannot write.
void write_chunks(hid_t dataset, const std::string& name, std::span<const std::size_t> extents,
                  std::span<const float> values, const WriteOptions& options);

}  // namespace stratus::io::hdf5
