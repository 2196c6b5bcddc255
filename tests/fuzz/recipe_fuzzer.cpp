// Any text at all as a recipe.
#include <stratus/bake/recipe.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    // Texts that name files, or spheres, whose scattering takes seconds.
    for (const char* costly : {"file", "mie"})
        if (text.find(costly) != std::string::npos) return 0;
    try {
        stratus::parse_recipe(text);
    } catch (const std::exception&) {
    }
    return 0;
}
