// Any bytes at all as a phase curve and as a list of moments.
#include <stratus/runtime/phase_function.h>

#include "memory_file.h"

#include <exception>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const stratus::test::MemoryFile file(data, size);
    for (const char* kind : {"tabulated", "moments"}) try {
            stratus::parse_phase_function(kind + (":file=" + file.name()));
        } catch (const std::exception&) {
        }
    return 0;
}
