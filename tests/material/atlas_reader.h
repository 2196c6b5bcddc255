// A reader of atlases, as a shader reads them: the texture's own bilinear filter in two tiles.
#pragma once

#include <stratus/io/image.h>

#include "../base/indices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace stratus::test {

class AtlasReader {
  public:
    AtlasReader(const std::filesystem::path& picture, const std::string& json)
        : image_(read_exr_image(picture)), json_(json) {
        columns_ = number("columns");
        width_ = number("tile_width");
        height_ = number("tile_height");
        if (image_.width != columns_ * width_) throw std::runtime_error("width");
        if (image_.height != rows() * height_) throw std::runtime_error("height");
    }

    int rows() const {
        const std::string names = after("rows");
        return static_cast<int>(
                   std::count(names.begin(),
                              names.begin() + static_cast<std::ptrdiff_t>(names.find(']')), ',')) +
               1;
    }

    /// f of the side in a row of tiles.
    std::array<double, 3> operator()(int row, double mu_in, double mu_out, double azimuth) const {
        const double column = (columns_ - 1) * evened(mu_in);
        const int first = std::min(static_cast<int>(column), columns_ - 2);
        const double x = 0.5 + (width_ - 1) * azimuth / pi_;
        const double y = 0.5 + (height_ - 1) * evened(mu_out) + row * height_;
        std::array<double, 3> f{};
        for (int next = 0; next < 2; ++next) {
            const double share = next == 0 ? 1 - (column - first) : column - first;
            const std::array<double, 3> texel = filtered((first + next) * width_ + x, y);
            for (const auto c : three_channels) f[c] += share * texel[c] / (pi_ * (mu_in + mu_out));
        }
        return f;
    }

    int number(const std::string& name) const { return std::stoi(after(name)); }

  private:
    static constexpr double pi_ = 3.14159265358979323846;

    static double evened(double mu) { return std::asin(std::sqrt(mu)) * 2 / pi_; }

    std::string after(const std::string& name) const {
        const std::size_t at = json_.find('"' + name + "\": ");
        if (at == std::string::npos) throw std::runtime_error(name + " is missing");
        return json_.substr(at + name.size() + 4);
    }

    /// A texture's bilinear filter: the centres of texels lie at half numbers.
    std::array<double, 3> filtered(double x, double y) const {
        const double left = x - 0.5, top = y - 0.5;
        const int i = static_cast<int>(std::floor(left)), j = static_cast<int>(std::floor(top));
        std::array<double, 3> sum{};
        for (int dj = 0; dj < 2; ++dj)
            for (int di = 0; di < 2; ++di) {
                const double weight =
                    (di ? left - i : 1 - (left - i)) * (dj ? top - j : 1 - (top - j));
                const float* const texel = image_.pixel(std::min(i + di, image_.width - 1),
                                                        std::min(j + dj, image_.height - 1));
                for (const auto c : three_channels)
                    sum[c] += weight * static_cast<double>(texel[c]);
            }
        return sum;
    }

    Image image_;
    std::string json_;
    int columns_, width_, height_;
};

}  // namespace stratus::test
