// The path law of narrow peaks for filtered textures: of a bound layer as it is, else as sums of functions
// of the scattering angle, four for R and eight for T (multiple.shader).
#pragma once

#include <stratus/table/table.h>

#include "as_cxx.h"

#include <vector>

namespace stratus {

/// Textures, and what the text is told. `stratus_path_law` has the law itself over slices, even in excess /
/// (excess + 4), reflection's own the last, and over slant depth.
struct FilteredPath {
    std::vector<ShaderTexture> textures;
    float lost_at_albedo_one, deepest;
    shader::vec4 grid;
};

/// `stratus_path_functions` over (word, angle), and the law over (slice, word, slant depth, albedo) at the
/// functions' own angles, those from which the others follow best.
FilteredPath filtered_path(const TableView& table, const std::vector<float>& albedos);

/// The law of three albedos over (slice, slant depth, angle), every `angle_step`-th of the law's own.
FilteredPath bound_path(const TableView& table, const double (&albedo)[3], int angle_step);

}  // namespace stratus
