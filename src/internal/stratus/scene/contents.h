// The contents of a scene, and what it sees of its layer, from its geometry and its profiles alone: no ray is
// cast. Ranges may be wider than those of a picture's rays, never narrower.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/scene/scene.h>

namespace stratus {

/// Extends a range to include a value, or all of another one.
void widen(Range& range, double value);
void widen(Range& range, const Range& other);

/// The kinds of light that a scene asks its layer for.
struct SeenLight {
    bool reflection = false;    // of the lit side
    bool transmission = false;  // diffuse, on the unlit side
    bool fluxes = false;        // through the layer: of a ground, or of a background of one colour
    bool underside = false;     // lit by the ground
    bool shine = false;         // that rings and their planet exchange, along all directions

    bool any() const { return reflection || transmission || fluxes; }
};

/// Follows from the side of the layer on which sun and camera stand, with the scene's effects.
SeenLight seen_light(const Scene& scene);

/// Directions to the sun and to the eye, as geometries of one scattering: cosines, and the azimuth
/// between the directions of propagation.
struct SeenDirections {
    Range mu_in{0, 1}, mu_out{0, 1};
    Range azimuth{0, 180};  // degrees
};

/// Exact for a point sun and an orthographic camera; of a perspective one over a plane, those of the
/// part of the plane that the picture may show.
SeenDirections seen_directions(const Scene& scene);

/// Scattering angles, degrees, of light that leaves on the lit side or, diffuse, on the other. Over a
/// plane they are found on a grid of directions and widened by what that may miss.
Range seen_scattering_angles(const Scene& scene, Side side);

/// Matter of which all depths, albedos and mixtures in these ranges may occur; none to begin with.
struct MatterSpan {
    Range optical_depth{infinity, 0}, albedo{1, 0}, mixture{1, 0};

    /// Extends it to hold a depth of some matter.
    void add(const Matter& matter, double depth);
};

/// All that the layer is made of, with the effect of density: the spans between the knots of a
/// ring's profile; one span of a planet or slab. Empty parts are left out.
std::vector<MatterSpan> matter_spans(const Scene& scene);

/// All of these in one.
MatterSpan whole_matter_span(const Scene& scene);

/// The brightest Lambert albedo of the ground that is seen through the layer; 0 without one.
double brightest_ground(const Scene& scene);

}  // namespace stratus
