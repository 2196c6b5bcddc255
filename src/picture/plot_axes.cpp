#include "plot_axes.h"

#include <stratus/base/number_text.h>
#include <stratus/picture/round_number.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace stratus {
namespace {

constexpr double exponent_size = 7, y_title_at = 14;

/// A label with its exponent, on a base line.
void draw_label(const Page& page, Point at, const Tick& tick, Align align) {
    if (!tick.exponent) {
        page.text(at, tick.label, plot_text_size, black, align);
        return;
    }
    const std::string raised =
        (*tick.exponent < 0 ? "\u2212" : "") + std::to_string(std::abs(*tick.exponent));
    const double base_width = page.text_width(tick.label, plot_text_size);
    const double width = base_width + page.text_width(raised, exponent_size);
    const double start = at.x - (align == Align::right ? width : width / 2);
    page.text({start, at.y}, tick.label, plot_text_size, black);
    page.text({start + base_width, at.y - 3.2}, raised, exponent_size, black);
}

}  // namespace

std::vector<Tick> decade_ticks(int first, int last, double length, double min_distance,
                               const std::function<double(double)>& position) {
    const int step =
        std::max(1, static_cast<int>(std::ceil(min_distance * (last - first) / length)));
    std::vector<Tick> ticks;
    for (int decade = first; decade <= last; ++decade) {
        const bool has_label = (decade - first) % step == 0;
        ticks.push_back({position(std::pow(10.0, decade)), has_label ? "10" : "", decade});
    }
    return ticks;
}

std::vector<Tick> linear_ticks(double low, double high,
                               const std::function<double(double)>& position) {
    const double step = round_below((high - low) / 4);
    const long long last = std::llround(std::floor(high / step + 1e-9));
    std::vector<Tick> ticks;
    for (long long k = std::llround(std::ceil(low / step - 1e-9)); k <= last; ++k) {
        const double value = static_cast<double>(k) * step;
        ticks.push_back({position(value), short_number(value, 3)});
    }
    return ticks;
}

void draw_x_axis(const Page& page, const Box& plot, const std::vector<Tick>& ticks,
                 const std::string& title) {
    for (const Tick& tick : ticks) {
        page.line({tick.at, plot.y0}, {tick.at, plot.y1}, {0.5, grid});
        if (!tick.label.empty()) draw_label(page, {tick.at, plot.y1 + 13}, tick, Align::centre);
    }
    page.text({plot.centre().x, plot.y1 + 26}, title, plot_text_size, black, Align::centre);
}

void draw_y_axis(const Page& page, const Box& plot, const std::vector<Tick>& ticks,
                 const std::string& title) {
    for (const Tick& tick : ticks) {
        page.line({plot.x0, tick.at}, {plot.x1, tick.at}, {0.5, grid});
        if (!tick.label.empty()) draw_label(page, {plot.x0 - 4, tick.at + 3}, tick, Align::right);
    }
    page.vertical_text({y_title_at, plot.centre().y}, title, plot_text_size, black);
}

}  // namespace stratus
