#include <stratus/scene/space.h>

#include <algorithm>

namespace stratus {

Geometry scattering_geometry(const Vector3& normal, const Vector3& to_sun, const Vector3& to_eye) {
    const double in = dot(normal, to_sun), out = dot(normal, to_eye);
    const Vector3 travelling_in = in * normal - to_sun, travelling_out = to_eye - out * normal;
    return {std::clamp(std::abs(in), least_cosine, 1.0),
            std::clamp(std::abs(out), least_cosine, 1.0),
            std::atan2(length(cross(travelling_in, travelling_out)),
                       dot(travelling_in, travelling_out))};
}

Vector3 Camera::forward() const { return normalised(look_at - position); }

Vector3 Camera::right() const {
    const Vector3 ahead = forward();
    const bool along_z = std::abs(ahead.z) > 1 - 1e-12;
    return normalised(cross(ahead, along_z ? Vector3{0, 1, 0} : Vector3{0, 0, 1}));
}

Vector3 Camera::up() const { return cross(right(), forward()); }

PictureRays::PictureRays(const Camera& camera, int width, int height)
    : position_(camera.position),
      forward_(camera.forward()),
      right_(camera.right()),
      up_(camera.up()),
      orthographic_(camera.orthographic),
      half_width_(camera.orthographic ? camera.width / 2 : std::tan(camera.width / 2)),
      width_(width),
      height_(height) {}

Ray PictureRays::through(double x, double y) const {
    const double across = (2 * x / width_ - 1) * half_width_;
    const double along = (height_ - 2 * y) / width_ * half_width_;
    const Vector3 offset = across * right_ + along * up_;
    if (orthographic_) return {position_ + offset, forward_};
    return {position_, normalised(forward_ + offset)};
}

}  // namespace stratus
