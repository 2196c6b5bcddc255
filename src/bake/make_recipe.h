// A recipe from TOML that is parsed already.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/bake/toml_section.h>

namespace stratus {

/// Parses as parse_recipe does, and leaves the recipe's text empty.
Recipe make_recipe(const toml::table& parsed, const TomlFile& file, const PhaseSource& source);

}  // namespace stratus
