#include <stratus/picture/portrait.h>

#include <stratus/runtime/constants.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/number_text.h>
#include <stratus/runtime/single_scattering.h>

#include "cairo_output.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace stratus {
namespace {

constexpr double beam_angle_deg = 60;   // of the lobes, from the normal
constexpr double phase_angle_deg = 40;  // of the spheres

// ---- What is shown: the depths, the albedos

/// The nearest number of so many significant digits.
double rounded(double value, int digits = 1) {
    if (!(value > 0) || !std::isfinite(value)) return value;
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - (digits - 1));
    return std::round(value / unit) * unit;
}

/// Finite depths, evenly spread in the logarithm over the part of the axis where layers differ
/// (nearly all light passes below 0.1, hardly any above 32, and 10 is next to endless), in numbers
/// as round as keeps them apart.
std::vector<double> shown_finite_depths(const AxisView& axis) {
    if (axis.count == 0) return {};
    if (axis.lowest == axis.highest) return {axis.lowest};
    double lowest = std::max(axis.lowest, 0.1);
    double highest = std::min(axis.highest, axis.ends_at_infinity ? 10.0 : 32.0);
    if (!(lowest < highest)) {
        lowest = axis.lowest;
        highest = axis.highest;
    }
    const int count = axis.ends_at_infinity ? 3 : 4;
    std::vector<double> depths(static_cast<std::size_t>(count));
    for (int digits = 1; digits <= 4; ++digits) {
        for (int k = 0; k < count; ++k) {
            const double depth = lowest * std::pow(highest / lowest, k / (count - 1.0));
            depths[static_cast<std::size_t>(k)] =
                std::clamp(rounded(depth, digits), axis.lowest, axis.highest);
        }
        if (std::ranges::adjacent_find(depths) == depths.end()) return depths;
    }
    return {axis.lowest, axis.highest};
}

/// Up to four optical depths, ascending, with infinity where the table holds it.
std::vector<double> shown_depths(const AxisView& axis) {
    std::vector<double> depths = shown_finite_depths(axis);
    if (axis.ends_at_infinity) depths.push_back(infinity);
    return depths;
}

/// Up to three albedos, descending from the table's highest, spread as its axis is; the darkest
/// third of it shows little.
std::vector<double> shown_albedos(const AxisView& axis) {
    const double brightest = std::sqrt(1 - axis.highest), darkest = std::sqrt(1 - axis.lowest);
    std::vector<double> albedos{axis.highest};
    for (const double share : {0.35, 0.7}) {
        const double loss = std::pow(brightest + share * (darkest - brightest), 2);
        const double albedo = std::clamp(1 - rounded(loss), axis.lowest, axis.highest);
        if (albedo < albedos.back()) albedos.push_back(albedo);
    }
    return albedos;
}

// ---- Where it stands

/// Everything in pixels; one zone for the lobes and one for the spheres in each of `columns`.
struct Layout {
    double width = 1600, height = 0;
    double margin = 40;
    double column_width = 0;
    double heading_y = 0;
    double lobe_x = 0, lobe_y = 0;  // where the beam meets the layer, from the column's left edge
    double lobe_radius = 0;
    double sphere_x[2] = {0, 0}, sphere_y = 0;
    double sphere_radius = 0;
    double legend_y = 0;
};

Layout make_layout(const TableView& table, std::size_t columns) {
    constexpr double header = 148, gap = 24, caption = 58;
    const double legend = table.has_reflection() ? 116 : 92;
    Layout layout;
    layout.column_width = (layout.width - 2 * layout.margin) / static_cast<double>(columns);
    const bool has_spheres = table.has_reflection();
    const bool side_by_side = columns <= 2 && has_spheres;
    const double zone = side_by_side ? layout.column_width / 2 : layout.column_width;
    layout.lobe_radius = std::min(zone / 2 - 20, 240.0);
    layout.sphere_radius = std::min(zone / 4 - 12, 140.0);

    const double above = (table.has_reflection() ? 1.0 : 0.65) * layout.lobe_radius;
    const double below = table.has_transmission() ? layout.lobe_radius + 12 : 60;
    layout.heading_y = header + gap;
    layout.lobe_x = zone / 2;
    layout.lobe_y = layout.heading_y + gap + above;
    const double lobes_end = layout.lobe_y + below;

    const double spheres = 2 * layout.sphere_radius + caption;
    const double spheres_x = side_by_side ? zone : 0;
    for (int k = 0; k < 2; ++k) layout.sphere_x[k] = spheres_x + zone * (k == 0 ? 0.25 : 0.75);
    layout.sphere_y =
        side_by_side ? (layout.heading_y + lobes_end) / 2 : lobes_end + gap + layout.sphere_radius;
    double end = lobes_end;
    if (has_spheres && !side_by_side) end = lobes_end + gap + spheres;
    if (side_by_side) end = std::max(end, layout.sphere_y + layout.sphere_radius + caption);
    layout.legend_y = end + gap;
    layout.height = std::ceil(layout.legend_y + legend);
    return layout;
}

