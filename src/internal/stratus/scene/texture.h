// Textures: the colour of a surface, and the optical depth of the layer on it. Patterns are
// procedural and the same on every machine; images are interpolated.
#pragma once

#include <stratus/bsdf/slice.h>
#include <stratus/io/image.h>
#include <stratus/layer/ground_law.h>
#include <stratus/scene/space.h>

#include <algorithm>
#include <numbers>

namespace stratus {

/// Light or a share of it: red, green and blue.
using Rgb3 = std::array<double, 3>;

inline Rgb3 operator*(double factor, const Rgb3& light) {
    return {factor * light[0], factor * light[1], factor * light[2]};
}
inline Rgb3 operator*(const Rgb3& share, const Rgb3& light) {
    return {share[0] * light[0], share[1] * light[1], share[2] * light[2]};
}
inline Rgb3 operator+(const Rgb3& a, const Rgb3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Rgb3& operator+=(Rgb3& sum, const Rgb3& light) { return sum = sum + light; }

inline Rgb3 widened(const Rgb& light) {
    return {double{light.r}, double{light.g}, double{light.b}};
}

inline double brightest(const Rgb& light) { return double{std::max({light.r, light.g, light.b})}; }

inline double brightness(const Rgb3& light) { return light[0] + light[1] + light[2]; }

/// A point of a surface: in space, for patterns, and on an image, (0, 0) the upper left corner and
/// (1, 1) the lower right one; images repeat beyond, but end at the poles of a sphere.
struct SurfacePoint {
    Vector3 position;
    double u, v;
    bool on_sphere = false;
};

/// On a planet, from a point of the unit sphere: longitude, 0 in the image's middle and along x, and
/// latitude.
SurfacePoint sphere_point(const Vector3& point);

/// Width of images on the unit sphere, along its equator.
constexpr double sphere_extent = 2 * std::numbers::pi;

/// On a plane whose images are `extent` wide and high, their lower left corner in the origin and
/// upright as seen from above.
SurfacePoint plane_point(double x, double y, double extent);

/// Perlin's gradient noise (Improving noise, 2002), about -1 to 1: eight octaves, each twice as fine
/// and half as strong as the one before. The same bits on every machine.
double noise(const Vector3& point, unsigned seed);

/// Colour of a Lambert surface (its albedo) or of a background (its radiance).
struct Texture {
    enum class Pattern {
        plain,
        squares,     // each of a random colour between `colour` and `other`
        continents,  // `other` where noise is above a level, else `colour`
        bands,       // along latitudes, between the two
        image,
    };
    Pattern pattern = Pattern::plain;
    Rgb colour{0, 0, 0}, other{0, 0, 0};
    double scale = 1;  // squares or bands per half turn (or unit of length); detail per unit
    unsigned seed = 1;
    std::shared_ptr<const Image> image;
    // The law of an ocean that mirrors, with its brightest colour as its Lambert part, and the
    // spherical albedo of both; `colour` then includes that of the mirror.
    std::shared_ptr<const GroundLaw> mirror;
    double mirror_albedo = 0;

    Rgb at(const SurfacePoint& point) const;
    /// Waves of its coarsest detail in a unit of length, where images are `extent` wide; of images a wave
    /// for four of their pixels.
    double waves(double extent) const;
    bool is_black() const;
    /// Whether it is one colour, and not black.
    bool is_one_colour() const { return pattern == Pattern::plain && !is_black(); }
    /// Whether it depends on the point's place on an image.
    bool uses_image_place() const {
        return pattern != Pattern::plain && pattern != Pattern::continents;
    }
};

/// Optical depth of a layer.
struct DepthMap {
    enum class Pattern {
        plain,
        clouds,  // noise above a level that leaves `coverage` of the surface under clouds
        image,   // brightness of the image times `max`
    };
    Pattern pattern = Pattern::plain;
    double max = 0;  // plain: everywhere
    double scale = 1, coverage = 0.5;
    unsigned seed = 1;
    Vector3 offset{0, 0, 0};  // by which clouds have drifted
    std::shared_ptr<const Image> image;

    double at(const SurfacePoint& point) const;
    /// Returns the same of a map of depths.
    double waves(double extent) const;
    bool is_plain() const { return pattern == Pattern::plain; }
    /// Whether it depends on the point's place on an image.
    bool uses_image_place() const { return pattern == Pattern::image; }
};

}  // namespace stratus
