// What varies over a surface: its colour, and the optical depth of the layer on it. Patterns are
// worked out wherever they are asked for, the same on every machine; images are looked up.
#pragma once

#include <stratus/io/image.h>
#include <stratus/runtime/slice.h>
#include <stratus/scene/space.h>

#include <memory>

namespace stratus {

/// A point of a surface: where patterns in space are asked for, and its place on an image, (0, 0)
/// the upper left corner and (1, 1) the lower right one; images repeat beyond.
struct Place {
    Vector3 point;
    double u, v;
};

/// Of a planet, from a point of the unit sphere: longitude and latitude.
Place place_on_sphere(const Vector3& point) noexcept;

/// Of a plane whose images are `extent` wide and high, from the origin on.
Place place_on_plane(double x, double y, double extent) noexcept;

/// A smooth random number of a point, about -1 to 1, of one octave of detail after another.
/// [Perlin 2002, improving noise; half as strong and twice as fine each]
double noise(Vector3 point, unsigned seed, int octaves = 8) noexcept;

/// Colour of a Lambert surface, or of a background: a share of light each.
struct Texture {
    enum class Pattern {
        plain,
        squares,     // each of a random colour between both
        continents,  // `other` where noise is above a level, else `colour`
        bands,       // along latitudes, between both
        image,
    };
    Pattern pattern = Pattern::plain;
    Rgb colour{0, 0, 0}, other{0, 0, 0};
    double scale = 1;  // squares or bands in half a turn (or a unit of length); spots a unit
    unsigned seed = 1;
    std::shared_ptr<const Image> image;

    Rgb at(const Place& place) const noexcept;
    bool is_black() const noexcept;
};

/// Optical depth of a layer.
struct DepthMap {
    enum class Pattern {
        plain,
        clouds,  // noise above a level that leaves `coverage` of the surface under clouds
        image,   // brightness of the image times `most`
    };
    Pattern pattern = Pattern::plain;
    double most = 0;  // plain: everywhere
    double scale = 1, coverage = 0.5;
    unsigned seed = 1;
    std::shared_ptr<const Image> image;

    double at(const Place& place) const noexcept;
    bool is_plain() const noexcept { return pattern == Pattern::plain; }
};

}  // namespace stratus
