// Any bytes as the query of `stratus eval`.
#include "memory_file.h"
#include "query.h"

#include <exception>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const stratus::test::MemoryFile file(data, size);
    try {
        stratus::read_query(file.name(), {"mu_in", "mu_out", "azimuth_deg"},
                            {"optical_depth", "albedo", "mixture"});
    } catch (const std::exception&) {
    }
    return 0;
}
