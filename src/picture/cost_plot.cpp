#include <stratus/picture/cost_plot.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>

#include "page.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

namespace stratus {
namespace {

// ---- Sizes, in points of print: 1/72 inch

constexpr double page_width = 16 / 2.54 * 72;
constexpr double margin = 6, left = 50, right = 14;
constexpr double title_height = 17, legend_row = 12, plot_height = 196, axis_height = 34;
constexpr double panel_gap = 10;
constexpr double title_size = 9.5, text_size = 8, label_size = 7, exponent_size = 7;
constexpr double mark_radius = 2.3, chosen_radius = 3.6;

enum class Shape { circle, square, triangle, cross, plus, diamond };

/// Of measured series in their order: dark and light in turn, so that grey print tells them apart.
struct Style {
    Shape shape;
    Colour colour;
};

constexpr Style styles[] = {
    {Shape::circle, {0.10, 0.30, 0.65}}, {Shape::square, {0.88, 0.55, 0.10}},
    {Shape::cross, {0.05, 0.45, 0.35}},  {Shape::triangle, {0.80, 0.35, 0.60}},
    {Shape::plus, {0.40, 0.25, 0.10}},   {Shape::diamond, {0.45, 0.65, 0.85}},
};

// ---- Axes

/// Whole decades that hold all values.
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

struct Box {
    double x0, y0, x1, y1;

    bool overlaps(const Box& other) const {
        return x0 < other.x1 && other.x0 < x1 && y0 < other.y1 && other.y0 < y1;
    }
    bool holds(const Box& other) const {
        return x0 <= other.x0 && other.x1 <= x1 && y0 <= other.y0 && other.y1 <= y1;
    }
};

/// A panel's frame on the page and the values at its edges.
struct Frame {
    Box box;
    Decades x, y;

    double across(double value) const { return box.x0 + x.share(value) * (box.x1 - box.x0); }
    double down(double value) const { return box.y1 - y.share(value) * (box.y1 - box.y0); }
};

// ---- The page

class PlotPage : public Page {
  public:
    using Page::Page;

    /// 10 with its exponent; the same `share` as for text.
    void power_of_ten(double x, double y, int exponent, double share) const {
        const std::string base = "10";
        const std::string raised =
            (exponent < 0 ? "\u2212" : "") + std::to_string(std::abs(exponent));
        const double start = x - share * (width(base, text_size) + width(raised, exponent_size));
        text(start, y, base, text_size, black);
        text(start + width(base, text_size), y - 3.2, raised, exponent_size, black);
    }

    void mark(double x, double y, const Style& style) const {
        const double r = mark_radius;
        cairo_new_path(cairo_);
        switch (style.shape) {
            case Shape::circle: cairo_arc(cairo_, x, y, r, 0, 2 * pi); break;
            case Shape::square: cairo_rectangle(cairo_, x - r, y - r, 2 * r, 2 * r); break;
            case Shape::triangle: polygon(x, y, {{0, -1.3}, {1.2, 0.9}, {-1.2, 0.9}}, r); break;
            case Shape::diamond:
                polygon(x, y, {{0, -1.3}, {1.3, 0}, {0, 1.3}, {-1.3, 0}}, r);
                break;
            case Shape::cross: strokes(x, y, r, r); break;
            case Shape::plus: strokes(x, y, 1.3 * r, 0); break;
        }
        colour(style.colour);
        cairo_set_line_width(cairo_, 0.9);
        cairo_stroke(cairo_);
    }

    /// Black with a white rim.
    void chosen_mark(double x, double y) const {
        cairo_new_path(cairo_);
        polygon(x, y, {{0, -1.25}, {1.25, 0}, {0, 1.25}, {-1.25, 0}}, chosen_radius);
        colour(white);
        cairo_set_line_width(cairo_, 1.6);
        cairo_stroke_preserve(cairo_);
        colour(black);
        cairo_fill(cairo_);
    }

