// Orders n >= 2 of sunlight that rings scatter towards the camera, tabulated over radius and azimuth:
// each point of the rings is seen along one direction, and a picture asks for nearly the same radii
// in all of its samples.
#pragma once

#include <stratus/scene/layer_light.h>

#include "azimuth_place.h"

#include <cstddef>
#include <vector>

namespace stratus {

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

}  // namespace stratus
