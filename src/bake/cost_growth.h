// What grows as a power of what: laws through the points of a study, and through layers timed for it.
#pragma once

#include "cost_sweep.h"

#include <vector>

namespace stratus {

/// Of the time of a solve of one phase function over nodes and optical depth, and of a bake of the
/// recipe over ranks.
std::vector<GrowthLaw> time_growth(const Recipe& alone, const Recipe& recipe,
                                   const CostBudget& budget);

/// Of what the points have.
std::vector<GrowthLaw> find_growth(const std::vector<CostPoint>& points);

}  // namespace stratus
