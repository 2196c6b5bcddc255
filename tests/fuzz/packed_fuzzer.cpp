// Arbitrary bytes as a packed table are refused, or answer lookups.
#include <stratus/base/constants.h>
#include <stratus/table/packed_table.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace {

/// Of what costs little to prepare: droplets take seconds.
bool names_droplets(const std::vector<char>& bytes) {
    constexpr char name[] = {'m', 'i', 'e', ':'};
    return std::search(bytes.begin(), bytes.end(), name, name + sizeof name) != bytes.end();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::vector<char> bytes(data, data + size);
    if (names_droplets(bytes)) return 0;
    try {
        const stratus::PackedTable table(bytes);
        for (const double albedo : {0.0, 0.9, 1.0})
            for (const double depth : {0.0, 0.7, 100.0, stratus::infinity})
                for (const stratus::Geometry& at :
                     {stratus::Geometry{0.9, 0.3, 1}, stratus::Geometry{1e-4, 1, 3}}) {
                    table.reflection(albedo, depth, at, 0.4);
                    table.transmission(albedo, depth, at, 0.4);
                }
    } catch (const std::invalid_argument&) {
    }
    return 0;
}
