#include <stratus/bake/stack_file.h>

#include <stratus/runtime/constants.h>

#include "toml_section.h"

#include <cmath>

namespace stratus {

namespace {

constexpr const char* caller = "stack";

StackLayer read_layer(const toml::table& table, const std::string& name,
                      const PhaseSource& source) {
    const Section section(table, caller, name, {"phase_function", "albedo", "optical_depth"});
    return {read_phase_function(section.text("phase_function"), source.directory, source.notes),
            section.number("albedo", 0, 1, "in [0, 1]"),
            section.number("optical_depth", 0, infinity, "in [0, inf]")};
}

}  // namespace

Stack parse_stack(const std::string& text, const std::string& directory,
                  std::vector<std::string>* notes) {
    const toml::table parsed = parse_toml(text, caller);
    const Section file(parsed, caller, "", {"layers", "below"});
    const PhaseSource source{directory, notes};
    const toml::array* layers = parsed.get_as<toml::array>("layers");
    require(layers != nullptr && !layers->empty(), caller, "layers", "one table [[layers]] or more",
            file.has("layers") ? "another value" : "none");
    Stack stack;
    for (const toml::node& node : *layers) {
        require(node.is_table(), caller, "layers", "one table [[layers]] or more", "another value");
        const std::string name = "layer " + std::to_string(stack.layers.size() + 1);
        stack.layers.push_back(read_layer(*node.as_table(), name, source));
    }
    if (file.has("below")) stack.lower_boundary = read_lower_boundary(file, caller, source);
    for (std::size_t k = 0; k < stack.layers.size(); ++k) {
        const bool last = k + 1 == stack.layers.size() && !stack.lower_boundary.is_present();
        require(last || !std::isinf(stack.layers[k].optical_depth), caller,
                "layer " + std::to_string(k + 1) + ".optical_depth",
                "finite where a layer or [below] lies under it", stack.layers[k].optical_depth);
    }
    return stack;
}

Stack read_stack(const std::filesystem::path& path, std::vector<std::string>* notes) {
    return parse_stack(read_text(path), path.parent_path().string(), notes);
}

}  // namespace stratus
