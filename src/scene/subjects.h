// The radiance along a ray in scenes of each kind: one file a kind.
#pragma once

#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>

namespace stratus {

struct Cell;

/// One ray, and the sun in one direction.
struct View {
    const Scene& scene;
    const LayerLight& light;
    const Ray& ray;
    const Vector3& to_sun;
    const Cell* cell = nullptr;  // that the ray stands for; null: itself alone
};

Rgb3 radiance_of(const Rings& rings, const View& view) noexcept;
Rgb3 radiance_of(const Planet& planet, const View& view) noexcept;
Rgb3 radiance_of(const Slab& slab, const View& view) noexcept;

/// The background's radiance in a direction.
Rgb3 background_along(const Scene& scene, const Vector3& direction) noexcept;

/// Distance at which a ray enters the unit sphere flattened along z; negative: nowhere.
double distance_to_globe(const Ray& ray, double flattening) noexcept;

/// The normal of that globe at one of its points.
Vector3 globe_normal(const Vector3& point, double flattening) noexcept;

inline Rgb3 operator*(double factor, const Rgb3& light) noexcept {
    return {factor * light[0], factor * light[1], factor * light[2]};
}
inline Rgb3 operator*(const Rgb3& share, const Rgb3& light) noexcept {
    return {share[0] * light[0], share[1] * light[1], share[2] * light[2]};
}
inline Rgb3 operator+(const Rgb3& a, const Rgb3& b) noexcept {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

}  // namespace stratus
