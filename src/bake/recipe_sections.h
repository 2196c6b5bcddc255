// Parts of recipes: the table [family], axes over parameters of the phase function, and the layers of a
// stack.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/bake/stack_file.h>
#include <stratus/bake/toml_section.h>

namespace stratus {

/// Reads [family], or second_phase_function with or without `mixture`, into a recipe whose phase
/// function and discretisation have been read. Axes lie in the order of PhaseParameter.
///
/// Errors   std::invalid_argument naming the key, what is allowed and what was met.
void read_family(const Section& file, const char* caller, const PhaseSource& source,
                 Recipe& recipe);

/// The lines that `read_family` reads, of a resolved recipe.
std::string family_text(const Recipe& recipe);

/// Key in [discretisation] of the samples along a parameter.
std::string samples_key(PhaseParameter parameter);

/// `file` is the root of a file whose keys are stack_keys().
///
/// Errors   as of parse_stack.
Stack read_layers(const Section& file, const TomlFile& origin, const PhaseSource& source);

/// Parses as parse_recipe does, and leaves the recipe's text empty.
Recipe make_recipe(const toml::table& parsed, const TomlFile& file, const PhaseSource& source);

}  // namespace stratus
