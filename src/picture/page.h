// The page that all plots and pictures are drawn on: text, lines, shapes, marks and images, written
// as PNG (one unit is a pixel) or SVG (one unit is a point, 1/72 inch). y points down. Then the axes of plots: lines
// across the plot at the ticks, a label beside each, a title.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/io/image.h>

#include <cairo.h>

#include <cerrno>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace stratus {

// Cairo's objects, owned, and its failures as exceptions.

struct CairoDelete {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_pattern_t* pattern) const { cairo_pattern_destroy(pattern); }
};
using Surface = std::unique_ptr<cairo_surface_t, CairoDelete>;
using Context = std::unique_ptr<cairo_t, CairoDelete>;
using Pattern = std::unique_ptr<cairo_pattern_t, CairoDelete>;

/// Reports a file that could not be read or written: with errno's reason or, where that is 0,
/// Cairo's.
///
/// Errors   std::system_error, in which write_atomically replaces the name of its temporary file by
///          the user's; std::runtime_error with Cairo's reason.
[[noreturn]] inline void fail(const std::filesystem::path& path, cairo_status_t status) {
    if (errno != 0) throw std::system_error(errno, std::generic_category(), path.string());
    throw std::runtime_error(path.string() + ": " + cairo_status_to_string(status));
}

struct Colour {
    double red, green, blue;
};

constexpr Colour black{0, 0, 0}, white{1, 1, 1};

struct Point {
    double x, y;
};

struct Box {
    double x0, y0, x1, y1;

    double width() const { return x1 - x0; }
    double height() const { return y1 - y0; }
    Point centre() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }
};

struct Pen {
    double width;
    Colour colour;
    double opacity = 1;
    std::vector<double> dashes{};  // on, off; none: solid
};

enum class Align { left, centre, right };

enum class Marker { circle, square, triangle, cross, plus, diamond };

/// Draws; what is drawn later covers what was drawn before.
class Page {
  public:
    explicit Page(cairo_t* cairo);

    double text_width(const std::string& text, double size) const;

    /// Text on a base line, blanks in place of line breaks. Wider than `max_width`, it is set smaller,
    /// down to 12 units, and then truncated.
    void text(Point at, std::string text, double size, const Colour& colour,
              Align align = Align::left, double max_width = infinity) const;
    /// Upwards, centred at a point of its base line.
    void vertical_text(Point at, const std::string& text, double size, const Colour& colour) const;
    /// With a rim, which keeps it legible on lines and images.
    void haloed_text(Point at, std::string text, double size, const Colour& colour, const Pen& halo,
                     Align align, double max_width = infinity) const;

    void line(Point from, Point to, const Pen& pen) const;
    void curve(const std::vector<Point>& points, const Pen& pen) const;
    void arc(Point centre, double radius, double from, double to, const Pen& pen) const;
    void arrow(Point from, Point to, const Pen& pen) const;

    void outline(const std::vector<Point>& shape, const Pen& pen) const;
    void outline(const Box& box, const Pen& pen) const;
    void fill(const std::vector<Point>& shape, const Colour& colour, double opacity = 1) const;
    /// The opacity changes linearly from top to bottom.
    void fill(const Box& box, const Colour& colour, double top = 1, double bottom = 1) const;
    void mark(Point at, Marker marker, double radius, const Pen& pen) const;

    /// Linear light, shown as sRGB(min(light / white, 1)).
    void image(Point corner, const Image& image, double white) const;

    void clipped(const Box& box, const std::function<void()>& draw) const;
    /// Draws with the origin moved.
    void translated(Point origin, const std::function<void()>& draw) const;

  private:
    void set_source(const Colour& colour, double opacity = 1) const;
    /// Makes a text fit, and moves to where it begins.
    void start_text(Point at, std::string& text, double& size, Align align, double max_width) const;
    void trace(const std::vector<Point>& points) const;
    void stroke(const Pen& pen) const;

    cairo_t* cairo_;
};

using Draw = std::function<void(const Page&)>;

/// A page of this size and background, written to `path` itself; callers who need it whole or not
/// at all wrap it.
///
/// Errors   as `fail`.
void draw_png(const std::filesystem::path& path, int width, int height, const Colour& background,
              const Draw& draw);
void draw_svg(const std::filesystem::path& path, double width, double height, const Draw& draw);

/// A page that is not written, to measure text on before the size of an SVG page is known.
void measure(const Draw& draw);

/// The curve of radii at even angles from one horizon to the other, about the origin. Light comes
/// from the right and goes on to the left; `up` is 1 above the layer and -1 below.
inline std::vector<Point> lobe_outline(const std::vector<double>& radii, double scale, double up) {
    const double steps = static_cast<double>(radii.size()) - 1;
    std::vector<Point> outline;
    for (std::size_t k = 0; k < radii.size(); ++k) {
        const double angle = pi * (static_cast<double>(k) / steps - 0.5);
        outline.push_back(
            {-scale * radii[k] * std::sin(angle), -up * scale * radii[k] * std::cos(angle)});
    }
    return outline;
}

constexpr Colour grid{0.87, 0.87, 0.87}, grey{0.35, 0.35, 0.35};
constexpr double plot_text_size = 8;
constexpr double plot_page_width = 16 / 2.54 * 72;  // points: 16 cm

/// An axis of a plot, linear or logarithmic.
struct PlotAxis {
    std::string title;
    bool logarithmic = false;
    double low = infinity, high = -infinity;

    /// Extends it to hold values.
    void include(std::initializer_list<double> values);
    /// Extends it to round numbers; to whole decades if it is logarithmic.
    void round();
    /// Where a number is along it, 0 at its lower end and 1 at its upper one.
    double share(double value) const;
};

/// A box and the axes along its lower and its left side.
struct PlotFrame {
    Box box;
    PlotAxis x, y;

    double across(double value) const { return box.x0 + x.share(value) * box.width(); }
    double down(double value) const { return box.y1 - y.share(value) * box.height(); }
    Point at(double of_x, double of_y) const { return {across(of_x), down(of_y)}; }
};

/// Draws lines across the box at round numbers, some five or more, or at powers of ten, a label for each
/// as far as there is room, and the axis' title.
void draw_x_axis(const Page& page, const PlotFrame& frame);
void draw_y_axis(const Page& page, const PlotFrame& frame);

}  // namespace stratus
