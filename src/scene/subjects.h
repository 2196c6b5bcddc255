// The radiance along a ray in scenes of each kind: one file a kind.
#pragma once

#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>

#include <algorithm>

namespace stratus {

struct Cell;

/// Waves of the coarsest detail of the layer and of what it lies on that a part of the picture covers, along
/// the longer side of its trace there.
double waves_within(const Rings& rings, const SceneLayer& layer, const Cell& cell);
double waves_within(const Planet& planet, const SceneLayer& layer, const Cell& cell);
double waves_within(const Slab& slab, const SceneLayer& layer, const Cell& cell);

/// One ray, and the sun in one direction. The light may have more of what rings and their planet exchange
/// than the scene's effects ask for.
struct View {
    const Scene& scene;
    const LayerLight& light;
    const Ray& ray;
    const Vector3& to_sun;
    const Cell* cell = nullptr;     // that the ray stands for; null: itself alone
    LightSum* scattered = nullptr;  // takes the layer's light where it is not null
};

Rgb3 ray_radiance(const Rings& rings, const View& view);
Rgb3 ray_radiance(const Planet& planet, const View& view);
Rgb3 ray_radiance(const Slab& slab, const View& view);

/// The background's radiance in a direction, without the sun's disk.
Rgb3 background_along(const Scene& scene, const Vector3& direction);

/// Whether the sun's disk is visible, and in that direction.
bool is_sun_along(const Scene& scene, const Vector3& direction);

/// pi I / F0 of the sun's disk, pi over its solid angle; 0 beside it and where it is not visible.
Rgb3 sun_along(const Scene& scene, const Vector3& direction);

/// Both, along a ray that meets nothing.
inline Rgb3 light_beyond(const Scene& scene, const Vector3& direction) {
    return background_along(scene, direction) + sun_along(scene, direction);
}

/// Distance at which a ray enters the unit sphere flattened along z; negative: nowhere.
double distance_to_globe(const Ray& ray, double flattening);

/// A point of a planet's surface, with its normal, and what lies there.
struct PlanetPlace {
    SurfacePoint point;
    Matter matter;
};
PlanetPlace planet_place(const Planet& planet, const SceneLayer& layer, const Vector3& normal);

/// Radiance of a planet, of its layer and of the ground through it, where its normal is `normal`.
Rgb3 planet_light(const Planet& planet, const View& view, const Vector3& normal);

/// Radiance along a ray of a planet whose layer is a shell (planet_and_slab.cpp).
Rgb3 shell_radiance(const Planet& planet, const View& view);

/// The cosine at which a plane layer takes as much of a beam out of it as a column of a spherical shell
/// on the unit sphere takes, where the beam comes at the cosine `mu` to the column, or from below its
/// horizon; 0 in the planet's shadow.
double shell_cosine(double optical_depth, double height, double mu);

/// Radiance of the globe in rings at one of its points, along the view's ray, for the sunlight that the
/// rings transmit directly, and for ringshine: by Lambert's law, or that of its layer.
Rgb3 globe_light(const Rings& rings, const View& view, const Vector3& point);

/// The normal of that globe at one of its points.
Vector3 globe_normal(const Vector3& point, double flattening);

/// The direction along which a camera sees a point, towards it.
inline Vector3 to_camera(const Camera& camera, const Vector3& point) {
    return camera.orthographic ? -camera.forward() : normalised(camera.position - point);
}

/// Where light from one direction leaves a layer in z = 0 along another.
inline Side side_of_plane(const Vector3& to_sun, const Vector3& to_eye) {
    return (to_sun.z > 0) == (to_eye.z > 0) ? Side::reflection : Side::transmission;
}

/// Irradiance of a surface that sees the sun at cosine `mu`, over that of one that faces a white sun.
inline Rgb3 irradiance(const View& view, double mu) { return mu * view.scene.sun_colour; }

/// Returns the sun's light that the layer sends, from its lit side or through it. Nothing here, but to the
/// view's sum, where it has one.
inline Rgb3 layer_light(const View& view, const Matter& matter, const Geometry& geometry,
                        Side side) {
    const Rgb3 lit = irradiance(view, geometry.mu_in);
    if (view.scattered) {
        if (matter.optical_depth > 0) view.scattered->add(side, geometry, lit);
        return {};
    }
    return lit * view.light.light(matter, geometry, side);
}

/// The light that an ocean's mirrored sun adds to Lambert's law of its colour: the mirror itself less
/// its spherical albedo, along the beams through the layer, where they cross it.
inline Rgb3 mirrored_sun(const View& view, const Texture& surface, const Matter& lit,
                         const Matter& seen, const Geometry& geometry) {
    if (!surface.mirror || !view.scene.effects.background) return {};
    const Geometry at{std::max(geometry.mu_in, least_cosine),
                      std::max(geometry.mu_out, least_cosine), geometry.azimuth};
    return ((*surface.mirror)(at)-surface.mirror_albedo) *
           (irradiance(view, at.mu_in) *
            (view.light.beam(lit, at.mu_in) * view.light.beam(seen, at.mu_out)));
}

}  // namespace stratus
