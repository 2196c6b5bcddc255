// Reading a table in a command: the option --max-memory, and notes about the file on stderr.
#pragma once

#include <stratus/io/table_file.h>

#include "allowed.h"

#include <filesystem>
#include <iostream>
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

/// Reads a table and prints its notes on stderr.
inline Table read_noted_table(const std::filesystem::path& path, ReadOptions options) {
    std::vector<std::string> notes;
    options.notes = &notes;
    Table table = read_table(path, options);
    for (const std::string& note : notes) std::cerr << "stratus: note: " << note << '\n';
    return table;
}

}  // namespace stratus
