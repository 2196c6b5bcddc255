// Error against cost as a figure for print: panels over logarithmic axes, stacked, 16 cm wide, as
// SVG.
//
// Measurements are marks, of one shape and colour a series, to be told apart without colour;
// frontiers are steps: between two points of a frontier, the cheaper one is the best available.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

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

}  // namespace stratus
