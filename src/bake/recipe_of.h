// A recipe from TOML that is parsed already.
#pragma once

#include <stratus/bake/recipe.h>

#include "toml_section.h"

namespace stratus {

/// As parse_recipe, but for the recipe's text, which stays empty.
Recipe recipe_of(const toml::table& parsed, const TomlFile& file, const PhaseSource& source);

}  // namespace stratus
