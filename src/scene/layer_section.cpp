// [layer].
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>

#include "sections.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

namespace stratus::scene_file {
namespace {

/// One depth, or red's, green's and blue's: the largest, and `extinction` of each over it.
double read_depths(const Section& section, const char* key, double max, const char* allowed,
                   SceneLayer& layer) {
    if (!section.is_list(key)) return section.number(key, 0, max, allowed);
    constexpr double max_of_three = 1e4;
    layer.extinction = read_three(section, key, max_of_three, "in [0, 1e4], three of them");
    const double largest = *std::ranges::max_element(layer.extinction);
    for (double& each : layer.extinction) each = largest > 0 ? each / largest : 1;
    return largest;
}

DepthMap read_depth(const Section& section, const Source& source, SceneLayer& layer) {
    constexpr const char* key = "optical_depth";
    DepthMap map;
    if (!section.is_table(key)) {
        map.max = read_depths(section, key, infinity, "in [0, inf], or a list of three, or a table",
                              layer);
        return map;
    }
    const Section table(section.table(key, "a number or a table"), caller, section.full_name(key),
                        {"image", "clouds", "most", "scale", "coverage", "seed"});
    require_exactly_one(table, "image", "clouds");
    map.max = read_depths(table, "most", 1e4, "in [0, 1e4], or a list of three", layer);
    if (table.has("image")) {
        map.pattern = DepthMap::Pattern::image;
        map.image = source.image(table, "image");
        return map;
    }
    map.pattern = DepthMap::Pattern::clouds;
    read_optional(map.scale, table, "scale", 1e-3, 1e3, "in [1e-3, 1e3]");
    read_optional(map.coverage, table, "coverage", 0, 1, "in [0, 1]");
    if (table.has("seed")) map.seed = read_seed(table);
    return map;
}

Opposition read_opposition(const Section& layer) {
    const Section section(layer.table("opposition", "a table"), caller, "layer.opposition",
                          {"law", "density", "amplitude", "width"});
    const std::string law = section.text("law");
    require(law == "blinn" || law == "hapke", caller, "layer.opposition.law",
            "\"blinn\" or \"hapke\"", law);
    if (law == "blinn")
        return Opposition::blinn(section.number("density", 1e-9, 1 - 1e-9, "in (0, 1)"));
    return Opposition::hapke(section.number("amplitude", 0, 1, "in [0, 1]"),
                             section.number("width", 1e-9, 1e9, "in [1e-9, 1e9]"));
}

std::vector<PhaseFunction> read_components(const Section& section, const Source& source) {
    constexpr const char* form = "a list of two phase functions, of w1 and of w2";
    const std::vector<std::string> texts = section.texts("components", form);
    require(texts.size() == 2, caller, "layer.components", form, texts.size());
    return {source.phase_function(texts[0]), source.phase_function(texts[1])};
}

/// One phase function, or three.
void read_phase_function(const Section& section, const Source& source, SceneLayer& layer) {
    constexpr const char* key = "phase_function";
    if (!section.is_list(key)) {
        layer.components = {source.phase_function(section.text(key))};
        return;
    }
    constexpr const char* form = "one phase function, or a list of three, of red, green and blue";
    const std::vector<std::string> texts = section.texts(key, form);
    require(texts.size() == 3, caller, section.full_name(key), form, texts.size());
    for (const std::string& text : texts) layer.channels.push_back(source.phase_function(text));
    layer.components = {layer.channels[1]};
}

/// `key` must be `otherwise` unless these are droplets.
Mie droplets_of(const PhaseFunction& phase_function, const char* key, const char* otherwise) {
    const auto& terms = phase_function.terms();
    const Mie* const droplets = std::get_if<Mie>(&terms[0].second);
    require(droplets != nullptr && terms.size() == 1, caller, key,
            std::string(otherwise) + " unless the phase function is of droplets (mie) alone",
            "\"phase_function\"");
    return *droplets;
}

/// The albedos of droplets for red, green and blue: at the wavelengths of their own phase functions,
/// or, of one phase function, at 0.65, 0.55 and 0.45 um.
std::array<double, 3> albedos_of_droplets(const SceneLayer& layer) {
    constexpr const char* name = "layer.albedo";
    std::array<double, 3> albedo{};
    constexpr std::array<double, 3> wavelengths = {0.65, 0.55, 0.45};
    for (std::size_t c = 0; c < 3; ++c) {
        if (!layer.channels.empty()) {
            albedo[c] = droplets_of(layer.channels[c], name, "numbers").albedo;
            continue;
        }
        Droplets droplets = droplets_of(layer.components[0], name, "numbers").droplets;
        droplets.wavelength = wavelengths[c];
        albedo[c] = Mie(droplets).albedo;
    }
    return albedo;
}

/// Extinction efficiencies over green's.
std::array<double, 3> extinction_of_droplets(const SceneLayer& layer) {
    constexpr const char* name = "layer.extinction";
    require(!layer.channels.empty(), caller, name, "absent unless phase_function is a list",
            "\"phase_function\"");
    const Mie green = droplets_of(layer.channels[1], name, "absent");
    std::array<double, 3> extinction{};
    for (std::size_t c = 0; c < 3; ++c) {
        const Mie own = droplets_of(layer.channels[c], name, "absent");
        require(own.droplets.effective_radius == green.droplets.effective_radius &&
                    own.droplets.effective_variance == green.droplets.effective_variance &&
                    own.droplets.distribution == green.droplets.distribution,
                caller, name, "absent unless all channels have droplets of the same sizes",
                layer.channels[c].text());
        extinction[c] = own.extinction_efficiency / green.extinction_efficiency;
    }
    return extinction;
}

}  // namespace

SceneLayer read_layer(const Section& root, const Source& source, bool of_rings) {
    std::vector<std::string> known{"albedo", "density", "opposition"};
    if (of_rings)
        known.push_back("components");
    else
        known.insert(known.end(), {"phase_function", "extinction", "optical_depth"});
    const Section section = section_of(root, "layer", known);
    SceneLayer layer;
    if (of_rings) {
        layer.components = read_components(section, source);
    } else {
        read_phase_function(section, source, layer);
        layer.optical_depth = read_depth(section, source, layer);
        if (section.has("extinction")) {
            require(layer.extinction == std::array<double, 3>{1, 1, 1}, caller, "layer.extinction",
                    "absent beside three optical depths", "\"phase_function\"");
            require(section.is("extinction", "phase_function"), caller, "layer.extinction",
                    "\"phase_function\" or absent", "another value");
            layer.extinction = extinction_of_droplets(layer);
        }
    }
    if (!of_rings && section.is("albedo", "phase_function"))
        layer.albedo = albedos_of_droplets(layer);
    else if (section.has("albedo"))
        layer.albedo = read_three(section, "albedo", 1, "in [0, 1]");
    else
        require(of_rings, caller, "layer.albedo", "present", "nothing");
    read_optional(layer.density, section, "density", 0, 1 - 1e-9, "in [0, 1)");
    if (section.has("opposition")) layer.opposition = read_opposition(section);
    return layer;
}

}  // namespace stratus::scene_file
