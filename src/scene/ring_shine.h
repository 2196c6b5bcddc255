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
#pragma once

#include <stratus/base/axis.h>
#include <stratus/scene/layer_light.h>

#include <array>
#include <vector>

namespace stratus {

class RingShine {
  public:
    /// Works E out on a grid of latitudes and local solar times. `layer` gives its
    /// orders n >= 2.
    ///
    /// Accuracy 5e-3 of E, 5e-6 where the rings hardly rise above the horizon; of light scattered
    ///          once for phase functions to asymmetry 0.9, of higher orders to 0.5.
    RingShine(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads,
              LightDetail detail);

    /// E at a point of the globe, of a white sun.
    Rgb3 irradiance(const Vector3& point) const noexcept;

    /// E in parts, for surfaces that reflect by a law of their own: of the rings on either side of the
    /// point's meridian.
    static constexpr std::size_t parts = 2;
    using Sources = std::array<LightSource, parts>;
    Sources sources(const Vector3& point) const noexcept;

  private:
    struct Light;
    /// At the places of both hemispheres: in darkness above its rings, and not. The sun is above the x
    /// axis, the place above the rings.
    std::array<Sources, 2> integrals(const Light& light, double latitude, double solar_time) const;
    double solar_time(const Vector3& point) const noexcept;
    bool is_lit(const Vector3& point) const noexcept { return (point.z > 0) == (to_sun_.z > 0); }
    template <class Grid>
    auto at(const Vector3& point, double solar_time, const Grid& grid) const noexcept;

    Vector3 to_sun_;
    double flattening_;
    bool shadows_;
    Axis latitude_, solar_time_;  // parametric, from the equator on; from the sun's meridian
    std::vector<Rgb3> grid_[2];   // of the hemisphere in darkness above its rings, and of the other
    std::array<std::vector<LightSource>, parts> sources_[2];
};

}  // namespace stratus
