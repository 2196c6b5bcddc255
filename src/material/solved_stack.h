// R and T of one colour of a material between all pairs of a list of cosines, lit from either side.
#pragma once

#include <stratus/bake/stack_file.h>
#include <stratus/transfer/stack.h>

#include <optional>
#include <vector>

namespace stratus {

constexpr double grazing = 1e-9;  // cosine that is solved for the limit at 0

/// True where light passes through.
bool is_transparent(const Stack& stack);

/// Returns the optical depth of all layers.
double optical_depth(const Stack& stack);

class SolvedStack {
  public:
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
    bool transparent_;
};

}  // namespace stratus
