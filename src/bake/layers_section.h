// [[layers]] and [below], in stack files and where recipes bake a stack.
#pragma once

#include <stratus/bake/stack_file.h>
#include <stratus/bake/toml_section.h>

namespace stratus {

/// `file` is the root of a file whose keys are stack_keys().
///
/// Errors   as of parse_stack.
Stack read_layers(const Section& file, const TomlFile& origin, const PhaseSource& source);

}  // namespace stratus
