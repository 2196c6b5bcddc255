// Figures for print as SVG: lines, lobes, residuals, and error against cost. All but lobes are 16 cm wide.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

// Lines over axes: linear ones that start at 0, or y logarithmic.

struct Line {
    std::string name;
    bool dashed = false;
    std::vector<std::pair<double, double>> points;  // x and y, at least 0
};

struct LinePlot {
    std::string title, x_title, y_title;
    double x_end = 1, y_end = 1;  // of the axes, where lines are clipped
    std::vector<Line> lines{};
    double y_begin = 0;         // above 0: the axis is logarithmic
    bool legend_below = false;  // the plot, for long names; beside it otherwise
};

/// Draws to `svg` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::runtime_error naming the path and the reason.
void draw_line_plot(const LinePlot& plot, const std::filesystem::path& svg);

// Polar plots of the light that a layer scatters, as figure 8 of [Blinn82]: panels in rows and
// columns, each with the layer edge-on, the ray coming from the right, and lobes above and below.

/// Radii at even angles from one horizon (-90 degrees, where the light comes from) to the other (90
/// degrees), above and below the layer.
struct LobeCurve {
    std::vector<double> above, below;
};

struct LobePanel {
    double incident;                // radians from the upper normal
    std::vector<LobeCurve> curves;  // as many as names
};

/// Columns under one heading.
struct LobeBlock {
    std::string title;
    std::vector<std::vector<LobePanel>> rows;
};

struct LobePlot {
    std::string title;
    std::vector<std::string> names;       // of curves
    std::vector<std::string> row_titles;  // as many as rows
    std::vector<LobeBlock> blocks;        // side by side
    /// One scale for all rows of a block; else each row has its own. A circle shows it.
    bool common_scale = false;
    double error = 0;  // relative, of the values, estimated; not drawn
};

/// Draws to `svg` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::runtime_error naming the path and the reason.
void draw_lobe_plot(const LobePlot& plot, const std::filesystem::path& svg);

// Observed values, a model's, and residuals below, 16 cm wide, as SVG.
//
// Observed values are circles with bars of one standard deviation either way, the model's are
// crosses; residuals are in standard deviations. Series have colours of their own.

struct ResidualPoint {
    double x, observed, sigma, model;
};

struct ResidualSeries {
    std::string name;
    std::vector<ResidualPoint> points;
};

struct ResidualPlot {
    std::string title, x_title, y_title;
    std::vector<ResidualSeries> series;
};

/// Draws to `svg` itself; callers who need it whole or not at all wrap it.
///
/// Range    one point at least, all numbers finite, every sigma above 0.
/// Errors   std::runtime_error naming the path and the reason.
void draw_residual_plot(const ResidualPlot& plot, const std::filesystem::path& svg);

// Error against cost as a figure for print: panels over logarithmic axes, stacked, 16 cm wide, as
// SVG.
//
// Measurements are marks, of one shape and colour a series, to be told apart without colour;
// frontiers are steps: between two points of a frontier, the cheaper one is the best available.

/// The label, if any, is drawn beside the point.
struct PlotPoint {
    double x, y;
    std::string label;
};

/// A series without points reserves its shape and colour but is not in the legend.
struct PlotSeries {
    enum class Role {
        measured,  // marks
        frontier,  // steps from point to point, ascending in x
        chosen,    // filled marks that stand out
    };
    std::string name;
    Role role = Role::measured;
    std::vector<PlotPoint> points;
};

struct PlotPanel {
    std::string title, x_title, y_title;
    std::vector<PlotSeries> series;
};

/// Draws panels to `svg` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::invalid_argument for no panel, a panel without points, or x or y that is not above
///          0 and finite; std::runtime_error naming the path and the reason when the file cannot be
///          written.
void draw_cost_plot(const std::vector<PlotPanel>& panels, const std::filesystem::path& svg);

// Round numbers, for scales and samples that a reader sees.

/// The nearest number of so many significant digits.
inline double rounded(double value, int digits = 1) {
    if (!(value > 0) || !std::isfinite(value)) return value;
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - (digits - 1));
    return std::round(value / unit) * unit;
}

/// 1, 2 or 5 times a power of ten: the largest up to `value`, which is above 0.
inline double round_below(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)));
    return unit * (value >= 5 * unit ? 5 : value >= 2 * unit ? 2 : 1);
}

}  // namespace stratus
