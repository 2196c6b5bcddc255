// Other ways to the same numbers, and other layers: Markov chains, photons, droplets of many sizes.
#pragma once

#include "cost_sweep.h"

#include <vector>

namespace stratus {

/// Markov chains over sublayers and photons over their number, of one layer; none over a lower
/// boundary, of counted orders and where there is no finite layer.
std::vector<CostPoint> measure_references(const Recipe& recipe, const CostBudget& budget,
                                          int reference_nodes);

/// The recipe's droplets in sizes from a quarter to four times theirs, solved with ever more nodes;
/// none of another phase function.
std::vector<CostPoint> measure_droplets(const Recipe& recipe, const CostBudget& budget);

}  // namespace stratus
