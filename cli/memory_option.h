// `--max-memory`, which every command that reads a table has.
#pragma once

#include "allowed.h"

#include <stratus/io/table_file.h>

#include <string>

namespace stratus {

inline void add_max_memory(CLI::App& command, ReadOptions& options) {
    constexpr long long mebibyte = 1 << 20;
    command
        .add_option_function<long long>(
            "--max-memory",
            [&options](const long long& size) {
                options.max_memory = static_cast<std::uintmax_t>(size * mebibyte);
            },
            "MiB that reading the table may take. Default: half of the machine's")
        ->check(whole_number(1, 1LL << 40));
}

}  // namespace stratus
