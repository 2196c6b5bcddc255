// Comma-separated numbers with a header line: what phase tables, moment lists and queries come in.
//
// Lines that are empty or start with '#' are skipped; columns may stand in any order; numbers are
// decimal, `inf` allowed; fields may be quoted.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

namespace stratus {

struct CsvColumns {
    std::string name;  // of the file
    std::vector<std::string> columns;

    /// Index of a column; std::invalid_argument naming the columns present when there is none of
    /// that name.
    int column(const std::string& wanted) const;
    bool has_column(const std::string& wanted) const;
};

/// A file: `rows[r][c]` belongs to `columns[c]` and stood in line `lines[r]` (from 1).
template <class Field>
struct CsvRows : CsvColumns {
    std::vector<std::vector<Field>> rows;
    std::vector<int> lines;
};

using CsvTable = CsvRows<double>;
using CsvTexts = CsvRows<std::string>;  // for files that hold more than numbers

/// A column of words rather than numbers; the value of a field is the place of its word.
struct CsvWords {
    std::string column;
    std::vector<std::string> words;
};

/// Reads a whole file; a line, and all that comes from elsewhere than a regular file, must have at
/// most 64 MiB.
///
/// Errors   std::runtime_error when the file cannot be opened; std::invalid_argument, naming file,
///          line and text, for a row that is too short, too long or not a number (or not one of a
///          column's words), and for a missing header.
CsvTable read_csv(const std::string& path, const std::vector<CsvWords>& words = {});

/// Reads from a stream of at most 64 MiB; `name` stands for the file in messages.
CsvTable read_csv(std::istream& stream, const std::string& name,
                  const std::vector<CsvWords>& words = {});

/// A whole file of texts, refused as above but for what its fields say.
CsvTexts read_csv_texts(const std::string& path);

}  // namespace stratus
