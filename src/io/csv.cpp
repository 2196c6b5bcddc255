#include <stratus/io/csv.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include <csv.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <istream>
#include <stdexcept>

namespace stratus {
namespace {

using Quotes = ::io::double_quote_escape<',', '"'>;
using Blanks = ::io::trim_chars<' ', '\t', '\r'>;

[[noreturn]] void refuse(const std::string& name, long line, const std::string& what) {
    throw std::invalid_argument("read_csv: " + name + ", line " + std::to_string(line) + ": " +
                                what);
}

/// The whole text, ending in a line break: without one, the library of 2016 reads beyond it.
std::string read_text(std::istream& stream, const std::string& name) {
    std::string text;
    std::getline(stream, text, '\0');
    if (stream.bad()) throw std::runtime_error("read_csv: cannot read " + name);
    if (!stream.eof())  // the library's lines are C strings
        refuse(name, 1 + std::count(text.begin(), text.end(), '\n'), "must be text, got a byte 0");
    return text + '\n';
}

/// The fields of a line, which is overwritten.
std::vector<std::string> split(char* line) {
    std::vector<std::string> fields;
    while (line != nullptr) {
        char *begin, *end;
        ::io::detail::chop_next_column<Quotes>(line, begin, end);
        Blanks::trim(begin, end);
        Quotes::unescape(begin, end);
        fields.emplace_back(begin, end);
    }
    return fields;
}

std::vector<std::string> read_header(const std::vector<std::string>& fields,
                                     const std::string& name, long line) {
    std::vector<std::string> columns;
    for (const std::string& column : fields) {
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

// The library's own numbers would not do: they are not correctly rounded, and know no infinity.
std::vector<double> read_row(const std::vector<std::string>& fields, const CsvTable& table,
                             long line) {
    if (fields.size() != table.columns.size())
        refuse(table.name, line,
               "a row must have " + std::to_string(table.columns.size()) + " values, got " +
                   std::to_string(fields.size()));
    std::vector<double> row(fields.size());
    for (std::size_t c = 0; c < fields.size(); ++c)
        if (fields[c].empty() || read_number(fields[c], row[c]) != fields[c].size())
            refuse(table.name, line,
                   "column '" + table.columns[c] + "' must be a number, got '" + fields[c] + "'");
    return row;
}

/// Adds a line, unless it is blank or a comment.
void add_line(char* content, int line, CsvTable& table) {
    content += std::strspn(content, " \t\r");
    if (*content == '\0' || *content == '#') return;
    const std::vector<std::string> fields = split(content);
    if (table.columns.empty()) {
        table.columns = read_header(fields, table.name, line);
    } else {
        table.rows.push_back(read_row(fields, table, line));
        table.lines.push_back(line);
    }
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
    const std::string text = read_text(stream, name);
    ::io::LineReader lines(name, text.data(), text.data() + text.size());
    const auto line = [&] { return static_cast<int>(lines.get_file_line()); };
    try {
        while (char* const content = lines.next_line()) add_line(content, line(), table);
    } catch (const ::io::error::escaped_string_not_closed&) {
        refuse(name, line(), "a quoted field must end in its line");
    } catch (const ::io::error::line_length_limit_exceeded&) {
        refuse(name, line(), "a line must be shorter than 16 MiB");
    }
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
