#include <stratus/picture/line_plot.h>

#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include "page.h"

#include <cmath>

namespace stratus {
namespace {

constexpr double page_width = 16 / 2.54 * 72, page_height = 280;
constexpr double left = 46, right = 110, top = 26, bottom = 36;
constexpr Colour line_colours[] = {{0, 0, 0},          {0.10, 0.30, 0.65}, {0.05, 0.50, 0.35},
                                   {0.85, 0.45, 0.05}, {0.70, 0.25, 0.50}, {0.45, 0.65, 0.85},
                                   {0.40, 0.25, 0.10}, {0.60, 0.60, 0.10}};

/// 1, 2 or 5 times a power of ten that divides `end` into some five parts.
double tick_step(double end) {
    const double unit = std::pow(10.0, std::floor(std::log10(end / 4)));
    const double part = end / 4 / unit;
    return unit * (part < 2 ? 1 : part < 5 ? 2 : 5);
}

}  // namespace

void draw_line_plot(const LinePlot& plot, const std::filesystem::path& svg) {
    write_svg(svg, page_width, page_height, [&](cairo_t* cairo) {
        const Page page(cairo);
        const double x1 = page_width - right, y1 = page_height - bottom;
        auto across = [&](double x) { return left + x / plot.x_end * (x1 - left); };
        auto down = [&](double y) { return y1 - y / plot.y_end * (y1 - top); };
        page.text(left, 16, plot.title, 10, black);
        const double x_step = tick_step(plot.x_end), y_step = tick_step(plot.y_end);
        for (int k = 0; k * x_step <= plot.x_end * (1 + 1e-9); ++k) {
            page.line(across(k * x_step), top, across(k * x_step), y1, 0.5, grid);
            page.text(across(k * x_step), y1 + 12, short_number(k * x_step, 3), 8, black, 0.5);
        }
        for (int k = 0; k * y_step <= plot.y_end * (1 + 1e-9); ++k) {
            page.line(left, down(k * y_step), x1, down(k * y_step), 0.5, grid);
            page.text(left - 5, down(k * y_step) + 3, short_number(k * y_step, 3), 8, black, 1);
        }
        page.text((left + x1) / 2, y1 + 27, plot.x_title, 8, black, 0.5);
        cairo_save(cairo);
        cairo_translate(cairo, 14, (top + y1) / 2);
        cairo_rotate(cairo, -pi / 2);
        page.text(0, 0, plot.y_title, 8, black, 0.5);
        cairo_restore(cairo);

        for (std::size_t n = 0; n < plot.lines.size(); ++n) {
            const Line& line = plot.lines[n];
            const Colour& colour = line_colours[n % std::size(line_colours)];
            const double dashes[] = {4, 3};
            cairo_save(cairo);
            cairo_rectangle(cairo, left, top, x1 - left, y1 - top);
            cairo_clip(cairo);
            cairo_new_path(cairo);
            for (const auto& [x, y] : line.points) cairo_line_to(cairo, across(x), down(y));
            page.colour(colour);
            cairo_set_line_width(cairo, 1.2);
            cairo_set_dash(cairo, dashes, line.dashed ? 2 : 0, 0);
            cairo_stroke(cairo);
            cairo_restore(cairo);
            const double y = top + 10 + 14 * static_cast<double>(n);
            cairo_set_dash(cairo, dashes, line.dashed ? 2 : 0, 0);
            page.line(x1 + 8, y - 3, x1 + 26, y - 3, 1.4, colour);
            cairo_set_dash(cairo, dashes, 0, 0);
            page.text(x1 + 31, y, line.name, 8, black);
        }
    });
}

}  // namespace stratus
