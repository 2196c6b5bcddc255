#include <stratus/scene/texture.h>

#include <stratus/base/constants.h>

#include "kernels/noise.h"

#include <cmath>
#include <cstdint>

namespace stratus {

namespace {

double unit_random(std::int64_t i, std::int64_t j, std::int64_t k, unsigned seed) {
    std::uint32_t n = seed_hash(seed);
    for (const std::int64_t cell : {i, j, k}) n = chained_hash(n, static_cast<std::uint32_t>(cell));
    return n * 0x1p-32;
}

Rgb mixed(const Rgb& a, const Rgb& b, double share) {
    const auto t = static_cast<float>(share);
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/// Bilinear; repeats, but for rows over a sphere, which end at its poles.
Rgb interpolated_pixel(const Image& image, const SurfacePoint& point) {
    const double u = point.u - std::floor(point.u),
                 v = point.on_sphere ? point.v : point.v - std::floor(point.v);
    const double x = u * image.width - 0.5, y = v * image.height - 0.5;
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    auto at = [&](int column, int row) {
        const float* const p = image.pixel((column + image.width) % image.width,
                                           point.on_sphere ? std::clamp(row, 0, image.height - 1)
                                                           : (row + image.height) % image.height);
        return Rgb{p[0], p[1], p[2]};
    };
    return mixed(mixed(at(i, j), at(i + 1, j), x - i), mixed(at(i, j + 1), at(i + 1, j + 1), x - i),
                 y - j);
}

double image_waves(const Image& image, double extent) { return image.width / (4 * extent); }

/// The level below which `share` of the noise lies. The noise is close to a normal distribution of
/// this width about 0, whose distribution function the logistic one approximates.
double noise_level(double share) {
    constexpr double spread = 0.34, logistic = 1.702;
    if (share <= 0) return -2;
    if (share >= 1) return 2;
    return spread * std::log(share / (1 - share)) / logistic;
}

}  // namespace

SurfacePoint sphere_point(const Vector3& point) {
    return {point, 0.5 + std::atan2(point.y, point.x) / (2 * pi),
            std::acos(std::clamp(point.z, -1.0, 1.0)) / pi, true};
}

SurfacePoint plane_point(double x, double y, double extent) {
    return {{x, y, 0}, x / extent, -y / extent};
}

double noise(const Vector3& point, unsigned seed) {
    return chosen_functions<NoiseKernel>().noise(point.x, point.y, point.z, seed);
}

Rgb Texture::at(const SurfacePoint& point) const {
    switch (pattern) {
        case Pattern::plain: break;
        case Pattern::squares: {
            // Twice as many around the equator as from pole to pole.
            const auto i = static_cast<std::int64_t>(std::floor(2 * scale * point.u)),
                       j = static_cast<std::int64_t>(std::floor(scale * point.v));
            auto share = [&](int channel) {
                return static_cast<float>(unit_random(i, j, channel, seed));
            };
            return {colour.r + share(0) * (other.r - colour.r),
                    colour.g + share(1) * (other.g - colour.g),
                    colour.b + share(2) * (other.b - colour.b)};
        }
        case Pattern::continents: {
            // A coast is as wide as the finest detail.
            const double height = noise(scale * point.position, seed) - noise_level(0.6);
            return mixed(colour, other, std::clamp(40 * height, 0.0, 1.0));
        }
        case Pattern::bands: {
            const double waves = std::sin(2 * pi * scale * point.v) +
                                 0.5 * std::sin(2 * pi * 1.9 * scale * point.v + 1) +
                                 0.25 * std::sin(2 * pi * 4.3 * scale * point.v + 2);
            return mixed(colour, other, std::clamp(0.5 + 0.3 * waves, 0.0, 1.0));
        }
        case Pattern::image: return interpolated_pixel(*image, point);
    }
    return colour;
}

double Texture::waves(double extent) const {
    switch (pattern) {
        case Pattern::plain: return 0;
        case Pattern::continents: return scale;
        case Pattern::image: return image_waves(*image, extent);
        case Pattern::squares: break;
        case Pattern::bands: return 4.3 * 2 * scale / extent;
    }
    return scale / extent;
}

bool Texture::is_black() const {
    return pattern == Pattern::plain && colour.r == 0 && colour.g == 0 && colour.b == 0;
}

double DepthMap::waves(double extent) const {
    if (pattern == Pattern::image) return image_waves(*image, extent);
    return is_plain() ? 0 : scale;
}

double DepthMap::at(const SurfacePoint& point) const {
    switch (pattern) {
        case Pattern::plain: break;
        case Pattern::clouds: {
            const double height = noise(scale * (point.position - offset), seed) -
                                  noise_level(1 - std::clamp(coverage, 0.0, 1.0));
            const double risen = std::clamp(height, 0.0, 1.0);  // 1: three widths above the mean
            return max * risen * risen * (3 - 2 * risen);
        }
        case Pattern::image: {
            const Rgb bright = interpolated_pixel(*image, point);
            return max * static_cast<double>((bright.r + bright.g + bright.b) / 3);
        }
    }
    return max;
}

}  // namespace stratus
