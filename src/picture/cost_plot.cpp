#include <stratus/picture/plots.h>

#include <stratus/base/argument.h>

#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

namespace stratus {
namespace {

using Role = PlotSeries::Role;

// ---- Sizes, in points

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
    {Marker::circle, {0.10, 0.30, 0.65}}, {Marker::square, {0.88, 0.55, 0.10}},
    {Marker::cross, {0.05, 0.45, 0.35}},  {Marker::triangle, {0.80, 0.35, 0.60}},
    {Marker::plus, {0.40, 0.25, 0.10}},   {Marker::diamond, {0.45, 0.65, 0.85}},
    {Marker::circle, {0.80, 0.15, 0.10}}, {Marker::square, {0.30, 0.30, 0.30}},
};

// ---- Axes

/// Whole decades that contain all values.
struct Decades {
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();

    void include(double value) {
        const double decade = std::log10(value);
        first = std::min(first, static_cast<int>(std::floor(decade)));
        last = std::max(last, static_cast<int>(std::ceil(decade)));
        if (first == last) ++last;
    }
    int count() const { return last - first; }

    /// 0 at the first decade, 1 at the last.
    double share(double value) const { return (std::log10(value) - first) / count(); }
};

using Frame = PlotFrame<Decades>;

void draw_axes(const Page& page, const Frame& frame, const PlotPanel& panel) {
    const Box& box = frame.box;
    draw_x_axis(page, box,
                decade_ticks(frame.x.first, frame.x.last, box.width(), 30,
                             [&](double x) { return frame.across(x); }),
                panel.x_title);
    for (int decade = frame.x.first; decade < frame.x.last; ++decade)
        for (int digit = 2; digit < 10; ++digit) {
            const double x = frame.across(digit * std::pow(10.0, decade));
            page.line({x, box.y1}, {x, box.y1 - 2.5}, {0.5, grey});
        }
    draw_y_axis(page, box,
                decade_ticks(frame.y.first, frame.y.last, box.height(), 11,
                             [&](double y) { return frame.down(y); }),
                panel.y_title);
    page.outline(box, {0.7, black});
}

// ---- Series

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

void draw_steps(const Page& page, const Frame& frame, const PlotSeries& series) {
    std::vector<Point> steps;
    for (const PlotPoint& point : series.points) {
        const Point at = frame.at(point.x, point.y);
        if (!steps.empty()) steps.push_back({at.x, steps.back().y});
        steps.push_back(at);
    }
    page.curve(steps, {0.9, black});
}

void draw_series(const Page& page, const Frame& frame, const PlotPanel& panel) {
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

// ---- Legend

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

// ---- The whole

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
    Frame frame{{left, top + legend_height(panel), plot_page_width - right, 0}, {}, {}};
    frame.box.y1 = frame.box.y0 + plot_height;
    for (const PlotSeries& series : panel.series)
        for (const PlotPoint& point : series.points) {
            frame.x.include(point.x);
            frame.y.include(point.y);
        }
    page.text({left, top + 10}, panel.title, title_size, black);
    draw_legend(page, panel, top + title_height);
    draw_axes(page, frame, panel);
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

}  // namespace stratus
