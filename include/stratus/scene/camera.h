// Cameras: where a pixel looks.
#pragma once

#include <stratus/scene/space.h>

namespace stratus {

/// Looks from `position` at `look_at`, z up in the picture (y where it looks along z).
struct Camera {
    Vector3 position{1, 0, 0}, look_at{0, 0, 0};
    bool orthographic = false;
    double width = 0.6;  // of the picture: angle, radians; orthographic: length

    /// Directions of the picture's right and upper edges.
    Vector3 right() const noexcept;
    Vector3 up() const noexcept;
    Vector3 forward() const noexcept;
};

/// The rays of a picture of so many pixels.
class PictureRays {
  public:
    PictureRays(const Camera& camera, int width, int height) noexcept;

    /// Through the point (x, y): (0, 0) is the upper left corner, (width, height) the lower right
    /// one.
    Ray through(double x, double y) const noexcept;

  private:
    Vector3 position_, forward_, right_, up_;
    bool orthographic_;
    double half_width_;  // of the picture: length, at a distance of 1 where lines converge
    int width_, height_;
};

}  // namespace stratus
