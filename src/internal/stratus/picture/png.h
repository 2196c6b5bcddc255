// PNG files of linear pictures.
//
// Radiance L is stored as sRGB(min(L / white, 1)), [IEC 61966-2-1]: a screen shows light
// proportional to L up to white. NaN and negative numbers are black.
#pragma once

#include <stratus/io/image.h>

namespace stratus {

/// Text in a picture, which starts at (x, y), in pixels, on its base line; wider text is cut.
struct Label {
    double x, y, max_width;
    std::string text;
};

/// sRGB's transfer function, from linear light, clamped to [0, 1], to encoded values in [0, 1]; and
/// its inverse.
double srgb_encoded(double light) noexcept;
double srgb_decoded(double encoded) noexcept;

/// Writes `path` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::runtime_error naming the path and the reason.
void write_png(const Image& image, double white, const std::vector<Label>& labels,
               const std::filesystem::path& path);

/// A file's numbers encode light as sRGB, or are linear in what they stand for.
enum class PngEncoding { srgb, data };

/// Linear light, 1 where the file is white, black where it is transparent; 8 bits a channel. Takes at
/// most `max_memory` bytes; 0: half of the machine's.
///
/// Errors   std::runtime_error naming the path and the reason.
Image read_png(const std::filesystem::path& path, std::uintmax_t max_memory = 0,
               PngEncoding encoding = PngEncoding::srgb);

}  // namespace stratus
