#include "climb.h"

#include "depth_regime.h"
#include "doubling_ladder.h"
#include "ordered_ladder.h"
#include "reference/classic.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

/// Doubles a layer `doublings` times and calls record(depth, is_limit) at each depth of the ladder
/// that is asked for. Once it returns true, no layer is doubled any more: is_limit.
template <class Doubling, class Record>
void climb(Doubling& layer, int doublings, const DepthLadder& ladder, Record record) {
    for (int k = 0; k < doublings; ++k) layer.double_depth();
    bool is_limit = false;
    for (int depth = 0; depth < ladder.octaves; ++depth) {
        if (depth > 0 && !is_limit) layer.double_depth();
        if (ladder.asks_for(depth)) is_limit = record(depth, is_limit);
    }
    if (!ladder.to_infinity || !ladder.asks_for(ladder.octaves)) return;
    if (!is_limit) layer.double_to_infinity();
    record(ladder.octaves, is_limit);
}

using ModeOfAlbedo = std::pair<int, std::size_t>;

/// Number: Pack, or double for a single pair.
template <class Number>
void climb_pack(const ClimbTask& task, const std::vector<ModeOfAlbedo>& pack,
                const RecordMode& record) {
    std::vector<DoublingTask> lanes;
    for (const auto& [mode, a] : pack) {
        const ClimbTask::Albedo& of = task.albedos[a];
        lanes.push_back({mode, of.albedo, of.co_albedo, of.first_depth});
    }
    DoublingLadder<Number> layers(task.directions, task.moments, lanes, task.between_requested,
                                  task.completed);
    const std::vector<PhaseKernels> kernels = layers.kernels();
    climb(layers, 0, task.ladder, [&](int depth, bool is_limit) {
        if (!is_limit) layers.extract();
        std::vector<ModeMatrices> solved = layers.matrices();
        bool are_limits = true;
        for (std::size_t lane = 0; lane < pack.size(); ++lane) {
            if (is_limit) solved[lane].transmission.setZero();
            are_limits &= record(pack[lane].first, pack[lane].second, depth,
                                 std::move(solved[lane]), kernels[lane]);
        }
        return are_limits;
    });
}

// Doubled one by one, pairs leave no lane idle where they are few, and eight times less memory, which
// the cache holds, where there are many nodes.
constexpr std::ptrdiff_t few_pairs = 4;
constexpr int many_nodes = 96;

}  // namespace

void climb_harmonic(const ClimbTask& task, std::span<const int> modes, const RecordMode& record) {
    std::vector<ModeOfAlbedo> pairs;
    for (const int mode : modes)
        for (std::size_t a = 0; a < task.albedos.size(); ++a) pairs.emplace_back(mode, a);
    for (auto pack = pairs.begin(); pack != pairs.end();) {
        const auto count = std::min<std::ptrdiff_t>(lane_count, pairs.end() - pack);
        if (count <= few_pairs || task.directions.nodes >= many_nodes) {
            climb_pack<double>(task, {pack, pack + 1}, record);
            ++pack;
            continue;
        }
        climb_pack<Pack>(task, {pack, pack + count}, record);
        pack += count;
    }
}

void climb_classic(const ClimbTask& task, const SolverOptions& options, int first, int end,
                   const RecordMode& record) {
    for (int mode = first; mode < end; ++mode) {
        const PhaseKernels kernels = reference_phase_kernels(task.directions, task.moments, mode);
        for (std::size_t a = 0; a < task.albedos.size(); ++a) {
            const ClimbTask::Albedo& of = task.albedos[a];
            const int doublings =
                count_classic_doublings(task.directions, of.first_depth, options.start_depth);
            ClassicLayer layer(task.directions, kernels, mode, of.albedo,
                               std::ldexp(of.first_depth, -doublings), options.start);
            climb(layer, doublings, task.ladder, [&](int depth, bool) {
                record(mode, a, depth, layer.matrices(), kernels);
                return false;
            });
        }
    }
}

void climb_orders(const ClimbTask& task, double fraction,
                  const std::vector<Eigen::VectorXd>& order_weights, int first, int end,
                  const RecordMode& record) {
    std::vector<int> modes;
    for (int mode = first; mode < end; ++mode) modes.push_back(mode);
    const double first_depth = task.albedos[0].first_depth;
    const int doublings = count_doublings(task.directions.mu.minCoeff(), first_depth);
    OrderedLadder layers(task.directions, task.moments, fraction, modes,
                         static_cast<int>(order_weights[0].size()) - 1,
                         std::ldexp(first_depth, -doublings));
    const std::vector<PhaseKernels> kernels = layers.kernels();
    climb(layers, doublings, task.ladder, [&](int depth, bool) {
        for (std::size_t lane = 0; lane < modes.size(); ++lane)
            for (std::size_t a = 0; a < order_weights.size(); ++a)
                record(modes[lane], a, depth,
                       layers.matrices(static_cast<int>(lane), order_weights[a]), kernels[lane]);
        return false;
    });
}

}  // namespace stratus
