// Growth as powers: laws through the points of a study, and through layers timed for it.
#pragma once

#include "cost_sweep.h"

#include <vector>

namespace stratus {

/// Returns the laws of the time of a solve of one phase function over nodes and optical depth, and of a bake of the
/// recipe over ranks.
std::vector<GrowthLaw> time_growth(const Recipe& alone, const Recipe& recipe,
                                   const CostBudget& budget);

/// Finds the laws of the quantities that the points have.
std::vector<GrowthLaw> find_growth(const std::vector<CostPoint>& points);

}  // namespace stratus
