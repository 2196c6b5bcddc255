// Any bytes at all as TABLE.h5: refused with a reason or read.
#include "table_content.h"

#include <cstddef>
#include <cstdint>
#include <exception>

/// What HDF5 loses when it meets a damaged file is not ours to find.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::uintmax_t max_memory = 64 << 20;
    try {
        stratus::io::decode_hdf5({data, data + size}, stratus::io::MemoryLimit(max_memory));
    } catch (const std::exception&) {
    }
    return 0;
}
