// Images in memory and as OpenEXR files: linear light, 32-bit floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stratus {

/// Red, green and blue of each pixel, row by row from the upper left corner.
struct Image {
    int width = 0, height = 0;
    std::vector<float> rgb;

    Image() = default;
    Image(int columns, int rows)
        : width(columns),
          height(rows),
          rgb(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) * 3) {}

    float* pixel(int x, int y) { return rgb.data() + offset(x, y); }
    const float* pixel(int x, int y) const { return rgb.data() + offset(x, y); }

  private:
    std::size_t offset(int x, int y) const {
        return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x));
    }
};

enum class Alpha {
    none,
    opaque,  // a channel A of 1, for readers that take textures of four channels alone
};

/// Writes an image, with text attributes, to `path` directly; `write_atomically` makes it atomic.
///
/// Errors   std::system_error.
void write_exr_image(const Image& image, const std::map<std::string, std::string>& attributes,
                     const std::filesystem::path& path, Alpha alpha = Alpha::none);

/// Writes texels of four numbers, floats or halves, row by row, as channels R, G, B and A.
///
/// Errors   std::system_error.
void write_exr_texels(const char* texels, int width, int height, bool halves,
                      const std::filesystem::path& path);

/// Reads channels R, G and B, or Y for all three. File and image may take `max_memory` bytes; 0:
/// half of the machine's memory.
///
/// Errors   std::runtime_error naming the path.
Image read_exr_image(const std::filesystem::path& path, std::uintmax_t max_memory = 0);

}  // namespace stratus
