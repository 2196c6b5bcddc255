#include <stratus/io/file_bytes.h>
#include <stratus/picture/png.h>

#include "page.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace stratus {
namespace {

cairo_status_t read_from_file(void* file, unsigned char* bytes, unsigned int count) {
    auto& stream = *static_cast<std::ifstream*>(file);
    stream.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(count));
    return stream ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_READ_ERROR;
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
               const std::filesystem::path& path) {
    draw_png(path, image.width, image.height, black, [&](const Page& page) {
        page.image({0, 0}, image, white);
        for (const Label& label : labels)
            page.haloed_text({label.x, label.y}, label.text, 15, {0.85, 0.85, 0.85},
                             {3, black, 0.6}, Align::left, label.max_width);
    });
}

Image read_png(const std::filesystem::path& path, std::uintmax_t max_memory, PngEncoding encoding) {
    errno = 0;
    std::error_code absent;  // opening it says so better
    if (const auto status = std::filesystem::status(path, absent);
        std::filesystem::exists(status) && !std::filesystem::is_directory(status) &&
        !std::filesystem::is_regular_file(status))
        throw std::runtime_error(path.string() + ": is not a regular file");
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(path, CAIRO_STATUS_READ_ERROR);
    io::naming(path, [&] { check_size(file, io::MemoryLimit(max_memory)); });
    const Surface read(cairo_image_surface_create_from_png_stream(read_from_file, &file));
    if (const cairo_status_t status = cairo_surface_status(read.get());
        status != CAIRO_STATUS_SUCCESS) {
        errno = 0;  // the reason is Cairo's
        fail(path, status);
    }
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
    if (const cairo_status_t status = cairo_surface_status(plain.get());
        status != CAIRO_STATUS_SUCCESS)
        fail(path, status);
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

}  // namespace stratus
