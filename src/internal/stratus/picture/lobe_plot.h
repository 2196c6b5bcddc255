// Polar plots of the light that a layer scatters, as figure 8 of [Blinn82]: panels in rows and
// columns, each with the layer edge-on, the ray coming from the right, and lobes above and below.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

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

}  // namespace stratus
