#include <stratus/picture/portrait.h>

#include <stratus/base/number_text.h>
#include <stratus/picture/png.h>

#include "page.h"

#include <algorithm>

namespace stratus {
namespace {

// ---- Layout

constexpr double page_width = 1600, page_margin = 40;  // pixels
constexpr double text_width = page_width - 2 * page_margin;

/// In pixels: in each column one zone for the lobes and one for the spheres.
struct Layout {
    double height = 0;
    double column_width = 0;
    double heading_y = 0;
    Point lobes{};  // where the beam meets the layer, from the column's left edge
    double lobe_radius = 0;
    double sphere_x[2] = {0, 0}, sphere_y = 0;
    double legend_y = 0;
};

double column_width(std::size_t columns) { return text_width / static_cast<double>(columns); }

/// With few columns, spheres stand beside the lobes and not below.
bool is_side_by_side(std::size_t columns) { return columns <= 2; }

double zone_width(std::size_t columns, bool has_spheres) {
    return column_width(columns) / (has_spheres && is_side_by_side(columns) ? 2 : 1);
}

Layout make_layout(const Portrait& portrait) {
    constexpr double header = 148, gap = 24, caption = 58;
    const std::size_t columns = portrait.columns.size();
    const bool has_spheres = portrait.has_reflection;
    const bool side_by_side = has_spheres && is_side_by_side(columns);
    const double zone = zone_width(columns, has_spheres), radius = sphere_radius(columns);
    Layout layout;
    layout.column_width = column_width(columns);
    layout.lobe_radius = std::min(zone / 2 - 20, 240.0);

    const double above = (portrait.has_reflection ? 1.0 : 0.65) * layout.lobe_radius;
    const double below = portrait.has_transmission ? layout.lobe_radius + 12 : 60;
    layout.heading_y = header + gap;
    layout.lobes = {zone / 2, layout.heading_y + gap + above};
    const double lobes_end = layout.lobes.y + below;

    const double spheres_x = side_by_side ? zone : 0;
    for (int k = 0; k < 2; ++k) layout.sphere_x[k] = spheres_x + zone * (k == 0 ? 0.25 : 0.75);
    layout.sphere_y = side_by_side ? (layout.heading_y + lobes_end) / 2 : lobes_end + gap + radius;
    double end = lobes_end;
    if (has_spheres) end = std::max(end, layout.sphere_y + radius + caption);
    layout.legend_y = end + gap;
    layout.height = std::ceil(layout.legend_y + (has_spheres ? 116 : 92));
    return layout;
}

// ---- Colours

constexpr Colour background{0.063, 0.075, 0.102};
constexpr Colour bright{0.94, 0.95, 0.97};
constexpr Colour quiet{0.60, 0.64, 0.71};
constexpr Colour faint{0.30, 0.33, 0.40};
constexpr Colour beam{1.0, 0.97, 0.86};
constexpr Colour single_order{1.0, 0.45, 0.58};
constexpr Colour all_orders[] = {{1.0, 0.80, 0.30}, {0.20, 0.80, 0.70}, {0.36, 0.58, 0.98}};

Pen single_pen(double width) { return {width, single_order, 1, {7, 5}}; }

// ---- Lobes

/// One side of a column's lobes, above or below the layer.
struct LobeSide {
    double up = 1;  // -1 below
    const std::vector<double>* single = nullptr;
    std::vector<const std::vector<double>*> all;  // one an albedo
    double full_radius = 0;  // value that reaches the edge of the zone; 0: no side
};

LobeSide make_side(const PortraitColumn& column, std::vector<double> LobeCurve::*radii, double up) {
    LobeSide side;
    side.up = up;
    side.single = &(column.single.*radii);
    if (side.single->empty()) return side;
    double max = std::ranges::max(*side.single);
    for (const LobeCurve& curve : column.all) {
        side.all.push_back(&(curve.*radii));
        max = std::max(max, std::ranges::max(curve.*radii));
    }
    side.full_radius = 1.04 * max;
    return side;
}

/// Both sides get one scale where theirs differ by no more than this.
constexpr double max_shared_ratio = 4;

void share_scale(LobeSide& above, LobeSide& below) {
    const double max = std::max(above.full_radius, below.full_radius);
    const double min = std::min(above.full_radius, below.full_radius);
    if (max <= max_shared_ratio * min) above.full_radius = below.full_radius = max;
}

/// Half circles at multiples of a round value, two or three of them.
struct Scale {
    double step;
    int count;
};

Scale ring_scale(const LobeSide& side) {
    const double step = rounded(side.full_radius / 2.4);
    return {step, static_cast<int>(side.full_radius / step)};
}

void draw_scale(const Page& page, const LobeSide& side, double pixels) {
    const Scale scale = ring_scale(side);
    for (int ring = 1; ring <= scale.count; ++ring)
        page.arc({0, 0}, ring * scale.step / side.full_radius * pixels, side.up > 0 ? pi : 0,
                 side.up > 0 ? 2 * pi : pi, {1, faint, 0.75});
}

/// The outermost ring's value where it meets the layer, on the beam's side: lobes are small there.
void label_scale(const Page& page, const LobeSide& side, double pixels) {
    const Scale scale = ring_scale(side);
    const double value = scale.count * scale.step;
    page.haloed_text({value / side.full_radius * pixels - 4, side.up > 0 ? -5.0 : 15.0},
                     short_number(value, 3), 12, quiet, {4, background, 0.85}, Align::right);
}

void draw_side(const Page& page, const LobeSide& side, double pixels) {
    const double scale = pixels / side.full_radius;
    for (std::size_t a = side.all.size(); a-- > 0;) {
        const std::vector<Point> lobe = lobe_outline(*side.all[a], scale, side.up);
        if (a == 0) page.fill(lobe, all_orders[a], 0.13);
        page.outline(lobe, {2.4, all_orders[a]});
    }
    page.outline(lobe_outline(*side.single, scale, side.up), single_pen(2));
}

/// A bar, the more opaque the deeper the layer; fades out where it is infinitely deep.
void draw_layer(const Page& page, double optical_depth, double half_width, double thickness) {
    const double opacity = 0.15 + 0.75 * -std::expm1(-optical_depth);
    const bool is_infinite = std::isinf(optical_depth);
    page.fill({-half_width, 0, half_width, is_infinite ? 4 * thickness : thickness},
              {0.55, 0.60, 0.70}, opacity, is_infinite ? 0 : opacity);
}

/// The beam from the right, and below the layer what is transmitted of it.
void draw_beam(const Page& page, double angle, double transmittance, double length,
               double thickness) {
    const double across = std::sin(angle), up = std::cos(angle);
    page.arrow({length * across, -length * up}, {0, 0}, {2.5, beam});
    if (transmittance < 0.01) return;
    const double shift = thickness * across / up;
    page.arrow({-shift, thickness},
               {-shift - 0.45 * length * across, thickness + 0.45 * length * up},
               {0.5 + 2 * transmittance, beam, 0.25 + 0.75 * transmittance});
}

void draw_lobes(const Page& page, const Layout& layout, const Portrait& portrait,
                const PortraitColumn& column) {
    constexpr double thickness = 12;
    LobeSide above = make_side(column, &LobeCurve::above, 1);
    LobeSide below = make_side(column, &LobeCurve::below, -1);
    if (portrait.has_reflection && portrait.has_transmission) share_scale(above, below);

    const double pixels = layout.lobe_radius;
    const auto on_each_side = [&](const auto& draw) {
        if (above.full_radius > 0) draw(page, above, pixels);
        if (below.full_radius > 0)
            page.translated({0, thickness}, [&] { draw(page, below, pixels); });
    };
    on_each_side(draw_scale);
    draw_layer(page, column.optical_depth, pixels, thickness);
    draw_beam(page, portrait.beam_angle, column.beam_transmittance,
              portrait.has_reflection ? pixels : 0.65 * pixels, thickness);
    on_each_side(draw_side);
    on_each_side(label_scale);
}

// ---- Spheres

double sum(const Image& image) {
    double total = 0;
    for (const float value : image.rgb) total += double{value};
    return total;
}

/// The radiance shown white: all but the brightest 0.5 % of the brightest disc lies below it.
double white_level(const Portrait& portrait) {
    double white = 0;
    for (const PortraitColumn& column : portrait.columns) {
        std::vector<double> values;
        for (std::size_t k = 0; k < column.sphere.rgb.size(); k += 3)
            if (portrait.uncovered.rgb[k] < 1) values.push_back(double{column.sphere.rgb[k]});
        if (values.empty()) continue;
        const auto place = values.begin() + static_cast<std::ptrdiff_t>(
                                                0.995 * static_cast<double>(values.size() - 1));
        std::ranges::nth_element(values, place);
        white = std::max(white, *place);
    }
    return white > 0 ? white : 1;
}

/// `sphere` relative to white, on the page's background.
Image on_background(Image sphere, const Image& uncovered, double white) {
    const double behind[] = {srgb_decoded(background.red), srgb_decoded(background.green),
                             srgb_decoded(background.blue)};
    for (std::size_t k = 0; k < sphere.rgb.size(); ++k)
        sphere.rgb[k] = static_cast<float>(std::min(double{sphere.rgb[k]} / white, 1.0) +
                                           double{uncovered.rgb[k]} * behind[k % 3]);
    return sphere;
}

void draw_spheres(const Page& page, const Layout& layout, const Portrait& portrait,
                  const PortraitColumn& column, double white) {
    const Image* const spheres[] = {&column.single_sphere, &column.sphere};
    for (int k = 0; k < 2; ++k) {
        const double half = spheres[k]->width / 2.0;
        page.image({std::round(layout.sphere_x[k] - half), std::round(layout.sphere_y - half)},
                   on_background(*spheres[k], portrait.uncovered, white), 1);
    }
    const double y = layout.sphere_y + sphere_radius(portrait.columns.size()) + 26;
    page.text({layout.sphere_x[0], y}, "scattered once", 15, single_order, Align::centre);
    page.text({layout.sphere_x[1], y}, portrait.orders, 15, all_orders[0], Align::centre);
    const double single = sum(column.single_sphere);
    if (single > 0)
        page.text({layout.sphere_x[1], y + 20},
                  short_number(sum(column.sphere) / single, 3) + " times as bright", 13, quiet,
                  Align::centre);
}

// ---- Text

void draw_header(const Page& page, const Portrait& portrait) {
    page.text({page_margin, 66}, portrait.title, 36, bright, Align::left, text_width);
    page.text({page_margin, 100}, portrait.subtitles[0], 19, quiet, Align::left, text_width);
    page.text({page_margin, 126}, portrait.subtitles[1], 16, quiet, Align::left, text_width);
}

std::string depth_heading(double optical_depth) {
    return std::isinf(optical_depth) ? "infinitely deep"
                                     : "optical depth " + short_number(optical_depth, 3);
}

/// A short line and its meaning; returns where the next may begin.
double draw_key(const Page& page, Point at, const Pen& pen, const std::string& meaning) {
    page.line({at.x, at.y - 5}, {at.x + 36, at.y - 5}, pen);
    page.text({at.x + 46, at.y}, meaning, 16, bright);
    return at.x + 46 + page.text_width(meaning, 16) + 34;
}

void draw_legend(const Page& page, const Layout& layout, const Portrait& portrait, double white) {
    double x = page_margin;
    const double y = layout.legend_y + 24;
    const auto albedo = [&](std::size_t a) {
        return "albedo " + short_number(portrait.albedos[a], 4) + ", ";
    };
    for (std::size_t a = 0; a < portrait.albedos.size(); ++a)
        x = draw_key(page, {x, y}, {3, all_orders[a]}, albedo(a) + portrait.orders);
    x = draw_key(page, {x, y}, single_pen(3), albedo(0) + "scattered once");
    draw_key(page, {x, y}, {3, beam},
             "beam, " + short_number(degrees(portrait.beam_angle), 3) + "\u00b0 from the normal");

    const std::string sides = portrait.has_reflection && portrait.has_transmission
                                  ? "R \u00b7 mu_out above the layer, T \u00b7 mu_out below"
                              : portrait.has_reflection ? "R \u00b7 mu_out"
                                                        : "T \u00b7 mu_out";
    page.text({page_margin, y + 34},
              "Lobes: light leaving per solid angle in the plane of incidence, " + sides +
                  "; the outer ring's value stands beside it. A white Lambert surface "
                  "draws a circle of diameter 1.",
              15, quiet, Align::left, text_width);
    if (!portrait.has_reflection) return;
    page.text({page_margin, y + 58},
              "Spheres: covered with the layer, " + albedo(0) + portrait.lower_boundary +
                  ", phase angle " + short_number(degrees(portrait.phase_angle), 3) +
                  "\u00b0; I/F = mu_in \u00b7 R in sRGB, white from I/F = " +
                  short_number(white, 2) + " up, the same for all.",
              15, quiet, Align::left, text_width);
}

}  // namespace

PictureSize portrait_size(const Portrait& portrait) {
    const Layout layout = make_layout(portrait);
    return {static_cast<int>(page_width), static_cast<int>(layout.height)};
}

double sphere_radius(std::size_t columns) {
    return std::min(zone_width(columns, true) / 4 - 12, 140.0);
}

void draw_portrait(const Portrait& portrait, const std::filesystem::path& png) {
    const Layout layout = make_layout(portrait);
    const PictureSize size = portrait_size(portrait);
    const double white = white_level(portrait);
    draw_png(png, size.width, size.height, background, [&](const Page& page) {
        draw_header(page, portrait);
        for (std::size_t k = 0; k < portrait.columns.size(); ++k) {
            const PortraitColumn& column = portrait.columns[k];
            const double left = page_margin + static_cast<double>(k) * layout.column_width;
            page.translated({left, 0}, [&] {
                page.text({layout.column_width / 2, layout.heading_y},
                          depth_heading(column.optical_depth), 20, bright, Align::centre);
                if (portrait.has_reflection) draw_spheres(page, layout, portrait, column, white);
                page.translated(layout.lobes, [&] { draw_lobes(page, layout, portrait, column); });
            });
        }
        draw_legend(page, layout, portrait, white);
    });
}

}  // namespace stratus
