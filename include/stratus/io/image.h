// Pictures in memory, and as OpenEXR files: linear light, 32-bit floats, as they were computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stratus {

/// Red, green, blue of each pixel, row by row from the upper left corner.
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

/// Writes `path` itself, attributes as texts; callers who need it whole or not at all wrap it.
///
/// Errors   std::system_error.
void write_exr_image(const Image& image, const std::map<std::string, std::string>& attributes,
                     const std::filesystem::path& path);

/// Channels R, G, B, or Y for all three. Takes no more than `max_memory` bytes for the file and the
/// picture; 0: half of the machine's.
///
/// Errors   std::runtime_error naming the path.
Image read_exr_image(const std::filesystem::path& path, std::uintmax_t max_memory = 0);

}  // namespace stratus
