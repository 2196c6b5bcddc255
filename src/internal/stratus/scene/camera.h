// Cameras: where a pixel looks.
#pragma once

#include <stratus/scene/space.h>

namespace stratus {

/// Looks from `position` at `look_at`; z is up in the picture (y where it looks along z).
struct Camera {
    Vector3 position{1, 0, 0}, look_at{0, 0, 0};
    bool orthographic = false;
    double width = 0.6;  // of the picture: an angle in radians; orthographic: a length

    /// The picture's axes.
    Vector3 right() const noexcept;
    Vector3 up() const noexcept;
    Vector3 forward() const noexcept;
};

/// The rays through a picture of so many pixels.
class PictureRays {
  public:
    PictureRays(const Camera& camera, int width, int height) noexcept;

    /// Through the point (x, y): (0, 0) is the upper left corner, (width, height) the lower right
    /// one.
    Ray through(double x, double y) const noexcept;

  private:
    Vector3 position_, forward_, right_, up_;
    bool orthographic_;
    double half_width_;  // of the picture, in perspective at distance 1
    int width_, height_;
};

}  // namespace stratus
