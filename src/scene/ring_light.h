// Light of rings that a picture asks for at many places, tabulated beforehand: orders n >= 2 towards the
// camera, ringshine and planetshine.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/base/constants.h>
#include <stratus/scene/layer_light.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace stratus {

struct View;

/// Where a point is seen from the z axis among `count` azimuths, the first along x: four of them, and
/// their weights.
struct AzimuthPlace {
    std::array<std::size_t, 4> column{};
    std::array<double, 4> weight{};

    AzimuthPlace() = default;
    AzimuthPlace(const Vector3& point, std::size_t count) noexcept {
        const double turn = std::atan2(point.y, point.x) / (2 * pi),
                     along = (turn - std::floor(turn)) * static_cast<double>(count),
                     first = std::floor(along), t = along - first;
        for (std::size_t k = 0; k < 4; ++k)
            column[k] = (static_cast<std::size_t>(first) + k + count - 1) % count;
        weight = {-t * (t - 1) * (t - 2) / 6, (t * t - 1) * (t - 2) / 2, -t * (t + 1) * (t - 2) / 2,
                  t * (t * t - 1) / 6};
    }

    /// Interpolates values at all azimuths.
    Rgb3 interpolated(const Rgb3* values) const noexcept {
        Rgb3 sum{};
        for (std::size_t k = 0; k < 4; ++k) sum = sum + weight[k] * values[column[k]];
        return sum;
    }
};

// Orders n >= 2 of sunlight that rings scatter towards the camera, tabulated over radius and azimuth:
// each point of the rings is seen along one direction, and a picture asks for nearly the same radii
// in all of its samples.
class RingOrders {
  public:
    /// `light` must have tables.
    ///
    /// Accuracy a twentieth of the scene's tolerance where it is not empty.
    RingOrders(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
               LightDetail detail);

    /// Whether it has no values: of a camera so close that azimuths would have to be too many.
    bool empty() const noexcept { return grid_.empty(); }

    /// Returns the place of a point of the rings, for `light`.
    AzimuthPlace place(const Vector3& point) const noexcept { return {point, azimuth_count_}; }

    /// R or diffuse T, whichever the camera sees.
    Rgb3 light(const AzimuthPlace& place, double radius) const noexcept;

  private:
    Rgb3 at(const AzimuthPlace& place, std::size_t node) const noexcept;

    std::size_t azimuth_count_;
    std::vector<double>
        radius_;              // ends of intervals, in each of which a parabola joins three nodes
    std::vector<Rgb3> grid_;  // over node and azimuth
};

// Ringshine: diffuse light off and through rings that falls on their planet.
//
// The irradiance of the globe at p, with normal n, over the sun's on a surface that faces it, is the
// integral over the rings that rise above p's horizon, q with v = q - p and n v > 0:
//
//     E(p) = (1/pi) integral of I(q -> p) (n v / d) (|p_z| / d) / d^2 dA,   d = |v|
//
// I is pi times radiance over the sun's irradiance: mu0 R where p and the sun are on one side of the
// rings, else mu0 T, and 0 in the planet's shadow. Horizon and shadow bound the azimuths q may have
// at one radius: quadrature over radius and azimuth ends there. Light that rings scatter after the
// planet did is left out; so are opposition effects, which are narrower than the rings as the planet
// sees them, and the size of the sun.
class RingShine {
  public:
    /// Works E out on a grid of latitudes and local solar times. `layer` gives its
    /// orders n >= 2.
    ///
    /// Accuracy 5e-3 of E, 5e-6 where the rings hardly rise above the horizon; of light scattered
    ///          once for phase functions to asymmetry 0.9, of higher orders to 0.5.
    RingShine(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads,
              LightDetail detail);

    /// E at a point of the globe, of a white sun, in parts: of the rings on either side of the point's
    /// meridian.
    static constexpr std::size_t parts = 2;
    using Sources = std::array<LightSource, parts>;
    Sources sources(const Vector3& point) const noexcept;

  private:
    struct Light;
    /// At the places of both hemispheres: in darkness above its rings, and not. The sun is above the x
    /// axis, the place above the rings.
    std::array<Sources, 2> integrals(const Light& light, double latitude, double solar_time) const;

    Vector3 to_sun_;
    double sun_azimuth_, flattening_;
    bool shadows_;
    Axis latitude_, solar_time_;  // parametric, from the equator on; from the sun's meridian
    // One for the hemisphere in darkness above its rings, one for the other.
    std::array<std::vector<LightSource>, parts> grid_[2];
};

// Planetshine: light of a planet that falls on its rings.
//
// One half of the globe is above the rings and lights their upper face, the other their lower face.
// With L = pi I / F0 of the globe, by Lambert's law, ringshine included, a point of the rings adds
// to its radiance
//
//     (1/pi) integral of L(d) R(d, eye) |d_z| over directions d to the half on the eye's side,
//
// and the same with T over the other half. In units in which the globe is a sphere of radius 1, a
// point at radius r sees it within asin(1/r) of its centre; with sin(angle) = sin(chi) / r, chi in
// [0, pi/2], and the angle psi around the centre, nodes of Gauss crowd where light leaves the globe
// at grazing angles. Light that the rings return to the planet and back is left out.
//
// It is tabulated over radius and azimuth for all rings that one camera sees, as each of their points is
// seen along one direction.
class PlanetShine {
  public:
    /// `light` without planetshine.
    ///
    /// Accuracy 2e-3 of the rings' radiance, or of 5e-3 where they are darker.
    PlanetShine(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
                LightDetail detail);

    /// Light of the rings' matter at a radius, in the direction from their centre to `point`, where the
    /// view's ray meets them: for rays to the camera, interpolated.
    Rgb3 to_camera(const AzimuthPlace& place, double radius) const noexcept;
    AzimuthPlace place(const Vector3& point) const noexcept { return {point, azimuths_}; }

    /// For others, integrated.
    ///
    /// Range    directions that shine's table holds: those towards the camera, at least.
    static Rgb3 to_elsewhere(const Rings& rings, const View& view, const Vector3& point,
                             double radius, const Matter& matter) noexcept;

  private:
    std::size_t azimuths_;
    std::vector<double> radius_;  // every row of the profile, and between where depth changes
    std::vector<Rgb3> grid_;      // over radius and azimuth
};

}  // namespace stratus
