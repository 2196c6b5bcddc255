#include "fit_rows.h"

#include <stratus/base/angle.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <set>
#include <string>
#include <utility>

namespace stratus {

Light light_of(const RowDirection& direction) {
    if (!direction.side) return Light::beam;
    return *direction.side == Side::reflection ? Light::reflected : Light::transmitted;
}

const char* name_of(Light light) {
    constexpr const char* names[] = {"lit", "unlit", "beam"};
    return names[static_cast<int>(light)];
}

bool all_are_beams(const Query& rows) {
    return std::ranges::all_of(rows.directions,
                               [](const RowDirection& direction) { return !direction.side; });
}

void write_rows(std::ostream& out, const Query& query, const std::vector<double>& model) {
    const CsvTable& table = query.table;
    const auto brightness = static_cast<std::size_t>(table.column("brightness"));
    const std::vector<std::string> columns{"model", "residual"};
    write_answer_header(out, query, columns);
    for (std::size_t r = 0; r < model.size(); ++r)
        write_answer_row(out, query, r, columns, {model[r], table.rows[r][brightness] - model[r]});
}

namespace {

/// Beams come from behind: their phase angle is 180 degrees.
double phase_angle_deg(const RowDirection& at) {
    if (!at.side) return 180;
    const bool is_lit = at.side == Side::reflection;
    return 180 - degrees(std::acos(is_lit ? cos_scattering_angle_reflected(at.geometry)
                                          : cos_scattering_angle_transmitted(at.geometry)));
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

struct PlotPlaces {
    std::string title;
    std::vector<double> of_rows;
};

PlotPlaces plot_places(const Query& query) {
    const CsvTable& table = query.table;
    PlotPlaces wavelength{"wavelength (um)", {}}, phase{"phase angle (degrees)", {}},
        emission{"emission angle (degrees)", {}};
    for (const RowDirection& direction : query.directions) {
        phase.of_rows.push_back(phase_angle_deg(direction));
        emission.of_rows.push_back(emission_angle_deg(direction));
    }
    if (!table.has_column("wavelength"))
        return count_distinct(emission.of_rows) > count_distinct(phase.of_rows) ? emission : phase;
    const auto column = static_cast<std::size_t>(table.column("wavelength"));
    for (const std::vector<double>& row : table.rows) wavelength.of_rows.push_back(row[column]);
    return wavelength;
}

}  // namespace

ResidualPlot plot_of_rows(const Query& query, const std::vector<double>& model) {
    const CsvTable& table = query.table;
    const auto brightness = static_cast<std::size_t>(table.column("brightness"));
    const auto sigma = static_cast<std::size_t>(table.column("sigma"));
    const PlotPlaces places = plot_places(query);
    ResidualPlot plot;
    plot.title = "Fit of " + std::filesystem::path(table.name).filename().string();
    plot.x_title = places.title;
    plot.y_title = all_are_beams(query) ? "I/F0" : "I/F";
    for (const Light light : {Light::reflected, Light::transmitted, Light::beam}) {
        ResidualSeries series{name_of(light), {}};
        for (std::size_t r = 0; r < model.size(); ++r)
            if (light_of(query.directions[r]) == light)
                series.points.push_back(
                    {places.of_rows[r], table.rows[r][brightness], table.rows[r][sigma], model[r]});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

}  // namespace stratus
