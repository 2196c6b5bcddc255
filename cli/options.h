// The subcommands; options that several of them have, the tables and caches that these name, and validators, which
// refuse in the house form: option, allowed range, value met.
//
// CLI11 alone would read an empty value as zero and 010 as eight.
#pragma once

#include <stratus/base/argument.h>
#include <stratus/scene/scene.h>
#include <stratus/scene/table_cache.h>
#include <stratus/table/member_and_ground.h>

#include "query.h"

#include <CLI/CLI.hpp>

namespace stratus {

// The subcommands, a file each but for convert, pack and seal, and for shader and view. Each function registers a command with its options and callback.

using AddCommand = void(CLI::App& app);

AddCommand add_solve, add_bake, add_eval, add_info, add_verify, add_convert, add_pack, add_seal,
    add_export, add_shader, add_fit, add_cost, add_phase, add_plan, add_render, add_view;

/// A number for which `holds` is true; never nan. `allowed` names its range: "above 0".
CLI::Validator number(const std::string& allowed, const std::function<bool(double value)>& holds);

/// A number in an interval such as "[0, 1)".
CLI::Validator number_in(const NumberRange& interval);

/// A decimal whole number in [min, max].
CLI::Validator whole_number(long long min, long long max);

/// Anything but the empty text that a script passes when its variable is unset. `allowed` names what is meant.
CLI::Validator not_empty(const std::string& allowed);

/// Registers a command, which calls `run` with its options once these are parsed. Returns the command and the options.
template <class Options, class Run>
std::pair<CLI::App&, Options&> add_command(CLI::App& app, const std::string& name,
                                           const std::string& description, Run run) {
    const auto options = std::make_shared<Options>();
    CLI::App* const command = app.add_subcommand(name, description);
    command->callback([=] { run(*options); });
    return {*command, *options};
}

/// Adds an argument or an option for a text, or several, which `allowed` names: "a phase function".
template <class Texts>
CLI::Option* add_text(CLI::App& command, const std::string& name, Texts& texts,
                      const std::string& allowed, const std::string& help) {
    return command.add_option(name, texts, help)->check(not_empty(allowed));
}

/// Adds an argument or an option that names a file, or several.
template <class Paths>
CLI::Option* add_file(CLI::App& command, const std::string& name, Paths& paths,
                      const std::string& help) {
    return add_text(command, name, paths, "the name of a file", help);
}

/// Adds an option for a whole number in [min, max].
template <class Number>
CLI::Option* add_whole_number(CLI::App& command, const std::string& name, Number& value,
                              long long min, long long max, const std::string& help) {
    return command.add_option(name, value, help)->check(whole_number(min, max));
}

/// Adds an option for numbers in an interval, comma between.
CLI::Option* add_numbers(CLI::App& command, const std::string& name, std::vector<double>& numbers,
                         const NumberRange& interval, const std::string& help);

/// The parts of a comma-separated list.
std::vector<std::string> split(const std::string& list);

/// Adds the table that a command reads.
void add_table(CLI::App& command, std::string& path);

/// Adds the option --output of commands that answer in CSV.
void add_csv_output(CLI::App& command, std::string& path);

/// Adds the flag --quiet of commands that show progress and notes.
void add_quiet(CLI::App& command, bool& quiet);
/// The ground of the option --over of a command, which refusals name.
LowerBoundary read_over(const std::string& command, const std::string& text);

/// Adds the option --threads; `more` ends its help.
void add_threads(CLI::App& command, int& threads, const std::string& more = "");

/// Adds --nodes or --tolerance of the solver, and --accept; `more` ends the help of --nodes.
void add_accuracy(CLI::App& command, int& nodes, double& tolerance, bool& accept,
                  const std::string& more = "");

/// Adds the option --keys, which prints a file's keys and ends the program.
void add_keys(CLI::App& command, const std::string& files, Keys keys);

/// Adds the options --density and --opposition of commands that look at layers.
void add_density_and_opposition(CLI::App& command, std::string& density, std::string& opposition);

/// A share of the volume, or `number=N,radius=R` of the particles that fill it.
///
/// Errors   std::invalid_argument naming the command.
double parse_density(const char* command, const std::string& text);

/// `blinn`, or `hapke` and what it is given of `width=H` and `amplitude=A`; the rest follows from
/// the density.
///
/// Errors   std::invalid_argument naming the command.
Opposition parse_opposition(const char* command, const std::string& text, double density);

// Reading a table in a command; the options --max-memory and --at, which takes one member of a family:
// "radius=8,wavelength=0.55", by the names, and in the units, of a query's columns.

void add_max_memory(CLI::App& command, ReadOptions& options);

inline bool is_packed(const fs::path& path) { return path.extension() == packed_ending; }

/// Reads a table of any kind, and refuses a packed one that is not as it was written.
inline AnyTable read_intact_table(const fs::path& path, const ReadOptions& options) {
    AnyTable table = read_any_table(path, options);
    if (table.packed() && !table.packed()->is_intact())
        throw std::runtime_error(
            path.string() +
            ": numbers or texts are not those of its checksum; bake or pack it "
            "again");
    return table;
}

/// Reads a table with its samples; those of a packed one are evaluated.
inline Table read_samples(const fs::path& path, const ReadOptions& options) {
    if (!is_packed(path)) return read_table(path, options);
    return read_intact_table(path, options).packed()->unpacked();
}

/// Refuses a file that is neither .h5 nor .exr, before a long read finds out.
inline void require_table_ending(const char* command, const char* argument, const fs::path& path) {
    if (path.extension() == ".h5" || path.extension() == ".exr") return;
    throw std::invalid_argument(std::string(command) + ": " + argument +
                                " must end in .h5 or .exr, got " + path.string());
}

/// A table ready for lookups: a packed one mapped, another one read and packed.
inline PackedTable read_packed_table(const std::string& path, const ReadOptions& options) {
    if (is_packed(path)) return PackedTable(path);
    return PackedTable(pack(read_table(path, options)));
}

/// Adds --at. Where there are several, `more` says what they are for.
template <class Texts>
CLI::Option* add_at(CLI::App& command, Texts& at, const std::string& more = "") {
    return add_text(command, "--at", at, "a member, such as radius=8,wavelength=0.55",
                    "Member of a table's family, such as radius=8,wavelength=0.55: all parameters "
                    "that the table varies (g, variance, mixture; radius and wavelength in um)" +
                        more);
}

/// The point that the option names, within the family; of a table without a family, none.
///
/// Errors   std::invalid_argument for what names no member of the family, for an option that is
///          missing, "", or given to a table without a family; `path`: the table's.
FamilyPoint parse_point(const char* caller, const std::string& at, const FamilyAxes& family,
                        const std::string& path);

/// A number; of lengths um or nm may follow, um without it. Not-a-number where it is none.
double parameter_value(const std::string& text, PhaseParameter parameter);

/// A table ready for lookups, of one member where it has several.
PackedTable read_member(const char* caller, const std::string& path, const ReadOptions& options,
                        const std::string& at);

// Options that are given once, or once for each of red, green and blue.

inline void require_count(const char* command, const char* option, std::size_t count) {
    require(count <= 1 || count == 3, command, option, "one, or three for red, green and blue",
            count);
}

/// The value of a colour in a list of one or three.
template <class Value>
const Value& of_colour(const std::vector<Value>& values, std::size_t colour) {
    return values.size() == 1 ? values[0] : values[colour];
}

// Options that the commands on scenes share: --drop, --width, and the cache of tables.

struct CacheOptions {
    bool off = false;
    std::uintmax_t limit = default_cache_limit;
};

void add_drop(CLI::App& command, std::string& names);
void add_width(CLI::App& command, int& width);
void add_cache(CLI::App& command, CacheOptions& options);

/// Returns the name that messages give a panel: its title, or its number.
std::string panel_name(const SceneFile& file, std::size_t panel);

/// Null where it is switched off or no folder is known. It keeps the scattering of droplets, too: it is
/// opened before a scene is read.
std::unique_ptr<TableCache> open_cache(const CacheOptions& options);

}  // namespace stratus
