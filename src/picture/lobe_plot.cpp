#include <stratus/picture/lobe_plot.h>

#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include "page.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

// In points.
constexpr double margin = 10, left = 52, cell_width = 88, cell_height = 84, block_gap = 18;
constexpr double heading = 58, row_gap = 16;
constexpr double box_height = 5, box_width = 70, radius_of_largest = 39;

constexpr Colour curve_colours[] = {{0.10, 0.30, 0.65}, {0.05, 0.50, 0.35}, {0.85, 0.45, 0.05},
                                    {0.70, 0.25, 0.50}, {0.40, 0.25, 0.10}, {0.45, 0.65, 0.85},
                                    {0.20, 0.20, 0.20}, {0.60, 0.60, 0.10}};

double largest_of(const std::vector<LobePanel>& row) {
    double largest = 0;
    for (const LobePanel& panel : row)
        for (const LobeCurve& curve : panel.curves)
            for (const auto* side : {&curve.above, &curve.below})
                for (const double radius : *side) largest = std::max(largest, radius);
    return largest > 0 ? largest : 1;
}

/// 1, 2 or 5 times a power of ten, below `value`.
double round_below(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)));
    return unit * (value >= 5 * unit ? 5 : value >= 2 * unit ? 2 : 1);
}

void trace(cairo_t* cairo, const std::vector<double>& radii, double scale, double up) {
    const double steps = static_cast<double>(radii.size()) - 1;
    for (std::size_t k = 0; k < radii.size(); ++k) {
        const double angle = pi * (static_cast<double>(k) / steps - 0.5);
        // Light that comes from the right goes on to the left.
        cairo_line_to(cairo, -scale * radii[k] * std::sin(angle),
                      -up * scale * radii[k] * std::cos(angle));
    }
}

void draw_panel(const Page& page, const LobePanel& panel, double scale, double circle) {
    cairo_t* const cairo = page.cairo();
    cairo_set_line_width(cairo, 0.5);
    page.colour(grid);
    cairo_new_path(cairo);
    cairo_arc(cairo, 0, 0, circle * scale, 0, 2 * pi);
    cairo_stroke(cairo);
    page.colour({0.93, 0.93, 0.93});
    cairo_rectangle(cairo, -box_width / 2, -box_height / 2, box_width, box_height);
    cairo_fill_preserve(cairo);
    page.colour(quiet);
    cairo_stroke(cairo);

    const double towards_x = std::sin(panel.incident), towards_y = -std::cos(panel.incident);
    page.line(0.98 * cell_width / 2 * towards_x, 0.98 * cell_width / 2 * towards_y, 0, 0, 0.9,
              {0.85, 0.60, 0.0});
    for (std::size_t c = 0; c < panel.curves.size(); ++c) {
        cairo_new_path(cairo);
        trace(cairo, panel.curves[c].above, scale, 1);
        cairo_new_sub_path(cairo);
        trace(cairo, panel.curves[c].below, scale, -1);
        page.colour(curve_colours[c % std::size(curve_colours)]);
        cairo_set_line_width(cairo, 0.9);
        cairo_stroke(cairo);
    }
}

}  // namespace

void draw_lobe_plot(const LobePlot& plot, const std::filesystem::path& svg) {
    std::size_t columns = 0;
    for (const LobeBlock& block : plot.blocks) columns += block.rows[0].size();
    const double width = left + static_cast<double>(columns) * cell_width + margin +
                         block_gap * (static_cast<double>(plot.blocks.size()) - 1);
    const double height =
        heading + static_cast<double>(plot.row_titles.size()) * (cell_height + row_gap) + margin;
    write_svg(svg, width, height, [&](cairo_t* cairo) {
        const Page page(cairo);
        page.text(margin, 18, plot.title, 11, black);
        double x = width - margin;
        for (std::size_t n = plot.names.size(); n-- > 0;) {
            x -= page.width(plot.names[n], 9);
            page.text(x, 18, plot.names[n], 9, black);
            page.line(x - 20, 15, x - 4, 15, 1.4, curve_colours[n % std::size(curve_colours)]);
            x -= 32;
        }
        for (std::size_t r = 0; r < plot.row_titles.size(); ++r)
            page.text(margin,
                      heading + (static_cast<double>(r) + 0.5) * (cell_height + row_gap) + 3,
                      plot.row_titles[r], 9, black);
        x = left;
        for (const LobeBlock& block : plot.blocks) {
            page.text(x + 6, 36, block.title, 9, black);
            for (std::size_t c = 0; c < block.rows[0].size(); ++c)
                page.text(x + (static_cast<double>(c) + 0.5) * cell_width, 50,
                          short_number(block.rows[0][c].incident * 180 / pi, 3) + "\u00b0", 8,
                          quiet, 0.5);
            for (std::size_t r = 0; r < block.rows.size(); ++r) {
                const double largest = largest_of(block.rows[r]);
                const double scale = radius_of_largest / largest, circle = round_below(largest);
                const double y = heading + (static_cast<double>(r) + 0.5) * (cell_height + row_gap);
                page.text(x + 4, y + cell_height / 2 + 5, "circle " + short_number(circle, 3), 7,
                          quiet);
                for (std::size_t c = 0; c < block.rows[r].size(); ++c) {
                    cairo_save(cairo);
                    cairo_translate(cairo, x + (static_cast<double>(c) + 0.5) * cell_width, y);
                    draw_panel(page, block.rows[r][c], scale, circle);
                    cairo_restore(cairo);
                }
            }
            x += static_cast<double>(block.rows[0].size()) * cell_width + block_gap;
        }
    });
}

}  // namespace stratus
