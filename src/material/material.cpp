#include <stratus/bake/parallel.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/file_bytes.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "solved_stack.h"

#include <memory>

namespace stratus {
namespace {

void check(const Material& material) {
    require(material.colours.size() == 1 || material.colours.size() == 3, "export", "colours",
            "one or three", material.colours.size());
    for (const Stack& stack : material.colours)
        require(!stack.layers.empty(), "export", "layers", "at least one", "none");
}

std::string describe(const Stack& stack) {
    std::string text;
    for (const StackLayer& layer : stack.layers)
        text += (text.empty() ? "" : " on ") + layer.phase_function.text() + ", albedo " +
                shortest_text(layer.albedo) + ", optical depth " +
                shortest_text(layer.optical_depth);
    const LowerBoundary& below = stack.lower_boundary;
    const std::string albedo = "albedo " + shortest_text(below.albedo);
    if (below.is_surface()) text += " on a Lambert surface of " + albedo;
    if (below.law) text += " on " + below.law->text();
    if (below.is_layer())
        text += " on a semi-infinite layer, " + below.phase_function.text() + ", " + albedo;
    return text;
}

}  // namespace

bool Material::is_opaque() const { return std::ranges::none_of(colours, is_transparent); }

const std::vector<std::string>& material_format_names() {
    static const std::vector<std::string> names{"fourier", "tensor",    "tensor-rgb",
                                                "netcdf",  "exr-atlas", "slice"};
    return names;
}

SolvedColours solve_colours(const Material& material, const std::vector<double>& mu,
                            const MaterialOptions& options) {
    const int count = int_size(material.colours);
    SolvedColours solved(material.colours.size());
    parallel_for(
        count, options.threads,
        [&](int c) { solved[size(c)] = SolvedStack(material.colours[size(c)], mu, options.nodes); },
        [&](int done) {
            if (options.progress) options.progress(static_cast<double>(done) / count, "solving");
        });
    return solved;
}

std::function<void(const std::filesystem::path&)> writing(std::vector<char> bytes) {
    return [all = std::make_shared<const std::vector<char>>(std::move(bytes))](
               const std::filesystem::path& path) {
        write_content(path, {all->data(), all->size()});
    };
}

std::string describe(const Material& material) {
    constexpr const char* names[] = {"red: ", "; green: ", "; blue: "};
    std::string text = material.title.empty() ? "" : material.title + ". ";
    for (std::size_t c = 0; c < material.colours.size(); ++c)
        text += (material.colours.size() == 1 ? "" : names[c]) + describe(material.colours[c]);
    return text;
}

void note_transmission(const Material& material, std::vector<std::string>& notes) {
    if (material.is_opaque()) return;
    notes.push_back(
        "diffuse transmission is not in the file: the format holds reflection, lit from above, "
        "alone; --over puts ground under the layer");
}

namespace {

/// The note on the beam, where it passes.
std::string beam_note(const Material& material) {
    std::vector<std::string> depths;
    for (const Stack& stack : material.colours) {
        const std::string depth = shortest_text(stack.optical_depth());
        if (depths.empty() || depth != depths.back()) depths.push_back(depth);
    }
    return "the beam straight through, exp(-tau/mu) with tau = " + joined(depths) +
           ", is not in the file: a renderer adds it, or --over puts ground under the layer";
}

/// Nodes for the most demanding colour, and the largest error of any.
ChosenNodes choose_nodes(const Material& material, const MaterialOptions& options) {
    SolverOptions solver;
    if (options.nodes != 0)
        solver.nodes = options.nodes;
    else
        solver.tolerance = options.tolerance;
    std::vector<ChosenNodes> chosen(material.colours.size());
    parallel_for(int_size(chosen), options.threads, [&](int c) {
        const Stack& stack = material.colours[size(c)];
        chosen[size(c)] = stratus::choose_nodes(stack.layers, stack.lower_boundary, solver);
    });
    return {std::ranges::max(chosen, {}, &ChosenNodes::nodes).nodes,
            std::ranges::max(chosen, {}, &ChosenNodes::error).error};
}

MaterialFile encode(const Material& material, MaterialFormat format,
                    const MaterialOptions& options) {
    switch (format) {
        case MaterialFormat::fourier: return make_fourier(material, options);
        case MaterialFormat::tensor: return make_tensor(material, false, options);
        case MaterialFormat::tensor_rgb: return make_tensor(material, true, options);
        case MaterialFormat::netcdf: return make_mqdiffuse(material, options);
        case MaterialFormat::exr_atlas: return make_atlas(material, options);
        case MaterialFormat::slice: return make_slice(material, options);
    }
    throw std::invalid_argument("export: format must be one of " + joined(material_format_names()) +
                                ", got another");
}

}  // namespace

MaterialFile make_material(const Material& material, MaterialFormat format,
                           const MaterialOptions& options) {
    check(material);
    require(options.nodes >= 0 && options.nodes <= 512, "export", "nodes", "in [1, 512]",
            options.nodes);
    const ChosenNodes chosen = choose_nodes(material, options);
    if (options.nodes == 0 && chosen.error > options.tolerance && !options.accept)
        throw std::runtime_error("export: the tolerance of " + short_number(options.tolerance, 3) +
                                 " is missed: the estimated error of R and T is " +
                                 short_number(chosen.error, 2) + " with " +
                                 std::to_string(chosen.nodes) +
                                 " nodes; accept it (--accept) or choose a larger tolerance");
    MaterialOptions with = options;
    with.nodes = chosen.nodes;
    MaterialFile file = encode(material, format, with);
    if (!material.is_opaque()) file.notes.insert(file.notes.begin(), beam_note(material));
    file.error = chosen.error;
    file.nodes = chosen.nodes;
    return file;
}

void write_material(const MaterialFile& file, const std::filesystem::path& path) {
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        file.write(temporary);
        if (file.json.empty()) return;
        std::filesystem::path beside = path;
        write_content_atomically(beside.replace_extension(".json"), file.json);
    });
}

}  // namespace stratus
