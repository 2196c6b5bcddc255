#include "query.h"

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>

#include "progress.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <iostream>
#include <set>
#include <unistd.h>

namespace stratus {
namespace {

struct ColumnRange {
    std::string column;
    NumberRange interval;
    std::string words{};  // for it, where the interval does not speak for itself
};

const ColumnRange column_ranges[] = {
    {"mu_in", "(0, 1]"},
    {"mu_out", "(0, 1]"},
    {"azimuth_deg", "(-inf, inf)", "finite"},
    {"optical_depth", "[0, inf]"},
    {"albedo", "[0, 1]"},
    {"mixture", "[0, 1]"},
    {"g", "(-1, 1)"},
    {"wavelength", "(0, inf]", "above 0 (um)"},
    {"variance", "[0, 0.5]"},
    {"radius", "(-inf, inf)", "finite"},
    {"pixel", "(-inf, inf)", "finite"},
    {"brightness", "(-inf, inf)", "finite"},
    {"sigma", "(0, inf)"},
};

const std::vector<std::string> side_names{"lit", "unlit", "beam"};
constexpr int beam = 2;  // its place

const std::vector<std::string> cosine_columns{"mu_in", "mu_out", "azimuth_deg"};
const std::vector<std::string> observed_columns{"incidence_deg", "emission_deg", "phase_deg"};

bool is_observed(const CsvTable& rows) {
    return std::ranges::any_of(observed_columns,
                               [&](const std::string& name) { return rows.has_column(name); });
}

/// `of_directions`: the columns that name them, of which the places `needed` must be there.
void check_columns(const CsvTable& query, const std::vector<std::string>& of_directions,
                   const std::vector<std::size_t>& needed, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional) {
    for (const std::size_t place : needed) query.column(of_directions[place]);  // refuses
    for (const std::string& column : required) query.column(column);
    std::vector<std::string> allowed = of_directions;
    allowed.insert(allowed.end(), required.begin(), required.end());
    allowed.insert(allowed.end(), optional.begin(), optional.end());
    for (const std::string& column : query.columns)
        require(is_listed(column, allowed), query.name.c_str(), "column",
                "one of " + joined(allowed), column);
}

/// Refuses the first line with a value out of its column's range.
void check_values(const CsvTable& query, bool signed_mu_out) {
    for (std::size_t r = 0; r < query.rows.size(); ++r)
        for (const auto& [column, interval, words] : column_ranges) {
            const Row row(query, r);
            if (!row.has(column)) continue;
            const double value = row[column];
            const bool is_signed = signed_mu_out && column == "mu_out";
            if (is_signed ? value != 0 && std::abs(value) <= 1 : interval.holds(value)) continue;
            require(false, row.place().c_str(), column,
                    is_signed       ? "in [-1, 1] and not 0"
                    : words.empty() ? "in " + interval.text
                                    : words,
                    value);
        }
}

std::string reason() { return errno != 0 ? std::strerror(errno) : "write error"; }

bool is_stream(const std::string& path) { return path.empty() || path == "-"; }

/// Adds to the end, as `>>` does: others may have written there.
void append(const fs::path& path, const std::string& content) {
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::app);
    file << content;
    file.close();
    if (!file) throw std::runtime_error(path.string() + ": " + reason());
}

CsvTable read_rows(const std::string& path, const std::vector<CsvWords>& words) {
    return is_stream(path) ? read_csv(std::cin, "standard input", words) : read_csv(path, words);
}

RowDirection observed_direction(const Row& row) {
    const ObservedAngles angles{row["incidence_deg"], row["emission_deg"], row["phase_deg"]};
    const auto [geometry, side] = observed_geometry(angles, row.place().c_str());
    return {geometry, side};
}

RowDirection cosine_direction(const Row& row) {
    return {{row["mu_in"], std::abs(row["mu_out"]), radians(row["azimuth_deg"])}};
}

/// A beam leaves along the line of sight; nothing else of its direction counts.
RowDirection beam_direction(const Row& row) {
    if (!row.has("emission_deg")) return {{row["mu_out"], row["mu_out"], 0}};
    const double emission = row["emission_deg"];
    return {observed_geometry({0, emission, emission}, row.place().c_str()).geometry};
}

RowDirection observation_direction(const Row& row) {
    const int stated = row.has("side") ? static_cast<int>(row["side"]) : -1;
    if (stated == beam) return beam_direction(row);
    if (!row.has("emission_deg")) {
        RowDirection direction = cosine_direction(row);
        direction.side = stated == 1 || row["mu_out"] < 0 ? Side::transmission : Side::reflection;
        return direction;
    }
    const RowDirection direction = observed_direction(row);
    const bool is_lit = direction.side == Side::reflection;
    require(stated < 0 || is_lit == (stated == 0), row.place().c_str(), "emission_deg",
            stated == 0 ? "below 90 on the side lit" : "above 90 on the side unlit",
            row["emission_deg"]);
    return direction;
}

}  // namespace

