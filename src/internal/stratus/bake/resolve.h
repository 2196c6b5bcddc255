#pragma once

#include <stratus/bake/bake.h>

#include <string>
#include <vector>

namespace stratus {

/// An axis whose last candidate still misses its share of the tolerance.
struct AxisAtCap {
    std::string name;
    double value;
    double error;   // relative error that it alone leaves
    double needed;  // what would do, extrapolated; 0: unknown
};

/// A resolved recipe.
struct Resolution {
    Recipe recipe;
    std::vector<AxisAtCap> at_cap;
    double max_error = 0;  // that every choice was allowed
};

/// Resolves with every choice measured against `strictness` times the tolerance.
Resolution resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

/// The choices of a bake's first attempt, found in the bake's log and kept there.
Resolution resolve_as_first(const Recipe& recipe, const BakeOptions& options);

}  // namespace stratus
