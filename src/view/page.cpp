#include <stratus/view/page.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/shader/shader.h>

#include "page_parts.h"

#include <libdeflate.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <new>
#include <utility>

namespace stratus {
namespace {

std::string base64(const char* data, std::size_t size) {
    constexpr const char* letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((size + 2) / 3 * 4);
    for (std::size_t first = 0; first < size; first += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k)
            three =
                three << 8 | (first + k < size ? static_cast<unsigned char>(data[first + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += first + k > size ? '=' : letters[three >> (18 - 6 * k) & 63];
    }
    return text;
}

/// Compresses for browsers' DecompressionStream("deflate").
std::string deflated(const std::vector<char>& bytes) {
    constexpr int level = 9;
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(level), libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    std::vector<char> packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
    const std::size_t size = libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                                      packed.data(), packed.size());
    return base64(packed.data(), size);
}

/// A JSON string that may stand in HTML.
std::string quoted(const std::string& text) {
    std::string all = "\"";
    for (const char letter : text) {
        const bool plain =
            (letter >= ' ' && letter != '"' && letter != '\\' && letter != '<') || letter < 0;
        constexpr const char* digits = "0123456789abcdef";
        if (plain)
            all += letter;
        else
            all += std::string("\\u00") + digits[letter >> 4] + digits[letter & 15];
    }
    return all + '"';
}

std::string object(const std::vector<std::pair<std::string, std::string>>& fields) {
    std::vector<std::string> all;
    for (const auto& [name, value] : fields) all.push_back(quoted(name) + ": " + value);
    return std::string("{").append(joined(all)).append("}");
}

std::string list(const std::vector<std::string>& values) {
    return std::string("[").append(joined(values)).append("]");
}

std::string axis(const Axis& axis) {
    std::vector<std::string> finite;
    for (const double value : axis.values)
        if (!std::isinf(value)) finite.push_back(shortest_text(value));
    return object({{"values", list(finite)},
                   {"scale", quoted(axis_scale_name(axis.scale))},
                   {"ends_at_infinity", axis.view().ends_at_infinity ? "true" : "false"}});
}

std::string attribute(const Table& table, const std::string& name) {
    const auto found = table.attributes.find(name);
    return found == table.attributes.end() ? "" : found->second;
}

/// Tells the errors that the bake measured, as far as the table has them.
std::string errors(const Table& table) {
    std::vector<std::pair<std::string, std::string>> all;
    for (const auto& [name, shown] : {std::pair("measured_error_median", "median"),
                                      std::pair("measured_error_99.9_percent", "99.9 %")}) {
        double value = 0;
        if (read_number(attribute(table, name), value) > 0)
            all.emplace_back(shown, shortest_text(value));
    }
    all.emplace_back("largest", shortest_text(table.measured_error));
    return object(all);
}

/// A text may list a thousand numbers.
std::string shortened(const std::string& text) {
    constexpr std::size_t most = 240;
    return text.size() <= most ? text : text.substr(0, most) + " ...";
}

/// Tells what light is scattered by.
std::string matter(const Table& table) {
    std::string text = "Phase function: " + shortened(table.phase_function.text());
    if (table.is_stack()) {
        std::vector<std::string> layers;
        for (const StackLayer& layer : table.layers)
            layers.push_back(shortened(layer.phase_function.text()) + " (τ " +
                             shortest_text(layer.optical_depth) + ", w " +
                             shortest_text(layer.albedo) + ")");
        text = "Layers from the top: " + joined(layers);
    }
    const LowerBoundary& below = table.lower_boundary;
    if (below.is_surface())
        text += "; below: Lambert ground of albedo " + shortest_text(below.albedo);
    if (below.law) text += "; below: " + shortened(below.law->text());
    if (below.is_layer())
        text += "; below: a deep layer, " + shortened(below.phase_function.text()) + " (w " +
                shortest_text(below.albedo) + ")";
    return text;
}

std::string facts(const Table& table, const std::vector<ShaderTexture>& textures) {
    std::vector<std::string> described;
    for (const ShaderTexture& texture : textures)
        described.push_back(object({{"name", quoted(texture.name)},
                                    {"width", std::to_string(shader_texture_width)},
                                    {"height", std::to_string(texture.height)},
                                    {"halves", texture.halves ? "true" : "false"}}));
    return object({{"title", quoted(attribute(table, "title"))},
                   {"matter", quoted(matter(table))},
                   {"is_stack", table.is_stack() ? "true" : "false"},
                   {"has_ground", table.lower_boundary.is_present() ? "true" : "false"},
                   {"tolerance", shortest_text(table.tolerance)},
                   {"errors", errors(table)},
                   {"highest_order", std::to_string(table.highest_order)},
                   {"albedo", axis(table.albedo)},
                   {"optical_depth", axis(table.optical_depth)},
                   {"mu_in", axis(table.mu_in)},
                   {"textures", list(described)}});
}

/// Diffuse transmittance over (albedo, optical depth, mu), then spherical albedo over the first two,
/// of light from below; nothing over a lower boundary.
std::string fluxes(const Table& table) {
    std::vector<float> all = table.diffuse_transmittance;
    if (table.is_stack())
        all.push_back(static_cast<float>(table.spherical_albedo_below));
    else if (!all.empty())
        all.insert(all.end(), table.spherical_albedo.begin(), table.spherical_albedo.end());
    return base64(reinterpret_cast<const char*>(all.data()), all.size() * sizeof(float));
}

void check(const Table& table, const TableView& view) {
    const auto must = [](bool holds, const char* allowed, const char* met) {
        require(holds, "view", "TABLE", allowed, met);
    };
    must(!view.has_family(), "of one phase function: table_at(), --at", "one of a family");
    must(view.has_reflection() && (view.has_transmission() || view.has_lower_boundary()),
         "of both sides", "one of one side");
    must(view.has_all_directions() &&
             (view.has_lower_boundary() || !table.diffuse_transmittance.empty()),
         "of all directions", "one of some");
    must(view.optical_depth.count > 0, "of finite optical depths", "one of infinite depth alone");
}

/// The text with each {{name}} in it replaced.
std::string filled(const std::string& text, const std::map<std::string, std::string>& parts) {
    std::string all;
    std::size_t at = 0;
    for (std::size_t open; (open = text.find("{{", at)) != std::string::npos;) {
        const std::size_t close = text.find("}}", open);
        all += text.substr(at, open - at) + parts.at(text.substr(open + 2, close - open - 2));
        at = close + 2;
    }
    return all + text.substr(at);
}

}  // namespace

std::string view_page(const PackedTable& table) {
    const Table& header = table.header();
    check(header, table.view());
    const std::vector<ShaderTexture> textures = shader_textures(table);
    std::string scripts;
    for (const ShaderTexture& texture : textures)
        scripts += "<script type=\"text/plain\" id=\"" + texture.name + "\">" +
                   deflated(texture.bytes) + "</script>\n";
    return filled(page_html, {{"style", style_css},
                              {"shader", shader_text(ShaderLanguage::glsl) + scenes_glsl},
                              {"facts", facts(header, textures)},
                              {"fluxes", fluxes(header)},
                              {"textures", scripts},
                              {"script", std::string(picture_js) + page_js}});
}

}  // namespace stratus
