// Lines over axes, 16 cm wide, as SVG: linear ones that start at 0, or y logarithmic.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

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

}  // namespace stratus
