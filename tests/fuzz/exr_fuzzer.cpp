// Arbitrary bytes as TABLE.exr are refused or read.
#include "table_content.h"

#include <cstddef>
#include <cstdint>
#include <exception>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::uintmax_t max_memory = 64 << 20;
    try {
        stratus::io::decode_exr({data, data + size}, {max_memory});
    } catch (const std::exception&) {
    }
    return 0;
}
