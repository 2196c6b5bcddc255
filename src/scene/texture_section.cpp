// Surfaces and the background: colours, patterns, images.
#include <stratus/runtime/argument.h>

#include "sections.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace stratus::scene_file {
namespace {

Texture::Pattern read_pattern(const Section& section) {
    const std::string name = section.text("pattern");
    const std::vector<std::pair<std::string, Texture::Pattern>> patterns{
        {"squares", Texture::Pattern::squares},
        {"continents", Texture::Pattern::continents},
        {"bands", Texture::Pattern::bands}};
    const auto found =
        std::ranges::find(patterns, name, &std::pair<std::string, Texture::Pattern>::first);
    require(found != patterns.end(), caller, section.full_name("pattern"),
            "\"squares\", \"continents\" or \"bands\"", name);
    return found->second;
}

}  // namespace

Texture read_surface(const Section& parent, const Source& source) {
    constexpr const char* key = "surface";
    Texture texture;
    if (!parent.has(key)) return texture;
    if (!parent.is_table(key)) {
        texture.colour = read_colour(parent, key, 1, "in [0, 1]");
        return texture;
    }
    const Section section(parent.table(key, "a number, a list of three, or a table"), caller,
                          parent.full_name(key),
                          {"image", "pattern", "colour", "other", "scale", "seed"});
    require_exactly_one(section, "image", "pattern");
    if (section.has("image")) return read_image(section, source);
    texture.pattern = read_pattern(section);
    texture.colour = {0.02f, 0.05f, 0.12f};
    texture.other = {0.5f, 0.5f, 0.5f};
    if (section.has("colour")) texture.colour = read_colour(section, "colour", 1, "in [0, 1]");
    if (section.has("other")) texture.other = read_colour(section, "other", 1, "in [0, 1]");
    read_optional(texture.scale, section, "scale", 1e-3, 1e3, "in [1e-3, 1e3]");
    if (section.has("seed")) texture.seed = read_seed(section);
    return texture;
}

Texture read_background(const Section& root, const Source& source) {
    const Section section = section_of(root, "background", {"colour", "image"});
    require_exactly_one(section, "colour", "image");
    if (section.has("image")) return read_image(section, source);
    Texture texture;
    texture.colour = read_colour(section, "colour", 1e6, "in [0, 1e6]");
    return texture;
}

}  // namespace stratus::scene_file
