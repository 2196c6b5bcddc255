// Any text at all as a recipe; what is read must read back from its resolved text.
#include <stratus/bake/recipe.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    if (text.find("file") != std::string::npos) return 0;  // opens whatever it names
    std::optional<stratus::Recipe> recipe;
    try {
        recipe = stratus::parse_recipe(text);
    } catch (const std::exception&) {
        return 0;
    }
    stratus::parse_recipe(stratus::resolved_text(*recipe));  // ends the fuzzer where it throws
    return 0;
}
