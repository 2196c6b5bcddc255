// The beginning of all solvers of stacks: layers and lower boundary truncated, the directions, and the
// modes of each; and the loop over modes.
#pragma once

#include "mode_recorder.h"
#include "options.h"
#include "paths.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace stratus {

class StackSolver {
  protected:
    /// Layers, boundary and options outlive this. `has_line_law`: as of StackTruncation.
    StackSolver(const StackLayers& layers, const LowerBoundary& boundary,
                const std::vector<double>& mu, const SolverOptions& options, bool has_line_law)
        : layers_(layers),
          boundary_(boundary),
          options_(options),
          truncation_(layers, options, has_line_law),
          boundary_truncation_(choose_truncation(boundary, options)),
          directions_(stack_directions(truncation_.layers, boundary_truncation_, mu, options)),
          boundary_modes_(boundary, boundary_truncation_, directions_),
          layer_modes_(layers, truncation_.layers, directions_) {}

    /// A StackSolution or an InsideSolution that says what was solved.
    template <class Solution>
    Solution blank() const {
        Solution solution;
        solution.layers = layers_;
        solution.lower_boundary = boundary_;
        solution.truncations = truncation_.layers;
        solution.boundary_truncation = boundary_truncation_;
        if (truncation_.follows_paths)
            solution.path = std::make_shared<const StackPath>(layers_, truncation_.layers);
        return solution;
    }

    /// Calls solve(first, end) for modes `first` to before `end`, as many as the options ask for; without
    /// such, until all recorders find further modes negligible.
    template <class Solve>
    void solve_modes(const Solve& solve) {
        const FlushSubnormals flush(std::ranges::min(layer_modes_.depths()));
        const int count = std::max({1, boundary_modes_.count(), layer_modes_.count()});
        solve_groups(options_.modes ? std::min(options_.modes, count) : count, lane_count,
                     options_.modes == 0, solve, [&](int last) {
                         return std::ranges::all_of(recorders_, [&](const ModeRecorder& recorder) {
                             return recorder.is_negligible(last, options_.mode_tolerance);
                         });
                     });
    }

    const StackLayers& layers_;
    const LowerBoundary& boundary_;
    const SolverOptions& options_;
    const StackTruncation truncation_;
    const Truncation boundary_truncation_;
    const Directions directions_;
    BoundaryModes boundary_modes_;
    StackModes layer_modes_;
    std::vector<ModeRecorder> recorders_;
};

}  // namespace stratus