// ---- The canvas: cairo, owned

struct Colour {
    double red, green, blue;
};

constexpr Colour background{0.063, 0.075, 0.102};
constexpr Colour bright{0.94, 0.95, 0.97};
constexpr Colour quiet{0.60, 0.64, 0.71};
constexpr Colour faint{0.30, 0.33, 0.40};
constexpr Colour beam{1.0, 0.97, 0.86};
constexpr Colour once_only{1.0, 0.45, 0.58};
constexpr Colour all_orders[] = {{1.0, 0.80, 0.30}, {0.20, 0.80, 0.70}, {0.36, 0.58, 0.98}};

enum class Align { left, centre, right };

/// Of UTF-8 text: a letter's bytes after its first begin with the bits 10.
void remove_last_letter(std::string& text) {
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80)
        text.pop_back();
    if (!text.empty()) text.pop_back();
}

class Canvas {
  public:
    Canvas(int width, int height)
        : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)),
          cairo_(cairo_create(surface_.get())) {
        cairo_select_font_face(cairo(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                               CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_line_join(cairo(), CAIRO_LINE_JOIN_ROUND);
        colour(background);
        cairo_paint(cairo());
    }

    cairo_t* cairo() const { return cairo_.get(); }
    cairo_surface_t* surface() const { return surface_.get(); }

    void colour(const Colour& c, double opacity = 1) const {
        cairo_set_source_rgba(cairo(), c.red, c.green, c.blue, opacity);
    }

    double text_width(const std::string& text, double size) const {
        cairo_text_extents_t extents;
        cairo_set_font_size(cairo(), size);
        cairo_text_extents(cairo(), text.c_str(), &extents);
        return extents.x_advance;
    }

    /// Text on a base line; set smaller, down to 12 pixels, and then cut where it is wider than
    /// `widest`.
    void text(double x, double y, std::string text, double size, const Colour& c,
              Align align = Align::left, double widest = infinity) const {
        while (size > 12 && text_width(text, size) > widest) size -= 0.5;
        if (text_width(text, size) > widest) {
            do remove_last_letter(text);
            while (!text.empty() && text_width(text + "...", size) > widest);
            text += "...";
        }
        const double share = align == Align::left ? 0 : align == Align::centre ? 0.5 : 1;
        colour(c);
        cairo_move_to(cairo(), x - share * text_width(text, size), y);
        cairo_show_text(cairo(), text.c_str());
    }

    /// Right-aligned text that stays legible across lines.
    void haloed_text(double x, double y, const std::string& text, double size,
                     const Colour& c) const {
        cairo_move_to(cairo(), x - text_width(text, size), y);
        cairo_text_path(cairo(), text.c_str());
        colour(background, 0.85);
        cairo_set_line_width(cairo(), 4);
        cairo_stroke_preserve(cairo());
        colour(c);
        cairo_fill(cairo());
    }

    /// A line whose end carries an arrow's head.
    void arrow(double x0, double y0, double x1, double y1, double width) const {
        const double angle = std::atan2(y1 - y0, x1 - x0);
        const double head = 12;
        cairo_set_line_width(cairo(), width);
        cairo_move_to(cairo(), x0, y0);
        cairo_line_to(cairo(), x1 - 0.8 * head * std::cos(angle),
                      y1 - 0.8 * head * std::sin(angle));
        cairo_stroke(cairo());
        cairo_move_to(cairo(), x1, y1);
        for (const double side : {-0.35, 0.35})
            cairo_line_to(cairo(), x1 - head * std::cos(angle + side),
                          y1 - head * std::sin(angle + side));
        cairo_close_path(cairo());
        cairo_fill(cairo());
    }

  private:
    Surface surface_;
    Context cairo_;
};

// ---- Words

std::string depth_heading(double optical_depth) {
    return std::isinf(optical_depth) ? "infinitely deep"
                                     : "optical depth " + short_number(optical_depth, 3);
}

std::string title_of(const Table& table) {
    const auto title = table.attributes.find("title");
    return title != table.attributes.end() && !title->second.empty() ? title->second
                                                                     : "A table of scattered light";
}

std::string orders_of(const Table& table) {
    return table.highest_order == 0 ? "all orders"
                                    : "orders 1 to " + std::to_string(table.highest_order);
}

/// Tables that mix are shown at their middle.
TableView shown_view(const Table& table) {
    const TableView view = table.view();
    return view.at_mixture((view.mixture.lowest + view.mixture.highest) / 2);
}

void draw_header(const Canvas& canvas, const Layout& layout, const Table& table) {
    const PhaseFunction phase_function = shown_view(table).mixed_phase_function();
    const double x = layout.margin, widest = layout.width - 2 * layout.margin;
    canvas.text(x, 66, title_of(table), 36, bright, Align::left, widest);
    canvas.text(x, 100, "Phase function: " + phase_function.caption(), 19, quiet, Align::left,
                widest);
    std::string accuracy =
        "Mean cosine of scattering g = " + short_number(phase_function.asymmetry(), 3);
    if (table.measured_error > 0) {
        char error[32];
        std::snprintf(error, sizeof error, "%.1e", table.measured_error);
        accuracy += ";  largest relative error measured at the bake " + std::string(error);
    }
    canvas.text(x, 126, accuracy, 16, quiet, Align::left, widest);
}

// ---- Lobes

enum class Part { once, all };

/// R mu_out or T mu_out in the plane of incidence, from the side the beam comes from (-90 degrees)
/// to the forward horizon.
struct Lobe {
    static constexpr int samples = 721;
    std::array<double, samples> radius;

    static double angle(int k) { return pi * (k / (samples - 1.0) - 0.5); }
    double largest() const { return *std::max_element(radius.begin(), radius.end()); }
};

Lobe make_lobe(const TableView& table, bool transmitted, double albedo, double optical_depth,
               Part part) {
    Lobe lobe;
    for (int k = 0; k < Lobe::samples; ++k) {
        const double angle = Lobe::angle(k);
        const Geometry geometry{std::cos(beam_angle_deg * pi / 180),
                                std::max(std::cos(angle), 1e-6), angle >= 0 ? 0 : pi};
        const Scattered light = transmitted ? transmission(table, albedo, optical_depth, geometry)
                                            : reflection(table, albedo, optical_depth, geometry);
        const double value = part == Part::once ? light.single : light.total();
        lobe.radius[static_cast<std::size_t>(k)] = value * geometry.mu_out;
    }
    return lobe;
}

/// One half of a column's figure: the light of one side, at every albedo shown.
struct LobeSide {
    bool transmitted = false;
    Lobe once;               // at the highest albedo
    std::vector<Lobe> all;   // one an albedo
    double full_radius = 0;  // value at which a lobe would reach the figure's edge
};

LobeSide make_side(const TableView& table, bool transmitted, const std::vector<double>& albedos,
                   double optical_depth) {
    LobeSide side;
    side.transmitted = transmitted;
    side.once = make_lobe(table, transmitted, albedos.front(), optical_depth, Part::once);
    side.full_radius = side.once.largest();
    for (const double albedo : albedos) {
        side.all.push_back(make_lobe(table, transmitted, albedo, optical_depth, Part::all));
        side.full_radius = std::max(side.full_radius, side.all.back().largest());
    }
    side.full_radius *= 1.04;
    return side;
}

void trace(const Canvas& canvas, const Lobe& lobe, const LobeSide& side, double pixels) {
    cairo_new_path(canvas.cairo());
    for (int k = 0; k < Lobe::samples; ++k) {
        const double radius = lobe.radius[static_cast<std::size_t>(k)] / side.full_radius * pixels;
        const double across = -radius * std::sin(Lobe::angle(k));  // the beam comes from the right
        const double up = radius * std::cos(Lobe::angle(k)) * (side.transmitted ? -1 : 1);
        cairo_line_to(canvas.cairo(), across, -up);
    }
    cairo_close_path(canvas.cairo());
}

/// Half circles at multiples of a round value, two or three of them.
struct Rings {
    double step;
    int count;
};

Rings rings_of(const LobeSide& side) {
    const double step = rounded(side.full_radius / 2.4);
    return {step, static_cast<int>(side.full_radius / step)};
}

void draw_rings(const Canvas& canvas, const LobeSide& side, double pixels) {
    const Rings rings = rings_of(side);
    cairo_set_line_width(canvas.cairo(), 1);
    for (int ring = 1; ring <= rings.count; ++ring) {
        canvas.colour(faint, 0.75);
        cairo_new_path(canvas.cairo());
        cairo_arc(canvas.cairo(), 0, 0, ring * rings.step / side.full_radius * pixels,
                  side.transmitted ? 0 : pi, side.transmitted ? pi : 2 * pi);
        cairo_stroke(canvas.cairo());
    }
}

/// The outermost ring's value where it meets the layer, on the side of the beam: little light is
/// there.
void label_rings(const Canvas& canvas, const LobeSide& side, double pixels) {
    const Rings rings = rings_of(side);
    const double value = rings.count * rings.step;
    canvas.haloed_text(value / side.full_radius * pixels - 4, side.transmitted ? 15 : -5,
                       short_number(value, 3), 12, quiet);
}

void draw_side(const Canvas& canvas, const LobeSide& side, double pixels) {
    cairo_t* const cairo = canvas.cairo();
    for (std::size_t a = side.all.size(); a-- > 0;) {
        trace(canvas, side.all[a], side, pixels);
        if (a == 0) {
            canvas.colour(all_orders[a], 0.13);
            cairo_fill_preserve(cairo);
        }
        canvas.colour(all_orders[a]);
        cairo_set_line_width(cairo, 2.4);
        cairo_stroke(cairo);
    }
    trace(canvas, side.once, side, pixels);
    const double dashes[] = {7, 5};
    cairo_set_dash(cairo, dashes, 2, 0);
    canvas.colour(once_only);
    cairo_set_line_width(cairo, 2);
    cairo_stroke(cairo);
    cairo_set_dash(cairo, nullptr, 0, 0);
}

/// The layer as a bar, the effective_optical_depth the more it hides; without end when it is infinitely deep.
void draw_layer(const Canvas& canvas, double optical_depth, double half_width, double thickness) {
    cairo_t* const cairo = canvas.cairo();
    const double opacity = 0.15 + 0.75 * -std::expm1(-optical_depth);
    const bool endless = std::isinf(optical_depth);
    const double depth = endless ? 4 * thickness : thickness;
    std::unique_ptr<cairo_pattern_t, decltype(&cairo_pattern_destroy)> fill(
        cairo_pattern_create_linear(0, 0, 0, depth), &cairo_pattern_destroy);
    cairo_pattern_add_color_stop_rgba(fill.get(), 0, 0.55, 0.60, 0.70, opacity);
    cairo_pattern_add_color_stop_rgba(fill.get(), 1, 0.55, 0.60, 0.70, endless ? 0 : opacity);
    cairo_set_source(cairo, fill.get());
    cairo_rectangle(cairo, -half_width, 0, 2 * half_width, depth);
    cairo_fill(cairo);
}

/// The beam from the right, and below the layer as much of it as passes straight through.
void draw_beam(const Canvas& canvas, double optical_depth, double length, double thickness) {
    const double angle = beam_angle_deg * pi / 180;
    const double across = std::sin(angle), up = std::cos(angle);
    canvas.colour(beam);
    canvas.arrow(length * across, -length * up, 0, 0, 2.5);
    const double passing = direct_transmittance(optical_depth, up);
    if (passing < 0.01) return;
    const double shift = thickness * across / up;
    canvas.colour(beam, 0.25 + 0.75 * passing);
    canvas.arrow(-shift, thickness, -shift - 0.45 * length * across, thickness + 0.45 * length * up,
                 0.5 + 2 * passing);
}

/// Both halves on one scale where they differ by no more than this; else each on its own.
constexpr double largest_shared_ratio = 4;

void share_scale(LobeSide& above, LobeSide& below) {
    const double larger = std::max(above.full_radius, below.full_radius);
    const double smaller = std::min(above.full_radius, below.full_radius);
    if (larger <= largest_shared_ratio * smaller) above.full_radius = below.full_radius = larger;
}

void draw_lobes(const Canvas& canvas, const Layout& layout, const TableView& table,
                double optical_depth, const std::vector<double>& albedos) {
    constexpr double thickness = 12;
    LobeSide above, below;
    if (table.has_reflection()) above = make_side(table, false, albedos, optical_depth);
    if (table.has_transmission()) below = make_side(table, true, albedos, optical_depth);
    if (table.has_reflection() && table.has_transmission()) share_scale(above, below);

    const double pixels = layout.lobe_radius;
    const auto on_each_side = [&](auto&& draw) {
        if (above.full_radius > 0) draw(canvas, above, pixels);
        cairo_save(canvas.cairo());
        cairo_translate(canvas.cairo(), 0, thickness);
        if (below.full_radius > 0) draw(canvas, below, pixels);
        cairo_restore(canvas.cairo());
    };
    on_each_side(draw_rings);
    draw_layer(canvas, optical_depth, pixels, thickness);
    const bool seen_below = !table.has_lower_boundary();
    draw_beam(canvas, seen_below ? optical_depth : infinity,
              table.has_reflection() ? pixels : 0.65 * pixels, thickness);
    on_each_side(draw_side);
    on_each_side(label_rings);
}

// ---- Spheres

/// I/F over a sphere's disc, seen from far away, row after row; `side` pixels square.
struct Disc {
    int side = 0;
    double radius = 0;
    std::vector<double> brightness;
    std::vector<double> coverage;  // of each pixel by the disc

    double sum() const {
        double total = 0;
        for (std::size_t k = 0; k < brightness.size(); ++k) total += brightness[k] * coverage[k];
        return total;
    }
};

/// What lights a point of the sphere, in its own frame; mu_in <= 0 in the dark.
Geometry geometry_on_sphere(double x, double y) {
    constexpr double smallest_mu = 1e-3;  // limb and terminator: the picture cannot show less
    const double phase = phase_angle_deg * pi / 180, tilt = 25 * pi / 180;
    const double light[] = {std::sin(phase) * std::cos(tilt), std::sin(phase) * std::sin(tilt),
                            std::cos(phase)};
    const double mu_out = std::sqrt(std::max(1 - x * x - y * y, smallest_mu * smallest_mu));
    const double mu_in = x * light[0] + y * light[1] + mu_out * light[2];
    const double sines = std::sqrt((1 - mu_in * mu_in) * (1 - mu_out * mu_out));
    // cos a = mu mu0 - s s0 cos(azimuth), a the phase angle
    const double cos_azimuth =
        sines > 0 ? std::clamp((mu_in * mu_out - light[2]) / sines, -1.0, 1.0) : 1;
    return {std::min(mu_in, 1.0), mu_out, std::acos(cos_azimuth)};
}

Disc make_disc(const TableView& table, double albedo, double optical_depth, double radius,
               Part part) {
    Disc disc;
    disc.side = 2 * static_cast<int>(std::ceil(radius)) + 2;
    disc.radius = radius;
    for (int row = 0; row < disc.side; ++row)
        for (int column = 0; column < disc.side; ++column) {
            const double x = (column + 0.5 - disc.side / 2.0) / radius;
            const double y = (disc.side / 2.0 - row - 0.5) / radius;
            const double distance = std::hypot(x, y);
            const double coverage = std::clamp((1 - distance) * radius + 0.5, 0.0, 1.0);
            const double inside =
                distance > 1 ? 1 / distance : 1;  // a limb's pixel: its nearest point
            const Geometry geometry = geometry_on_sphere(x * inside, y * inside);
            double brightness = 0;
            if (coverage > 0 && geometry.mu_in > 0) {
                const Scattered light = reflection(table, albedo, optical_depth, geometry);
                brightness = geometry.mu_in * (part == Part::once ? light.single : light.total());
            }
            disc.brightness.push_back(brightness);
            disc.coverage.push_back(coverage);
        }
    return disc;
}

/// sRGB's transfer curve.
double encoded(double linear) {
    const double value = std::clamp(linear, 0.0, 1.0);
    return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

void draw_disc(const Canvas& canvas, const Disc& disc, double white, double x, double y) {
    const Surface image(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, disc.side, disc.side));
    if (cairo_surface_status(image.get()) != CAIRO_STATUS_SUCCESS) return;  // caught at the end
    unsigned char* const pixels = cairo_image_surface_get_data(image.get());
    const std::ptrdiff_t stride = cairo_image_surface_get_stride(image.get());
    const auto side = static_cast<std::size_t>(disc.side);
    for (int row = 0; row < disc.side; ++row)
        for (int column = 0; column < disc.side; ++column) {
            const auto k = static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column);
            const double coverage = disc.coverage[k];
            const auto level = static_cast<std::uint32_t>(
                std::lround(255 * coverage * encoded(disc.brightness[k] / white)));
            const auto alpha = static_cast<std::uint32_t>(std::lround(255 * coverage));
            const std::uint32_t pixel = alpha << 24 | level << 16 | level << 8 | level;
            std::memcpy(pixels + row * stride + std::ptrdiff_t{4} * column, &pixel, sizeof pixel);
        }
    cairo_surface_mark_dirty(image.get());
    cairo_set_source_surface(canvas.cairo(), image.get(), std::round(x - disc.side / 2.0),
                             std::round(y - disc.side / 2.0));
    cairo_paint(canvas.cairo());
}

