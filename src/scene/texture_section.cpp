// Surfaces and the background: colours, patterns, images.
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include "sections.h"

#include <algorithm>
#include <string>

namespace stratus::scene_file {
namespace {

Texture::Pattern read_pattern(const Section& section) {
    const std::string name = section.choice("pattern", {"squares", "continents", "bands"});
    return name == "squares"      ? Texture::Pattern::squares
           : name == "continents" ? Texture::Pattern::continents
                                  : Texture::Pattern::bands;
}

/// Water: Lambert's law by its colour, and the sun that its facets mirror.
Texture read_ocean(const Section& section) {
    for (const char* other : {"image", "pattern", "other"})
        require(!section.has(other), caller, section.at(other), "absent where there is wind",
                "one");
    Texture texture;
    texture.colour = read_colour(section, "colour");
    const std::string facets = "ocean:wind=" + shortest_text(section.number("wind")) +
                               ",index=" + shortest_text(section.number("index"));
    texture.mirror = section.placed("colour", [&] {
        const float most = std::max({texture.colour.r, texture.colour.g, texture.colour.b});
        read_ground_law(facets + ",albedo=" + shortest_text(double{most}));
        return read_ground_law(facets);
    });
    texture.mirror_albedo = spherical_albedo(*texture.mirror);
    for (float* const channel : {&texture.colour.r, &texture.colour.g, &texture.colour.b})
        *channel += static_cast<float>(texture.mirror_albedo);
    return texture;
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
    if (section.has("wind")) return read_ocean(section);
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
