// Grids that strangers look up: cosines even in u = asin(sqrt(mu)) 2 / pi, azimuths even from 0 to
// pi, and R or T times mu_in + mu_out. That factor removes the growth at grazing angles; in u
// neither it nor the sines near the normal are steep.
#pragma once

#include <stratus/material/material.h>

#include "solved_stack.h"

#include <vector>

namespace stratus {

/// `count` cosines even in u, of which the first stands for the limit 0.
std::vector<double> even_cosines(int count);

/// `count` azimuths from 0 to pi.
std::vector<double> even_azimuths(int count);

/// A side that light leaves, by the side that it came from.
struct LitSide {
    const char* name;
    std::vector<SolvedValue> (SolvedStack::*values)(int in, int out,
                                                    const std::vector<double>& azimuths) const;
};

/// Reflection; transmission, where light passes; reflection_below, where it is another.
std::vector<LitSide> lit_sides(const Material& material, const std::vector<SolvedStack>& colours);

/// Optical depth that the beam passes, for each colour; infinity where nothing does.
std::vector<double> beam_depths(const Material& material);

}  // namespace stratus
