// Cost against error as a figure for print: panels of points over logarithmic axes, one below the
// other, 16 cm wide, as SVG.
//
// What was measured is drawn as marks, a shape and a colour a series, so that they keep apart
// without colour; what a frontier joins as steps: between two of its points the cheaper one is the
// best there is.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

/// A point of a panel; its label, if any, stands beside it.
struct PlotPoint {
    double x, y;
    std::string label;
};

/// Without points it keeps its shape and colour from other series, and is not named.
struct PlotSeries {
    enum class Role {
        measured,  // marks; labels are left out where there is no room
        frontier,  // steps from point to point, ascending in x; labels as above
        chosen,    // filled marks that stand out; every label is drawn
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
/// Errors   std::invalid_argument for no panel, a panel without points, and x or y that is not
/// above
///          0 and finite; std::runtime_error naming the path and the reason when the file cannot be
///          written.
void draw_cost_plot(const std::vector<PlotPanel>& panels, const std::filesystem::path& svg);

}  // namespace stratus
