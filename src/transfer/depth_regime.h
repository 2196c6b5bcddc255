// How the layer of a given depth follows from doubling: thin | solved | conservative | infinite.
#pragma once

#include <stratus/transfer/solver_options.h>

#include "layer.h"

namespace stratus {

/// In a layer this thin second-order scattering is below rounding, while single scattering is still
/// a normal number.
constexpr double thinnest_depth = 1e-280;

enum class DepthRegime {
    thin,          // below thinnest_depth: R and T in proportion to the depth
    solved,        // doubled to the depth itself
    conservative,  // beyond 2^12 / (1 - g) at w = 1: T by the law of diffusion
    infinite,      // doubled until T vanishes
};

struct DepthTarget {
    double optical_depth;
    DepthRegime regime = DepthRegime::solved;
    double doubled_depth = optical_depth;  // where doubling ends
};

/// The regime of a depth in [0, inf], for a layer that is conservative or not.
DepthTarget choose_target(double optical_depth, bool conservative, double asymmetry);

/// The ladder to double through; its last depth becomes the target (reach). Two depths where
/// conservative, the first of them half the second.
DepthLadder ladder_to(const DepthTarget& target);

/// R and T of a mode at the target, from those at the end of its ladder. T is empty at infinite
/// depth. `half_transmittance`: mean_transmittance one depth earlier, where conservative.
ModeMatrices reach(const DepthTarget& target, int mode, double half_transmittance,
                   const Directions& directions, ModeMatrices layer);

/// Diffuse transmittance under uniform illumination, from mode 0.
double mean_transmittance(const Directions& directions, const Eigen::MatrixXd& transmission);

/// Doublings to `optical_depth` from a thin start, exact to rounding along all cosines from the
/// smallest on.
int count_doublings(double smallest_cosine, double optical_depth);

/// Where doubling to infinity alone begins, a depth like any other.
constexpr double first_depth_to_infinity = 1;

/// Doublings after which any layer has reached the limit of infinite depth: those up to depth 1, 56
/// more until the change is below rounding, and a reserve for g near 1.
int max_doublings_to_infinity(double optical_depth);

}  // namespace stratus
