// `stratus shader` and `stratus view`: a table for graphics programs, its lookup as shader code with the textures that it reads, and as a web page.
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/image.h>
#include <stratus/shader/shader.h>
#include <stratus/view/page.h>

#include "options.h"
#include "progress.h"

namespace stratus {
namespace {

struct ShaderOptions {
    std::string input, language, folder, at;
    std::vector<double> optical_depth, albedo;
    ReadOptions reading;
    bool filtered = false, quiet = false;
};

struct OutputFile {
    std::string name;
    std::function<void(const fs::path& path)> write;
};

OutputFile text_file(const std::string& name, const std::string& text) {
    return {name, [text](const fs::path& path) { write_content(path, text); }};
}

/// Raw numbers, or for OSL, whose texture() reads pictures, OpenEXR.
OutputFile texture_file(const ShaderTexture& texture, bool as_exr) {
    return {texture.name + (as_exr ? ".exr" : ".bin"), [&texture, as_exr](const fs::path& path) {
                if (as_exr) {
                    write_exr_texels(texture.bytes.data(), shader_texture_width, texture.height,
                                     texture.halves, path);
                    return;
                }
                write_content(path, {texture.bytes.data(), texture.bytes.size()});
            }};
}

std::string textures_json(const PackedTable& table, const std::vector<ShaderTexture>& textures) {
    const TableView view = table.view();
    std::ostringstream json;
    json << std::boolalpha
         << "{\n  \"format\": \"stratus-shader\",\n  \"version\": 1,\n  \"optical_depth\": ["
         << shortest_text(view.optical_depth.lowest) << ", "
         << (view.optical_depth.ends_at_infinity ? "null"
                                                 : shortest_text(view.optical_depth.highest))
         << "],\n  \"albedo\": [" << shortest_text(view.albedo.lowest) << ", "
         << shortest_text(view.albedo.highest) << "],\n  \"reflection\": " << view.has_reflection()
         << ",\n  \"transmission\": " << view.has_transmission()
         << ",\n  \"layers\": " << (view.is_stack() ? view.layers->size() : 1)
         << ",\n  \"lit_from_below\": " << !(view.is_stack() || view.has_lower_boundary())
         << ",\n  \"path_law\": " << (view.path_law != nullptr)
         << ",\n  \"tolerance\": " << shortest_text(view.tolerance) << ",\n  \"textures\": [";
    for (const ShaderTexture& texture : textures)
        json << (&texture == &textures.front() ? "\n" : ",\n") << "    {\"name\": \""
             << texture.name << "\", \"file\": \"" << texture.name
             << ".bin\", \"width\": " << texture.width << ", \"height\": " << texture.height
             << (texture.depth > 0 ? ", \"depth\": " + std::to_string(texture.depth) : "")
             << ", \"channels\": 4, \"type\": \"" << (texture.halves ? "float16" : "float32")
             << "\"}";
    json << "\n  ]\n}\n";
    return json.str();
}

/// Heights and files of the textures, for OSL.
std::string textures_header(const std::vector<ShaderTexture>& textures) {
    std::string text = "// Textures of stratus.osl.h; define these yourself if the files move.\n";
    for (const ShaderTexture& texture : textures) {
        std::string name = texture.name;
        std::ranges::transform(name, name.begin(), [](unsigned char letter) {
            return static_cast<char>(std::toupper(letter));
        });
        const std::string of_layer = texture.name == "stratus_layer" ? "_FILE" : "";
        text += "#define " + name + of_layer + " \"" + texture.name + ".exr\"\n#define " + name +
                "_HEIGHT " + std::to_string(texture.height) + "\n";
    }
    return text;
}

/// The bound medium: one layer for all colours, or one for each, or a stack. None: nothing is bound.
std::optional<Medium<3>> make_medium(const TableView& table, std::vector<double> optical_depth,
                                     std::vector<double> albedo) {
    if (table.is_stack() && albedo.empty()) {
        const AxisView& depth = table.optical_depth;
        optical_depth = {depth.count > 0 ? depth.lowest : infinity};
        albedo = {table.albedo.lowest};
    }
    if (albedo.empty()) return {};
    Medium<3> medium{};
    for (std::size_t c = 0; c < 3; ++c) {
        medium.optical_depth[c] = of_colour(optical_depth, c);
        medium.albedo[c] = of_colour(albedo, c);
    }
    return medium;
}

void check_layer(const ShaderOptions& options) {
    require_count("shader", "--optical-depth", options.optical_depth.size());
    require_count("shader", "--albedo", options.albedo.size());
    require(options.optical_depth.empty() == options.albedo.empty(), "shader",
            "--optical-depth and --albedo", "both given or both left out",
            options.albedo.empty() ? "--optical-depth" : "--albedo");
}

void run_shader(const ShaderOptions& options) {
    check_layer(options);
    const std::vector<std::string>& names = shader_language_names();
    const auto language =
        static_cast<ShaderLanguage>(std::ranges::find(names, options.language) - names.begin());
    const bool osl = language == ShaderLanguage::osl, cpp = language == ShaderLanguage::cpp;
    require(!cpp || options.albedo.empty(), "shader", "--albedo and --optical-depth",
            "left out for cpp, whose class Layer binds any", "both");
    const PackedTable table = read_member("shader", options.input, options.reading, options.at);
    std::vector<ShaderTexture> textures;
    const auto medium = make_medium(table.view(), options.optical_depth, options.albedo);
    std::optional<FilteredLight> filtered;
    if (options.filtered) {
        filtered = medium ? filtered_layer(table, *medium) : filtered_layers(table);
        textures = filtered->textures;
    } else if (!cpp) {
        textures = shader_textures(table);
        if (medium) textures.push_back(shader_layer(table, *medium));
    }

    std::vector<OutputFile> files{
        text_file(cpp   ? "stratus_lookup.h"
                  : osl ? "stratus.osl.h"
                        : "stratus." + options.language,
                  shader_text(language, filtered ? &*filtered : nullptr)),
        cpp   ? text_file("table.stratus", std::string(table.file()))
        : osl ? text_file("stratus_textures.h", textures_header(textures))
              : text_file("stratus_textures.json", textures_json(table, textures))};
    for (const ShaderTexture& texture : textures) files.push_back(texture_file(texture, osl));
    fs::create_directories(options.folder);
    double bytes = 0;
    for (const OutputFile& file : files) {
        const fs::path path = fs::path(options.folder) / file.name;
        write_file(path, file.write);
        bytes += static_cast<double>(fs::file_size(path));
    }
    if (options.quiet) return;
    say(options.folder + ": " + std::to_string(files.size()) + " files, " +
        short_number(bytes / 1e6, 3) + " MB");
    if (!filtered) return;
    const ShaderTexture& light = filtered->light();
    say(formatted(
        "%s: %d x %d x %d texels; R and T are off by %.2g of them in the median, %.2g for "
        "all but one in a thousand, %.2g at most, at 5000 random directions",
        light.name.c_str(), light.width, light.height, light.depth, filtered->median_error,
        filtered->usual_error, filtered->worst_error));
}

}  // namespace

void add_shader(CLI::App& app) {
    const auto [command, options] = add_command<ShaderOptions>(
        app, "shader", "Write a table's lookup as shader code, with its textures", run_shader);
    add_file(command, "TABLE", options.input, "Packed table (.stratus), or one to be packed")
        ->required();
    command
        .add_option("--language", options.language,
                    "glsl (ES 3.00, 4.50), hlsl, osl, or cpp (C++17)")
        ->required()
        ->check(CLI::IsMember(shader_language_names()));
    add_text(command, "-o,--output", options.folder, "the name of a folder",
             "Folder to write into; made if missing")
        ->required();
    add_numbers(command, "--optical-depth", options.optical_depth, "[0, inf]",
                "Also bind one layer, of this depth, [0, inf]; one, or three with commas");
    add_numbers(command, "--albedo", options.albedo, "[0, 1]",
                "The layer's single-scattering albedo, [0, 1]; one, or three with commas");
    command.add_flag("--filtered", options.filtered,
                     "For games: orders n >= 2 from textures that the GPU filters, by 4 fetches "
                     "of the bound layer, 27 to 32 of layers that are not bound; glsl and hlsl");
    add_at(command, options.at);
    command.add_flag("--quiet", options.quiet, "No notes, no report of the size");
    add_max_memory(command, options.reading);
    command.footer(
        "The text, stratus.glsl, stratus.hlsl or stratus.osl.h, is the same for all tables; the\n"
        "textures are the table. --language cpp writes stratus_lookup.h, which needs nothing but "
        "the table:\n"
        "table.stratus beside it, of a family the member --at.\n\n"
        "A bound layer is one more texture, stratus_layer, with which directions can be sampled; a "
        "stack always\nhas it. --filtered writes stratus_light, a 3-D texture, in place of "
        "stratus_functions, and stratus_weights\nwhere no layer is bound, with "
        "stratus_path_functions; stratus_path_law for narrow peaks.\n\n"
        "Examples:\n  stratus shader saturn_rings.stratus --language glsl -o rings\n"
        "  stratus shader saturn_rings.stratus --language hlsl --optical-depth 1.5 \\\n"
        "    --albedo 0.95,0.93,0.8 -o rings");
}

namespace {

struct ViewOptions {
    std::string table, output, at;
    ReadOptions reading;
    bool quiet = false;
};

void run_view(const ViewOptions& options) {
    require_output("view", "--output", options.output, {options.table}, {".html"});
    const std::string page =
        view_page(read_member("view", options.table, options.reading, options.at));
    write_content_held(options.output, page);
    if (!options.quiet)
        say(options.output + ": " + short_number(static_cast<double>(page.size()) / 1e6, 3) +
            " MB");
}

}  // namespace

void add_view(CLI::App& app) {
    const auto [command, options] = add_command<ViewOptions>(
        app, "view", "Write a web page on which to look at a table", run_view);
    command.add_option("TABLE", options.table, "Table, .stratus, .h5 or .exr")->required();
    command.add_option("-o,--output", options.output, "File to write, .html")->required();
    add_at(command, options.at);
    command.add_flag("--quiet", options.quiet, "Do not report the size");
    add_max_memory(command, options.reading);
    command.footer(
        "The page is one file, needs no network, and draws by WebGL2: a lit sphere, rings, a slab "
        "over ground, and\n"
        "lobes, light scattered once beside all orders; of what can be lit from above alone, no "
        "rings. Tables\nmust be of both sides and all directions.\n\n"
        "Example:\n  stratus view saturn_rings.stratus -o saturn_rings.html");
}

}  // namespace stratus