/// A depth's two spheres at the highest albedo.
struct SpherePair {
    Disc once, all;
};

std::vector<SpherePair> make_spheres(const TableView& table, const std::vector<double>& depths,
                                     double albedo, double radius) {
    std::vector<SpherePair> spheres;
    if (!table.has_reflection()) return spheres;
    for (const double depth : depths)
        spheres.push_back({make_disc(table, albedo, depth, radius, Part::once),
                           make_disc(table, albedo, depth, radius, Part::all)});
    return spheres;
}

/// The I/F shown white: all but the brightest 0.5 % of the brightest sphere lies below it.
double white_level(const std::vector<SpherePair>& spheres) {
    double white = 0;
    for (const SpherePair& pair : spheres) {
        std::vector<double> values;
        for (std::size_t k = 0; k < pair.all.brightness.size(); ++k)
            if (pair.all.coverage[k] > 0) values.push_back(pair.all.brightness[k]);
        const auto place = values.begin() + static_cast<std::ptrdiff_t>(
                                                0.995 * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), place, values.end());
        white = std::max(white, *place);
    }
    return white > 0 ? white : 1;
}

void draw_spheres(const Canvas& canvas, const Layout& layout, const SpherePair& pair, double white,
                  const std::string& orders) {
    draw_disc(canvas, pair.once, white, layout.sphere_x[0], layout.sphere_y);
    draw_disc(canvas, pair.all, white, layout.sphere_x[1], layout.sphere_y);
    const double y = layout.sphere_y + layout.sphere_radius + 26;
    canvas.text(layout.sphere_x[0], y, "scattered once", 15, once_only, Align::centre);
    canvas.text(layout.sphere_x[1], y, orders, 15, all_orders[0], Align::centre);
    if (pair.once.sum() > 0)
        canvas.text(layout.sphere_x[1], y + 20,
                    short_number(pair.all.sum() / pair.once.sum(), 3) + " times as bright", 13,
                    quiet, Align::centre);
}

