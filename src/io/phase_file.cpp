#include <stratus/io/phase_file.h>

#include <stratus/io/csv.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <utility>

namespace stratus {
namespace {

using Notes = std::vector<std::string>;

void note(Notes* notes, const std::string& line) {
    if (notes != nullptr) notes->push_back(line);
}

/// Names a row of the file in messages.
auto row_name(const CsvTable& file) {
    return [&file](std::size_t row) {
        return " (" + file.name + ", line " + std::to_string(file.lines[row]) + ")";
    };
}

std::vector<double> values_of(const CsvTable& file, const char* column) {
    const auto at = static_cast<std::size_t>(file.column(column));
    std::vector<double> values;
    for (const std::vector<double>& row : file.rows) values.push_back(row[at]);
    return values;
}

PhaseFunction read_tabulated(const CsvTable& file, const Tabulated::Options& options,
                             Notes* notes) {
    Tabulated table(values_of(file, "phase_angle_deg"), values_of(file, "value"), row_name(file),
                    options);
    if (std::abs(table.normalisation - 1) > 1e-9)
        note(notes, file.name + ": values were divided by their spherical mean " +
                        shortest_text(1 / table.normalisation));
    return PhaseFunction(std::move(table));
}

PhaseFunction read_moments(const CsvTable& file, Notes* notes) {
    const std::vector<double> order = values_of(file, "l"), chi = values_of(file, "chi");
    for (std::size_t l = 0; l < order.size(); ++l)
        require(order[l] == static_cast<double>(l), Moments::kind.name,
                std::string("l") + row_name(file)(l),
                std::to_string(l) + " (0, 1, 2, ... in order)", order[l]);
    Moments moments(chi, row_name(file));
    if (chi[0] != 1)
        note(notes, file.name + ": moments were divided by chi_0 = " + shortest_text(chi[0]));
    return PhaseFunction(std::move(moments));
}

}  // namespace

PhaseFunction read_phase_function(const std::string& text, const std::string& directory,
                                  std::vector<std::string>* notes) {
    return parse_phase_function(
        text, notes,
        [&](const std::string& kind, const std::string& file, const Tabulated::Options& options) {
            const CsvTable table = read_csv((std::filesystem::path(directory) / file).string());
            return kind == Moments::kind.name ? read_moments(table, notes)
                                              : read_tabulated(table, options, notes);
        });
}

}  // namespace stratus
