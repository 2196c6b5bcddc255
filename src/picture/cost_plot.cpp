#include <stratus/picture/cost_plot.h>

#include <stratus/base/argument.h>

#include "plot_axes.h"

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
constexpr double mark_radius = 2.3, chosen_radius = 3.6;
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
                if (role == Role::chosen) draw_chosen_mark(page, frame.at(point.x, point.y));
                if (role == Role::measured)
                    draw_measured_mark(page, frame.at(point.x, point.y),
                                       series_style(panel, series));
            }
        }
}

// ---- Labels: each is placed near its point where it covers least

struct PointLabel {
    Point point;
    std::string text;
    bool is_required;  // drawn where it covers other things too, if need be
};

/// Areas that labels should not cover.
struct Obstacles {
    std::vector<Box> marks, lines;
};

constexpr double label_size = 7, padding = 0.8, descent = 1.2, ascent = 5.4;
constexpr double near = 8, far = 32;  // from the point

bool overlap(const Box& a, const Box& b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

bool contains(const Box& outer, const Box& inner) {
    return outer.x0 <= inner.x0 && inner.x1 <= outer.x1 && outer.y0 <= inner.y0 &&
           inner.y1 <= outer.y1;
}

double penalty(const Box& label, const Box& plot, const Obstacles& obstacles,
               const std::vector<Box>& placed) {
    constexpr double mark = 2, line = 1, other_label = 100, outside = 1000;
    double sum = contains(plot, label) ? 0 : outside;
    const auto add = [&](const std::vector<Box>& boxes, double each) {
        for (const Box& box : boxes) sum += overlap(label, box) ? each : 0;
    };
    add(obstacles.marks, mark);
    add(obstacles.lines, line);
    add(placed, other_label);
    return sum;
}

/// Places labels in their order; those without room are left out unless required.
void draw_labels(const Page& page, const Box& plot, const Obstacles& obstacles,
                 const std::vector<PointLabel>& labels) {
    constexpr double max_optional_penalty = 2;  // from here on a label is left out
    std::vector<Box> placed;
    for (const PointLabel& label : labels) {
        const double width = page.text_width(label.text, label_size) + 2 * padding;
        const double height = ascent + descent + 2 * padding;
        Box best{};
        double best_penalty = infinity;
        for (int distance = 5; distance <= (label.is_required ? far : near); distance += 3)
            for (const double angle : {-0.25, 0.0, 0.25, 0.75, 1.0, -0.75, 0.5, -0.5}) {
                const double across = std::cos(pi * angle), down = -std::sin(pi * angle);
                const double x = label.point.x + distance * across + across * width / 2;
                const double y = label.point.y + distance * down + down * height / 2;
                const Box box{x - width / 2, y - height / 2, x + width / 2, y + height / 2};
                const double met = penalty(box, plot, obstacles, placed) + 0.02 * distance;
                if (met >= best_penalty) continue;
                best_penalty = met;
                best = box;
            }
        if (!label.is_required && penalty(best, plot, obstacles, placed) >= max_optional_penalty)
            continue;
        placed.push_back(best);
        page.fill(best, white);
        page.text({best.x0 + padding, best.y1 - padding - descent}, label.text, label_size,
                  label.is_required ? black : grey);
    }
}

Obstacles series_obstacles(const Frame& frame, const PlotPanel& panel) {
    Obstacles obstacles;
    for (const PlotSeries& series : panel.series) {
        const double r = series.role == Role::chosen ? 1.25 * chosen_radius : mark_radius;
        for (std::size_t n = 0; n < series.points.size(); ++n) {
            const auto [x, y] = frame.at(series.points[n].x, series.points[n].y);
            if (series.role != Role::frontier) {
                obstacles.marks.push_back({x - r, y - r, x + r, y + r});
            } else if (n > 0) {
                const auto [from_x, from_y] =
                    frame.at(series.points[n - 1].x, series.points[n - 1].y);
                obstacles.lines.push_back({from_x, from_y - 0.5, x, from_y + 0.5});
                obstacles.lines.push_back({x - 0.5, from_y, x + 0.5, y});
            }
        }
    }
    return obstacles;
}

std::vector<PointLabel> point_labels(const Frame& frame, const PlotPanel& panel) {
    std::vector<PointLabel> labels;
    for (const Role role : {Role::chosen, Role::frontier, Role::measured})
        for (const PlotSeries& series : panel.series)
            if (series.role == role)
                for (const PlotPoint& point : series.points)
                    if (!point.label.empty())
                        labels.push_back(
                            {frame.at(point.x, point.y), point.label, role == Role::chosen});
    return labels;
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
    draw_labels(page, frame.box, series_obstacles(frame, panel), point_labels(frame, panel));
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