// ---- Legend

/// A short line and its meaning; returns where the next may begin.
double draw_key(const Canvas& canvas, double x, double y, const Colour& colour, bool dashed,
                const std::string& meaning) {
    cairo_t* const cairo = canvas.cairo();
    const double dashes[] = {7, 5};
    if (dashed) cairo_set_dash(cairo, dashes, 2, 0);
    canvas.colour(colour);
    cairo_set_line_width(cairo, 3);
    cairo_move_to(cairo, x, y - 5);
    cairo_line_to(cairo, x + 36, y - 5);
    cairo_stroke(cairo);
    cairo_set_dash(cairo, nullptr, 0, 0);
    canvas.text(x + 46, y, meaning, 16, bright);
    return x + 46 + canvas.text_width(meaning, 16) + 34;
}

std::string below_of(const Table& table) {
    const std::string albedo = " of albedo " + short_number(table.lower_boundary.albedo, 3);
    switch (table.lower_boundary.kind) {
        case LowerBoundary::Kind::surface: return "over a Lambert surface" + albedo;
        case LowerBoundary::Kind::layer: return "over a semi-infinite layer" + albedo;
        default: return "black below it";
    }
}

void draw_legend(const Canvas& canvas, const Layout& layout, const Table& table,
                 const std::vector<double>& albedos, double white) {
    const bool reflected = !table.reflection_multiple.empty();
    const bool transmitted = !table.transmission_multiple.empty();
    double x = layout.margin, y = layout.legend_y + 24;
    for (std::size_t a = 0; a < albedos.size(); ++a)
        x = draw_key(canvas, x, y, all_orders[a], false,
                     "albedo " + short_number(albedos[a], 4) + ", " + orders_of(table));
    x = draw_key(canvas, x, y, once_only, true,
                 "albedo " + short_number(albedos.front(), 4) + ", scattered once");
    draw_key(canvas, x, y, beam, false,
             "beam, " + short_number(beam_angle_deg, 3) + "\u00b0 from the normal");

    const double widest = layout.width - 2 * layout.margin;
    const std::string sides = reflected && transmitted
                                  ? "R \u00b7 mu_out above the layer, T \u00b7 mu_out below"
                              : reflected ? "R \u00b7 mu_out"
                                          : "T \u00b7 mu_out";
    canvas.text(layout.margin, y + 34,
                "Lobes: light leaving per solid angle in the plane of incidence, " + sides +
                    "; the outer ring's value stands beside it. A white Lambert surface "
                    "draws a circle of diameter 1.",
                15, quiet, Align::left, widest);
    if (!reflected) return;
    canvas.text(layout.margin, y + 58,
                "Spheres: covered with the layer, albedo " + short_number(albedos.front(), 4) +
                    ", " + below_of(table) + ", phase angle " + short_number(phase_angle_deg, 3) +
                    "\u00b0; I/F = mu_in \u00b7 R in sRGB, white from I/F = " +
                    short_number(white, 2) + " up, the same for all.",
                15, quiet, Align::left, widest);
}

}  // namespace

