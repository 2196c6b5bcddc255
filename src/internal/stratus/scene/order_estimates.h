// How much the orders n >= 2 matter in a scene: estimates over all that it contains and sees, by the
// solver itself, in milliseconds and without a table.
//
// Along a ray the light of a layer is R = R_1 + R_m, of a ground A t t' / (1 - A s), of a
// background B t. What leaving out the orders n >= 2 changes is at most the largest of the relative
// changes of these, so each is looked at alone. The share R_m / R grows with albedo and optical
// depth: the layer is solved with the largest albedo that occurs, at octaves up to the largest depth,
// on a grid over all directions that are seen. An estimate is a margin times the largest change
// found there. It is no bound: `bench/plan_bench.cpp` keeps the record of how often, and by how much,
// pictures change by more (docs/scenes.md).
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/scene/scene.h>

#include <string>
#include <vector>

namespace stratus {

/// The largest relative change of light along a ray that leaving an effect out makes.
struct ChangeEstimate {
    double found = 0;   // the largest at the geometries that were solved
    double change = 0;  // with a margin for all others
    std::string where;  // the matter and geometry of what was found
};

/// Makes `all` the larger change.
void join(ChangeEstimate& all, const ChangeEstimate& one);

struct OrderEstimates {
    ChangeEstimate multiple;  // orders n >= 2, and what they carry through the layer
    ChangeEstimate azimuth;   // replaced by their mean over azimuth
};

/// Ends as soon as both effects are found to change more than `enough`, which what is found then
/// says. The change is taken to be 1 of both effects of a shell, and of azimuth where few nodes do
/// not resolve the phase function.
OrderEstimates estimate_orders(const Scene& scene, double enough);

/// Directions of scattering, and how much they count.
struct WeightedGeometry {
    Geometry geometry;
    double weight;
};

/// Shares of the orders in the light of one side of a layer, summed over directions: [n - 1] is that of
/// order n.
///
/// Range    orders [1, 200]; at least one direction.
std::vector<double> order_shares(const PhaseFunction& phase_function, double albedo,
                                 double optical_depth, Side side,
                                 const std::vector<WeightedGeometry>& directions, int orders);

/// The fewest orders that leave out no more than `tolerance`; beyond those listed as if they went on
/// in the geometric series that the rest of all light leaves.
int orders_for(const std::vector<double>& shares, double tolerance);

}  // namespace stratus