  private:
    struct Corner {
        double x, y;
    };

    void polygon(double x, double y, std::initializer_list<Corner> corners, double r) const {
        for (const Corner& corner : corners)
            cairo_line_to(cairo_, x + r * corner.x, y + r * corner.y);
        cairo_close_path(cairo_);
    }

    /// Two strokes at right angles through the middle.
    void strokes(double x, double y, double dx, double dy) const {
        cairo_move_to(cairo_, x - dx, y - dy);
        cairo_line_to(cairo_, x + dx, y + dy);
        cairo_move_to(cairo_, x - dy, y + dx);
        cairo_line_to(cairo_, x + dy, y - dx);
    }
};

// ---- Series

/// What a series is drawn with: its style, or none for a frontier and what is chosen.
std::vector<const Style*> styles_of(const PlotPanel& panel) {
    std::vector<const Style*> chosen;
    std::size_t next = 0;
    for (const PlotSeries& series : panel.series)
        chosen.push_back(series.role == PlotSeries::Role::measured
                             ? &styles[next++ % std::size(styles)]
                             : nullptr);
    return chosen;
}

void draw_steps(const PlotPage& page, const Frame& frame, const PlotSeries& series) {
    cairo_t* const cairo = page.cairo();
    cairo_new_path(cairo);
    double y = 0;
    for (const PlotPoint& point : series.points) {
        if (&point != &series.points.front()) cairo_line_to(cairo, frame.across(point.x), y);
        y = frame.down(point.y);
        cairo_line_to(cairo, frame.across(point.x), y);
    }
    page.colour(black);
    cairo_set_line_width(cairo, 0.9);
    cairo_stroke(cairo);
}

void draw_series(const PlotPage& page, const Frame& frame, const PlotPanel& panel) {
    const std::vector<const Style*> drawn_with = styles_of(panel);
    using Role = PlotSeries::Role;
    for (const Role role : {Role::measured, Role::frontier, Role::chosen})
        for (std::size_t s = 0; s < panel.series.size(); ++s) {
            const PlotSeries& series = panel.series[s];
            if (series.role != role) continue;
            if (role == Role::frontier) {
                draw_steps(page, frame, series);
                continue;
            }
            for (const PlotPoint& point : series.points) {
                const double x = frame.across(point.x), y = frame.down(point.y);
                if (role == Role::chosen)
                    page.chosen_mark(x, y);
                else
                    page.mark(x, y, *drawn_with[s]);
            }
        }
}

// ---- Labels: each where it covers least

class Labels {
  public:
    Labels(const PlotPage& page, const Frame& frame, const PlotPanel& panel)
        : page_(page), frame_(frame) {
        for (const PlotSeries& series : panel.series) {
            const double r =
                series.role == PlotSeries::Role::chosen ? 1.25 * chosen_radius : mark_radius;
            for (std::size_t n = 0; n < series.points.size(); ++n) {
                const double x = frame.across(series.points[n].x);
                const double y = frame.down(series.points[n].y);
                if (series.role != PlotSeries::Role::frontier) {
                    marks_.push_back({x - r, y - r, x + r, y + r});
                } else if (n > 0) {
                    const double from_x = frame.across(series.points[n - 1].x);
                    const double from_y = frame.down(series.points[n - 1].y);
                    lines_.push_back({from_x, from_y - 0.5, x, from_y + 0.5});
                    lines_.push_back({x - 0.5, from_y, x + 0.5, y});
                }
            }
        }
    }

    void draw(const PlotSeries& series) {
        const bool must = series.role == PlotSeries::Role::chosen;
        for (const PlotPoint& point : series.points) {
            if (point.label.empty()) continue;
            const Box best = place(point, must ? farthest : near);
            if (!must && cost(best) >= worth_leaving_out) continue;
            labels_.push_back(best);
            page_.colour(white);
            cairo_rectangle(page_.cairo(), best.x0, best.y0, best.x1 - best.x0, best.y1 - best.y0);
            cairo_fill(page_.cairo());
            page_.text(best.x0 + padding, best.y1 - padding - descent, point.label, label_size,
                       must ? black : quiet);
        }
    }

