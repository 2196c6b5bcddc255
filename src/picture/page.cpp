#include "page.h"

#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/picture/plots.h>
#include <stratus/picture/png.h>

#include <cairo-svg.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace stratus {
namespace {

cairo_status_t read_from_file(void* file, unsigned char* bytes, unsigned int count) {
    auto& stream = *static_cast<std::ifstream*>(file);
    stream.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(count));
    return stream ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_READ_ERROR;
}

void require_success(const fs::path& path, const Surface& surface) {
    const cairo_status_t status = cairo_surface_status(surface.get());
    if (status != CAIRO_STATUS_SUCCESS) fail(path, status);
}

/// Checks the size in the header before Cairo allocates memory for it. Files that are not PNG are
/// left to Cairo.
void check_size(std::ifstream& file, io::MemoryLimit limit) {
    constexpr std::uint64_t max_side = 1 << 14;
    constexpr std::size_t width_at = 16, height_at = 20;
    unsigned char start[height_at + 4];
    if (file.read(reinterpret_cast<char*>(start), sizeof start)) {
        const auto side = [&](std::size_t at) {
            return std::uint64_t{start[at]} << 24 | std::uint64_t{start[at + 1]} << 16 |
                   std::uint64_t{start[at + 2]} << 8 | start[at + 3];
        };
        const std::uint64_t width = side(width_at), height = side(height_at);
        if (width > max_side || height > max_side)
            throw std::runtime_error("a picture must have sides in [1, 16384]");
        // Cairo's pixels twice, as read and over black, and ours.
        limit.take("the picture", width * height * (4 + 4 + 3 * sizeof(float)));
    }
    file.clear();
    file.seekg(0);
}

}  // namespace

double srgb_encoded(double light) noexcept {
    if (!(light > 0)) return 0;  // NaN too
    light = std::min(light, 1.0);
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

double srgb_decoded(double encoded) noexcept {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

void write_png(const Image& image, double white, const std::vector<Label>& labels,
               const fs::path& path) {
    draw_png(path, image.width, image.height, black, [&](const Page& page) {
        page.image({0, 0}, image, white);
        for (const Label& label : labels)
            page.haloed_text({label.x, label.y}, label.text, 15, {0.85, 0.85, 0.85},
                             {3, black, 0.6}, Align::left, label.max_width);
    });
}

Image read_png(const fs::path& path, std::uintmax_t max_memory, PngEncoding encoding) {
    errno = 0;
    std::error_code absent;  // opening it says so better
    if (const auto status = fs::status(path, absent);
        fs::exists(status) && !fs::is_directory(status) && !fs::is_regular_file(status))
        throw std::runtime_error(path.string() + ": is not a regular file");
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(path, CAIRO_STATUS_READ_ERROR);
    io::naming(path, [&] { check_size(file, io::MemoryLimit(max_memory)); });
    const Surface read(cairo_image_surface_create_from_png_stream(read_from_file, &file));
    errno = 0;  // the reason is Cairo's
    require_success(path, read);
    // Whatever the format: 32 bits a pixel, over black.
    Image image(cairo_image_surface_get_width(read.get()),
                cairo_image_surface_get_height(read.get()));
    const Surface plain(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
    {
        const Context context(cairo_create(plain.get()));
        cairo_set_source_surface(context.get(), read.get(), 0, 0);
        cairo_paint(context.get());
    }
    cairo_surface_flush(plain.get());
    require_success(path, plain);
    double light[256];
    for (int n = 0; n < 256; ++n)
        light[n] = encoding == PngEncoding::srgb ? srgb_decoded(n / 255.0) : n / 255.0;
    const unsigned char* const bytes = cairo_image_surface_get_data(plain.get());
    const int stride = cairo_image_surface_get_stride(plain.get());
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            std::uint32_t pixel;
            std::memcpy(&pixel,
                        bytes + static_cast<std::ptrdiff_t>(y) * stride + std::ptrdiff_t{4} * x,
                        sizeof pixel);
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = static_cast<float>(light[pixel >> (16 - 8 * c) & 255]);
        }
    return image;
}

namespace {

/// Handles UTF-8: the bytes of a character after its first begin with the bits 10.
void remove_last_character(std::string& text) {
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80)
        text.pop_back();
    if (!text.empty()) text.pop_back();
}

std::uint32_t eight_bits(double light) {
    return static_cast<std::uint32_t>(std::lround(255 * srgb_encoded(light)));
}

/// A cairo_write_func_t; `file` is a std::ofstream.
cairo_status_t append_to_file(void* file, const unsigned char* bytes, unsigned int count) {
    auto& stream = *static_cast<std::ofstream*>(file);
    stream.write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(count));
    return stream ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

void draw_on(cairo_surface_t* surface, const Colour& background, const Draw& draw) {
    const Context context(cairo_create(surface));
    cairo_set_source_rgb(context.get(), background.red, background.green, background.blue);
    cairo_paint(context.get());
    draw(Page(context.get()));
}
constexpr double exponent_size = 7, y_title_at = 14;

/// A number at which a line is drawn across a plot.
struct Tick {
    double value;
    std::string label{};            // may be empty
    std::optional<int> exponent{};  // of the label, raised
};

/// Ticks of an axis so long, whose labels of powers of ten are at least `min_distance` apart.
std::vector<Tick> make_ticks(const PlotAxis& axis, double length, double min_distance) {
    std::vector<Tick> ticks;
    if (axis.logarithmic) {
        const int first = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)),
                  last = static_cast<int>(std::floor(std::log10(axis.high) + 1e-9));
        const int step =
            std::max(1, static_cast<int>(std::ceil(min_distance * (last - first) / length)));
        for (int decade = first; decade <= last; ++decade)
            ticks.push_back(
                {std::pow(10.0, decade), (decade - first) % step == 0 ? "10" : "", decade});
        return ticks;
    }
    const double step = round_below((axis.high - axis.low) / 4);
    const long long last = std::llround(std::floor(axis.high / step + 1e-9));
    for (long long k = std::llround(std::ceil(axis.low / step - 1e-9)); k <= last; ++k) {
        const double value = static_cast<double>(k) * step;
        ticks.push_back({value, short_number(value, 3)});
    }
    return ticks;
}

