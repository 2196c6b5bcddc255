#include <stratus/picture/plots.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include "page.h"

#include <iterator>

namespace stratus {

// ---- lines over axes

namespace {

constexpr double plot_bottom = 244, page_height = 280, line_legend_row = 14;
constexpr Colour blue{0.10, 0.30, 0.65}, green{0.05, 0.50, 0.35}, orange{0.85, 0.45, 0.05},
    rose{0.70, 0.25, 0.50}, sky{0.45, 0.65, 0.85}, brown{0.40, 0.25, 0.10}, olive{0.60, 0.60, 0.10};
constexpr Colour line_colours[] = {black, blue, green, orange, rose, sky, brown, olive};

constexpr double lowest = 1e-99;  // for 0 on a logarithmic axis, which is clipped

}  // namespace

void draw_line_plot(const LinePlot& plot, const std::filesystem::path& svg) {
    const bool below = plot.legend_below;
    const bool logarithmic = plot.y_begin > 0;
    const PlotFrame frame{{46, 26, plot_page_width - (below ? 14 : 110), plot_bottom},
                          {plot.x_title, false, 0, plot.x_end},
                          {plot.y_title, logarithmic, plot.y_begin, plot.y_end}};
    const Box& box = frame.box;
    const double rows = below ? static_cast<double>(plot.lines.size()) : 0;
    const Point legend = below ? Point{box.x0, page_height + 8} : Point{box.x1 + 8, box.y0 + 10};
    draw_svg(svg, plot_page_width, page_height + line_legend_row * rows, [&](const Page& page) {
        page.text({box.x0, 16}, plot.title, 10, black);
        draw_x_axis(page, frame);
        draw_y_axis(page, frame);
        for (std::size_t n = 0; n < plot.lines.size(); ++n) {
            const Line& line = plot.lines[n];
            Pen pen{1.2, line_colours[n % std::size(line_colours)]};
            if (line.dashed) pen.dashes = {4, 3};
            std::vector<Point> curve;
            for (const auto& [x, y] : line.points)
                curve.push_back(frame.at(x, logarithmic ? std::max(y, lowest) : y));
            page.clipped(box, [&] { page.curve(curve, pen); });
            const double y = legend.y + line_legend_row * static_cast<double>(n);
            pen.width = 1.4;
            page.line({legend.x, y - 3}, {legend.x + 18, y - 3}, pen);
            page.text({legend.x + 23, y}, line.name, plot_text_size, black);
        }
    });
}

// ---- observed values, a model's, and residuals

namespace {

constexpr double values_top = 40, values_bottom = 230, residuals_top = 252, residuals_bottom = 340;
constexpr double residual_page_height = 376, point_radius = 2.2;
constexpr Colour series_colours[] = {blue, orange, green, rose};

Colour series_colour(std::size_t series) {
    return series_colours[series % std::size(series_colours)];
}

/// A value with its bar.
void draw_measured(const Page& page, const PlotFrame& frame, double x, double y, double sigma,
                   const Pen& pen) {
    page.line(frame.at(x, y - sigma), frame.at(x, y + sigma), pen);
    page.mark(frame.at(x, y), Marker::circle, point_radius, pen);
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
    PlotFrame values{{46, values_top, plot_page_width - 14, values_bottom}, {}, {plot.y_title}};
    PlotFrame residuals{{46, residuals_top, plot_page_width - 14, residuals_bottom},
                        {},
                        {"residual / sigma", false, -2, 2}};
    for (const ResidualSeries& series : plot.series)
        for (const auto& [x, observed, sigma, model] : series.points) {
            values.x.include({x});
            values.y.include({0, observed - sigma, observed + sigma, model});
            residuals.y.include({(observed - model) / sigma - 1, (observed - model) / sigma + 1});
        }
    for (PlotAxis* const axis : {&values.x, &values.y, &residuals.y}) axis->round();
    residuals.x = values.x;
    residuals.x.title = plot.x_title;
    draw_svg(svg, plot_page_width, residual_page_height, [&](const Page& page) {
        page.text({values.box.x0, 14}, plot.title, 10, black, Align::left, values.box.width());
        draw_legend(page, plot.series, {values.box.x0 + 4, 30});
        for (const PlotFrame* const frame : {&values, &residuals}) {
            draw_x_axis(page, *frame);
            draw_y_axis(page, *frame);
        }
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

// ---- error against cost

namespace {

using Role = PlotSeries::Role;

// Sizes, in points

constexpr double margin = 6, left = 50, right = 14;
constexpr double title_height = 17, legend_row = 12, plot_height = 196, axis_height = 34;
constexpr double panel_gap = 10;
constexpr double title_size = 9.5;
constexpr double label_size = 7, mark_radius = 2.3, chosen_radius = 3.6;
constexpr double key_width = 16;  // of the legend

struct Style {
    Marker marker;
    Colour colour;
};

/// Styles of measured series in their order: dark and light alternate, for print without colour.
constexpr Style styles[] = {
    {Marker::circle, blue},
    {Marker::square, {0.88, 0.55, 0.10}},
    {Marker::cross, {0.05, 0.45, 0.35}},
    {Marker::triangle, {0.80, 0.35, 0.60}},
    {Marker::plus, brown},
    {Marker::diamond, sky},
    {Marker::circle, {0.80, 0.15, 0.10}},
    {Marker::square, {0.30, 0.30, 0.30}},
};

void draw_axes(const Page& page, const PlotFrame& frame) {
    draw_x_axis(page, frame);
    const Box& box = frame.box;
    const double last = std::log10(frame.x.high) - 0.5;
    for (double decade = std::log10(frame.x.low); decade < last; ++decade)
        for (int digit = 2; digit < 10; ++digit) {
            const double x = frame.across(digit * std::pow(10.0, decade));
            page.line({x, box.y1}, {x, box.y1 - 2.5}, {0.5, grey});
        }
    draw_y_axis(page, frame);
    page.outline(box, {0.7, black});
}

// Series

/// Returns the style of a measured series, by its place among them.
const Style& series_style(const PlotPanel& panel, const PlotSeries& series) {
    const auto before = std::count_if(panel.series.data(), &series, [](const PlotSeries& other) {
        return other.role == Role::measured;
    });
    return styles[static_cast<std::size_t>(before) % std::size(styles)];
}

void draw_measured_mark(const Page& page, Point at, const Style& style) {
    page.mark(at, style.marker, mark_radius, {0.9, style.colour});
}

/// Black with a white rim.
void draw_chosen_mark(const Page& page, Point at) {
    std::vector<Point> shape{{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}};
    for (Point& corner : shape)
        corner = {at.x + chosen_radius * corner.x, at.y + chosen_radius * corner.y};
    page.outline(shape, {1.6, white});
    page.fill(shape, black);
}

void draw_steps(const Page& page, const PlotFrame& frame, const PlotSeries& series) {
    std::vector<Point> steps;
    for (const PlotPoint& point : series.points) {
        const Point at = frame.at(point.x, point.y);
        if (!steps.empty()) steps.push_back({at.x, steps.back().y});
        steps.push_back(at);
    }
    page.curve(steps, {0.9, black});
}

void draw_series(const Page& page, const PlotFrame& frame, const PlotPanel& panel) {
    for (const Role role : {Role::measured, Role::frontier, Role::chosen})
        for (const PlotSeries& series : panel.series) {
            if (series.role != role) continue;
            if (role == Role::frontier) draw_steps(page, frame, series);
            for (const PlotPoint& point : series.points) {
                const Point at = frame.at(point.x, point.y);
                if (role == Role::chosen) draw_chosen_mark(page, at);
                if (role == Role::measured)
                    draw_measured_mark(page, at, series_style(panel, series));
            }
        }
    // Errors fall as costs rise: above and to the right of a chosen point there are few others.
    for (const PlotSeries& series : panel.series)
        for (const PlotPoint& point : series.points) {
            const Point at = frame.at(point.x, point.y);
            const bool has_room =
                at.x + 5 + page.text_width(point.label, label_size) < frame.box.x1;
            page.haloed_text({at.x + (has_room ? 5 : -5), at.y - 3}, point.label, label_size, black,
                             {2, white}, has_room ? Align::left : Align::right);
        }
}

// Legend

constexpr std::size_t legend_columns = 3;

std::vector<const PlotSeries*> series_in_legend(const PlotPanel& panel) {
    std::vector<const PlotSeries*> shown;
    for (const PlotSeries& series : panel.series)
        if (!series.points.empty()) shown.push_back(&series);
    return shown;
}

double legend_height(const PlotPanel& panel) {
    const std::size_t rows = (series_in_legend(panel).size() + legend_columns - 1) / legend_columns;
    return title_height + legend_row * static_cast<double>(rows) + 4;
}

void draw_legend(const Page& page, const PlotPanel& panel, double top) {
    constexpr double column = (plot_page_width - left - right) / legend_columns;
    const std::vector<const PlotSeries*> shown = series_in_legend(panel);
    for (std::size_t n = 0; n < shown.size(); ++n) {
        const double x = left + column * static_cast<double>(n % legend_columns);
        const double y = top + legend_row * static_cast<double>(n / legend_columns) + 6;
        const Point key{x + key_width / 2 - 2, y};
        switch (shown[n]->role) {
            case Role::measured:
                draw_measured_mark(page, key, series_style(panel, *shown[n]));
                break;
            case Role::chosen: draw_chosen_mark(page, key); break;
            case Role::frontier: page.line({x, y}, {x + key_width - 4, y}, {0.9, black}); break;
        }
        page.text({x + key_width, y + 3}, shown[n]->name, plot_text_size, black);
    }
}

// The whole

void check(const std::vector<PlotPanel>& panels) {
    require(!panels.empty(), "draw_cost_plot", "panels", "at least one", "none");
    for (const PlotPanel& panel : panels) {
        bool any = false;
        for (const PlotSeries& series : panel.series)
            for (const PlotPoint& point : series.points) {
                any = true;
                for (const auto& [name, value] : {std::pair("x", point.x), std::pair("y", point.y)})
                    require(value > 0 && std::isfinite(value), "draw_cost_plot",
                            std::string(name) + " of '" + series.name + "'", "above 0 and finite",
                            value);
            }
        require(any, "draw_cost_plot", "panel '" + panel.title + "'", "one with points", "none");
    }
}

void draw_panel(const Page& page, const PlotPanel& panel, double top) {
    const double box_top = top + legend_height(panel);
    PlotFrame frame{{left, box_top, plot_page_width - right, box_top + plot_height},
                    {panel.x_title, true},
                    {panel.y_title, true}};
    for (const PlotSeries& series : panel.series)
        for (const PlotPoint& point : series.points) {
            frame.x.include({point.x});
            frame.y.include({point.y});
        }
    frame.x.round();
    frame.y.round();
    page.text({left, top + 10}, panel.title, title_size, black);
    draw_legend(page, panel, top + title_height);
    draw_axes(page, frame);
    draw_series(page, frame, panel);
}

}  // namespace

void draw_cost_plot(const std::vector<PlotPanel>& panels, const std::filesystem::path& svg) {
    check(panels);
    double height = 2 * margin - panel_gap;
    for (const PlotPanel& panel : panels)
        height += legend_height(panel) + plot_height + axis_height + panel_gap;
    draw_svg(svg, plot_page_width, height, [&](const Page& page) {
        double top = margin;
        for (const PlotPanel& panel : panels) {
            draw_panel(page, panel, top);
            top += legend_height(panel) + plot_height + axis_height + panel_gap;
        }
    });
}

// ---- lobes

namespace {

// In points.
constexpr double lobe_margin = 10, lobe_left = 52, cell_width = 88, cell_height = 84,
                 block_gap = 18;
constexpr double title_line = 18, names_line = 36, block_line = 56, angle_line = 70;
constexpr double heading = 78, row_gap = 16;
constexpr double layer_height = 5, layer_width = 70, max_radius = 39;
constexpr double lobe_title_size = 11, text_size = 9;

constexpr Colour curve_colours[] = {blue, green, orange, rose, brown, sky, {0.20, 0.20, 0.20},
                                    olive};

Colour curve_colour(std::size_t curve) { return curve_colours[curve % std::size(curve_colours)]; }

double row_middle(std::size_t row) {
    return heading + (static_cast<double>(row) + 0.5) * (cell_height + row_gap);
}

double column_middle(std::size_t column) {
    return (static_cast<double>(column) + 0.5) * cell_width;
}

double max_value(const std::vector<LobePanel>& row) {
    double max = 0;
    for (const LobePanel& panel : row)
        for (const LobeCurve& curve : panel.curves)
            for (const auto* side : {&curve.above, &curve.below})
                for (const double radius : *side) max = std::max(max, radius);
    return max;
}

double max_value(const LobeBlock& block) {
    double max = 0;
    for (const auto& row : block.rows) max = std::max(max, max_value(row));
    return max;
}

void draw_panel(const Page& page, const LobePanel& panel, double scale, double circle) {
    page.arc({0, 0}, circle * scale, 0, 2 * pi, {0.5, grid});
    const Box layer{-layer_width / 2, -layer_height / 2, layer_width / 2, layer_height / 2};
    page.fill(layer, {0.93, 0.93, 0.93});
    page.outline(layer, {0.5, grey});
    const double ray = 0.98 * cell_width / 2;
    page.line({ray * std::sin(panel.incident), -ray * std::cos(panel.incident)}, {0, 0},
              {0.9, {0.85, 0.60, 0.0}});
    for (std::size_t c = 0; c < panel.curves.size(); ++c) {
        const Pen pen{0.9, curve_colour(c)};
        page.curve(lobe_outline(panel.curves[c].above, scale, 1), pen);
        page.curve(lobe_outline(panel.curves[c].below, scale, -1), pen);
    }
}

constexpr double line_length = 16, names_gap = 32;

double names_width(const Page& page, const std::vector<std::string>& names) {
    double width = -12;
    for (const std::string& name : names) width += page.text_width(name, text_size) + names_gap;
    return width;
}

/// From the left, under the title.
void draw_names(const Page& page, const std::vector<std::string>& names) {
    double x = lobe_margin;
    for (std::size_t n = 0; n < names.size(); ++n) {
        page.line({x, names_line - 3}, {x + line_length, names_line - 3}, {1.4, curve_colour(n)});
        page.text({x + line_length + 4, names_line}, names[n], text_size, black);
        x += page.text_width(names[n], text_size) + names_gap;
    }
}

void draw_block(const Page& page, const LobeBlock& block, double x, bool common_scale) {
    page.text({x + 6, block_line}, block.title, text_size, black);
    for (std::size_t c = 0; c < block.rows[0].size(); ++c)
        page.text({x + column_middle(c), angle_line},
                  short_number(block.rows[0][c].incident * 180 / pi, 3) + "\u00b0", 8, grey,
                  Align::centre);
    for (std::size_t r = 0; r < block.rows.size(); ++r) {
        const double largest = common_scale ? max_value(block) : max_value(block.rows[r]);
        const double max = largest > 0 ? largest : 1;
        const double scale = max_radius / max, circle = round_below(max);
        page.text({x + 4, row_middle(r) + cell_height / 2 + 5}, "circle " + short_number(circle, 3),
                  7, grey);
        for (std::size_t c = 0; c < block.rows[r].size(); ++c)
            page.translated({x + column_middle(c), row_middle(r)},
                            [&] { draw_panel(page, block.rows[r][c], scale, circle); });
    }
}

}  // namespace

void draw_lobe_plot(const LobePlot& plot, const std::filesystem::path& svg) {
    std::size_t columns = 0;
    for (const LobeBlock& block : plot.blocks) columns += block.rows[0].size();
    double width = lobe_left + static_cast<double>(columns) * cell_width + lobe_margin +
                   block_gap * (static_cast<double>(plot.blocks.size()) - 1);
    measure([&](const Page& page) {
        width = std::max({width, 2 * lobe_margin + page.text_width(plot.title, lobe_title_size),
                          2 * lobe_margin + names_width(page, plot.names)});
    });
    const double height = heading +
                          static_cast<double>(plot.row_titles.size()) * (cell_height + row_gap) +
                          lobe_margin;
    draw_svg(svg, width, height, [&](const Page& page) {
        page.text({lobe_margin, title_line}, plot.title, lobe_title_size, black);
        draw_names(page, plot.names);
        for (std::size_t r = 0; r < plot.row_titles.size(); ++r)
            page.text({lobe_margin, row_middle(r) + 3}, plot.row_titles[r], text_size, black);
        double x = lobe_left;
        for (const LobeBlock& block : plot.blocks) {
            draw_block(page, block, x, plot.common_scale);
            x += static_cast<double>(block.rows[0].size()) * cell_width + block_gap;
        }
    });
}

}  // namespace stratus
