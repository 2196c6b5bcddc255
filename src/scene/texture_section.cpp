// Surfaces and the background: colours, patterns, images.
#include "sections.h"

#include <string>

namespace stratus::scene_file {
namespace {

Texture::Pattern read_pattern(const Section& section) {
    const std::string name = section.choice("pattern", {"squares", "continents", "bands"});
    return name == "squares"      ? Texture::Pattern::squares
           : name == "continents" ? Texture::Pattern::continents
                                  : Texture::Pattern::bands;
}

}  // namespace

Texture read_surface(const Section& parent, const Source& source) {
    constexpr const char* key = "surface";
    Texture texture;
    if (!parent.has(key)) return texture;
    if (!parent.is_table(key)) {
        texture.colour = read_colour(parent, key);
        return texture;
    }
    const Section section = parent.section(key, "surface");
    if (has_image(section, "pattern")) return read_image(section, source, 1);
    texture.pattern = read_pattern(section);
    texture.colour = read_colour(section, "colour");
    texture.other = read_colour(section, "other");
    texture.scale = section.number("scale");
    texture.seed = read_seed(section);
    return texture;
}

Texture read_background(const Section& root, const Source& source) {
    const Section section = root.section("background");
    if (has_image(section, "colour")) return read_image(section, source, 1e6);
    Texture texture;
    texture.colour = read_colour(section, "colour");
    return texture;
}

}  // namespace stratus::scene_file
