#include "climb.h"

#include <stratus/base/gauss_legendre.h>
#include <stratus/transfer/solve.h>

#include "doubling_ladder.h"
#include "ordered_ladder.h"
#include "reference/classic.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<int> modes_between(int first, int end) {
    std::vector<int> modes(size(end - first));
    std::iota(modes.begin(), modes.end(), first);
    return modes;
}

namespace {

/// Doubles a layer, of `depth` at least, until nothing changes any more. These doublings suffice: those up to
/// depth 1, 56 more until the change is below rounding, and a reserve for g near 1.
template <class Doubling>
void double_to_infinity(Doubling& layer, double depth) {
    const int most = 120 + std::max(0, -std::ilogb(depth));
    for (int k = 0; !layer.is_converged(); ++k) {
        if (k == most)
            throw std::runtime_error("solve: infinite depth not reached after " +
                                     std::to_string(most) + " doublings");
        layer.double_depth();
    }
}

void double_to_infinity(ClassicLayer& layer, double) { layer.double_to_infinity(); }

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
    if (!is_limit) double_to_infinity(layer, ladder.first);
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

void climb_classic(const ClimbTask& task, const SolverOptions& options, std::span<const int> modes,
                   const RecordMode& record) {
    for (const int mode : modes) {
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
                  const std::vector<VectorXd>& order_weights, std::span<const int> modes,
                  const RecordMode& record) {
    const double first_depth = task.albedos[0].first_depth;
    const int doublings = count_doublings(task.directions.mu.minCoeff(), first_depth);
    OrderedLadder layers(task.directions, task.moments, fraction, modes,
                         int_size(order_weights[0]) - 1, std::ldexp(first_depth, -doublings));
    const std::vector<PhaseKernels> kernels = layers.kernels();
    climb(layers, doublings, task.ladder, [&](int depth, bool) {
        for (std::size_t lane = 0; lane < modes.size(); ++lane)
            for (std::size_t a = 0; a < order_weights.size(); ++a)
                record(modes[lane], a, depth,
                       layers.matrices(static_cast<int>(lane), order_weights[a]), kernels[lane]);
        return false;
    });
}

constexpr std::size_t fitted_points = 8;  // of the polynomials that fill gaps

std::vector<int> thinned_modes(int count, double tolerance) {
    constexpr int dense = 48;  // modes below are all solved
    // From pair to pair, of the mode; what polynomials miss falls as its power of their points.
    const double step = 0.07 * std::pow(tolerance / 1e-2, 1.0 / fitted_points);
    std::vector<int> modes = modes_between(0, std::min(count, dense));
    for (int pair = dense; pair < count;) {
        for (const int mode : {pair, pair + 1})
            if (mode < count && mode > modes.back()) modes.push_back(mode);
        if (modes.back() == count - 1) break;
        const int next = pair + 2 * std::max(1, static_cast<int>(std::lround(step / 2 * pair)));
        pair = std::min(next, count - 2);
    }
    return modes;
}

void fill_modes(std::span<const int> solved, std::vector<AzimuthalMode>& modes) {
    std::vector<double> of_parity[2];
    std::vector<const MatrixXd*> values[2];
    for (std::size_t k = 0; k < modes.size(); ++k) {
        of_parity[solved[k] % 2].push_back(solved[k]);
        values[solved[k] % 2].push_back(&modes[k].values);
    }
    std::vector<AzimuthalMode> all;
    for (int mode = 0; mode <= solved[modes.size() - 1]; ++mode) {
        const std::vector<double>& x = of_parity[mode % 2];
        const auto next = size(std::ranges::lower_bound(x, mode) - x.begin());
        if (next < x.size() && x[next] == mode) {
            all.push_back({*values[mode % 2][next]});
            continue;
        }
        const std::size_t count = std::min(fitted_points, x.size());
        const std::size_t first =
            std::min(next > count / 2 ? next - count / 2 : 0, x.size() - count);
        const std::span points = std::span(x).subspan(first, count);
        const std::vector<double> weights = lagrange_weights({points.begin(), points.end()}, mode);
        MatrixXd sum = MatrixXd::Zero(modes[0].values.rows(), modes[0].values.cols());
        for (std::size_t k = 0; k < count; ++k) sum += weights[k] * *values[mode % 2][first + k];
        all.push_back({std::move(sum)});
    }
    modes = std::move(all);
}

namespace {

constexpr double point_weight = 1e-10;  // of requested directions, where nodes sum to 1

/// Gauss nodes that mode m and higher ones reach.
int nodes_reached(const Directions& directions, int mode) {
    const double least = std::log(1e-3);
    int count = 0;
    while (count < directions.nodes &&
           mode * 0.5 * std::log1p(-directions.mu(count) * directions.mu(count)) >= least)
        ++count;
    return count;
}

/// The first `kept` nodes, then all requested directions twice, as nodes.
Directions nodes_and_points(const Directions& from, int kept) {
    const int points = from.size() - from.nodes, size = kept + 2 * points;
    Directions to{size, VectorXd(size), VectorXd(size), VectorXd(size)};
    const VectorXd mu = from.mu.tail(points);
    to.mu << from.mu.head(kept), mu, mu;
    to.weight << from.weight.head(kept), VectorXd::Constant(2 * points, point_weight);
    to.s = (2 * to.mu.array() * to.weight.array()).sqrt();
    return to;
}

/// A matrix over nodes_and_points as one over all `directions`; `unscale`: s of a requested direction
/// there over that here.
MatrixXd over_all(const Directions& directions, int kept, const MatrixXd& from, double unscale) {
    const int N = directions.nodes, points = directions.size() - N;
    MatrixXd to = MatrixXd::Zero(directions.size(), directions.size());
    to.topLeftCorner(kept, kept) = from.topLeftCorner(kept, kept);
    to.block(0, N, kept, points) = unscale * from.block(0, kept, kept, points);
    to.block(N, 0, points, kept) = to.block(0, N, kept, points).transpose();
    to.bottomRightCorner(points, points) =
        unscale * unscale * from.block(kept, kept + points, points, points);
    return to;
}

}  // namespace

void climb_grazing(const ClimbTask& task, std::span<const int> modes, const RecordMode& record) {
    const int kept = nodes_reached(task.directions, modes.front());
    const Directions nodes = nodes_and_points(task.directions, kept);
    const ClimbTask completed{nodes, task.moments, task.ladder, task.albedos, false, true};
    const auto all = [&](const MatrixXd& matrix, double unscale) {
        return over_all(task.directions, kept, matrix, unscale);
    };
    const double unscale = 1 / std::sqrt(point_weight);
    climb_harmonic(completed, modes,
                   [&](int mode, std::size_t albedo, int depth, ModeMatrices layer,
                       const PhaseKernels& kernels) {
                       return record(
                           mode, albedo, depth,
                           {all(layer.reflection, unscale), all(layer.transmission, unscale)},
                           {all(kernels.reflection, 1), all(kernels.transmission, 1)});
                   });
}

}  // namespace stratus
