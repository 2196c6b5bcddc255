#include "options.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace stratus {
namespace {

std::string refusal(const std::string& allowed, const std::string& met) {
    return "must be " + allowed + ", got " + (met.empty() ? "nothing" : met);
}

/// Adds an option for a number of bytes, of at least `min` MiB.
void add_mebibytes(CLI::App& command, const std::string& name, std::uintmax_t& bytes, int min,
                   const std::string& help) {
    const auto set = [&bytes](const long long& mebibytes) { bytes = size(mebibytes) << 20; };
    command.add_option_function<long long>(name, set, help)->check(whole_number(min, 1LL << 40));
}

/// True when `format`, which ends in %n, reads all of `text`.
template <class... Values>
bool reads(const std::string& text, const char* format, Values*... values) {
    int read = -1;
    std::sscanf(text.c_str(), format, values..., &read);
    return read >= 0 && size(read) == text.size();
}

/// A family's first member, as an example.
std::string example_point(const FamilyAxes& family) {
    std::vector<std::string> parts;
    for (const FamilyAxis& axis : family)
        parts.push_back(std::string(axis.name()) + "=" + shortest_text(axis.axis.values.front()));
    return joined(parts, ",");
}

}  // namespace

CLI::Validator number(const std::string& allowed, const std::function<bool(double value)>& holds) {
    const auto check = [=](std::string& text) {
        double value = 0;
        const bool is_number = !text.empty() && read_number(text, value) == text.size();
        return is_number && holds(value) ? std::string() : refusal(allowed, text);
    };
    return {check, ""};
}

CLI::Validator number_in(const NumberRange& interval) {
    return number("in " + interval.text, [=](double value) { return interval.holds(value); });
}

CLI::Validator whole_number(long long min, long long max) {
    const std::string allowed =
        "a whole number in [" + std::to_string(min) + ", " + std::to_string(max) + "]";
    const auto check = [=](std::string& text) {
        long long value = 0;
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, value);
        if (read.ec != std::errc() || read.ptr != end || value < min || value > max)
            return refusal(allowed, text);
        text = std::to_string(value);  // CLI11 reads a leading zero as octal
        return std::string();
    };
    return {check, ""};
}

CLI::Validator not_empty(const std::string& allowed) {
    const auto check = [=](std::string& text) {
        return text.empty() ? refusal(allowed, text) : std::string();
    };
    return {check, ""};
}

CLI::Option* add_numbers(CLI::App& command, const std::string& name, std::vector<double>& numbers,
                         const NumberRange& interval, const std::string& help) {
    return command.add_option(name, numbers, help)->delimiter(',')->check(number_in(interval));
}

std::vector<std::string> split(const std::string& list) {
    std::vector<std::string> parts;
    std::istringstream text(list);
    for (std::string part; std::getline(text, part, ',');) parts.push_back(part);
    return parts;
}

void add_table(CLI::App& command, std::string& path) {
    command.add_option("TABLE", path, "Baked table, .h5, .exr or .stratus")->required();
}

void add_csv_output(CLI::App& command, std::string& path) {
    add_file(command, "-o,--output", path, "CSV to write. Default or -: standard output");
}

void add_quiet(CLI::App& command, bool& quiet) {
    command.add_flag("--quiet", quiet, "No progress, no notes");
}

LowerBoundary read_over(const std::string& command, const std::string& text) {
    try {
        return read_ground(text);
    } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(command + ": --over: " + error.what());
    }
}

void add_max_memory(CLI::App& command, ReadOptions& options) {
    add_mebibytes(command, "--max-memory", options.max_memory, 1,
                  "Memory for reading the table, in MiB. Default: half of the machine's");
}

void add_threads(CLI::App& command, int& threads, const std::string& more) {
    add_whole_number(command, "--threads", threads, 0, 1024,
                     "Threads; 0: one for each processor" + more)
        ->capture_default_str();
}

void add_accuracy(CLI::App& command, int& nodes, double& tolerance, bool& accept,
                  const std::string& more) {
    add_whole_number(command, "--nodes", nodes, 1, 512,
                     "Gauss nodes of the solver, [1, 512], in place of --tolerance" + more);
    command
        .add_option("--tolerance", tolerance,
                    "Relative error of R and T, or of fluxes, [1e-12, 1]: the solver chooses nodes "
                    "to meet it, and gives estimated errors")
        ->capture_default_str()
        ->check(number_in("[1e-12, 1]"))
        ->excludes("--nodes");
    command.add_flag("--accept", accept, "Go on even if 512 nodes do not meet the tolerance");
}

void add_keys(CLI::App& command, const std::string& files, Keys keys) {
    std::string text = key_columns(keys);
    text.pop_back();  // CLI11 ends the line
    command.set_version_flag("--keys", text,
                             "Print every key of " + files +
                                 " with its form, unit, range, default and meaning, and exit");
}

