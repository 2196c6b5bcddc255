// The formats, one file each.
#pragma once

#include <stratus/material/material.h>

#include "solved_stack.h"

#include <string>
#include <vector>

namespace stratus {

MaterialFile make_fourier(const Material& material, const MaterialOptions& options);
MaterialFile make_tensor(const Material& material, bool rgb, const MaterialOptions& options);
MaterialFile make_mqdiffuse(const Material& material, const MaterialOptions& options);
MaterialFile make_atlas(const Material& material, const MaterialOptions& options);
MaterialFile make_slice(const Material& material, const MaterialOptions& options);

/// Every colour of a material solved at the same cosines.
std::vector<SolvedStack> solve_colours(const Material& material, const std::vector<double>& mu,
                                       const MaterialOptions& options);

/// Describes a material for a file's text: its title, layers and the ground under them.
std::string describe(const Material& material);

/// The note on the beam; none where nothing passes.
void note_beam(const Material& material, std::vector<std::string>& notes);

/// The note on what passes, for formats of reflection alone; none where nothing does.
void note_transmission(const Material& material, std::vector<std::string>& notes);

}  // namespace stratus
