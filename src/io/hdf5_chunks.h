// Datasets of samples in chunks, shuffled and deflated here: libdeflate is faster than what HDF5
// would use, and HDF5 would inflate a chunk to any size that a forged file leads to.
#pragma once

#include "file_bytes.h"
#include "hdf5_library.h"
#include "memory_limit.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace stratus::io::hdf5 {

/// Makes a dataset over `extents` chunked, shuffled and deflated.
void set_chunks(hid_t creation, std::span<const std::size_t> extents);

/// Chunks that are runs of consecutive samples, as this program writes them.
struct ChunkRuns {
    std::vector<hsize_t> extents;  // of the dataset
    std::vector<hsize_t> chunk;
    std::size_t split;  // the dimension that chunks divide: they are 1 long in those before it, and
                        // as long as the dataset in those after it
    std::size_t inner;  // samples in the dimensions after `split`

    std::size_t length() const { return chunk[split] * inner; }
};

/// The chunks of the dataset `name`, by its creation properties.
///
/// Errors   std::runtime_error for filters other than shuffle and deflate, for chunks that are not
///          runs, and for more of them than a dataset may have.
ChunkRuns chunk_runs(hid_t creation, const std::string& name, std::span<const std::size_t> extents);

/// Writes all chunks of a dataset from `values`, which has the size of its extents.
///
/// Errors   std::runtime_error for a chunk that HDF5 cannot write.
void write_chunks(hid_t dataset, const std::string& name, const ChunkRuns& runs,
                  std::span<const float> values);

/// Reads all chunks of a dataset into `values`, which has the size of its extents.
///
/// Errors   std::runtime_error for a chunk that is missing, damaged, outside the file or larger
///          than `limit` allows.
void read_chunks(hid_t dataset, const std::string& name, const ChunkRuns& runs,
                 const Bytes& file_bytes, MemoryLimit limit, std::vector<float>& values);

}  // namespace stratus::io::hdf5
