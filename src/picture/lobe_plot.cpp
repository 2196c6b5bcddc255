#include <stratus/base/number_text.h>
#include <stratus/picture/plots.h>

#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace stratus {
namespace {

// In points.
constexpr double margin = 10, left = 52, cell_width = 88, cell_height = 84, block_gap = 18;
constexpr double title_line = 18, names_line = 36, block_line = 56, angle_line = 70;
constexpr double heading = 78, row_gap = 16;
constexpr double layer_height = 5, layer_width = 70, max_radius = 39;
constexpr double title_size = 11, text_size = 9;

constexpr Colour curve_colours[] = {{0.10, 0.30, 0.65}, {0.05, 0.50, 0.35}, {0.85, 0.45, 0.05},
                                    {0.70, 0.25, 0.50}, {0.40, 0.25, 0.10}, {0.45, 0.65, 0.85},
                                    {0.20, 0.20, 0.20}, {0.60, 0.60, 0.10}};

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
    double x = margin;
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
    double width = left + static_cast<double>(columns) * cell_width + margin +
                   block_gap * (static_cast<double>(plot.blocks.size()) - 1);
    measure([&](const Page& page) {
        width = std::max({width, 2 * margin + page.text_width(plot.title, title_size),
                          2 * margin + names_width(page, plot.names)});
    });
    const double height =
        heading + static_cast<double>(plot.row_titles.size()) * (cell_height + row_gap) + margin;
    draw_svg(svg, width, height, [&](const Page& page) {
        page.text({margin, title_line}, plot.title, title_size, black);
        draw_names(page, plot.names);
        for (std::size_t r = 0; r < plot.row_titles.size(); ++r)
            page.text({margin, row_middle(r) + 3}, plot.row_titles[r], text_size, black);
        double x = left;
        for (const LobeBlock& block : plot.blocks) {
            draw_block(page, block, x, plot.common_scale);
            x += static_cast<double>(block.rows[0].size()) * cell_width + block_gap;
        }
    });
}

}  // namespace stratus
