// Arbitrary bytes as TABLE.h5 are refused or read. Mutated files get valid checksums, or nearly all
// of them would be refused before they are decoded.
#include "../io/forged_hdf5.h"
#include "table_content.h"

#include <hdf5.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <random>
#include <string>
#include <vector>

/// HDF5 itself leaks memory on damaged files.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
    constexpr std::size_t max_run = 64, seal_size = sizeof "\nstratus-table crc32:00000000";
    std::minstd_rand random(seed);
    const auto below = [&](std::size_t count) { return random() % count; };
    if (below(16) == 0) return LLVMFuzzerMutate(data, size, max_size);
    stratus::test::ForgedHdf5 file(std::string(data, data + size));
    std::string& bytes = file.bytes();
    if (const std::size_t seal = bytes.rfind("\nstratus-table "); seal + seal_size >= bytes.size())
        bytes.resize(std::min(seal, bytes.size()));
    if (bytes.empty()) return LLVMFuzzerMutate(data, size, max_size);
    // Mutate up to three structures, each after its name, so that the file still has them.
    for (std::size_t n = below(3) + 1; n > 0; --n) {
        std::vector<std::size_t> starts = file.starts();
        starts.push_back(bytes.size());
        const std::size_t chosen = below(starts.size() - 1);
        const std::size_t start = starts[chosen] + (chosen == 0 ? 8 : 4), end = starts[chosen + 1];
        if (start >= end) continue;
        const std::size_t at = start + below(std::min<std::size_t>(end - start, 1024));
        const std::size_t length = std::min(end - at, 1 + below(max_run));
        LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()) + at, length, length);
    }
    file.stamp();
    return bytes.copy(reinterpret_cast<char*>(data), max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::uintmax_t max_memory = 64 << 20;
    try {
        stratus::io::decode_hdf5({data, data + size}, stratus::io::MemoryLimit(max_memory));
    } catch (const std::exception&) {
    }
    // An object that is still open would fail to close at exit.
    if (H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL) != 0) std::abort();
    return 0;
}
