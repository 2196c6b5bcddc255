// The table [family] of a recipe: axes over parameters of the phase function.
#pragma once

#include <stratus/bake/recipe.h>
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

}  // namespace stratus
