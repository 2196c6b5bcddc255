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

/// Through the point (x, y) of a picture of so many pixels: (0, 0) is its upper left corner,
/// (width, height) its lower right one.
Ray camera_ray(const Camera& camera, int width, int height, double x, double y) noexcept;

}  // namespace stratus