// ---- The whole

PictureSize portrait_size(const Table& table) {
    const TableView view = table.view();
    const Layout layout = make_layout(view, shown_depths(view.optical_depth).size());
    return {static_cast<int>(layout.width), static_cast<int>(layout.height)};
}

void draw_portrait(const Table& table, const std::filesystem::path& png) {
    const TableView view = shown_view(table);
    const std::vector<double> depths = shown_depths(view.optical_depth);
    const std::vector<double> albedos = shown_albedos(view.albedo);
    const Layout layout = make_layout(view, depths.size());
    const PictureSize size = portrait_size(table);
    const std::vector<SpherePair> spheres =
        make_spheres(view, depths, albedos.front(), layout.sphere_radius);
    const double white = white_level(spheres);

    const Canvas canvas(size.width, size.height);
    cairo_t* const cairo = canvas.cairo();
    draw_header(canvas, layout, table);
    for (std::size_t column = 0; column < depths.size(); ++column) {
        cairo_save(cairo);
        cairo_translate(cairo, layout.margin + static_cast<double>(column) * layout.column_width,
                        0);
        canvas.text(layout.column_width / 2, layout.heading_y, depth_heading(depths[column]), 20,
                    bright, Align::centre);
        if (!spheres.empty())
            draw_spheres(canvas, layout, spheres[column], white, orders_of(table));
        cairo_translate(cairo, layout.lobe_x, layout.lobe_y);
        draw_lobes(canvas, layout, view, depths[column], albedos);
        cairo_restore(cairo);
    }
    draw_legend(canvas, layout, table, albedos, white);
    write_surface(canvas.surface(), png);
}

}  // namespace stratus
