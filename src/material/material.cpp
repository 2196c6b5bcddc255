#include <stratus/material/material.h>

#include <stratus/bake/parallel.h>
#include <stratus/io/atomic_file.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include "formats.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace stratus {
namespace {

void check(const Material& material, const MaterialOptions& options) {
    require(material.colours.size() == 1 || material.colours.size() == 3, "export", "colours",
            "one or three", material.colours.size());
    require(options.nodes >= 1 && options.nodes <= 512, "export", "nodes", "in [1, 512]",
            options.nodes);
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
    if (below.kind == LowerBoundary::Kind::surface)
        text += " on a Lambert surface of albedo " + shortest_text(below.albedo);
    if (below.kind == LowerBoundary::Kind::layer)
        text += " on a semi-infinite layer, " + below.phase_function.text() + ", albedo " +
                shortest_text(below.albedo);
    return text;
}

}  // namespace

bool Material::is_opaque() const {
    return std::none_of(colours.begin(), colours.end(), is_transparent);
}

const std::vector<std::string>& material_format_names() {
    static const std::vector<std::string> names{"fourier", "tensor",    "tensor-rgb",
                                                "netcdf",  "exr-atlas", "slice"};
    return names;
}

std::vector<SolvedStack> solve_colours(const Material& material, const std::vector<double>& mu,
                                       const MaterialOptions& options) {
    const int count = static_cast<int>(material.colours.size());
    std::vector<std::optional<SolvedStack>> solved(material.colours.size());
    const auto finished = [&](int done) {
        if (options.progress) options.progress(static_cast<double>(done) / count, "solving");
    };
    parallel_for(
        count, options.threads,
        [&](int c) {
            const auto at = static_cast<std::size_t>(c);
            solved[at].emplace(material.colours[at], mu, options.nodes);
        },
        finished);
    std::vector<SolvedStack> all;
    for (std::optional<SolvedStack>& one : solved) all.push_back(std::move(*one));
    return all;
}

std::string describe(const Material& material) {
    constexpr const char* names[] = {"red: ", "; green: ", "; blue: "};
    std::string text = material.title.empty() ? "" : material.title + ". ";
    for (std::size_t c = 0; c < material.colours.size(); ++c)
        text += (material.colours.size() == 1 ? "" : names[c]) + describe(material.colours[c]);
    return text;
}

void note_beam(const Material& material, std::vector<std::string>& notes) {
    if (material.is_opaque()) return;
    std::vector<std::string> depths;
    for (const Stack& stack : material.colours) {
        const std::string depth = shortest_text(optical_depth(stack));
        if (depths.empty() || depth != depths.back()) depths.push_back(depth);
    }
    notes.push_back(
        "the beam straight through, exp(-tau/mu) with tau = " + joined(depths) +
        ", is not in the file: a renderer adds it, or --over puts ground under the layer");
}

void note_transmission(const Material& material, std::vector<std::string>& notes) {
    if (material.is_opaque()) return;
    notes.push_back(
        "diffuse transmission is not in the file: the format holds reflection, lit from above, "
        "alone; --over puts ground under the layer");
}

MaterialFile make_material(const Material& material, MaterialFormat format,
                           const MaterialOptions& options) {
    check(material, options);
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

void write_material(const MaterialFile& file, const std::filesystem::path& path) {
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        file.write(temporary);
        if (file.json.empty()) return;
        std::filesystem::path beside = path;
        write_atomically(beside.replace_extension(".json"),
                         [&](const std::filesystem::path& to) { write_content(to, file.json); });
    });
}

}  // namespace stratus
