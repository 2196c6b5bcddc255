#include "fit_rows.h"

#include <stratus/base/angle.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <set>
#include <utility>

namespace stratus {
namespace {

/// Beams come from behind: their phase angle is 180 degrees.
double phase_angle_deg(const RowDirection& at) {
    if (!at.side) return 180;
    return 180 - degrees(std::acos(cos_scattering_angle(*at.side, at.geometry)));
}

/// The angle is beyond 90 degrees on the unlit side.
double emission_angle_deg(const RowDirection& at) {
    const double angle = degrees(std::acos(at.geometry.mu_out));
    return at.side == Side::transmission ? 180 - angle : angle;
}

std::size_t count_distinct(const std::vector<double>& angles_deg) {
    constexpr double per_degree = 100;
    std::set<double> rounded;
    for (const double angle : angles_deg) rounded.insert(std::round(angle * per_degree));
    return rounded.size();
}

/// Returns the title of a figure's axis, and where its rows are along it: over the wavelength if that is a
/// column, else over the phase angle, or over the emission angle if that takes more values.
std::pair<std::string, std::vector<double>> plot_places(const Query& query) {
    const CsvTable& table = query.table;
    std::vector<double> wavelengths, phases, emissions;
    if (table.has_column("wavelength")) {
        for (const std::vector<double>& row : table.rows)
            wavelengths.push_back(row[column_index(table, "wavelength")]);
        return {"wavelength (um)", wavelengths};
    }
    for (const RowDirection& direction : query.directions) {
        phases.push_back(phase_angle_deg(direction));
        emissions.push_back(emission_angle_deg(direction));
    }
    if (count_distinct(emissions) > count_distinct(phases))
        return {"emission angle (degrees)", emissions};
    return {"phase angle (degrees)", phases};
}

}  // namespace

std::size_t column_index(const CsvTable& table, const std::string& column) {
    return static_cast<std::size_t>(table.column(column));
}

Light observed_light(const RowDirection& direction) {
    if (!direction.side) return Light::beam;
    return *direction.side == Side::reflection ? Light::reflected : Light::transmitted;
}

const char* light_word(Light light) {
    constexpr const char* names[] = {"lit", "unlit", "beam"};
    return names[static_cast<int>(light)];
}

bool all_are_beams(const Query& rows) {
    return std::ranges::all_of(rows.directions,
                               [](const RowDirection& direction) { return !direction.side; });
}

void write_rows(std::ostream& out, const Query& query, const std::vector<double>& model) {
    const CsvTable& table = query.table;
    const std::size_t brightness = column_index(table, "brightness");
    const std::vector<std::string> columns{"model", "residual"};
    write_answer_header(out, query, columns);
    for (std::size_t r = 0; r < model.size(); ++r)
        write_answer_row(out, query, r, columns, {model[r], table.rows[r][brightness] - model[r]});
}

ResidualPlot plot_of_rows(const Query& query, const std::vector<double>& model) {
    const CsvTable& table = query.table;
    const std::size_t brightness = column_index(table, "brightness"),
                      sigma = column_index(table, "sigma");
    ResidualPlot plot;
    plot.title = "Fit of " + std::filesystem::path(table.name).filename().string();
    const auto [x_title, places] = plot_places(query);
    plot.x_title = x_title;
    plot.y_title = all_are_beams(query) ? "I/F0" : "I/F";
    for (const Light light : {Light::reflected, Light::transmitted, Light::beam}) {
        ResidualSeries series{light_word(light), {}};
        for (std::size_t r = 0; r < model.size(); ++r)
            if (observed_light(query.directions[r]) == light)
                series.points.push_back(
                    {places[r], table.rows[r][brightness], table.rows[r][sigma], model[r]});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

}  // namespace stratus
