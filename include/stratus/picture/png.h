// PNG files of linear pictures, through one stated tone curve.
//
// A pixel of radiance L is shown as sRGB(min(L / white, 1)), [IEC 61966-2-1]: a screen then gives
// light in proportion to L, up to where it is white. NaN and negative numbers are black.
#pragma once

#include <stratus/io/image.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

/// Words in a picture; x and y in pixels, where the base line begins.
struct Label {
    double x, y;
    std::string text;
};

/// sRGB's curve: a share of light, clamped to [0, 1], to a share of the numbers in a file. And
/// back.
double srgb_encoded(double light) noexcept;
double srgb_decoded(double number) noexcept;

/// Writes `path` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::runtime_error naming the path and the reason.
void write_png(const Image& image, double white, const std::vector<Label>& labels,
               const std::filesystem::path& path);

/// Linear light, 1 where the file is white. Takes no more than `max_memory` bytes for the picture;
/// 0: half of the machine's.
///
/// Errors   std::runtime_error naming the path and the reason.
Image read_png(const std::filesystem::path& path, std::uintmax_t max_memory = 0);

}  // namespace stratus
