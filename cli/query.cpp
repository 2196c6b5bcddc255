#include "query.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/io/atomic_file.h>

#include "signals_held.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <unistd.h>

namespace stratus {
namespace {

struct ColumnRange {
    const char* column;
    const char* allowed;
    bool (*holds)(double value);
};

constexpr ColumnRange column_ranges[] = {
    {"mu_in", "in (0, 1]", [](double mu) { return mu > 0 && mu <= 1; }},
    {"mu_out", "in (0, 1]", [](double mu) { return mu > 0 && mu <= 1; }},
    {"azimuth_deg", "finite", [](double degrees) { return std::isfinite(degrees); }},
    {"optical_depth", "in [0, inf]", [](double depth) { return depth >= 0; }},
    {"albedo", "in [0, 1]", [](double albedo) { return albedo >= 0 && albedo <= 1; }},
    {"mixture", "in [0, 1]", [](double mixture) { return mixture >= 0 && mixture <= 1; }},
    {"g", "in (-1, 1)", [](double g) { return std::abs(g) < 1; }},
    {"wavelength", "above 0 (um)", [](double length) { return length > 0; }},
    {"variance", "in [0, 0.5]", [](double v) { return v >= 0 && v <= 0.5; }},
    {"radius", "finite", [](double radius) { return std::isfinite(radius); }},
    {"pixel", "finite", [](double pixel) { return std::isfinite(pixel); }},
    {"brightness", "finite", [](double brightness) { return std::isfinite(brightness); }},
    {"sigma", "in (0, inf)", [](double sigma) { return sigma > 0 && std::isfinite(sigma); }},
};

constexpr ColumnRange either_side{"mu_out", "in [-1, 1] and not 0",
                                  [](double mu) { return mu != 0 && std::abs(mu) <= 1; }};

bool contains(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

void check_columns(const CsvTable& query, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional) {
    for (const std::string& column : required) query.column(column);  // refuses a missing one
    std::vector<std::string> allowed = required;
    allowed.insert(allowed.end(), optional.begin(), optional.end());
    for (const std::string& column : query.columns)
        if (!contains(allowed, column))
            throw std::invalid_argument(query.name + ": column must be one of " + joined(allowed) +
                                        ", got " + shown(column));
}

/// Refuses the first line with a value out of its column's range.
void check_values(const CsvTable& query, bool signed_mu_out) {
    for (std::size_t r = 0; r < query.rows.size(); ++r)
        for (const ColumnRange& plain : column_ranges) {
            const bool either = signed_mu_out && std::strcmp(plain.column, either_side.column) == 0;
            const ColumnRange& range = either ? either_side : plain;
            if (!query.has_column(range.column)) continue;
            const double value =
                query.rows[r][static_cast<std::size_t>(query.column(range.column))];
            if (range.holds(value)) continue;
            throw std::invalid_argument(query.name + ", line " + std::to_string(query.lines[r]) +
                                        ": " + range.column + " must be " + range.allowed +
                                        ", got " + shortest_text(value));
        }
}

std::string reason() { return errno != 0 ? std::strerror(errno) : "write error"; }

bool is_stream(const std::string& path) { return path.empty() || path == "-"; }

/// Adds to the end, as `>>` does: others may have written there.
void append(const std::filesystem::path& path, const std::string& content) {
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::app);
    file << content;
    file.close();
    if (!file) throw std::runtime_error(path.string() + ": " + reason());
}

CsvTable read_rows(const std::string& path, const std::vector<CsvWords>& words) {
    return is_stream(path) ? read_csv(std::cin, "standard input", words) : read_csv(path, words);
}

}  // namespace

CsvTable read_query(const std::string& path, const std::vector<std::string>& required,
                    const std::vector<std::string>& optional) {
    CsvTable query = read_rows(path, {});
    check_columns(query, required, optional);
    check_values(query, false);
    return query;
}

CsvTable read_observations(const std::string& path, const std::vector<std::string>& required,
                           const std::vector<std::string>& optional) {
    CsvTable rows = read_rows(path, {{"side", side_names}});
    check_columns(rows, required, optional);
    check_values(rows, !rows.has_column("side"));
    return rows;
}

void write_answer(const std::filesystem::path& path,
                  const std::function<void(std::ostream&)>& write) {
    if (is_stream(path.string())) {
        write(std::cout);
        return;
    }
    std::ostringstream answer;  // written here first, where signals still interrupt
    write(answer);
    if (takes_what_comes(path)) return append(path, answer.str());
    const SignalsHeld held;
    write_content_atomically(path, answer.view());
}

void require_different_files(const std::string& command, const std::filesystem::path& input,
                             const std::filesystem::path& output) {
    std::error_code absent;
    if (std::filesystem::equivalent(input, output, absent))
        throw std::invalid_argument(command + ": output must be another file than the input, got " +
                                    output.string());
}

void require_writable(const std::string& command, const std::string& option,
                      const std::filesystem::path& path, const std::vector<std::string>& endings) {
    const auto refuse = [&](const std::string& allowed, const std::string& met) {
        throw std::invalid_argument(command + ": " + option + " must " + allowed + ", got " + met);
    };
    if (!endings.empty() && std::ranges::find(endings, path.extension().string()) == endings.end())
        refuse("end in " + joined(endings, " or "), path.empty() ? "nothing" : path.string());
    if (std::filesystem::is_directory(path)) refuse("be a file", "the folder " + path.string());
    if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path))
        refuse("be a file", "the device " + path.string());
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    if (!std::filesystem::is_directory(folder))
        throw std::runtime_error(path.string() + ": there is no folder " + folder.string());
    if (access(folder.c_str(), W_OK) != 0)
        throw std::runtime_error(path.string() + ": the folder cannot be written to");
}

void require_writable_answer(const std::string& command, const std::filesystem::path& path) {
    if (!is_stream(path.string()) && !takes_what_comes(path))
        require_writable(command, "--output", path);
}

std::string full_text(double value) {
    char text[32];
    const int length = std::snprintf(text, sizeof text, "%.17g", value);
    return {text, static_cast<std::size_t>(length)};
}

}  // namespace stratus
