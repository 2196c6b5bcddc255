// Axes of plots: lines across the plot at the ticks, a label beside each, a title.
#pragma once

#include "page.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

constexpr Colour grid{0.87, 0.87, 0.87}, grey{0.35, 0.35, 0.35};
constexpr double plot_text_size = 8;
constexpr double plot_page_width = 16 / 2.54 * 72;  // points: 16 cm

struct Tick {
    double at;                      // on the page
    std::string label;              // may be empty
    std::optional<int> exponent{};  // of the label, raised
};

/// A tick at 10^first .. 10^last, `length` being that of the axis; labels are at least
/// `min_distance` apart. `position` puts a value on the page.
std::vector<Tick> decade_ticks(int first, int last, double length, double min_distance,
                               const std::function<double(double)>& position);

/// Some five ticks or more, at round numbers from `low` to `high`. `position` as above.
std::vector<Tick> linear_ticks(double low, double high,
                               const std::function<double(double)>& position);

/// A box and where numbers are in it, by axes that know the share of a number.
template <class PlotAxis>
struct PlotFrame {
    Box box;
    PlotAxis x{}, y{};

    double across(double value) const { return box.x0 + x.share(value) * box.width(); }
    double down(double value) const { return box.y1 - y.share(value) * box.height(); }
    Point at(double of_x, double of_y) const { return {across(of_x), down(of_y)}; }
};

void draw_x_axis(const Page& page, const Box& plot, const std::vector<Tick>& ticks,
                 const std::string& title);
void draw_y_axis(const Page& page, const Box& plot, const std::vector<Tick>& ticks,
                 const std::string& title);

}  // namespace stratus
