// What grows as a power of what: laws through the points of a study, and through layers timed for it.
#pragma once

#include "cost_sweep.h"

#include <vector>

namespace stratus {

std::vector<GrowthLaw> measure_growth(const Recipe& recipe, const CostBudget& budget,
                                      const std::vector<CostPoint>& points);

}  // namespace stratus
