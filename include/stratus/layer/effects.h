// Effects of a layer, each asked for by name and paid for only then.
//
// Effects are chosen when a slice is bound (slice.h), once for all its lookups. How they combine:
//
//   density      particles that fill the share D of the volume: every order sees the depth
//                tau / (1 - D). [Blinn82] 5.1
//   opposition   less shadow where the light comes from behind the eye (opposition.h): single
//                scattering on the lit side alone is multiplied by it; light scattered twice has
//                lost the direction that it came from. [Blinn82] 5.2
//   background   the share of a uniform background that is seen through the layer: the beam and the
//                diffuse transmittance of the orders asked for (SliceOf::background). Binding works
//                out the latter, some 0.1 ms without a table; without this effect the beam is seen
//                alone.
#pragma once

#include <stratus/layer/opposition.h>

namespace stratus {

/// The share D of the volume that particles of one radius fill: n (4/3) pi r^3. [Blinn82] figures 1
/// and 2
///
/// Units    number_density per cubed unit of radius, any unit.
/// Range    number_density [0, inf), radius (0, inf), so that D is in [0, 1).
double volume_fraction(double number_density, double radius);

/// tau / (1 - D). [Blinn82] 5.1
///
/// Range    optical_depth [0, inf], density [0, 1).
double effective_optical_depth(double optical_depth, double density) noexcept;

/// The effects asked of a layer. A lookup does nothing for the others.
struct Effects {
    bool single = true;
    bool multiple = true;  // all orders n >= 2 that the table holds; needs a table
    bool reflection = true;
    bool transmission = true;
    bool background = true;  // light scattered in SliceOf::background; costs a lookup nothing
    double density = 0;      // D, [0, 1)
    Opposition opposition;   // as seen_opposition(opposition, density)
};

/// Throws std::invalid_argument, naming the argument, when a number is out of range.
void check_effects(const Effects& effects);

}  // namespace stratus
