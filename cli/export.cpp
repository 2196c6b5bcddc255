// `stratus export`: one layer or stack as a material file of another renderer.
#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/material/material.h>

#include "options.h"
#include "progress.h"

#include <cmath>

namespace stratus {
namespace {

struct ExportCommand {
    std::vector<std::string> inputs, at, over;
    std::vector<double> optical_depth, albedo;
    std::string format, output, title;
    MaterialOptions options;
    ReadOptions reading;
    bool quiet = false;
};

constexpr const char* endings[] = {".bsdf", ".bsdf", ".bsdf", ".nc", ".exr", ".safetensors"};

MaterialFormat find_format(const std::string& name) {
    const std::vector<std::string>& names = material_format_names();
    return static_cast<MaterialFormat>(std::ranges::find(names, name) - names.begin());
}

bool is_stack(const std::string& path) { return fs::path(path).extension() == ".toml"; }

/// Returns the layer of a table: its phase function (of a family that of one member) and what it lies
/// on.
Stack layer_of_table(const std::string& path, const std::string& at, const ReadOptions& reading) {
    const AnyTable given = read_intact_table(path, reading);
    const Table& table = given.table();
    const std::string name = "TABLE " + path;
    require(table.highest_order == 0, "export", name, "of all orders of scattering",
            "orders up to " + std::to_string(table.highest_order));
    require(!table.is_stack(), "export", name,
            "of one layer; a stack is exported from its .toml file", "of a stack");
    const FamilyPoint point = parse_point("export", at, table.family, path);
    return {{{table.view().at(point).chosen_phase_function(), 0, 0}}, table.lower_boundary};
}

/// The grounds of all light or of three colours. Albedos of three may stand in one text.
std::vector<LowerBoundary> read_grounds(const std::vector<std::string>& over) {
    double albedo = 0;
    const bool are_albedos = over.size() == 1 && read_number(over[0], albedo) > 0;
    const std::vector<std::string> texts = are_albedos ? split(over[0]) : over;
    require_count("export", "--over", texts.size());
    std::vector<LowerBoundary> grounds;
    for (const std::string& text : texts) grounds.push_back(read_over("export", text));
    return grounds;
}

void put_on_ground(Stack& stack, const LowerBoundary& ground, const std::string& over) {
    require(!stack.lower_boundary.is_present(), "export", "--over",
            "left out for a layer that lies on something already", over);
    require(!std::isinf(stack.layers.back().optical_depth), "export", "--over",
            "left out for a layer of infinite depth, which hides the ground", over);
    stack.lower_boundary = ground;
}

std::vector<Stack> read_inputs(const ExportCommand& command, std::vector<std::string>& notes) {
    const auto stacks = std::ranges::count_if(command.inputs, is_stack);
    require(stacks == 0 || stacks == std::ssize(command.inputs), "export", "TABLE|STACK.toml",
            "tables alone or stacks alone", joined(command.inputs));
    const auto layer_options = {std::pair{"--optical-depth", &command.optical_depth},
                                std::pair{"--albedo", &command.albedo}};
    for (const auto& [option, given] : layer_options)
        require(stacks == 0 || given->empty(), "export", option,
                "left out for a stack, which has its own", given->empty() ? 0 : given->front());
    require(stacks == 0 || command.at.empty(), "export", "--at", "left out for a stack",
            joined(command.at));
    if (stacks == 1) return read_coloured_stack(command.inputs[0], &notes);
    std::vector<Stack> read;
    for (std::size_t c = 0; c < std::max(command.inputs.size(), command.at.size()); ++c) {
        const std::string& path = of_colour(command.inputs, c);
        read.push_back(stacks ? read_stack(path, &notes)
                              : layer_of_table(path,
                                               command.at.empty() ? "" : of_colour(command.at, c),
                                               command.reading));
    }
    for (const auto& [option, given] : layer_options)
        require(stacks > 0 || !given->empty(), "export", option, "given for a table", "nothing");
    return read;
}

Material read_material(const ExportCommand& command, std::vector<std::string>& notes) {
    require_count("export", "TABLE|STACK.toml", command.inputs.size());
    require_count("export", "--optical-depth", command.optical_depth.size());
    require_count("export", "--albedo", command.albedo.size());
    require_count("export", "--at", command.at.size());
    const std::vector<LowerBoundary> grounds = read_grounds(command.over);
    const std::vector<Stack> read = read_inputs(command, notes);
    Material material;
    material.title = command.title;
    const std::size_t colours = std::max(
        {read.size(), command.optical_depth.size(), command.albedo.size(), grounds.size()});
    for (std::size_t c = 0; c < colours; ++c) {
        Stack& stack = material.colours.emplace_back(of_colour(read, c));
        if (!command.albedo.empty()) {
            stack.layers[0].albedo = of_colour(command.albedo, c);
            stack.layers[0].optical_depth = of_colour(command.optical_depth, c);
        }
        require(
            !stack.lower_boundary.is_present() || !std::isinf(stack.layers.back().optical_depth),
            "export", "--optical-depth", "finite for a layer that lies on something",
            stack.layers.back().optical_depth);
        if (!grounds.empty()) put_on_ground(stack, of_colour(grounds, c), joined(command.over));
    }
    return material;
}

void run_export(ExportCommand command) {
    const MaterialFormat format = find_format(command.format);
    require_writable("export", "--output", command.output,
                     {endings[static_cast<std::size_t>(format)]});
    const fs::path json = fs::path(command.output).replace_extension(".json");
    if (format == MaterialFormat::exr_atlas) require_writable("export", "--output", json);
    require_different_files("export", command.inputs, {command.output});

    const auto started = Clock::now();
    std::vector<std::string> notes;
    const Material material = read_material(command, notes);
    Progress progress(command.quiet);
    progress.notes(notes);
    command.options.progress = std::ref(progress);
    const MaterialFile file = make_material(material, format, command.options);
    {
        const SignalsHeld held;
        write_material(file, command.output);
    }
    progress.notes(file.notes);
    progress.note(command.output + ": " +
                  short_number(static_cast<double>(fs::file_size(command.output)) / 1e6, 3) +
                  " MB in " + short_number(seconds_since(started), 2) + " s; R and T within " +
                  short_number(file.error, 2) + " at cosines from 0.15 on, as estimated (" +
                  std::to_string(file.nodes) + " nodes)");
}

void add_layer_options(CLI::App& app, ExportCommand& command) {
    add_file(
        app, "TABLE|STACK.toml", command.inputs,
        "Table (.h5, .exr, .stratus), of which phase function and ground are taken, or a stack "
        "with layers of its own (.toml, as for `stratus solve --layers`). Three, if "
        "red, green and blue differ")
        ->required();
    add_numbers(app, "--optical-depth", command.optical_depth, "[0, inf]",
                "Vertical optical depth of a table's layer, [0, inf]; one, or three with commas");
    add_numbers(app, "--albedo", command.albedo, "[0, 1]",
                "Its single-scattering albedo, [0, 1]; one, or three with commas");
    add_at(app, command.at, ". Given three times, it is of red, green and blue")
        ->allow_extra_args(false);  // or it would take TABLE too
    app.add_option("--over", command.over,
                   "The ground to put it on: albedo of a Lambert surface, [0, 1], one, or three "
                   "with commas, or\n" +
                       ground_help() + "\nGiven three times, it is of red, green and blue")
        ->type_name("GROUND")
        ->allow_extra_args(false);
}

}  // namespace

void add_export(CLI::App& app) {
    const auto [command, options] = add_command<ExportCommand>(
        app, "export", "Write a layer or stack as a material of other renderers", run_export);
    command.description(
        "Write a layer or stack as a material of other renderers.\n\nThe layer is solved again, at "
        "the directions that the format samples: of a table only the phase function and the ground "
        "are taken, and any depth and albedo may be asked. The beam straight through, "
        "exp(-tau/mu), "
        "is in no file.");
    add_layer_options(command, options);
    command
        .add_option("--format", options.format,
                    "fourier (.bsdf, SCATFUN: reflection and transmission)\n"
                    "tensor (.bsdf, spectral), tensor-rgb (.bsdf): reflection\n"
                    "netcdf (.nc, Eradiate's mqdiffuse): reflection, one colour\n"
                    "exr-atlas (.exr and .json, for shaders): reflection and transmission\n"
                    "slice (.safetensors, arrays for any program): reflection and transmission")
        ->required()
        ->check(CLI::IsMember(material_format_names()));
    add_file(command, "-o,--output", options.output, "File to write")->required();
    command.add_option("--title", options.title, "Text kept in the file");
    add_accuracy(command, options.options.nodes, options.options.tolerance, options.options.accept);
    add_threads(command, options.options.threads);
    add_max_memory(command, options.reading);
    add_quiet(command, options.quiet);
    command.footer(
        "Examples:\n"
        "  stratus export baked/saturn_rings.stratus --optical-depth 1.5 --albedo 0.95,0.93,0.8 "
        "\\\n"
        "    --format fourier -o rings.bsdf\n"
        "  stratus export baked/stratus_cloud.stratus --optical-depth 8 --albedo 1 --over 0.3 \\\n"
        "    --format tensor -o cloud_over_ground.bsdf\n"
        "  stratus export baked/rayleigh_haze.stratus --optical-depth 0.1 --albedo 1 \\\n"
        "    --over ocean:wind=5 --format exr-atlas -o sea.exr\n"
        "  stratus export stratus_clouds.h5 --at radius=8,wavelength=0.65 \\\n"
        "    --at radius=8,wavelength=0.55 --at radius=8,wavelength=0.45 --optical-depth 8 \\\n"
        "    --albedo 1 --format fourier -o cloud.bsdf\n"
        "  stratus export tables/stacks/haze_over_ground.toml --format netcdf -o haze.nc");
}

}  // namespace stratus
