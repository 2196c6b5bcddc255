// [layer].
#include <stratus/bake/stack_file.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>

#include "sections.h"

#include <utility>
#include <variant>

namespace stratus::scene_file {
namespace {

/// One depth, or red's, green's and blue's: the largest, and `extinction` of each over it.
double read_depths(const Section& section, const char* key, SceneLayer& layer) {
    if (!section.is_list(key)) return section.number(key);
    layer.extinction = section.three(key);
    const double largest = std::ranges::max(layer.extinction);
    section.require(largest < infinity, key, "finite where there are three", largest);
    for (double& each : layer.extinction) each = largest > 0 ? each / largest : 1;
    return largest;
}

DepthMap read_depth(const Section& section_of_layer, const Source& source, SceneLayer& layer) {
    constexpr const char* key = "optical_depth";
    DepthMap map;
    if (!section_of_layer.is_table(key)) {
        map.max = read_depths(section_of_layer, key, layer);
        return map;
    }
    const Section section = section_of_layer.section(key);
    const bool is_image = has_image(section, "clouds");
    map.max = read_depths(section, "most", layer);
    if (is_image) {
        map.pattern = DepthMap::Pattern::image;
        map.image = source.image(section, 1);
        return map;
    }
    section.require(section.flag("clouds"), "clouds",
                    "true; a layer without clouds has a number as its optical_depth", "false");
    map.pattern = DepthMap::Pattern::clouds;
    map.scale = section.number("scale");
    map.coverage = section.number("coverage");
    map.seed = read_seed(section);
    map.offset = read_vector(section, "offset");
    return map;
}

/// The share of the volume that particles fill, given, or from their number and radius.
double read_density(const Section& layer) {
    constexpr const char* key = "density";
    if (!layer.is_table(key)) return layer.number(key);
    const Section section = layer.section(key);
    const double number = section.number("number"), radius = section.number("radius");
    return layer.placed(key, [&] { return volume_fraction(number, radius); });
}

/// Reads the opposition effect; values not given follow from the layer's density.
Opposition read_opposition(const Section& layer, double density) {
    const Section section = layer.section("opposition");
    const bool of_blinn = section.choice("law", {"blinn", "hapke"}) == "blinn";
    const char* const key = of_blinn ? "density" : "width";
    section.require(section.has(key) || density > 0, key, "given where the layer has no density",
                    "nothing");
    if (of_blinn) return Opposition::blinn(section.has(key) ? section.number(key) : density);
    const double amplitude = section.number("amplitude");
    return Opposition::hapke(
        amplitude, section.has(key) ? section.number(key) : Opposition::width_of_density(density));
}

/// One phase function, or three.
void read_phase_function(const Section& section, const Source& source, SceneLayer& layer) {
    constexpr const char* key = "phase_function";
    if (section.is_list(key)) layer.channels = section.phase_functions(key, 3, source);
    layer.components = {layer.channels.empty() ? section.phase_function(key, source)
                                               : layer.channels[1]};
}

/// Null unless a phase function is of droplets alone.
const Mie* find_droplets(const PhaseFunction& phase_function) {
    const auto& terms = phase_function.terms();
    return terms.size() == 1 ? std::get_if<Mie>(&terms[0].second) : nullptr;
}

/// The albedos that phase functions bring with them: of droplets at their own wavelengths, or, of one
/// phase function that gives none, at 0.65, 0.55 and 0.45 um; of tables by their geometric albedo.
Rgb3 own_albedos(const Section& section, const SceneLayer& layer) {
    Rgb3 albedo{};
    constexpr Rgb3 wavelengths = {0.65, 0.55, 0.45};
    const bool each = !layer.channels.empty(),
               at_own =
                   each || section.text("phase_function").find("wavelength=") != std::string::npos;
    for (std::size_t c = 0; c < 3; ++c) {
        const PhaseFunction& own = each ? layer.channels[c] : layer.components[0];
        section.require(
            own.albedo().has_value(), "albedo",
            "numbers unless the phase function is of droplets (mie) or has a geometric_albedo",
            "\"phase_function\"");
        albedo[c] = *own.albedo();
        const Mie* const droplets = find_droplets(own);
        if (at_own || !droplets) continue;
        Droplets coloured = droplets->droplets;
        coloured.wavelength = wavelengths[c];
        albedo[c] = Mie(coloured).albedo();
    }
    return albedo;
}

/// Extinction efficiencies over green's.
Rgb3 extinction_of_droplets(const Section& section, const SceneLayer& layer) {
    constexpr const char* key = "extinction";
    section.require(!layer.channels.empty(), key, "absent unless phase_function is a list",
                    "\"phase_function\"");
    const auto droplets = [&](std::size_t c) -> const Mie& {
        const Mie* const own = find_droplets(layer.channels[c]);
        section.require(own != nullptr, key,
                        "absent unless the phase function is of droplets (mie) alone",
                        "\"phase_function\"");
        return *own;
    };
    const Mie& green = droplets(1);
    Rgb3 extinction{};
    for (std::size_t c = 0; c < 3; ++c) {
        const Mie& own = droplets(c);
        section.require(have_same_sizes(own.droplets, green.droplets), key,
                        "absent unless all channels have droplets of the same sizes",
                        layer.channels[c].text());
        extinction[c] = own.extinction_efficiency() / green.extinction_efficiency();
    }
    return extinction;
}

/// Layers on top of one another, seen as one material in each colour.
SceneLayer read_stack(const Section& section, const Source& source) {
    for (const char* key : {"phase_function", "components", "albedo", "extinction", "optical_depth",
                            "density", "opposition"})
        require_absent(section, key, "beside a stack, whose layers are all that scatters");
    const fs::path path = source.directory / section.text("stack");
    std::vector<Stack> stacks =
        section.placed("stack", [&] { return read_coloured_stack(path, source.notes); });
    section.require(
        !stacks[0].lower_boundary.is_present(), "stack",
        "a stack without [below]: ground is the scene's surface, and a semi-infinite layer one "
        "of optical_depth inf",
        "one with it");
    std::vector<StackLayers> layers;
    for (Stack& stack : stacks) layers.push_back(std::move(stack.layers));
    return section.placed("stack", [&] { return layer_of_stacks(std::move(layers)); });
}

}  // namespace

SceneLayer read_layer(const Section& section, const Source& source, bool of_rings) {
    if (section.has("stack")) {
        section.require(!of_rings, "stack",
                        "absent where there are [rings], whose profile mixes two components",
                        "given");
        return read_stack(section, source);
    }
    SceneLayer layer;
    if (of_rings) {
        require_absent(section, "phase_function",
                       "where there are [rings]: components has those of the profile's w1 and w2");
        for (const char* key : {"extinction", "optical_depth"})
            require_absent(section, key, "where there are [rings], whose profile has the depth");
        layer.components = section.phase_functions("components", 2, source);
    } else {
        require_absent(section, "components", "but of [rings]");
        read_phase_function(section, source, layer);
        layer.optical_depth = read_depth(section, source, layer);
        if (section.has("extinction")) {
            section.choice("extinction", {"phase_function"});
            const bool three = layer.extinction != Rgb3{1, 1, 1};
            section.require(!three, "extinction", "absent beside three optical depths", "given");
            layer.extinction = extinction_of_droplets(section, layer);
        }
    }
    if (!of_rings && section.is("albedo", "phase_function"))
        layer.albedo = own_albedos(section, layer);
    else if (section.has("albedo") || !of_rings)
        layer.albedo = section.three("albedo");
    layer.density = read_density(section);
    if (section.has("opposition")) layer.opposition = read_opposition(section, layer.density);
    return layer;
}

}  // namespace stratus::scene_file

namespace stratus {

SceneLayer layer_of_stacks(std::vector<StackLayers> stacks) {
    SceneLayer layer;
    StackLayers means;
    for (const StackLayers& stack : stacks) {
        const Recipe recipe = recipe_of_stack(stack, {});
        means.push_back({recipe.phase_function, recipe.albedo.max, recipe.optical_depth.max});
    }
    const double deepest =
        std::ranges::max_element(means, {}, &StackLayer::optical_depth)->optical_depth;
    layer.optical_depth.max = deepest;
    for (std::size_t c = 0; c < 3; ++c) {
        const StackLayer& mean = means[means.size() > 1 ? c : 0];
        layer.albedo[c] = mean.albedo;
        layer.extinction[c] = deepest < infinity ? mean.optical_depth / deepest : 1;
        if (means.size() > 1) layer.channels.push_back(mean.phase_function);
    }
    layer.components = {means[means.size() / 2].phase_function};
    layer.stacks = std::move(stacks);
    return layer;
}

}  // namespace stratus
