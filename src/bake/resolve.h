#pragma once

#include <stratus/bake/bake.h>

#include <string>
#include <vector>

namespace stratus {

/// An axis whose last candidate still misses its share of the tolerance.
struct AxisAtCap {
    std::string name;
    double value;
    double error;  // relative error that it alone leaves
};

/// A resolved recipe.
struct Resolution {
    Recipe recipe;
    std::vector<AxisAtCap> at_cap;
};

/// As `resolve`, every choice measured against `strictness` times the tolerance.
Resolution resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

}  // namespace stratus
