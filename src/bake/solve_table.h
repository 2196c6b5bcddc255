#pragma once

#include <stratus/bake/recipe.h>

#include <ctime>
#include <vector>

namespace stratus {

/// Seconds that a processor has worked for this process: what else the machine does adds nothing.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The units of a resolved recipe, which any thread or rank may solve, from one that is timed.
struct PredictedUnits {
    std::vector<double> seconds;  // of each, on one thread
    double flops;                 // of all, at most
};

PredictedUnits predict_units(const Recipe& resolved);

}  // namespace stratus
