// Observed values, a model's, and residuals below, 16 cm wide, as SVG.
//
// Observed values are circles with bars of one standard deviation either way, the model's are
// crosses; residuals are in standard deviations. Series have colours of their own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

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

}  // namespace stratus
