// `stratus info`: prints what a table holds, how accurate it is and how it was made.
#include <stratus/base/constants.h>
#include <stratus/base/half.h>
#include <stratus/base/number_text.h>
#include <stratus/scene/render.h>
#include <stratus/table/table.h>

#include "options.h"
#include "query.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct InfoOptions {
    std::string table;
    std::string picture;
    ReadOptions reading;
};

constexpr std::size_t label_width = 22;
constexpr int digits = 6;  // of numbers

std::string megabytes(double bytes) {
    char text[64];
    std::snprintf(text, sizeof text, "%.2f MB", bytes / 1e6);
    return text;
}

/// A text may list a thousand numbers; the file has all of them.
std::string shortened(const std::string& text) {
    constexpr std::size_t max_length = 240;
    return text.size() <= max_length ? text : text.substr(0, max_length) + " ...";
}

/// `label` and a text of any number of lines.
void print(const std::string& label, const std::string& text) {
    std::string head = label;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line); head.clear()) {
        head.resize(std::max(label_width, head.size() + 1), ' ');
        std::cout << head << line << '\n';
    }
}

std::string attribute(const Table& table, const std::string& name) {
    const auto found = table.attributes.find(name);
    return found == table.attributes.end() ? "" : found->second;
}

std::string described(const Axis& axis, const char* scale_name, double unit = 1,
                      const char* unit_name = "") {
    const std::vector<double>& values = axis.values;
    std::string text =
        std::to_string(values.size()) + (values.size() == 1 ? " sample" : " samples");
    text += " at " + short_number(values.front() / unit, digits);
    if (values.size() > 1) text += " to " + short_number(values.back() / unit, digits);
    if (axis.view().ends_at_infinity && values.size() > 2)
        text += " (finite to " + short_number(values[values.size() - 2] / unit, digits) + ")";
    text += unit_name;
    if (values.size() > 1) text += std::string(", ") + scale_name;
    return text;
}

std::string describe_sides(const TableView& table) {
    if (!table.has_reflection()) return "transmission";
    if (!table.has_transmission()) return "reflection";
    return "reflection, transmission";
}

std::string lower_boundary_text(const Table& table) {
    const std::string albedo = "albedo " + short_number(table.lower_boundary.albedo, digits);
    switch (table.lower_boundary.kind) {
        case LowerBoundary::Kind::surface: return "Lambert surface, " + albedo;
        case LowerBoundary::Kind::ground: return table.lower_boundary.law->text() + ", " + albedo;
        case LowerBoundary::Kind::layer:
            return "semi-infinite layer, " + albedo + ", " +
                   shortened(table.lower_boundary.phase_function.text());
        default: return "none";
    }
}

std::string describe_orders(const Table& table) {
    const std::string multiple =
        table.highest_order == 0 ? "2 and above"
        : table.highest_order == 2
            ? "2, where the series is truncated"
            : "2 to " + std::to_string(table.highest_order) + ", where the series is truncated";
    return multiple + " (lookups add order 1 in closed form)";
}

/// Bytes of samples, of `sample_size` each, and of fluxes.
double bytes_in_memory(const Table& table, std::size_t sample_size) {
    const std::size_t samples =
        table.reflection_multiple.size() + table.transmission_multiple.size();
    const std::size_t fluxes = table.plane_albedo.size() + table.diffuse_transmittance.size() +
                               table.spherical_albedo.size();
    return static_cast<double>(samples * sample_size + fluxes * sizeof(float));
}