  private:
    static constexpr double padding = 0.8, descent = 1.2, ascent = 5.4;
    static constexpr double over_mark = 2, over_line = 1, over_label = 100, off_frame = 1000;
    static constexpr double worth_leaving_out = 2;
    static constexpr double near = 8, farthest = 32;

    double cost(const Box& label) const {
        double sum = frame_.box.holds(label) ? 0 : off_frame;
        auto count = [&](const std::vector<Box>& boxes, double each) {
            for (const Box& box : boxes) sum += label.overlaps(box) ? each : 0;
        };
        count(marks_, over_mark);
        count(lines_, over_line);
        count(labels_, over_label);
        return sum;
    }

    /// Round the point, near first; the first of the places that cover least.
    Box place(const PlotPoint& point, double most) const {
        const double width = page_.width(point.label, label_size) + 2 * padding;
        const double height = ascent + descent + 2 * padding;
        const double x = frame_.across(point.x), y = frame_.down(point.y);
        Box best{};
        double least = infinity;
        for (int away = 5; away <= most; away += 3)
            for (const double angle : {-0.25, 0.0, 0.25, 0.75, 1.0, -0.75, 0.5, -0.5}) {
                const double across = std::cos(pi * angle), down = -std::sin(pi * angle);
                const double middle_x = x + away * across + across * width / 2;
                const double middle_y = y + away * down + down * height / 2;
                const Box box{middle_x - width / 2, middle_y - height / 2, middle_x + width / 2,
                              middle_y + height / 2};
                const double met = cost(box) + 0.02 * away;
                if (met < least) {
                    least = met;
                    best = box;
                }
            }
        return best;
    }

