// R and T of one colour of a material between all pairs of a list of cosines, lit from either side.
#pragma once

#include <stratus/bake/stack_file.h>
#include <stratus/material/material.h>
#include <stratus/transfer/stack.h>

#include <optional>
#include <vector>

namespace stratus {

constexpr double grazing = 1e-9;  // cosine that is solved for the limit at 0

/// True where light passes through.
bool is_transparent(const Stack& stack);

class SolvedStack {
  public:
    SolvedStack() = default;
    SolvedStack(const Stack& stack, const std::vector<double>& mu, int nodes);

    /// R lit from above at many azimuths in radians.
    std::vector<SolvedValue> reflection(int in, int out, const std::vector<double>& azimuths) const;
    /// R lit from below; 0 of what is opaque.
    std::vector<SolvedValue> reflection_below(int in, int out,
                                              const std::vector<double>& azimuths) const;
    /// Diffuse T, lit from above; lit from below, the cosines change places.
    std::vector<SolvedValue> transmission(int in, int out,
                                          const std::vector<double>& azimuths) const;

    const ModeSolution& solution() const { return above_; }

    /// Whether T is the same with the cosines exchanged, and R from either side.
    bool is_symmetric() const { return !below_.has_value(); }

    bool is_transparent() const { return transparent_; }

  private:
    StackSolution above_;
    std::optional<StackSolution> below_;  // of layers that differ and let light through
    bool transparent_ = false;
};

// Grids that strangers look up: cosines even in u = asin(sqrt(mu)) 2 / pi, azimuths even from 0 to
// pi, and R or T times mu_in + mu_out. That factor removes the growth at grazing angles; in u
// neither it nor the sines near the normal are steep.

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
