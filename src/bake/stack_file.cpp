#include <stratus/bake/stack_file.h>

#include <stratus/base/constants.h>

#include "recipe_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace stratus {
namespace {

/// A layer in red, green and blue; one that is alike in all where there are no lists.
StackLayers read_colours(const Section& section, const PhaseSource& source) {
    const bool phases = section.is_list("phase_function"),
               depths = section.is_list("optical_depth");
    const std::vector<PhaseFunction> phase_functions =
        phases ? section.phase_functions("phase_function", 3, source)
               : std::vector{section.phase_function("phase_function", source)};
    const std::array<double, 3> albedo = section.three("albedo"),
                                depth = section.three("optical_depth");
    StackLayers colours;
    for (std::size_t c = 0; c < (phases || depths || section.is_list("albedo") ? 3 : 1); ++c) {
        section.require(!depths || depth[c] < infinity, "optical_depth",
                        "finite where there are three", depth[c]);
        colours.push_back({phase_functions[phases ? c : 0], albedo[c], depth[c]});
    }
    return colours;
}

/// One stack, or those of red, green and blue where a layer has lists of three.
std::vector<Stack> read_stacks(const Section& file, const TomlFile& origin,
                               const PhaseSource& source) {
    std::vector<Section> sections;
    std::vector<StackLayers> layers;
    std::size_t colours = 1;
    for (const toml::node& node : file.tables("layers")) {
        sections.emplace_back(*node.as_table(), origin, stack_keys(),
                              "layer " + std::to_string(sections.size() + 1), "layers");
        layers.push_back(read_colours(sections.back(), source));
        colours = std::max(colours, layers.back().size());
    }
    std::vector<Stack> stacks(colours);
    for (std::size_t c = 0; c < colours; ++c)
        for (const StackLayers& layer : layers)
            stacks[c].layers.push_back(layer[layer.size() > 1 ? c : 0]);
    if (file.has("below")) {
        const LowerBoundary boundary = read_lower_boundary(file, origin.caller, source);
        for (Stack& stack : stacks) stack.lower_boundary = boundary;
    }
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const bool last = k + 1 == layers.size() && !stacks[0].lower_boundary.is_present();
        sections[k].require(last || !std::isinf(layers[k][0].optical_depth), "optical_depth",
                            "finite where a layer or [below] lies under it",
                            layers[k][0].optical_depth);
    }
    return stacks;
}

/// `read`(root, origin, source) of a stack file.
template <class Read>
auto parsed(const std::string& text, const std::string& directory, std::vector<std::string>* notes,
            const std::string& name, const Read& read) {
    const TomlFile origin{"stack", name};
    const toml::table table = parse_toml(text, origin);
    return read(Section(table, origin, stack_keys()), origin, PhaseSource{directory, notes});
}

}  // namespace

double Stack::optical_depth() const { return total_depth(layers); }

bool Stack::is_lossless() const {
    return (!lower_boundary.is_present() || lower_boundary.albedo == 1) &&
           std::ranges::all_of(layers, [](const StackLayer& layer) { return layer.albedo == 1; });
}

double absorptance(const Stack& stack, const SolvedFluxes& fluxes, int orders) {
    if (orders == 0 && stack.is_lossless()) return 0;
    // Light that falls on the boundary is not lost: its share is part of it.
    const double passed = stack.lower_boundary.is_present() ? 0 : fluxes.total_transmittance;
    return 1 - fluxes.spherical_albedo - passed;
}

Stack read_layers(const Section& file, const TomlFile& origin, const PhaseSource& source) {
    std::vector<Stack> stacks = read_stacks(file, origin, source);
    file.require(stacks.size() == 1, "layers", "without lists of three where one colour is solved",
                 "red, green and blue");
    return std::move(stacks[0]);
}

Stack parse_stack(const std::string& text, const std::string& directory,
                  std::vector<std::string>* notes, const std::string& name) {
    return parsed(text, directory, notes, name, read_layers);
}

Stack read_stack(const std::filesystem::path& path, std::vector<std::string>* notes) {
    return parse_stack(read_text(path), path.parent_path().string(), notes, path.string());
}

std::vector<Stack> read_coloured_stack(const std::filesystem::path& path,
                                       std::vector<std::string>* notes) {
    return parsed(read_text(path), path.parent_path().string(), notes, path.string(), read_stacks);
}

}  // namespace stratus
