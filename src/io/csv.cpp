#include <stratus/io/csv.h>

#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>

#include <csv.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <istream>
#include <limits>
#include <stdexcept>
#include <unordered_set>

namespace stratus {
namespace {

using Quotes = ::io::double_quote_escape<',', '"'>;
using Blanks = ::io::trim_chars<' ', '\t', '\r'>;

[[noreturn]] void refuse(const std::string& name, int line, const std::string& what) {
    throw std::invalid_argument(name + ", line " + std::to_string(line) + ": " + what);
}

/// The fields of a line, which is overwritten.
std::vector<std::string> split(std::string& text, const std::string& name, int line) {
    if (text.find('\0') != std::string::npos)  // the library's lines are C strings
        refuse(name, line, "must be text, got a byte 0");
    std::vector<std::string> fields;
    try {
        for (char *left = text.data(), *begin, *end; left != nullptr;) {
            ::io::detail::chop_next_column<Quotes>(left, begin, end);
            Blanks::trim(begin, end);
            Quotes::unescape(begin, end);
            fields.emplace_back(begin, end);
        }
    } catch (const ::io::error::escaped_string_not_closed&) {
        refuse(name, line, "a quoted field must end in its line");
    }
    return fields;
}

void check_header(const std::vector<std::string>& fields, const std::string& name, int line) {
    std::unordered_set<std::string> met;
    for (const std::string& column : fields) {
        double number;
        if (column.empty()) refuse(name, line, "a column has no name");
        if (read_number(column, number) == column.size())
            refuse(name, line,
                   "a header naming the columns must come first, got '" + shown(column) + "'");
        if (!met.insert(column).second)
            refuse(name, line, "column '" + shown(column) + "' appears twice");
    }
}

// The library's own numbers would not do: they are not correctly rounded, and know no infinity.
std::vector<double> read_row(const CsvTable& table, const std::vector<std::string>& fields,
                             const std::vector<CsvWords>& words, int line) {
    std::vector<double> row(fields.size());
    for (std::size_t c = 0; c < fields.size(); ++c) {
        const std::string& column = table.columns[c];
        const auto of = std::ranges::find(words, column, &CsvWords::column);
        if (of != words.end()) {
            const auto word = std::ranges::find(of->words, fields[c]);
            if (word == of->words.end())
                refuse(table.name, line,
                       "column '" + column + "' must be one of " + joined(of->words) + ", got '" +
                           shown(fields[c]) + "'");
            row[c] = static_cast<double>(word - of->words.begin());
        } else if (fields[c].empty() || read_number(fields[c], row[c]) != fields[c].size()) {
            refuse(
                table.name, line,
                "column '" + shown(column) + "' must be a number, got '" + shown(fields[c]) + "'");
        }
    }
    return row;
}

/// Reads all lines, rows by read(table so far, fields, line). Together they have at most `max_bytes`.
template <class Field, class Read>
CsvRows<Field> read_lines(std::istream& stream, const std::string& name, std::uint64_t max_bytes,
                          const Read& read) {
    CsvRows<Field> table;
    table.name = name;
    std::string text;
    std::uint64_t bytes = 0;
    for (int line = 1; read_line(stream, text); ++line) {
        if (text.size() > max_text)
            refuse(table.name, line, "must have at most " + std::to_string(max_text) + " bytes");
        bytes += text.size() + 1;
        if (bytes > max_bytes)
            refuse(table.name, line,
                   "all but a regular file given by its name must have at most " +
                       std::to_string(max_bytes) + " bytes, got more");
        const char* const byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets begin with one
        if (line == 1 && text.compare(0, 3, byte_order_mark) == 0) text.erase(0, 3);
        const std::size_t first = text.find_first_not_of(" \t\r");
        if (first == std::string::npos || text[first] == '#') continue;
        const std::vector<std::string> fields = split(text, table.name, line);
        if (table.columns.empty()) {
            check_header(fields, table.name, line);
            table.columns = fields;
            continue;
        }
        if (fields.size() != table.columns.size())
            refuse(table.name, line,
                   "a row must have " + std::to_string(table.columns.size()) + " values, got " +
                       std::to_string(fields.size()));
        table.rows.push_back(read(table, fields, line));
        table.lines.push_back(line);
    }
    if (stream.bad()) throw std::runtime_error(table.name + ": cannot be read");
    if (table.columns.empty())
        throw std::invalid_argument(table.name +
                                    ": a header naming the columns must come first, got nothing");
    return table;
}

auto row_reader(const std::vector<CsvWords>& words) {
    return [&](const CsvTable& table, const std::vector<std::string>& fields, int line) {
        return read_row(table, fields, words, line);
    };
}

/// Reads a whole file.
template <class Field, class Read>
CsvRows<Field> read_file(const std::string& path, const Read& read) {
    std::ifstream stream(path);
    if (!stream) throw std::runtime_error(path + ": cannot be opened");
    constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();
    return read_lines<Field>(stream, path, fs::is_regular_file(path) ? unlimited : max_text, read);
}

}  // namespace

bool CsvColumns::has_column(const std::string& wanted) const { return is_listed(wanted, columns); }

int CsvColumns::column(const std::string& wanted) const {
    const auto found = std::ranges::find(columns, wanted);
    if (found != columns.end()) return static_cast<int>(found - columns.begin());
    throw std::invalid_argument(name + ": column '" + wanted + "' must be there, got " +
                                shown(joined(columns)));
}

CsvTable read_csv(std::istream& stream, const std::string& name,
                  const std::vector<CsvWords>& words) {
    return read_lines<double>(stream, name, max_text, row_reader(words));
}

CsvTable read_csv(const std::string& path, const std::vector<CsvWords>& words) {
    return read_file<double>(path, row_reader(words));
}

CsvTexts read_csv_texts(const std::string& path) {
    return read_file<std::string>(
        path, [](const CsvTexts&, const std::vector<std::string>& fields, int) { return fields; });
}

}  // namespace stratus
