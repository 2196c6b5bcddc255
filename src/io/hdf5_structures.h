// Checks of HDF5 files that HDF5 1.10 omits: it trusts the counts, sizes and addresses in the
// structures that it decodes, and forged ones make it access memory out of bounds.
//
// Supported are the structures that tables consist of, which came with HDF5 1.10; all others are
// refused, and with them all files of older versions. Names and numbers are those of the HDF5 File
// Format Specification, version 3.0.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <span>

namespace stratus::io {

class Hdf5Structures {
  public:
    explicit Hdf5Structures(std::span<const char> file) : file_(file) {}

    /// Why the library must not decode the `size` bytes at `address` that it is about to read; null
    /// if it may. Must be called for all reads in their order.
    ///
    /// Cost   visits everything that an object header refers to, attributes in heaps included.
    const char* refusal(H5FD_mem_t kind, std::uint64_t address, std::uint64_t size) noexcept;

  private:
    std::span<const char> file_;
    std::uint64_t rest_ = HADDR_UNDEF;  // where a header continues whose first part has been read
};

}  // namespace stratus::io
