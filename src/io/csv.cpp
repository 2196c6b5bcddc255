#include <stratus/io/csv.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include <algorithm>
#include <fstream>
#include <istream>
#include <stdexcept>
#include <string_view>

namespace stratus {
namespace {

std::string_view trimmed(std::string_view text) {
    const char* const blanks = " \t\r";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> split_at_commas(std::string_view line) {
    std::vector<std::string_view> fields;
    for (std::size_t begin = 0;;) {
        const std::size_t comma = line.find(',', begin);
        fields.push_back(trimmed(line.substr(begin, comma - begin)));
        if (comma == std::string_view::npos) return fields;
        begin = comma + 1;
    }
}

[[noreturn]] void refuse(const std::string& name, int line, const std::string& what) {
    throw std::invalid_argument("read_csv: " + name + ", line " + std::to_string(line) + ": " +
                                what);
}

std::vector<std::string> read_header(const std::vector<std::string_view>& fields,
                                     const std::string& name, int line) {
    std::vector<std::string> columns;
    for (const std::string_view field : fields) {
        const std::string column(field);
        double number;
        if (column.empty()) refuse(name, line, "a column has no name");
        if (read_number(column, number) == column.size())
            refuse(name, line, "a header naming the columns must come first, got '" + column + "'");
        if (std::find(columns.begin(), columns.end(), column) != columns.end())
            refuse(name, line, "column '" + column + "' appears twice");
        columns.push_back(column);
    }
    return columns;
}

std::vector<double> read_row(const std::vector<std::string_view>& fields, const CsvTable& table,
                             int line) {
    if (fields.size() != table.columns.size())
        refuse(table.name, line,
               "a row must have " + std::to_string(table.columns.size()) + " values, got " +
                   std::to_string(fields.size()));
    std::vector<double> row(fields.size());
    for (std::size_t c = 0; c < fields.size(); ++c)
        if (fields[c].empty() || read_number(fields[c], row[c]) != fields[c].size())
            refuse(table.name, line,
                   "column '" + table.columns[c] + "' must be a number, got '" +
                       std::string(fields[c]) + "'");
    return row;
}

}  // namespace

bool CsvTable::has_column(const std::string& wanted) const {
    return std::find(columns.begin(), columns.end(), wanted) != columns.end();
}

int CsvTable::column(const std::string& wanted) const {
    const auto found = std::find(columns.begin(), columns.end(), wanted);
    if (found != columns.end()) return static_cast<int>(found - columns.begin());
    throw std::invalid_argument("read_csv: " + name + ": column '" + wanted +
                                "' must be there, got " + joined(columns));
}

CsvTable read_csv(std::istream& stream, const std::string& name) {
    CsvTable table;
    table.name = name;
    std::string text;
    for (int line = 1; std::getline(stream, text); ++line) {
        const std::string_view byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets begin with one
        std::string_view content = trimmed(text);
        if (line == 1 && content.substr(0, 3) == byte_order_mark) content.remove_prefix(3);
        if (content.empty() || content[0] == '#') continue;
        const std::vector<std::string_view> fields = split_at_commas(content);
        if (table.columns.empty()) {
            table.columns = read_header(fields, name, line);
        } else {
            table.rows.push_back(read_row(fields, table, line));
            table.lines.push_back(line);
        }
    }
    if (stream.bad()) throw std::runtime_error("read_csv: cannot read " + name);
    if (table.columns.empty())
        throw std::invalid_argument("read_csv: " + name +
                                    ": a header naming the columns must come first, got nothing");
    return table;
}

CsvTable read_csv(const std::string& path) {
    std::ifstream stream(path);
    if (!stream) throw std::runtime_error("read_csv: cannot open " + path);
    return read_csv(stream, path);
}

}  // namespace stratus
