// Layers that stand for a recipe where solvers are compared and timed.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/recipe.h>

#include <vector>

namespace stratus {

/// Layers of a recipe, and their values at directions other than those that `resolve` probes.
class CostLayers {
  public:
    CostLayers(const Recipe& recipe, int threads);

    using Layers = std::vector<LayerSolution>;

    /// All albedos at some depths of the ladder, the first and the last among them.
    Layers solve(const SolverOptions& solver) const;

    /// Totals at all pairs of directions, and the floors of their errors, in one order.
    struct Values {
        std::vector<double> total, floor;
    };

    Values values(const Layers& layers) const;

    /// Seconds of one solve of the deepest and brightest layer, the best of some.
    double time_solve(const SolverOptions& solver) const;

  private:
    Values values_of(const LayerSolution& layer) const;

    const Recipe& recipe_;
    const int threads_;
    std::vector<double> albedos_, mu_ = floor_cosines();
    DepthLadder ladder_;
};

std::vector<double> errors_of(const CostLayers::Values& found, const CostLayers::Values& expected);

}  // namespace stratus
