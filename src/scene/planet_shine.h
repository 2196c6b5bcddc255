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
#pragma once

#include <stratus/scene/layer_light.h>

#include "azimuth_place.h"

#include <cstddef>
#include <vector>

namespace stratus {

struct View;

/// For all rings that one camera sees: tabulated over radius and azimuth, as each point of the rings
/// is seen along one direction.
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
