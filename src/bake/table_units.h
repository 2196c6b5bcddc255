// Solutions that make up a table, then the units in which they are solved.
//
// Solutions that tables are made from: a layer at some albedos and depths, or a stack.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/table/layer_samples.h>
#include <stratus/table/table.h>
#include <stratus/transfer/fourier_sum.h>
#include <stratus/transfer/solve.h>

#include <cstddef>
#include <string>
#include <vector>

namespace stratus {

/// Solutions over [albedo][depth] (solve_ladder); of a stack, whose `layers` are top first, the one
/// that there is. `phase_function`, `albedos` and `ladder` are those of a layer, or of the stack's
/// mean layer.
std::vector<std::vector<LayerSolution>> solve_material(
    const StackLayers& layers, const PhaseFunction& phase_function,
    const std::vector<double>& albedos, const DepthLadder& ladder, const std::vector<double>& mu,
    const SolverOptions& options, const LowerBoundary& boundary, const TakeMode& take = {});

/// The phase functions in a layer, or in a stack's layers, and of a semi-infinite layer below.
std::vector<PhaseFunction> list_phase_functions(const StackLayers& layers,
                                                const PhaseFunction& phase_function,
                                                const LowerBoundary& boundary);

// The layers of a resolved recipe's table, in units that are solved at once: some albedos at the
// depths of one run of doubling.

/// Solved on one thread.
struct Unit {
    std::size_t member;
    int run;  // samples run, run + runs, run + 2 runs, ... of optical depth
    std::vector<std::size_t> albedos;
    DepthLadder ladder;  // of the run, and the last sample
};

/// A layer of a unit and its number (layer_samples.h).
struct SolvedLayer {
    int number;
    LayerSolution solution;
};

class TableUnits {
  public:
    /// `resolved` outlives this.
    ///
    /// Errors   std::invalid_argument for a choice left open.
    explicit TableUnits(const Recipe& resolved);

    /// Axes and what else is known of the table before any layer is solved.
    const Table& header() const { return header_; }
    const Recipe& recipe() const { return recipe_; }
    /// The directions of the samples of a member.
    const DirectionGrid& grid(std::size_t member) const { return grids_[member]; }

    /// All layers, each in one unit.
    std::vector<Unit> all() const;
    /// Some layers, all modes of which are to be held: one albedo at a time, unless orders are counted.
    std::vector<Unit> holding(const std::vector<int>& layers) const;

    /// In the order of their solutions: albedos one after the other, ascending depths of each.
    std::vector<int> unit_layers(const Unit& unit) const;
    /// `take`: of layers; solutions of stacks keep their modes.
    std::vector<SolvedLayer> solve(const Unit& unit, const TakeMode& take = {}) const;
    std::string unit_name(const Unit& unit) const;

    /// Seconds that one thread takes for each of all units, from a few layers that are timed.
    std::vector<double> predicted_seconds() const;

  private:
    void place_axes();
    void place_cosines();
    int runs() const;
    std::vector<Unit> make_units(const std::vector<int>& layers, std::size_t at_once) const;
    double unit_weight(const Unit& unit) const;
    double layer_seconds(const Unit& unit) const;

    const Recipe recipe_;
    Table header_;
    std::vector<Recipe> members_;       // one where the recipe has no family
    std::vector<DirectionGrid> grids_;  // of each member
    std::vector<double> mu_;            // of solutions
    CosinePairs pairs_;                 // of them, along the table's axes
};

}  // namespace stratus
