#include <stratus/picture/line_plot.h>

#include <stratus/picture/round_number.h>
#include <stratus/runtime/number_text.h>

#include "plot_axes.h"

#include <cstddef>
#include <iterator>

namespace stratus {
namespace {

constexpr double page_height = 280;
constexpr Box plot_box{46, 26, plot_page_width - 110, page_height - 36};
constexpr Colour line_colours[] = {{0, 0, 0},          {0.10, 0.30, 0.65}, {0.05, 0.50, 0.35},
                                   {0.85, 0.45, 0.05}, {0.70, 0.25, 0.50}, {0.45, 0.65, 0.85},
                                   {0.40, 0.25, 0.10}, {0.60, 0.60, 0.10}};

/// Some five of them, at round numbers from 0 to `end`.
template <class Position>
std::vector<Tick> linear_ticks(double end, const Position& position) {
    std::vector<Tick> ticks;
    const double step = round_below(end / 4);
    for (int k = 0; k * step <= end * (1 + 1e-9); ++k)
        ticks.push_back({position(k * step), short_number(k * step, 3)});
    return ticks;
}

}  // namespace

void draw_line_plot(const LinePlot& plot, const std::filesystem::path& svg) {
    const Box& box = plot_box;
    const auto across = [&](double x) { return box.x0 + x / plot.x_end * box.width(); };
    const auto down = [&](double y) { return box.y1 - y / plot.y_end * box.height(); };
    draw_svg(svg, plot_page_width, page_height, [&](const Page& page) {
        page.text({box.x0, 16}, plot.title, 10, black);
        draw_x_axis(page, box, linear_ticks(plot.x_end, across), plot.x_title);
        draw_y_axis(page, box, linear_ticks(plot.y_end, down), plot.y_title);
        for (std::size_t n = 0; n < plot.lines.size(); ++n) {
            const Line& line = plot.lines[n];
            Pen pen{1.2, line_colours[n % std::size(line_colours)]};
            if (line.dashed) pen.dashes = {4, 3};
            std::vector<Point> curve;
            for (const auto& [x, y] : line.points) curve.push_back({across(x), down(y)});
            page.clipped(box, [&] { page.curve(curve, pen); });
            const double y = box.y0 + 10 + 14 * static_cast<double>(n);
            pen.width = 1.4;
            page.line({box.x1 + 8, y - 3}, {box.x1 + 26, y - 3}, pen);
            page.text({box.x1 + 31, y}, line.name, plot_text_size, black);
        }
    });
}

}  // namespace stratus
