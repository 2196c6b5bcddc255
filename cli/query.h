// Queries and answers as CSV: what the commands that evaluate geometries read and write.
//
// A query's columns are mu_in, mu_out, azimuth_deg and, for tables, optical_depth and albedo, for
// some mixture; each has its one allowed range, checked here row by row. Answers go to stdout or,
// whole or not at all, to a file.
#pragma once

#include <stratus/io/csv.h>

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace stratus {

/// The rows of a query, every value in its range; `path` "" or "-" is standard input.
///
/// Errors   std::invalid_argument for a value outside its range (naming line, column, range and
///          value), for a missing `required` column and for one that is not asked for at all.
CsvTable read_query(const std::string& path, const std::vector<std::string>& required,
                    const std::vector<std::string>& optional = {});

/// The same of observations, whose mu_out is negative where the side that is not lit was seen.
CsvTable read_observations(const std::string& path, const std::vector<std::string>& required,
                           const std::vector<std::string>& optional);

/// Calls `write` with stdout where `path` is "" or "-", else writes a file that appears at `path`
/// whole or not at all.
///
/// Errors   std::runtime_error when not all of a file could be written; stdout is checked in main.
void write_answer(const std::filesystem::path& path,
                  const std::function<void(std::ostream&)>& write);

/// Throws std::invalid_argument when writing to `output` would overwrite `input`.
void require_different_files(const std::string& command, const std::filesystem::path& input,
                             const std::filesystem::path& output);

/// Refuses a file that could not be written, before the work rather than after it; with an
/// `ending`, one that does not have it.
///
/// Errors   std::invalid_argument naming command and option; std::runtime_error for its folder.
void require_writable(const std::string& command, const std::string& option,
                      const std::filesystem::path& path, const std::string& ending = "");

/// An answer's number: 17 significant digits.
std::string full_text(double value);

}  // namespace stratus
