// Parts of recipes: keys of axes over parameters of the phase function, and the layers of a stack.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/bake/stack_file.h>
#include <stratus/bake/toml_section.h>

namespace stratus {

/// Key in [discretisation] of the samples along a parameter.
std::string samples_key(PhaseParameter parameter);

/// `file` is the root of a file whose keys are stack_keys().
///
/// Errors   as of parse_stack.
Stack read_layers(const Section& file, const TomlFile& origin, const PhaseSource& source);

/// Parses as parse_recipe does, and leaves the recipe's text empty.
Recipe make_recipe(const toml::table& parsed, const TomlFile& file, const PhaseSource& source);

}  // namespace stratus
