#pragma once

#include <stratus/bake/recipe.h>

#include <vector>

namespace stratus {

/// The units of a resolved recipe, which any thread or rank may solve, from one that is timed.
struct PredictedUnits {
    std::vector<double> seconds;  // of each, on one thread
    double flops;                 // of all, at most
};

PredictedUnits predict_units(const Recipe& resolved);

}  // namespace stratus
