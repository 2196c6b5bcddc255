#include "layer_sums.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "layer_blend.h"

#include <cstddef>
#include <limits>
#include <map>
#include <utility>

namespace stratus {
namespace {

/// Divides albedos and optical depths into blocks as large as some number of functions suffices for; gives up
/// beyond a number of blocks.
class BlockSearch {
  public:
    BlockSearch(const LayerSums& sums, const SampleRange& members, std::size_t functions,
                std::size_t most_blocks)
        : sums_(sums),
          members_(members),
          functions_(functions),
          most_blocks_(most_blocks),
          view_(sums.table().view()),
          tolerance_(kept_tolerance(view_)) {
        cover({0, std::max(1, view_.albedo.count - 1)}, 0);
    }

    bool gave_up() const { return found_.size() > most_blocks_; }
    FoundBlocks take() { return {members_, functions_, std::move(found_)}; }

  private:
    /// Samples that the cubics of some cells reach.
    static SampleRange reach(const SampleRange& cells, int samples) {
        if (samples <= stencil_size) return {0, samples};
        const int first = std::clamp(cells.first - 1, 0, samples - stencil_size);
        const int last =
            std::clamp(cells.first + cells.count + 1, first + stencil_size - 1, samples - 1);
        return {first, last - first + 1};
    }

    /// Blocks of some albedos from an optical depth on, each as deep as holds; where not even a
    /// shallow one does, of half the albedos each.
    void cover(const SampleRange& albedo_cells, int first_depth) {
        constexpr int narrow = 4;  // cells
        const int end = std::max(1, view_.optical_depth.count - 1);
        for (int first = first_depth; first < end && !gave_up();) {
            const SampleRange depth_cells{first, end - first};
            Candidate deepest = deepest_block(albedo_cells, depth_cells);
            if (!deepest.holds && albedo_cells.count > narrow) {
                const int half = albedo_cells.count / 2;
                cover({albedo_cells.first, half}, first);
                cover({albedo_cells.first + half, albedo_cells.count - half}, first);
                return;
            }
            first += deepest.depth_cells.count;
            found_.push_back(std::move(deepest));
        }
    }

    /// The block of most of the depth cells from their first on that holds, found by bisection; a
    /// shallow one where none does.
    Candidate deepest_block(const SampleRange& albedo_cells, const SampleRange& depth_cells) const {
        constexpr int usual = 9, shallow = 3;
        int held = std::min(shallow, depth_cells.count), fails = depth_cells.count + 1;
        Candidate deepest{};
        for (int cells = std::min(usual, depth_cells.count); fails > held;
             cells = (held + fails) / 2) {
            Candidate tried = candidate(albedo_cells, {depth_cells.first, cells});
            if (tried.holds)
                held = cells + 1;
            else
                fails = cells;
            if (tried.holds || !deepest.holds) deepest = std::move(tried);
        }
        return deepest;
    }

    Candidate candidate(const SampleRange& albedo_cells, const SampleRange& depth_cells) const {
        Candidate made{albedo_cells, depth_cells, cell_layers(albedo_cells, depth_cells),
                       {},           infinity,    false};
        const LayerBasis basis = greedy_basis(made.layers, functions_, basis_share * tolerance_);
        const double allowed = (total_share - sums_share) * tolerance_;
        // Fewer functions leave room for what rounding leaves of them.
        double least = infinity;
        for (std::size_t count = basis.pivot.size(); !made.holds; --count) {
            LayerBasis fewer = basis.first(count);
            const double half_error = error_of_halves(sums_, made.layers, fewer);
            const double error = basis.error[count] + half_error;
            if (error < least) {
                least = error;
                made.basis = std::move(fewer);
                made.half_error = half_error;
                made.holds = error <= allowed;
            }
            if (count == 0 || basis.error[count - 1] > least) break;
        }
        return made;
    }

    BlockLayers cell_layers(const SampleRange& albedo_cells, const SampleRange& depth_cells) const {
        const AxisView& depth = view_.optical_depth;
        const int albedos = view_.albedo.count;
        const bool deepest = depth_cells.first + depth_cells.count >= depth.count - 1;
        BlockLayers layers{members_,
                           reach(albedo_cells, albedos),
                           reach(depth_cells, depth.count),
                           deepest && depth.ends_at_infinity,
                           {},
                           {},
                           {}};
        for (int m = members_.first; m <= members_.last(); ++m)
            for (int a = layers.albedos.first; a <= layers.albedos.last(); ++a)
                for (int d = 0; d < layers.depth_count(); ++d) {
                    const int at = (m * albedos + a) * depth.size() + layers.depths.first + d;
                    layers.number.push_back(at);
                    layers.values.push_back(&sums_.values[size(at)]);
                    layers.importance.push_back(&sums_.importance[size(at)]);
                }
        return layers;
    }

    const LayerSums& sums_;
    SampleRange members_;
    std::size_t functions_, most_blocks_;
    TableView view_;
    double tolerance_;
    std::vector<Candidate> found_;
};

/// Blocks of the fewest functions, which are looked up the fastest, or of the most where those are many. Families
/// keep to the fewest: to search their many layers twice would take longer than all else in a bake.
FoundBlocks find_blocks(const LayerSums& sums, const SampleRange& members) {
    constexpr std::size_t many = 8, any = std::numeric_limits<std::size_t>::max();
    BlockSearch fewest(sums, members, fewest_functions, sums.table().has_family() ? any : many);
    if (!fewest.gave_up()) return fewest.take();
    return BlockSearch(sums, members, most_functions, any).take();
}

}  // namespace

std::vector<FoundBlocks> grouped_blocks(const LayerSums& sums, const SampleRange& members) {
    std::vector<FoundBlocks> groups;
    if (members.count == 1) {
        groups.push_back(find_blocks(sums, members));
        return groups;
    }
    const int half = members.count / 2;
    groups = grouped_blocks(sums, {members.first, half});
    for (FoundBlocks& group : grouped_blocks(sums, {members.first + half, members.count - half}))
        groups.push_back(std::move(group));
    if (groups.size() > 2) return groups;
    FoundBlocks joined = find_blocks(sums, members);
    if (!joined.hold() ||
        joined.function_count() >= groups[0].function_count() + groups[1].function_count())
        return groups;
    groups.clear();
    groups.push_back(std::move(joined));
    return groups;
}

std::map<int, int> pivot_layers(const std::vector<FoundBlocks>& groups) {
    std::map<int, int> pivots;
    for (const FoundBlocks& group : groups)
        for (const Candidate& block : group.blocks)
            for (const int pivot : block.basis.pivot) ++pivots[block.layers.number[size(pivot)]];
    return pivots;
}

}  // namespace stratus
