// Points, directions and cameras of a scene. z is up; directions are of unit length; a planet's equator lies
// in z = 0.
#pragma once

#include <stratus/layer/single_scattering.h>

#include <cmath>

namespace stratus {

struct Vector3 {
    double x, y, z;

    friend Vector3 operator+(const Vector3& a, const Vector3& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend Vector3 operator-(const Vector3& a, const Vector3& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend Vector3 operator-(const Vector3& a) { return {-a.x, -a.y, -a.z}; }
    friend Vector3 operator*(double factor, const Vector3& a) {
        return {factor * a.x, factor * a.y, factor * a.z};
    }
};

inline double dot(const Vector3& a, const Vector3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }
inline Vector3 normalised(const Vector3& a) { return (1 / length(a)) * a; }

/// From the x axis by `azimuth` towards y, then up by `elevation`; radians.
inline Vector3 direction_at(double elevation, double azimuth) {
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
            std::sin(elevation)};
}

struct Ray {
    Vector3 origin, direction;

    Vector3 at(double distance) const { return origin + distance * direction; }
};

constexpr double least_cosine = 1e-6;  // of light along a layer

/// Cosines (at least least_cosine) and azimuth of one scattering by a layer, whichever its sides: those are
/// given by the signs of dot(normal, to_sun) and dot(normal, to_eye).
Geometry scattering_geometry(const Vector3& normal, const Vector3& to_sun, const Vector3& to_eye);

/// Looks from `position` at `look_at`; z is up in the picture (y where it looks along z).
struct Camera {
    Vector3 position{1, 0, 0}, look_at{0, 0, 0};
    bool orthographic = false;
    double width = 0.6;  // of the picture: an angle in radians; orthographic: a length

    /// The picture's axes.
    Vector3 right() const;
    Vector3 up() const;
    Vector3 forward() const;
};

/// The rays through a picture of so many pixels.
class PictureRays {
  public:
    PictureRays(const Camera& camera, int width, int height);

    /// Through the point (x, y): (0, 0) is the upper left corner, (width, height) the lower right
    /// one.
    Ray through(double x, double y) const;

  private:
    Vector3 position_, forward_, right_, up_;
    bool orthographic_;
    double half_width_;  // of the picture, in perspective at distance 1
    int width_, height_;
};

}  // namespace stratus
