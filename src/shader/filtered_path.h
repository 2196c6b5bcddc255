// The path law of narrow peaks for filtered textures: sums of functions of the scattering angle, four for
// R and eight for T (multiple.shader).
#pragma once

#include <stratus/table/table.h>

#include "as_cxx.h"

#include <vector>

namespace stratus {

/// `stratus_path_functions` over (word, angle), `stratus_path_weights` over (slice, word, slant depth, albedo):
/// slices are even in excess / (excess + 4), and reflection's own is the last. The rest is what the text is told.
struct FilteredPath {
    ShaderTexture functions, weights;
    float lost_at_albedo_one, deepest;
    shader::vec4 grid;
};

/// The weights are the law itself at the functions' own angles, those from which the others follow best.
FilteredPath filtered_path(const TableView& table, const std::vector<float>& albedos);

}  // namespace stratus
