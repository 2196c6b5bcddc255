// Tables that the commands read: what is to be said of a file goes to stderr.
#pragma once

#include <stratus/io/table_file.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace stratus {

inline Table read_noted_table(const std::filesystem::path& path) {
    std::vector<std::string> notes;
    Table table = read_table(path, &notes);
    for (const std::string& note : notes) std::cerr << "stratus: note: " << note << '\n';
    return table;
}

}  // namespace stratus
