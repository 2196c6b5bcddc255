// The numbers that shaders of a bound, filtered layer read beside its light.
#pragma once

#include <stratus/phase/path_law.h>
#include <stratus/shader/shader.h>

namespace stratus {

/// `stratus_numbers` of a bound layer: records of both sides, samples of phase functions, and the path
/// law of its colours, each a step.
ShaderTexture bound_numbers(const PackedTable& table, const PathSheet& bound);

}  // namespace stratus
