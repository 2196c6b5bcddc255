// Queries and answers as CSV, for the commands that evaluate geometries.
//
// A query's columns are mu_in, mu_out, azimuth_deg and, for tables, optical_depth, albedo and
// mixture; the range of each is checked here row by row. Answers go to stdout or, atomically, to a
// file.
#pragma once

#include <stratus/io/csv.h>

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace stratus {

/// Reads a query, every value in its range; `path` "" or "-" is standard input.
///
/// Errors   std::invalid_argument for a value outside its range (naming line, column, range and
///          value), for a missing `required` column and for one that is neither required nor
///          optional.
CsvTable read_query(const std::string& path, const std::vector<std::string>& required,
                    const std::vector<std::string>& optional = {});

/// Words of the column side of observations.
inline const std::vector<std::string> side_names{"lit", "unlit", "beam"};

/// The same for observations: their column side holds the places of `side_names`; without it mu_out
/// is negative on the unlit side.
CsvTable read_observations(const std::string& path, const std::vector<std::string>& required,
                           const std::vector<std::string>& optional);

/// Calls `write` with stdout where `path` is "" or "-"; adds to the end of a device, a pipe or an
/// open file (/dev/stdout); writes any other file at `path` atomically.
///
/// Errors   std::runtime_error when the file cannot be written in full; main checks stdout.
void write_answer(const std::filesystem::path& path,
                  const std::function<void(std::ostream&)>& write);

/// Throws std::invalid_argument when writing to `output` would overwrite `input`.
void require_different_files(const std::string& command, const std::filesystem::path& input,
                             const std::filesystem::path& output);

/// Refuses, before any work, a file that cannot be written or whose name lacks `ending`.
///
/// Errors   std::invalid_argument naming command and option; std::runtime_error for its folder.
void require_writable(const std::string& command, const std::string& option,
                      const std::filesystem::path& path,
                      const std::vector<std::string>& endings = {});

/// The same for the file of an answer, which may be what write_answer adds to.
void require_writable_answer(const std::string& command, const std::filesystem::path& path);

/// An answer's number: 17 significant digits.
std::string full_text(double value);

}  // namespace stratus
