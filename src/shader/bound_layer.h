// The textures of bound layers: that of shader_layer, and the numbers that a filtered one reads.
#pragma once

#include <stratus/phase/path_law.h>
#include <stratus/shader/shader.h>

#include "as_cxx.h"

namespace stratus {

/// `shader_layer` by a lookup in the table's textures.
ShaderTexture bound_layer(const PackedTable& table, const Medium<3>& medium, shader::AsCxx& lookup);

/// `stratus_numbers` of a bound layer: records of both sides, samples of phase functions, and the path
/// law of its colours, each a step.
ShaderTexture bound_numbers(const PackedTable& table, const PathSheet& bound);

}  // namespace stratus
