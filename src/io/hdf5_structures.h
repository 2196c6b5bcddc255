// What HDF5 1.10 takes for granted of the structures that it decodes, checked before it does:
// counts, sizes and places that lead it out of its memory where they were made up.
//
// Known are the structures that tables consist of, which HDF5 1.10 brought; all others are refused,
// whole files of older ones too. Names and numbers are those of the HDF5 File Format Specification,
// version 3.0.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <span>
#include <string_view>

namespace stratus::io {

/// The checksum of HDF5's structures. [B. Jenkins 2006, lookup3, hashlittle]
std::uint32_t lookup3(std::string_view bytes);

class Hdf5Structures {
  public:
    explicit Hdf5Structures(std::span<const char> file) : file_(file) {}

    /// Why the library must not decode the `size` bytes at `address` that it asks for; null when it
    /// may. To be asked before every read, in their order.
    ///
    /// Cost   goes through all that an object header holds, attributes in heaps too.
    const char* fault(H5FD_mem_t kind, std::uint64_t address, std::uint64_t size) noexcept;

  private:
    std::span<const char> file_;
    std::uint64_t rest_ = HADDR_UNDEF;  // where an object header goes on whose start has been read
};

}  // namespace stratus::io
