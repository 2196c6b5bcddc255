#include <stratus/picture/plots.h>

#include <stratus/picture/round_number.h>

#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <iterator>

namespace stratus {
namespace {

constexpr double values_top = 40, values_bottom = 230, residuals_top = 252, residuals_bottom = 340;
constexpr double residual_page_height = 376, point_radius = 2.2;
constexpr Colour series_colours[] = {
    {0.10, 0.30, 0.65}, {0.85, 0.45, 0.05}, {0.05, 0.50, 0.35}, {0.70, 0.25, 0.50}};

Colour series_colour(std::size_t series) {
    return series_colours[series % std::size(series_colours)];
}

/// The range of an axis, widened to round numbers.
struct AxisRange {
    double low = infinity, high = -infinity;

    void include(std::initializer_list<double> values) {
        low = std::min(low, std::min(values));
        high = std::max(high, std::max(values));
    }

    void widen() {
        if (high - low <= 1e-9 * std::max(std::abs(low), std::abs(high))) {  // one value alone
            const double about = low == 0 ? 1 : std::abs(low) / 10;
            low -= about;
            high += about;
        }
        const double step = round_below((high - low) / 4);
        low = step * std::floor(low / step + 1e-9);
        high = step * std::ceil(high / step - 1e-9);
    }

    double share(double value) const { return (value - low) / (high - low); }
};

using Panel = PlotFrame<AxisRange>;

void draw_axes(const Page& page, const Panel& panel, const std::string& x_title,
               const std::string& y_title) {
    draw_x_axis(page, panel.box,
                linear_ticks(panel.x.low, panel.x.high, [&](double x) { return panel.across(x); }),
                x_title);
    draw_y_axis(page, panel.box,
                linear_ticks(panel.y.low, panel.y.high, [&](double y) { return panel.down(y); }),
                y_title);
}

/// A value with its bar.
void draw_measured(const Page& page, const Panel& panel, double x, double y, double sigma,
                   const Pen& pen) {
    page.line(panel.at(x, y - sigma), panel.at(x, y + sigma), pen);
    page.mark(panel.at(x, y), Marker::circle, point_radius, pen);
}

void draw_legend(const Page& page, const std::vector<ResidualSeries>& series, Point at) {
    const auto entry = [&](Marker marker, const std::string& name, const Colour& colour) {
        page.mark({at.x, at.y - 3}, marker, point_radius, {1, colour});
        page.text({at.x + 6, at.y}, name, plot_text_size, colour);
        at.x += page.text_width(name, plot_text_size) + 20;
    };
    for (std::size_t n = 0; n < series.size(); ++n)
        entry(Marker::circle, series[n].name + ", observed", series_colour(n));
    entry(Marker::cross, "model", black);
}

}  // namespace

void draw_residual_plot(const ResidualPlot& plot, const std::filesystem::path& svg) {
    Panel values{{46, values_top, plot_page_width - 14, values_bottom}, {}, {}};
    Panel residuals{{46, residuals_top, plot_page_width - 14, residuals_bottom}, {}, {-2, 2}};
    for (const ResidualSeries& series : plot.series)
        for (const auto& [x, observed, sigma, model] : series.points) {
            values.x.include({x});
            values.y.include({0, observed - sigma, observed + sigma, model});
            residuals.y.include({(observed - model) / sigma - 1, (observed - model) / sigma + 1});
        }
    for (AxisRange* const range : {&values.x, &values.y, &residuals.y}) range->widen();
    residuals.x = values.x;
    draw_svg(svg, plot_page_width, residual_page_height, [&](const Page& page) {
        page.text({values.box.x0, 14}, plot.title, 10, black, Align::left, values.box.width());
        draw_legend(page, plot.series, {values.box.x0 + 4, 30});
        draw_axes(page, values, "", plot.y_title);
        draw_axes(page, residuals, plot.x_title, "residual / sigma");
        page.line(residuals.at(residuals.x.low, 0), residuals.at(residuals.x.high, 0), {0.8, grey});
        for (std::size_t n = 0; n < plot.series.size(); ++n)
            for (const auto& [x, observed, sigma, model] : plot.series[n].points) {
                const Pen pen{0.9, series_colour(n)};
                draw_measured(page, values, x, observed, sigma, pen);
                page.mark(values.at(x, model), Marker::cross, point_radius, {1, black});
                draw_measured(page, residuals, x, (observed - model) / sigma, 1, pen);
            }
    });
}

}  // namespace stratus