/// A label with its exponent, on a base line.
void draw_label(const Page& page, Point at, const Tick& tick, Align align) {
    if (tick.label.empty()) return;
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

Page::Page(cairo_t* cairo) : cairo_(cairo) {
    cairo_select_font_face(cairo_, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
}

void Page::set_source(const Colour& colour, double opacity) const {
    cairo_set_source_rgba(cairo_, colour.red, colour.green, colour.blue, opacity);
}

double Page::text_width(const std::string& text, double size) const {
    cairo_text_extents_t extents;
    cairo_set_font_size(cairo_, size);
    cairo_text_extents(cairo_, text.c_str(), &extents);
    return extents.x_advance;
}

void Page::start_text(Point at, std::string& text, double& size, Align align,
                      double max_width) const {
    std::ranges::replace_if(
        text, [](char c) { return c >= 0 && c < ' '; }, ' ');
    while (size > 12 && text_width(text, size) > max_width) size -= 0.5;
    if (text_width(text, size) > max_width) {
        do remove_last_character(text);
        while (!text.empty() && text_width(text + "...", size) > max_width);
        text += "...";
    }
    const double left_share = align == Align::left ? 0 : align == Align::centre ? 0.5 : 1;
    cairo_move_to(cairo_, at.x - left_share * text_width(text, size), at.y);
}

void Page::text(Point at, std::string text, double size, const Colour& colour, Align align,
                double max_width) const {
    start_text(at, text, size, align, max_width);
    set_source(colour);
    cairo_show_text(cairo_, text.c_str());
}

void Page::vertical_text(Point at, const std::string& text, double size,
                         const Colour& colour) const {
    translated(at, [&] {
        cairo_rotate(cairo_, -pi / 2);
        this->text({0, 0}, text, size, colour, Align::centre);
    });
}

void Page::haloed_text(Point at, std::string text, double size, const Colour& colour,
                       const Pen& halo, Align align, double max_width) const {
    cairo_new_path(cairo_);
    start_text(at, text, size, align, max_width);
    cairo_text_path(cairo_, text.c_str());
    set_source(halo.colour, halo.opacity);
    cairo_set_line_width(cairo_, halo.width);
    cairo_set_dash(cairo_, nullptr, 0, 0);
    cairo_stroke_preserve(cairo_);
    set_source(colour);
    cairo_fill(cairo_);
}

void Page::trace(const std::vector<Point>& points) const {
    cairo_new_path(cairo_);
    for (const Point& point : points) cairo_line_to(cairo_, point.x, point.y);
}

void Page::stroke(const Pen& pen) const {
    set_source(pen.colour, pen.opacity);
    cairo_set_line_width(cairo_, pen.width);
    cairo_set_dash(cairo_, pen.dashes.data(), static_cast<int>(pen.dashes.size()), 0);
    cairo_stroke(cairo_);
}

void Page::line(Point from, Point to, const Pen& pen) const { curve({from, to}, pen); }

void Page::curve(const std::vector<Point>& points, const Pen& pen) const {
    trace(points);
    stroke(pen);
}

void Page::arc(Point centre, double radius, double from, double to, const Pen& pen) const {
    cairo_new_path(cairo_);
    cairo_arc(cairo_, centre.x, centre.y, radius, from, to);
    stroke(pen);
}

void Page::arrow(Point from, Point to, const Pen& pen) const {
    constexpr double head = 12, half_angle = 0.35;
    const double angle = std::atan2(to.y - from.y, to.x - from.x);
    const auto behind = [&](double distance, double turn) {
        return Point{to.x - distance * std::cos(angle + turn),
                     to.y - distance * std::sin(angle + turn)};
    };
    line(from, behind(0.8 * head, 0), pen);
    fill({to, behind(head, -half_angle), behind(head, half_angle)}, pen.colour, pen.opacity);
}

void Page::outline(const std::vector<Point>& shape, const Pen& pen) const {
    trace(shape);
    cairo_close_path(cairo_);
    stroke(pen);
}

void Page::outline(const Box& box, const Pen& pen) const {
    outline({{box.x0, box.y0}, {box.x1, box.y0}, {box.x1, box.y1}, {box.x0, box.y1}}, pen);
}

void Page::fill(const std::vector<Point>& shape, const Colour& colour, double opacity) const {
    trace(shape);
    cairo_close_path(cairo_);
    set_source(colour, opacity);
    cairo_fill(cairo_);
}

void Page::fill(const Box& box, const Colour& colour, double top, double bottom) const {
    const Pattern gradient(cairo_pattern_create_linear(0, box.y0, 0, box.y1));
    cairo_pattern_add_color_stop_rgba(gradient.get(), 0, colour.red, colour.green, colour.blue,
                                      top);
    cairo_pattern_add_color_stop_rgba(gradient.get(), 1, colour.red, colour.green, colour.blue,
                                      bottom);
    cairo_new_path(cairo_);
    cairo_rectangle(cairo_, box.x0, box.y0, box.width(), box.height());
    if (top == bottom)
        set_source(colour, top);
    else
        cairo_set_source(cairo_, gradient.get());
    cairo_fill(cairo_);
}

void Page::mark(Point at, Marker marker, double r, const Pen& pen) const {
    const auto polygon = [&](std::vector<Point> corners) {
        for (Point& corner : corners) corner = {at.x + r * corner.x, at.y + r * corner.y};
        outline(corners, pen);
    };
    // Two strokes at right angles through the middle, in one path.
    const auto strokes = [&](double dx, double dy) {
        cairo_new_path(cairo_);
        cairo_move_to(cairo_, at.x - dx, at.y - dy);
        cairo_line_to(cairo_, at.x + dx, at.y + dy);
        cairo_move_to(cairo_, at.x - dy, at.y + dx);
        cairo_line_to(cairo_, at.x + dy, at.y - dx);
        stroke(pen);
    };
    switch (marker) {
        case Marker::circle: arc(at, r, 0, 2 * pi, pen); break;
        case Marker::square: polygon({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}); break;
        case Marker::triangle: polygon({{0, -1.3}, {1.2, 0.9}, {-1.2, 0.9}}); break;
        case Marker::diamond: polygon({{0, -1.3}, {1.3, 0}, {0, 1.3}, {-1.3, 0}}); break;
        case Marker::cross: strokes(r, r); break;
        case Marker::plus: strokes(1.3 * r, 0); break;
    }
}

void Page::image(Point corner, const Image& image, double white) const {
    const Surface surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
    if (const cairo_status_t status = cairo_surface_status(surface.get());
        status != CAIRO_STATUS_SUCCESS)
        throw std::runtime_error(std::string("picture: ") + cairo_status_to_string(status));
    unsigned char* const bytes = cairo_image_surface_get_data(surface.get());
    const std::ptrdiff_t stride = cairo_image_surface_get_stride(surface.get());
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float* const light = image.pixel(x, y);
            std::uint32_t pixel = 0;
            for (int c = 0; c < 3; ++c) pixel = pixel << 8 | eight_bits(double{light[c]} / white);
            std::memcpy(bytes + y * stride + std::ptrdiff_t{4} * x, &pixel, sizeof pixel);
        }
    cairo_surface_mark_dirty(surface.get());
    cairo_set_source_surface(cairo_, surface.get(), corner.x, corner.y);
    cairo_paint(cairo_);
}

void Page::clipped(const Box& box, const std::function<void()>& draw) const {
    cairo_save(cairo_);
    cairo_new_path(cairo_);
    cairo_rectangle(cairo_, box.x0, box.y0, box.width(), box.height());
    cairo_clip(cairo_);
    draw();
    cairo_restore(cairo_);
}

void Page::translated(Point origin, const std::function<void()>& draw) const {
    cairo_save(cairo_);
    cairo_translate(cairo_, origin.x, origin.y);
    draw();
    cairo_restore(cairo_);
}

void draw_png(const fs::path& path, int width, int height, const Colour& background,
              const Draw& draw) {
    const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
    draw_on(surface.get(), background, draw);
    errno = 0;
    require_success(path, surface);
    std::ofstream file(path, std::ios::binary);
    if (!file) fail(path, CAIRO_STATUS_WRITE_ERROR);
    const cairo_status_t status =
        cairo_surface_write_to_png_stream(surface.get(), append_to_file, &file);
    file.close();
    if (status != CAIRO_STATUS_SUCCESS || !file) fail(path, status);
}

void draw_svg(const fs::path& path, double width, double height, const Draw& draw) {
    errno = 0;
    std::ofstream file(path, std::ios::binary);
    if (!file) fail(path, CAIRO_STATUS_WRITE_ERROR);
    const Surface surface(
        cairo_svg_surface_create_for_stream(append_to_file, &file, width, height));
    draw_on(surface.get(), white, draw);
    cairo_surface_finish(surface.get());
    const cairo_status_t status = cairo_surface_status(surface.get());
    file.close();
    if (status != CAIRO_STATUS_SUCCESS || !file) fail(path, status);
}

void measure(const Draw& draw) {
    const Surface surface(cairo_recording_surface_create(CAIRO_CONTENT_COLOR, nullptr));
    draw_on(surface.get(), white, draw);
}

void PlotAxis::include(std::initializer_list<double> values) {
    low = std::min(low, std::min(values));
    high = std::max(high, std::max(values));
}

void PlotAxis::round() {
    if (logarithmic) {
        low = std::pow(10, std::floor(std::log10(low)));
        high = std::pow(10, std::ceil(std::log10(high)));
        if (low == high) high *= 10;
        return;
    }
    if (high - low <= 1e-9 * std::max(std::abs(low), std::abs(high))) {  // one value alone
        const double about = low == 0 ? 1 : std::abs(low) / 10;
        low -= about;
        high += about;
    }
    const double step = round_below((high - low) / 4);
    low = step * std::floor(low / step + 1e-9);
    high = step * std::ceil(high / step - 1e-9);
}

double PlotAxis::share(double value) const {
    return logarithmic ? std::log(value / low) / std::log(high / low)
                       : (value - low) / (high - low);
}

void draw_x_axis(const Page& page, const PlotFrame& frame) {
    const Box& box = frame.box;
    for (const Tick& tick : make_ticks(frame.x, box.width(), 30)) {
        const double x = frame.across(tick.value);
        page.line({x, box.y0}, {x, box.y1}, {0.5, grid});
        draw_label(page, {x, box.y1 + 13}, tick, Align::centre);
    }
    page.text({box.centre().x, box.y1 + 26}, frame.x.title, plot_text_size, black, Align::centre);
}

void draw_y_axis(const Page& page, const PlotFrame& frame) {
    const Box& box = frame.box;
    for (const Tick& tick : make_ticks(frame.y, box.height(), 11)) {
        const double y = frame.down(tick.value);
        page.line({box.x0, y}, {box.x1, y}, {0.5, grid});
        draw_label(page, {box.x0 - 4, y + 3}, tick, Align::right);
    }
    page.vertical_text({y_title_at, box.centre().y}, frame.y.title, plot_text_size, black);
}

}  // namespace stratus
