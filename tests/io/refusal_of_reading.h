// What reading a table file is refused with.
#pragma once

#include <stratus/io/table_file.h>

#include "refusal.h"

#include <filesystem>
#include <stdexcept>
#include <string>

namespace stratus::test {

inline std::string refusal_of_reading(const std::filesystem::path& path) {
    return refusal<std::runtime_error>([&] { read_table(path); });
}

}  // namespace stratus::test
