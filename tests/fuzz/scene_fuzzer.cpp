// Arbitrary text as a scene.
#include <stratus/scene/scene.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    // Texts that name files, or spheres, whose scattering takes seconds.
    for (const char* costly : {"file", ".png", ".exr", ".csv", "mie"})
        if (text.find(costly) != std::string::npos) return 0;
    try {
        stratus::parse_film(text);
    } catch (const std::exception&) {
    }
    return 0;
}
