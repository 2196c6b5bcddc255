// Surfaces and the background: colours, patterns, images.
#include <stratus/base/number_text.h>

#include "sections.h"

namespace stratus::scene_file {
namespace {

Texture::Pattern read_pattern(const Section& section) {
    const std::string name = section.choice("pattern", {"squares", "continents", "bands"});
    return name == "squares"      ? Texture::Pattern::squares
           : name == "continents" ? Texture::Pattern::continents
                                  : Texture::Pattern::bands;
}

/// Water: Lambert's law by its colour, and the sun that its facets mirror.
Texture read_ocean(const Section& section, const Source& source) {
    for (const char* other : {"image", "pattern", "other"})
        require_absent(section, other, "where there is wind");
    Rgb colour = read_colour(section, "colour");
    // The law refuses a colour too bright for it; an albedo is as much of R as of its mean.
    const double most = brightest(colour);
    const std::string law = "ocean:wind=" + shortest_text(section.number("wind")) +
                            ",index=" + shortest_text(section.number("index")) +
                            ",albedo=" + shortest_text(most);
    Texture& ocean = (*source.oceans)[law];
    if (!ocean.mirror) {
        ocean.mirror = section.placed("colour", [&] { return read_ground_law(law); });
        ocean.mirror_albedo = ocean.mirror->spherical_albedo();
    }
    for (float* const channel : {&colour.r, &colour.g, &colour.b})
        *channel += static_cast<float>(ocean.mirror_albedo - most);
    ocean.colour = colour;
    return ocean;
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
    if (section.has("wind")) return read_ocean(section, source);
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
