#include <stratus/picture/plots.h>

#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>

namespace stratus {
namespace {

constexpr double plot_bottom = 244, page_height = 280, legend_row = 14;
constexpr Colour line_colours[] = {{0, 0, 0},          {0.10, 0.30, 0.65}, {0.05, 0.50, 0.35},
                                   {0.85, 0.45, 0.05}, {0.70, 0.25, 0.50}, {0.45, 0.65, 0.85},
                                   {0.40, 0.25, 0.10}, {0.60, 0.60, 0.10}};

constexpr double lowest = 1e-99;  // for 0 on a logarithmic axis, which is clipped

/// Ticks at the powers of ten from y_begin to y_end.
std::vector<Tick> decades(const LinePlot& plot, const Box& box,
                          const std::function<double(double)>& down) {
    const int first = static_cast<int>(std::ceil(std::log10(plot.y_begin) - 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(plot.y_end) + 1e-9));
    return decade_ticks(first, last, box.height(), 11, down);
}

}  // namespace

void draw_line_plot(const LinePlot& plot, const std::filesystem::path& svg) {
    const bool below = plot.legend_below;
    const Box box{46, 26, plot_page_width - (below ? 14 : 110), plot_bottom};
    const double rows = below ? static_cast<double>(plot.lines.size()) : 0;
    const Point legend = below ? Point{box.x0, page_height + 8} : Point{box.x1 + 8, box.y0 + 10};
    const bool logarithmic = plot.y_begin > 0;
    const auto across = [&](double x) { return box.x0 + x / plot.x_end * box.width(); };
    const auto down = [&](double y) {
        const double share = logarithmic
                                 ? std::log(y / plot.y_begin) / std::log(plot.y_end / plot.y_begin)
                                 : y / plot.y_end;
        return box.y1 - share * box.height();
    };
    draw_svg(svg, plot_page_width, page_height + legend_row * rows, [&](const Page& page) {
        page.text({box.x0, 16}, plot.title, 10, black);
        draw_x_axis(page, box, linear_ticks(0, plot.x_end, across), plot.x_title);
        draw_y_axis(page, box,
                    logarithmic ? decades(plot, box, down) : linear_ticks(0, plot.y_end, down),
                    plot.y_title);
        for (std::size_t n = 0; n < plot.lines.size(); ++n) {
            const Line& line = plot.lines[n];
            Pen pen{1.2, line_colours[n % std::size(line_colours)]};
            if (line.dashed) pen.dashes = {4, 3};
            std::vector<Point> curve;
            for (const auto& [x, y] : line.points)
                curve.push_back({across(x), down(logarithmic ? std::max(y, lowest) : y)});
            page.clipped(box, [&] { page.curve(curve, pen); });
            const double y = legend.y + legend_row * static_cast<double>(n);
            pen.width = 1.4;
            page.line({legend.x, y - 3}, {legend.x + 18, y - 3}, pen);
            page.text({legend.x + 23, y}, line.name, plot_text_size, black);
        }
    });
}

}  // namespace stratus