Query read_query(const std::string& path, const std::vector<std::string>& required,
                 const std::vector<std::string>& optional) {
    Query query{read_rows(path, {}), {}};
    const CsvTable& rows = query.table;
    const bool observed = is_observed(rows);
    check_columns(rows, observed ? observed_columns : cosine_columns, {0, 1, 2}, required,
                  optional);
    check_values(rows, false);
    for (std::size_t r = 0; r < rows.rows.size(); ++r)
        query.directions.push_back(observed ? observed_direction(query.row(r))
                                            : cosine_direction(query.row(r)));
    return query;
}

Query read_observations(const std::string& path, const std::vector<std::string>& required,
                        const std::vector<std::string>& optional) {
    Query query{read_rows(path, {{"side", side_names}}), {}};
    const CsvTable& rows = query.table;
    std::vector<std::string> more = optional;
    more.emplace_back("side");
    check_columns(rows, is_observed(rows) ? observed_columns : cosine_columns, {1}, required, more);
    check_values(rows, !rows.has_column("side"));
    for (std::size_t r = 0; r < rows.rows.size(); ++r)
        query.directions.push_back(observation_direction(query.row(r)));
    return query;
}

void write_answer_header(std::ostream& out, const Query& query,
                         const std::vector<std::string>& columns) {
    std::vector<std::string> all = query.table.columns;
    all.insert(all.end(), columns.begin(), columns.end());
    out << joined(all, ",") << '\n';
}

void write_answer_row(std::ostream& out, const Query& query, std::size_t row,
                      const std::vector<std::string>& columns, const std::vector<double>& values) {
    const std::optional<Side> side = query.directions[row].side;
    const auto is_asked = [&](const std::string& column) {
        for (const char* const name : {"reflection", "upward"})
            if (column.starts_with(name)) return side != Side::transmission;
        for (const char* const name : {"transmission", "downward"})
            if (column.starts_with(name)) return side != Side::reflection;
        return true;
    };
    const std::vector<double>& asked = query.table.rows[row];
    for (std::size_t c = 0; c < asked.size(); ++c)
        out << (c ? "," : "")
            << (query.table.columns[c] == "side" ? side_names[static_cast<std::size_t>(asked[c])]
                                                 : shortest_text(asked[c]));
    for (std::size_t c = 0; c < columns.size(); ++c)
        out << ',' << (is_asked(columns[c]) ? full_text(values[c]) : "nan");
    out << '\n';
}

void write_answer(const fs::path& path, const std::function<void(std::ostream&)>& write) {
    if (is_stream(path.string())) {
        write(std::cout);
        return;
    }
    std::ostringstream answer;  // written here first, where signals still interrupt
    write(answer);
    if (takes_what_comes(path)) return append(path, answer.str());
    write_content_held(path, answer.view());
}

void write_content_held(const fs::path& path, std::string_view content) {
    const SignalsHeld held;
    write_content_atomically(path, content);
}

void write_file(const fs::path& path, const std::function<void(const fs::path& temporary)>& write) {
    const SignalsHeld held;
    write_atomically(path, write);
}

void require_different_files(const std::string& command, const std::vector<std::string>& inputs,
                             const std::vector<std::string>& outputs) {
    std::set<fs::path> written;
    for (const std::string& output : outputs) {
        std::error_code absent;
        for (const std::string& input : inputs)
            require(!fs::equivalent(input, output, absent), command.c_str(), "output",
                    "another file than the input", output);
        require(is_stream(output) || takes_what_comes(output) ||
                    written.insert(fs::weakly_canonical(fs::absolute(output))).second,
                command.c_str(), "output", "another file than the other output", output);
    }
}

void require_writable(const std::string& command, const std::string& option, const fs::path& path,
                      const std::vector<std::string>& endings) {
    const auto refuse = [&](const std::string& allowed, const std::string& met) {
        throw std::invalid_argument(command + ": " + option + " must " + allowed + ", got " + met);
    };
    if (!endings.empty() && !is_listed(path.extension().string(), endings))
        refuse("end in " + joined(endings, " or "), path.empty() ? "nothing" : path.string());
    if (fs::is_directory(path)) refuse("be a file", "the folder " + path.string());
    if (fs::exists(path) && !fs::is_regular_file(path))
        refuse("be a file", "the device " + path.string());
    const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
    if (!fs::is_directory(folder))
        throw std::runtime_error(path.string() + ": there is no folder " + folder.string());
    if (access(folder.c_str(), W_OK) != 0)
        throw std::runtime_error(path.string() + ": the folder cannot be written to");
}

void require_output(const std::string& command, const std::string& option, const fs::path& path,
                    const std::vector<std::string>& inputs,
                    const std::vector<std::string>& endings) {
    require_different_files(command, inputs, {path.string()});
    require_writable(command, option, path, endings);
}

void require_writable_answer(const std::string& command, const fs::path& path) {
    if (!is_stream(path.string()) && !takes_what_comes(path))
        require_writable(command, "--output", path);
}

std::string full_text(double value) { return formatted("%.17g", value); }

}  // namespace stratus