    const PlotPage& page_;
    const Frame& frame_;
    std::vector<Box> marks_, lines_, labels_;
};

void draw_labels(const PlotPage& page, const Frame& frame, const PlotPanel& panel) {
    Labels labels(page, frame, panel);
    using Role = PlotSeries::Role;
    for (const Role role : {Role::chosen, Role::frontier, Role::measured})
        for (const PlotSeries& series : panel.series)
            if (series.role == role) labels.draw(series);
}

// ---- Frame and legend

void draw_axes(const PlotPage& page, const Frame& frame, const PlotPanel& panel) {
    const Box& box = frame.box;
    const auto every = [](const Decades& decades, double length, double least) {
        return std::max(1, static_cast<int>(std::ceil(least * decades.count() / length)));
    };
    const int x_step = every(frame.x, box.x1 - box.x0, 30);
    const int y_step = every(frame.y, box.y1 - box.y0, 11);
    for (int decade = frame.x.first; decade <= frame.x.last; ++decade) {
        const double x = frame.across(std::pow(10.0, decade));
        page.line(x, box.y0, x, box.y1, 0.5, grid);
        if ((decade - frame.x.first) % x_step == 0) page.power_of_ten(x, box.y1 + 13, decade, 0.5);
        for (int digit = 2; digit < 10 && decade < frame.x.last; ++digit) {
            const double between = frame.across(digit * std::pow(10.0, decade));
            page.line(between, box.y1, between, box.y1 - 2.5, 0.5, quiet);
        }
    }
    for (int decade = frame.y.first; decade <= frame.y.last; ++decade) {
        const double y = frame.down(std::pow(10.0, decade));
        page.line(box.x0, y, box.x1, y, 0.5, grid);
        if ((decade - frame.y.first) % y_step == 0) page.power_of_ten(box.x0 - 4, y + 3, decade, 1);
    }
    page.colour(black);
    cairo_set_line_width(page.cairo(), 0.7);
    cairo_rectangle(page.cairo(), box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0);
    cairo_stroke(page.cairo());
    page.text((box.x0 + box.x1) / 2, box.y1 + 26, panel.x_title, text_size, black, 0.5);
    cairo_save(page.cairo());
    cairo_translate(page.cairo(), margin + text_size, (box.y0 + box.y1) / 2);
    cairo_rotate(page.cairo(), -pi / 2);
    page.text(0, 0, panel.y_title, text_size, black, 0.5);
    cairo_restore(page.cairo());
}

/// Where each entry of a legend stands, from the legend's upper left corner; as many rows as
/// needed.
struct Legend {
    struct Entry {
        double x;
        int row;
    };
    std::vector<Entry> entries;
    int rows = 1;
};

constexpr double key_width = 16, entry_gap = 12;

Legend make_legend(const PlotPage& page, const PlotPanel& panel) {
    Legend legend;
    double x = 0;
    for (const PlotSeries& series : panel.series) {
        const double width =
            series.points.empty() ? 0 : key_width + page.width(series.name, text_size);
        if (x > 0 && x + width > page_width - left - right) {
            x = 0;
            ++legend.rows;
        }
        legend.entries.push_back({x, legend.rows - 1});
        if (width > 0) x += width + entry_gap;
    }
    return legend;
}

void draw_legend(const PlotPage& page, const Legend& legend, const PlotPanel& panel, double top) {
    const std::vector<const Style*> drawn_with = styles_of(panel);
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
        const PlotSeries& series = panel.series[s];
        if (series.points.empty()) continue;
        const double x = left + legend.entries[s].x;
        const double y = top + legend_row * legend.entries[s].row + 6;
        const double middle = x + key_width / 2 - 2;
        if (series.role == PlotSeries::Role::measured) page.mark(middle, y, *drawn_with[s]);
        if (series.role == PlotSeries::Role::chosen) page.chosen_mark(middle, y);
        if (series.role == PlotSeries::Role::frontier)
            page.line(x, y, x + key_width - 4, y, 0.9, black);
        page.text(x + key_width, y + 3, series.name, text_size, black);
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

double height_above(const Legend& legend) { return title_height + legend_row * legend.rows + 4; }

void draw_panel(const PlotPage& page, const PlotPanel& panel, const Legend& legend, double top) {
    Frame frame{{left, top + height_above(legend), page_width - right, 0}, {}, {}};
    frame.box.y1 = frame.box.y0 + plot_height;
    for (const PlotSeries& series : panel.series)
        for (const PlotPoint& point : series.points) {
            frame.x.include(point.x);
            frame.y.include(point.y);
        }
    page.text(left, top + 10, panel.title, title_size, black);
    draw_legend(page, legend, panel, top + title_height);
    draw_axes(page, frame, panel);
    draw_series(page, frame, panel);
    draw_labels(page, frame, panel);
}

/// Measures text as the page will.
Surface make_scratch() {
    return Surface(cairo_recording_surface_create(CAIRO_CONTENT_COLOR, nullptr));
}

}  // namespace

void draw_cost_plot(const std::vector<PlotPanel>& panels, const std::filesystem::path& svg) {
    check(panels);
    const Surface scratch = make_scratch();
    const Context measuring(cairo_create(scratch.get()));
    std::vector<Legend> legends;
    double height = 2 * margin + panel_gap * static_cast<double>(panels.size() - 1);
    for (const PlotPanel& panel : panels) {
        legends.push_back(make_legend(PlotPage(measuring.get()), panel));
        height += height_above(legends.back()) + plot_height + axis_height;
    }

    write_svg(svg, page_width, height, [&](cairo_t* cairo) {
        const PlotPage page(cairo);
        double top = margin;
        for (std::size_t p = 0; p < panels.size(); ++p) {
            draw_panel(page, panels[p], legends[p], top);
            top += height_above(legends[p]) + plot_height + axis_height + panel_gap;
        }
    });
}

}  // namespace stratus
