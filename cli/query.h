// Queries and answers as CSV, for the commands that evaluate geometries.
//
// A query names directions by the columns mu_in, mu_out, azimuth_deg or, as observers do, by
// incidence_deg, emission_deg, phase_deg (direction.h); queries of tables also have optical_depth,
// albedo and the parameters of families. The range of each is checked here row by row. Answers go to
// stdout or, atomically, to a file.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/csv.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stratus {

namespace fs = std::filesystem;

/// The direction of a row, and the only side that it asks for, where it asks for one.
struct RowDirection {
    Geometry geometry;
    std::optional<Side> side{};
};

/// A row's numbers by the names of their columns.
class Row {
  public:
    Row(const CsvTable& rows, std::size_t r) : rows_(rows), r_(r) {}

    bool has(const std::string& column) const { return rows_.has_column(column); }
    double operator[](const std::string& column) const {
        return rows_.rows[r_][size(rows_.column(column))];
    }
    /// "FILE, line 7", for refusals.
    std::string place() const { return rows_.name + ", line " + std::to_string(rows_.lines[r_]); }

  private:
    const CsvTable& rows_;
    std::size_t r_;
};

struct Query {
    CsvTable table;
    std::vector<RowDirection> directions;  // of each row

    Row row(std::size_t r) const { return {table, r}; }
};

/// Help of `--query` on the columns that name directions.
inline const std::string direction_columns_help =
    "mu_in, mu_out, azimuth_deg, or in place of these incidence_deg, emission_deg, phase_deg";
inline const std::string observed_angles_help =
    "phase_deg is 180 degrees less the scattering angle; emission_deg beyond 90 is the unlit "
    "side. ";

/// Reads a query, every value in its range; `path` "" or "-" is standard input. Rows with an emission
/// angle ask for the side that it is on, others for both. `required` and `optional` are columns beside
/// those that name directions.
///
/// Errors   std::invalid_argument for a value outside its range (naming line, column, range and
///          value), for a missing column and for one that is not allowed.
Query read_query(const std::string& path, const std::vector<std::string>& required,
                 const std::vector<std::string>& optional = {});

/// Reads observations likewise. Their side is that of the column side: lit, unlit or beam, for which
/// RowDirection has none; without it that of the emission angle, or of the sign of mu_out. For beams
/// mu_out, or emission_deg, alone counts.
Query read_observations(const std::string& path, const std::vector<std::string>& required,
                        const std::vector<std::string>& optional);

/// Writes the columns of a query and those of its answer.
void write_answer_header(std::ostream& out, const Query& query,
                         const std::vector<std::string>& columns);

/// Writes a row of a query and its answer, a value for each of `columns`; those that begin with the
/// name of a side that the row does not ask for are "nan": reflection or upward, transmission or
/// downward.
void write_answer_row(std::ostream& out, const Query& query, std::size_t row,
                      const std::vector<std::string>& columns, const std::vector<double>& values);

/// Calls `write` with stdout where `path` is "" or "-"; adds to the end of a device, a pipe or an
/// open file (/dev/stdout); writes any other file at `path` atomically.
///
/// Errors   std::runtime_error when the file cannot be written in full; main checks stdout.
void write_answer(const fs::path& path, const std::function<void(std::ostream&)>& write);

/// Writes a file's content, or a file, atomically while Ctrl-C is held back (file_bytes.h, progress.h).
void write_content_held(const fs::path& path, std::string_view content);
void write_file(const fs::path& path, const std::function<void(const fs::path& temporary)>& write);

/// Throws std::invalid_argument when writing the outputs would overwrite an input, or one of them another.
/// Empty paths are passed over.
void require_different_files(const std::string& command, const std::vector<std::string>& inputs,
                             const std::vector<std::string>& outputs);

/// Refuses, before any work, a file that cannot be written or whose name lacks `ending`.
///
/// Errors   std::invalid_argument naming command and option; std::runtime_error for its folder.
void require_writable(const std::string& command, const std::string& option, const fs::path& path,
                      const std::vector<std::string>& endings = {});

/// Refuses likewise, and a file that is one of `inputs`.
void require_output(const std::string& command, const std::string& option, const fs::path& path,
                    const std::vector<std::string>& inputs,
                    const std::vector<std::string>& endings = {});

/// Refuses a file that an answer cannot be written to; write_answer may add to it.
void require_writable_answer(const std::string& command, const fs::path& path);

/// An answer's number: 17 significant digits.
std::string full_text(double value);

}  // namespace stratus
