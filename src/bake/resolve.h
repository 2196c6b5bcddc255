#pragma once

#include <stratus/bake/bake.h>

#include <string>
#include <vector>

namespace stratus {

/// A choice that is at the last of its candidates and misses all the same.
struct AxisAtCap {
    std::string name;
    double value;
    double error;  // relative error that it alone leaves
};

/// A recipe of which nothing is open any more.
struct Resolution {
    Recipe recipe;
    std::vector<AxisAtCap> at_cap;
};

/// As `resolve`, every choice measured against `strictness` times the tolerance.
Resolution resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

}  // namespace stratus