void add_density_and_opposition(CLI::App& command, std::string& density, std::string& opposition) {
    command
        .add_option("--density", density,
                    "Share of the volume that particles fill, [0, 1), or number=N,radius=R of the "
                    "particles, N per cubed unit of R: every order sees the depth "
                    "tau / (1 - density)")
        ->capture_default_str();
    add_text(
        command, "--opposition", opposition, "blinn or hapke",
        "How single scattering brightens towards the light: blinn or hapke, as wide as the density "
        "makes it, or hapke:width=0.05,amplitude=0.8 or one of these two. Default: not at all");
}

double parse_density(const char* command, const std::string& text) {
    double density = 0, number = 0, radius = 0;
    if (reads(text, "number=%lf,radius=%lf%n", &number, &radius))
        return volume_fraction(number, radius);
    require(reads(text, "%lf%n", &density) && density >= 0 && density < 1, command, "--density",
            "in [0, 1) or number=N,radius=R", text);
    return density;
}

Opposition parse_opposition(const char* command, const std::string& text, double density) {
    if (text.empty()) return {};
    double width = 0, amplitude = 1;
    const bool without_width =
        text == "blinn" || text == "hapke" || reads(text, "hapke:amplitude=%lf%n", &amplitude);
    if (without_width && density == 0)
        throw std::invalid_argument(std::string(command) + ": --opposition " + text +
                                    " must come with a --density above 0, got 0");
    if (text == "blinn") return Opposition::blinn();
    if (without_width) return Opposition::hapke(amplitude);
    require(reads(text, "hapke:width=%lf%n", &width) ||
                reads(text, "hapke:width=%lf,amplitude=%lf%n", &width, &amplitude),
            command, "--opposition",
            "blinn or hapke or hapke:width=H,amplitude=A or one of these two", text);
    return Opposition::hapke(amplitude, width);
}

double parameter_value(const std::string& text, PhaseParameter parameter) {
    double value = 0;
    const std::size_t end = read_number(text, value);
    const std::string unit = end > 0 ? text.substr(end) : "?";
    const bool is_length = parameter_unit(parameter) == std::string("um");
    if (unit.empty() || (is_length && unit == "um")) return value;
    return is_length && unit == "nm" ? value / 1000 : std::numeric_limits<double>::quiet_NaN();
}

FamilyPoint parse_point(const char* caller, const std::string& at, const FamilyAxes& family,
                        const std::string& path) {
    if (family.empty()) {
        require(at.empty(), caller, "--at",
                "left out for " + path + ", which is of one phase function", at);
        return {};
    }
    const std::string example = "as in " + example_point(family);
    require(!at.empty(), caller, "--at", "given for " + path + ", " + example, "nothing");
    const std::string form = "NAME=VALUE of each parameter of " + path + ", " + example;
    std::vector<double> values(family.size(), std::numeric_limits<double>::quiet_NaN());
    for (const std::string& part : split(at)) {
        const std::size_t equals = part.find('=');
        const std::string name = part.substr(0, equals);
        std::size_t axis = 0;
        while (axis < family.size() && family[axis].name() != name) ++axis;
        require(equals != std::string::npos && axis < family.size() && std::isnan(values[axis]),
                caller, "--at", form, at);
        values[axis] = parameter_value(part.substr(equals + 1), family[axis].parameter);
        require(holds(family[axis], values[axis]), caller, "--at " + name,
                allowed_text(family[axis]), part.substr(equals + 1));
    }
    for (const double value : values) require(!std::isnan(value), caller, "--at", form, at);
    return FamilyPoint(values);
}

PackedTable read_member(const char* caller, const std::string& path, const ReadOptions& options,
                        const std::string& at) {
    if (at.empty()) {
        PackedTable table = read_packed_table(path, options);
        parse_point(caller, at, table.header().family, path);
        return table;
    }
    const Table table = read_samples(path, options);
    return PackedTable(pack(table_at(table, parse_point(caller, at, table.family, path))));
}

void add_drop(CLI::App& command, std::string& names) {
    add_text(command, "--drop", names, "names of effects",
             "Effects to leave out whatever they change, even those that the scene names: "
             "NAME[,NAME]");
}

void add_width(CLI::App& command, int& width) {
    add_whole_number(command, "--width", width, 0, 16384,
                     "Pixels, instead of the scene's; 0: the scene's")
        ->capture_default_str();
}

void add_cache(CLI::App& command, CacheOptions& options) {
    command.add_flag("--no-cache", options.off, "Neither look for kept tables nor keep any");
    add_mebibytes(command, "--cache-limit", options.limit, 0,
                  "Size of all kept tables, in MiB, beyond which those longest unused are removed. "
                  "Default: 2048");
}

std::string panel_name(const SceneFile& file, std::size_t panel) {
    const std::string& title = file.panels[panel].title;
    if (!title.empty()) return shown(title);
    return file.panels.size() == 1 ? "the picture" : "panel " + std::to_string(panel + 1);
}

std::unique_ptr<TableCache> open_cache(const CacheOptions& options) {
    const fs::path folder = default_cache_folder();
    if (options.off || folder.empty()) return nullptr;
    auto cache = std::make_unique<TableCache>(folder, options.limit);
    cache->keep_droplets();
    return cache;
}

}  // namespace stratus
