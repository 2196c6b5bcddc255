// Arbitrary text as a scene.
#include <stratus/scene/scene.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    for (const char* opens : {"file", ".png", ".exr", ".csv"})  // texts that name files
        if (text.find(opens) != std::string::npos) return 0;
    try {
        stratus::parse_scene(text);
    } catch (const std::exception&) {
    }
    return 0;
}