void print_content(const Table& table, const TableView& view) {
    print("title", attribute(table, "title"));
    for (std::size_t k = 0; k < table.layers.size(); ++k) {
        const StackLayer& layer = table.layers[k];
        print("layer " + std::to_string(k + 1) + (k == 0 ? ", the top" : ""),
              "optical depth " + short_number(layer.optical_depth, digits) + ", albedo " +
                  short_number(layer.albedo, digits) + ", " +
                  shortened(layer.phase_function.text()));
    }
    if (table.is_stack()) print("the mean layer", "the table is of the stack, lit from above");
    print("phase function", shortened(table.phase_function.text()));
    print("asymmetry g", short_number(table.phase_function.asymmetry(), digits));
    for (const FamilyAxis& axis : table.family) {
        if (axis.parameter == PhaseParameter::mixture) {
            print("second phase function", shortened(table.second_phase_function.text()));
            print("asymmetry g", short_number(table.second_phase_function.asymmetry(), digits));
            print("mixture", described(axis.axis, mixture_scale_name) +
                                 ", the share of the first phase function");
        } else {
            const std::string unit = parameter_unit(axis.parameter);
            print(axis.name() + (unit == "1" ? std::string() : " (" + unit + ")"),
                  axis.is_discrete ? allowed_text(axis)
                                   : described(axis.axis, axis_scale_name(axis.axis.scale)) +
                                         ", a parameter of the phase function");
        }
    }
    print("lower boundary", lower_boundary_text(table));
    print("albedo", described(table.albedo, axis_scale_name(table.albedo.scale)));
    print("optical depth",
          described(table.optical_depth, axis_scale_name(table.optical_depth.scale)));
    print("mu_in", described(table.mu_in, axis_scale_name(table.mu_in.scale)));
    print("mu_out", described(table.mu_out, axis_scale_name(table.mu_out.scale)));
    print("azimuth",
          described(table.azimuth, axis_scale_name(table.azimuth.scale), pi / 180, " degrees"));
    print("sides", describe_sides(view));
    print("orders", describe_orders(table));
}

void print_size(const AnyTable& given, const std::string& path) {
    const Table& table = given.table();
    print("samples per side", std::to_string(table.sample_count()));
    if (given.packed() == nullptr)
        print("in memory", megabytes(bytes_in_memory(table, sizeof(float))) + " as float, " +
                               megabytes(bytes_in_memory(table, sizeof(Half))) + " as half");
    print("file", megabytes(static_cast<double>(std::filesystem::file_size(path))));
}

void print_accuracy(const Table& table) {
    print("tolerance", short_number(table.tolerance, digits));
    print("largest error",
          short_number(table.measured_error, digits) + ", relative, measured at the bake");
}

/// All attributes but the title: conventions, program version, recipes, how the table was made.
void print_attributes(const Table& table) {
    for (const auto& [name, text] : table.attributes) {
        if (name == "title" || text.empty()) continue;
        std::string label = name;
        std::replace(label.begin(), label.end(), '_', ' ');
        if (text.find('\n') == std::string::npos) {
            print(label, shortened(text));
        } else {
            std::cout << '\n' << label << '\n';
            std::istringstream lines(text);
            for (std::string line; std::getline(lines, line);) std::cout << "    " << line << '\n';
        }
    }
}

void draw_picture(const AnyTable& table, const InfoOptions& options) {
    const Portrait portrait = make_portrait(table.table(), table.view());
    write_file(options.picture,
               [&](const std::filesystem::path& temporary) { draw_portrait(portrait, temporary); });
}

void run_info(const InfoOptions& options) {
    if (!options.picture.empty())
        require_output("info", "--picture", options.picture, {options.table}, {".png"});
    const AnyTable given = read_intact_table(options.table, options.reading);
    const Table& table = given.table();
    if (!options.picture.empty()) draw_picture(given, options);
    print_content(table, given.view());
    print_size(given, options.table);
    print_accuracy(table);
    print("picture written", options.picture);
    print_attributes(table);
}

}  // namespace

void add_info(CLI::App& app) {
    auto options = std::make_shared<InfoOptions>();
    CLI::App* command = app.add_subcommand("info", "Show what a table holds and how it was made");
    add_table(*command, options->table);
    command->add_option("--picture", options->picture, "Portrait of the table to draw, .png");
    add_max_memory(*command, options->reading);
    command->footer("Example:\n  stratus info saturn_rings.h5 --picture saturn_rings.png");
    command->callback([options] { run_info(*options); });
}

}  // namespace stratus
