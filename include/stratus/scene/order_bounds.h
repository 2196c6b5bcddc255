// How much the orders n >= 2 matter in a scene: bounds over all that it contains and sees, by the
// solver itself, in milliseconds and without a table.
//
// Along a ray the light of a layer is R = R_1 + R_m, of a ground A t t' / (1 - A s), of a
// background B t. What leaving out the orders n >= 2 changes is at most the largest of the relative
// changes of these, so each is bounded alone. R_m / R_1 is the ratio r = R_m / S over the phase
// function's value, S the closed form of order 1 per unit of it. The ratio is smooth in both
// cosines and in azimuth and grows with albedo and optical depth: it is solved at every octave of
// depth, each with the largest albedo that occurs in it, on a grid over all directions that are
// seen, and its bound is the largest value with what second differences allow between grid points.
// The phase function's own minimum between them is taken from its curve. The grid is refined until
// bound and largest value agree.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/scene/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// Light scattered by some of a scene's matter.
struct ScatteringPlace {
    PhaseFunction phase_function;
    double albedo = 0, optical_depth = 0;
    double radius = 0;  // in rings
    Side side = Side::reflection;
    Geometry geometry{1, 1, 0};

    std::string text() const;
};

/// The largest relative change of light along a ray that leaving an effect out makes.
struct ChangeBound {
    double found = 0;                      // at an exact geometry
    double bound = 0;                      // not exceeded by any
    std::string where;                     // the former's matter and geometry
    std::optional<ScatteringPlace> place;  // the same, of light scattered to the eye
};

/// Makes `all` the larger change.
void join(ChangeBound& all, const ChangeBound& one);

struct OrderBounds {
    ChangeBound multiple;  // orders n >= 2, and what they carry through the layer
    ChangeBound azimuth;   // replaced by their mean over azimuth
};

/// Ends as soon as both effects are found to change more than `enough`; their bounds are then 1. So
/// they are, unless they are known better, of azimuth where the solver's nodes do not resolve the
/// phase function, and of both where that has a narrow peak (is_peaked, accuracy.h).
///
/// Range    scenes of one phase function, or of two that mix (channel_scenes of others).
OrderBounds bound_orders(const Scene& scene, double enough);

/// What each order adds to the light at a place: [n - 1] is order n's share in all orders' light.
///
/// Range    orders [1, 200].
std::vector<double> order_shares(const ScatteringPlace& place, int orders);

/// The fewest orders that leave out no more than `tolerance`; none where more than those listed.
std::optional<int> orders_for(const std::vector<double>& shares, double tolerance);

}  // namespace stratus
