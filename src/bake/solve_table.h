#pragma once

#include <stratus/bake/recipe.h>

namespace stratus {

/// Seconds that all samples of a resolved recipe take on some threads, from those of one piece.
double predicted_seconds(const Recipe& resolved, int threads);

}  // namespace stratus
