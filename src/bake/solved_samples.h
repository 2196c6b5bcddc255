// Samples of a table's layers, solved when packing asks for them (layer_samples.h): the table of all
// samples is never formed.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/table/layer_samples.h>

#include "table_units.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace stratus {

/// Ranks    all make their own of the same recipe, and ask for the same.
/// Pieces   of the log: the units of every request.
class SolvedSamples : public LayerSamples {
  public:
    /// `table` becomes that of the recipe without samples: one stands for those of each side. Its
    /// fluxes come with the samples of all layers.
    SolvedSamples(const Recipe& resolved, const BakeOptions& options, Table& table);

    bool is_first_rank() const override;
    int in_full(std::vector<int> layers, const Use& use) override;
    void at(const PerSide<DirectionList>& directions, const Use& use) override;
    void trim_memory() override;

  private:
    /// Whether a layer of the units that are solved is asked for.
    using Choice = std::function<bool(int layer)>;
    /// The positions of a member's samples, where not all of a side's are asked for.
    using SomePositions = PerSide<std::unique_ptr<const GridPositions>>;

    void make_room();
    void solve(const std::string& stage, const std::vector<Unit>& units, const Choice& is_asked_for,
               const PerSide<DirectionList>& directions, const Use& use);
    std::vector<char> solve_unit(const Unit& unit, const Choice& is_asked_for,
                                 const PerSide<std::vector<std::size_t>>& positions,
                                 const SomePositions& some) const;
    void take(const Unit& unit, const Choice& is_asked_for,
              const PerSide<DirectionList>& directions, std::span<const char> result,
              const Use& use);
    /// Calls visit(numbers) for the fluxes of a layer.
    template <class Visit>
    void for_each_flux(int layer, const Visit& visit);
    std::vector<float> flux_values(const LayerSolution& solution) const;

    const TableUnits units_;
    const BakeOptions& options_;
    Table& table_;
    const DirectionNumbers numbers_;
    const PerSide<bool> sides_;
    int requests_ = 0;
};

/// Hands freed memory back to the system, which the C library (glibc) would keep: a step of a bake then
/// needs no more than its own. A little is kept: it is sooner used again than given back.
void trim_memory();

}  // namespace stratus
