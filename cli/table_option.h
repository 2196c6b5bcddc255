// Reading a table in a command; the options --max-memory and --at, which takes one member of a family:
// "radius=8,wavelength=0.55", by the names, and in the units, of a query's columns.
#pragma once

#include <stratus/io/table_file.h>
#include <stratus/phase/phase_family.h>
#include <stratus/table/packed_table.h>

#include "options.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

inline void add_max_memory(CLI::App& command, ReadOptions& options) {
    constexpr long long mebibyte = 1 << 20;
    command
        .add_option_function<long long>(
            "--max-memory",
            [&options](const long long& size) {
                options.max_memory = static_cast<std::uintmax_t>(size * mebibyte);
            },
            "Memory for reading the table, in MiB. Default: half of the machine's")
        ->check(whole_number(1, 1LL << 40));
}

inline bool is_packed(const std::filesystem::path& path) {
    return path.extension() == packed_ending;
}

/// Reads a table of any kind, and refuses a packed one that is not as it was written.
inline AnyTable read_intact_table(const std::filesystem::path& path, const ReadOptions& options) {
    AnyTable table = read_any_table(path, options);
    if (table.packed() && !table.packed()->is_intact())
        throw std::runtime_error(
            path.string() +
            ": numbers or texts are not those of its checksum; bake or pack it "
            "again");
    return table;
}

/// Reads a table with its samples; those of a packed one are evaluated.
inline Table read_samples(const std::filesystem::path& path, const ReadOptions& options) {
    if (!is_packed(path)) return read_table(path, options);
    return read_intact_table(path, options).packed()->unpacked();
}

/// Refuses a file that is neither .h5 nor .exr, before a long read finds out.
inline void require_table_ending(const char* command, const char* argument,
                                 const std::filesystem::path& path) {
    if (path.extension() == ".h5" || path.extension() == ".exr") return;
    throw std::invalid_argument(std::string(command) + ": " + argument +
                                " must end in .h5 or .exr, got " + path.string());
}

/// A table ready for lookups: a packed one mapped, another one read and packed.
inline PackedTable read_packed_table(const std::string& path, const ReadOptions& options) {
    if (is_packed(path)) return PackedTable(path);
    return PackedTable(pack(read_table(path, options)));
}

/// Returns the help of --at. Where there are several, `more` says what they are for.
std::string at_help(const std::string& more = "");

/// The point that the option names, within the family; of a table without a family, none.
///
/// Errors   std::invalid_argument for what names no member of the family, for an option that is
///          missing, "", or given to a table without a family; `path`: the table's.
FamilyPoint parse_point(const char* caller, const std::string& at,
                        const std::vector<FamilyAxis>& family, const std::string& path);

/// A number; of lengths um or nm may follow, um without it. Not-a-number where it is none.
double parameter_value(const std::string& text, PhaseParameter parameter);

/// A table ready for lookups, of one member where it has several.
PackedTable read_member(const char* caller, const std::string& path, const ReadOptions& options,
                        const std::string& at);

}  // namespace stratus
