// Arbitrary bytes as a texture of a scene, in both formats, are refused or read.
#include <stratus/io/image.h>
#include <stratus/picture/png.h>

#include "memory_file.h"

#include <exception>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::uintmax_t max_memory = 64 << 20;
    const stratus::test::MemoryFile file(data, size);
    const bool png = size > 1 && data[1] == 'P';
    try {
        if (png)
            stratus::read_png(file.name(), max_memory);
        else
            stratus::read_exr_image(file.name(), max_memory);
    } catch (const std::exception&) {
    }
    return 0;
}
