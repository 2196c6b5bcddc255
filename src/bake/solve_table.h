#pragma once

#include <stratus/bake/recipe.h>

#include <ctime>

namespace stratus {

/// Seconds that a processor has worked for this process: what else the machine does adds nothing.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Seconds that all samples of a resolved recipe take on some threads, from those of one piece.
double predicted_seconds(const Recipe& resolved, int threads);

}  // namespace stratus
