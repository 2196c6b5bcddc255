// The option --mixture of commands that write one mixture of a table.
#pragma once

#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>
#include <stratus/shader/shader.h>

#include "allowed.h"
#include "table_option.h"

#include <optional>
#include <string>

namespace stratus {

inline void add_mixture(CLI::App& command, std::optional<double>& mixture) {
    command
        .add_option("--mixture", mixture,
                    "Share of the first phase function, [0, 1], of a table that mixes two")
        ->check(number("in [0, 1]", [](double share) { return share >= 0 && share <= 1; }));
}

/// A table ready for lookups, at one mixture where it has several.
inline PackedTable read_at_mixture(const char* caller, const std::string& path,
                                   const ReadOptions& options, std::optional<double> mixture) {
    const auto check = [&](bool has_mixture) {
        require(has_mixture == mixture.has_value(), caller, "--mixture",
                has_mixture ? "given, in [0, 1], for " + path
                            : "left out for " + path + ", which mixes nothing",
                mixture ? shortest_text(*mixture) : "nothing");
    };
    if (!mixture) {
        PackedTable table = read_packed_table(path, options);
        check(table.view().has_family() && is_mixture(*table.view().family));
        return table;
    }
    const Table table = read_noted_table(path, options);
    check(is_mixture(table.family));
    return PackedTable(pack(table_of_share(table, *mixture)));
}

}  // namespace stratus
