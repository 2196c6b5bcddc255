#include <stratus/io/phase_file.h>

#include <stratus/io/csv.h>

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace stratus {
namespace {

/// The column of a name, or of either of "one or other".
int find_column(const CsvTable& file, const std::string& wanted) {
    constexpr std::string_view between = " or ";
    const std::size_t gap = wanted.find(between);
    if (gap == wanted.npos) return file.column(wanted);
    const std::string one = wanted.substr(0, gap), other = wanted.substr(gap + between.size());
    if (file.has_column(one) && file.has_column(other))
        throw std::invalid_argument(file.name + ": columns must be " + wanted + ", got both");
    return file.column(file.has_column(other) ? other : one);
}

PhaseColumns find_columns(const CsvTable& file, const std::vector<std::string>& wanted) {
    PhaseColumns columns;
    columns.name = file.name;
    for (const std::string& column : wanted) {
        const auto at = static_cast<std::size_t>(find_column(file, column));
        columns.names.push_back(file.columns[at]);
        std::vector<double>& values = columns.values.emplace_back();
        for (const std::vector<double>& row : file.rows) values.push_back(row[at]);
    }
    columns.row_name = [name = file.name, lines = file.lines](std::size_t row) {
        return " (" + name + ", line " + std::to_string(lines[row]) + ")";
    };
    return columns;
}

}  // namespace

PhaseFunction read_phase_function(const std::string& text, const std::string& directory,
                                  std::vector<std::string>* notes) {
    return parse_phase_function(
        text, notes, [&](const std::string& file, const std::vector<std::string>& columns) {
            return find_columns(read_csv((std::filesystem::path(directory) / file).string()),
                                columns);
        });
}

}  // namespace stratus
