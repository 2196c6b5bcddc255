#include <stratus/bake/stack_file.h>

#include <stratus/base/constants.h>

#include "layers_section.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace stratus {

namespace {

StackLayer read_stack_layer(const Section& section, const PhaseSource& source) {
    return {section.phase_function("phase_function", source.directory, source.notes),
            section.number("albedo"), section.number("optical_depth")};
}

}  // namespace

Stack read_layers(const Section& file, const TomlFile& origin, const PhaseSource& source) {
    Stack stack;
    std::vector<Section> sections;
    for (const toml::node& node : file.tables("layers")) {
        sections.emplace_back(*node.as_table(), origin, stack_keys(),
                              "layer " + std::to_string(sections.size() + 1), "layers");
        stack.layers.push_back(read_stack_layer(sections.back(), source));
    }
    if (file.has("below")) stack.lower_boundary = read_lower_boundary(file, origin.caller, source);
    for (std::size_t k = 0; k < stack.layers.size(); ++k) {
        const bool last = k + 1 == stack.layers.size() && !stack.lower_boundary.is_present();
        require(last || !std::isinf(stack.layers[k].optical_depth), origin.caller,
                sections[k].at("optical_depth"), "finite where a layer or [below] lies under it",
                stack.layers[k].optical_depth);
    }
    return stack;
}

Stack parse_stack(const std::string& text, const std::string& directory,
                  std::vector<std::string>* notes, const std::string& name) {
    const TomlFile origin{"stack", name};
    const toml::table parsed = parse_toml(text, origin);
    return read_layers(Section(parsed, origin, stack_keys()), origin, {directory, notes});
}

Stack read_stack(const std::filesystem::path& path, std::vector<std::string>* notes) {
    return parse_stack(read_text(path), path.parent_path().string(), notes, path.string());
}

}  // namespace stratus
