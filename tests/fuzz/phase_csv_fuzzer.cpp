// Any bytes as a table of a phase function and as a list of moments.
#include <stratus/io/table_file.h>

#include "memory_file.h"

#include <exception>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const stratus::test::MemoryFile file(data, size);
    for (const char* kind : {"tabulated", "moments"}) try {
            stratus::read_phase_function(kind + (":file=" + file.name()));
        } catch (const std::exception&) {
        }
    return 0;
}
