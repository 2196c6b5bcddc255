#include <stratus/scene/texture.h>

#include <stratus/runtime/angle.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace stratus {
namespace {

/// Mueller's 32-bit integer hash: every bit of the result depends on every bit of n.
std::uint32_t scrambled(std::uint32_t n) noexcept {
    n = (n ^ (n >> 16)) * 0x45d9f3bu;
    n = (n ^ (n >> 16)) * 0x45d9f3bu;
    return n ^ (n >> 16);
}

std::uint32_t random_of(std::int64_t i, std::int64_t j, std::int64_t k, unsigned seed) noexcept {
    std::uint32_t n = scrambled(seed + 0x9e3779b9u);
    for (const std::int64_t cell : {i, j, k}) n = scrambled(n ^ static_cast<std::uint32_t>(cell));
    return n;
}

double unit_random(std::int64_t i, std::int64_t j, std::int64_t k, unsigned seed) noexcept {
    return random_of(i, j, k, seed) * 0x1p-32;
}

double eased(double t) noexcept { return t * t * t * (t * (6 * t - 15) + 10); }

double between(double a, double b, double share) noexcept { return a + share * (b - a); }

/// Dot product of an offset from a lattice point with that point's gradient: one of the twelve
/// directions to a cube's edges.
double slope_at(std::int64_t i, std::int64_t j, std::int64_t k, unsigned seed, double x, double y,
                double z) noexcept {
    const std::uint32_t which = random_of(i, j, k, seed) % 12;
    const double first = which < 8 ? x : y, second = which < 4 ? y : z;
    return (which & 1 ? -first : first) + (which & 2 ? -second : second);
}

double gradient_noise(const Vector3& p, unsigned seed) noexcept {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto i = static_cast<std::int64_t>(fx), j = static_cast<std::int64_t>(fy),
               k = static_cast<std::int64_t>(fz);
    const double x = p.x - fx, y = p.y - fy, z = p.z - fz;
    const double u = eased(x), v = eased(y), w = eased(z);
    auto row = [&](int dj, int dk) {
        return between(slope_at(i, j + dj, k + dk, seed, x, y - dj, z - dk),
                       slope_at(i + 1, j + dj, k + dk, seed, x - 1, y - dj, z - dk), u);
    };
    return between(between(row(0, 0), row(1, 0), v), between(row(0, 1), row(1, 1), v), w);
}

Rgb mixed(const Rgb& a, const Rgb& b, double share) noexcept {
    const auto t = static_cast<float>(share);
    return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}

/// Bilinear; repeats.
Rgb pixel_of(const Image& image, double u, double v) noexcept {
    const double x = (u - std::floor(u)) * image.width - 0.5,
                 y = (v - std::floor(v)) * image.height - 0.5;
    const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
    auto at = [&](int column, int row) {
        const float* const p =
            image.pixel((column + image.width) % image.width, (row + image.height) % image.height);
        return Rgb{p[0], p[1], p[2]};
    };
    return mixed(mixed(at(i, j), at(i + 1, j), x - i), mixed(at(i, j + 1), at(i + 1, j + 1), x - i),
                 y - j);
}

/// The level below which `share` of the noise lies. The noise is close to a normal distribution of
/// this width about 0, whose distribution function the logistic one approximates.
double noise_level(double share) noexcept {
    constexpr double spread = 0.34, logistic = 1.702;
    if (share <= 0) return -2;
    if (share >= 1) return 2;
    return spread * std::log(share / (1 - share)) / logistic;
}

}  // namespace

SurfacePoint sphere_point(const Vector3& point) noexcept {
    return {point, 0.5 + std::atan2(point.y, point.x) / (2 * pi),
            std::acos(std::clamp(point.z, -1.0, 1.0)) / pi};
}

SurfacePoint plane_point(double x, double y, double extent) noexcept {
    return {{x, y, 0}, x / extent, y / extent};
}

double noise(Vector3 point, unsigned seed, int octaves) noexcept {
    double sum = 0, share = 1;
    for (int octave = 0; octave < octaves; ++octave, share /= 2) {
        sum += share * gradient_noise(point, seed + static_cast<unsigned>(octave));
        // Rotated and shifted, so that the lattices of two octaves do not line up.
        point = {1.6 * point.x + 1.2 * point.y + 17.3, 1.6 * point.y - 1.2 * point.x + 5.1,
                 2 * point.z + 11.7};
    }
    return sum;
}

Rgb Texture::at(const SurfacePoint& point) const noexcept {
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
            const Rgb ground = mixed(other, {0.75f * other.r, 1.1f * other.g, 0.8f * other.b},
                                     std::clamp(3 * height, 0.0, 1.0));
            return mixed(colour, ground, std::clamp(40 * height, 0.0, 1.0));
        }
        case Pattern::bands: {
            const double waves = std::sin(2 * pi * scale * point.v) +
                                 0.5 * std::sin(2 * pi * 1.9 * scale * point.v + 1) +
                                 0.25 * std::sin(2 * pi * 4.3 * scale * point.v + 2);
            return mixed(colour, other, std::clamp(0.5 + 0.3 * waves, 0.0, 1.0));
        }
        case Pattern::image: return pixel_of(*image, point.u, point.v);
    }
    return colour;
}

bool Texture::is_black() const noexcept {
    return pattern == Pattern::plain && colour.r == 0 && colour.g == 0 && colour.b == 0;
}

double DepthMap::at(const SurfacePoint& point) const noexcept {
    switch (pattern) {
        case Pattern::plain: break;
        case Pattern::clouds: {
            const double height = noise(scale * point.position, seed) -
                                  noise_level(1 - std::clamp(coverage, 0.0, 1.0));
            const double risen = std::clamp(height, 0.0, 1.0);  // 1: three widths above the mean
            return max * risen * risen * (3 - 2 * risen);
        }
        case Pattern::image: {
            const Rgb bright = pixel_of(*image, point.u, point.v);
            return max * static_cast<double>((bright.r + bright.g + bright.b) / 3);
        }
    }
    return max;
}

}  // namespace stratus
