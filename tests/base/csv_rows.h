// The rows of CSV files in tests/reference.
#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

struct CsvRow {
    std::string label;  // a first field that is no number
    std::vector<double> numbers;
};

/// All rows that hold numbers, so neither comments nor the header.
///
/// Errors   std::runtime_error for a missing file or text behind a number.
inline std::vector<CsvRow> csv_rows(const std::string& name, char separator = ',') {
    std::ifstream file(STRATUS_REFERENCE_FOLDER "/" + name);
    if (!file) throw std::runtime_error("cannot read " + name);
    std::vector<CsvRow> rows;
    for (std::string line, field; std::getline(file, line);) {
        if (line[0] == '#') continue;
        CsvRow row;
        for (std::istringstream fields(line); std::getline(fields, field, separator);) {
            char* end = nullptr;
            const double number = std::strtod(field.c_str(), &end);
            if (!field.empty() && *end == 0)
                row.numbers.push_back(number);
            else if (row.numbers.empty())
                row.label = field;
            else
                throw std::runtime_error(name + ": not a number: '" + field + "'");
        }
        if (!row.numbers.empty()) rows.push_back(row);
    }
    return rows;
}
