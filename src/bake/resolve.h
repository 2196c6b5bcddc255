#pragma once

#include <string>

#include <stratus/bake/bake.h>

namespace stratus {

/// As `resolve`, every choice measured against `strictness` times the tolerance.
Recipe resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

/// A number as notes tell it.
std::string short_number(double value, int digits = 2);

}  // namespace stratus
