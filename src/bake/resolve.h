#pragma once

#include <stratus/bake/bake.h>

namespace stratus {

/// As `resolve`, every choice measured against `strictness` times the tolerance.
Recipe resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

}  // namespace stratus
