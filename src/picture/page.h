// Pages of print: words and lines by cairo, sizes in points (1/72 inch), as SVG.
#pragma once

#include "cairo_output.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <filesystem>
#include <string>

namespace stratus {

struct Colour {
    double red, green, blue;
};

constexpr Colour black{0, 0, 0}, white{1, 1, 1}, grid{0.87, 0.87, 0.87}, quiet{0.35, 0.35, 0.35};

class Page {
  public:
    explicit Page(cairo_t* cairo) : cairo_(cairo) {
        cairo_select_font_face(cairo_, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                               CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
    }

    cairo_t* cairo() const { return cairo_; }

    void colour(const Colour& c) const { cairo_set_source_rgb(cairo_, c.red, c.green, c.blue); }

    double width(const std::string& text, double size) const {
        cairo_text_extents_t extents;
        cairo_set_font_size(cairo_, size);
        cairo_text_extents(cairo_, text.c_str(), &extents);
        return extents.x_advance;
    }

    /// On a base line; `share` of the text stands left of x.
    void text(double x, double y, const std::string& text, double size, const Colour& c,
              double share = 0) const {
        colour(c);
        cairo_move_to(cairo_, x - share * width(text, size), y);
        cairo_show_text(cairo_, text.c_str());
    }

    void line(double x0, double y0, double x1, double y1, double thickness, const Colour& c) const {
        colour(c);
        cairo_set_line_width(cairo_, thickness);
        cairo_move_to(cairo_, x0, y0);
        cairo_line_to(cairo_, x1, y1);
        cairo_stroke(cairo_);
    }

  protected:
    cairo_t* cairo_;
};

/// Writes `svg` itself: a white page of that size with what `draw` puts on its cairo_t.
///
/// Errors   as `fail`.
template <class Draw>
void write_svg(const std::filesystem::path& svg, double width, double height, const Draw& draw) {
    errno = 0;
    std::ofstream file(svg, std::ios::binary);
    if (!file) fail(svg, CAIRO_STATUS_WRITE_ERROR);
    const Surface surface(
        cairo_svg_surface_create_for_stream(append_to_file, &file, width, height));
    {
        const Context context(cairo_create(surface.get()));
        cairo_set_source_rgb(context.get(), 1, 1, 1);
        cairo_paint(context.get());
        draw(context.get());
    }
    cairo_surface_finish(surface.get());
    const cairo_status_t status = cairo_surface_status(surface.get());
    file.close();
    if (status != CAIRO_STATUS_SUCCESS || !file) fail(svg, status);
}

}  // namespace stratus
