#include "doubling_ladder.h"

#include "depth_regime.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>

namespace stratus {

DoublingLadder::DoublingLadder(const Directions& directions, const std::vector<double>& moments,
                               const std::vector<DoublingTask>& tasks, const DoublingSteps& steps)
    : directions_(directions), steps_(steps), tasks_(static_cast<int>(tasks.size())) {
    const long n = directions.size(), N = directions.nodes;
    const auto moment_count = static_cast<long>(moments.size());
    // Odd strides: rows a power of two apart would compete for the same few cache sets.
    const long stride = n | 1, elimination_stride = (N + n + 1) | 1;
    const long matrix = n + n * stride;
    const long total = 8 * matrix + N * elimination_stride + (2 + 3) * n + 2 * moment_count * n + 1;
    const std::size_t bytes = static_cast<std::size_t>(total) * sizeof(Pack);
    memory_.reset(static_cast<double*>(std::aligned_alloc(alignof(Pack), bytes)));
    if (!memory_) throw std::bad_alloc();
    std::memset(memory_.get(), 0, bytes);

    Pack* next = reinterpret_cast<Pack*>(memory_.get());
    auto take = [&](long count) {
        Pack* start = next;
        next += count;
        return start;
    };
    layer_.gauss = directions.nodes;
    layer_.directions = directions.size();
    layer_.stride = static_cast<int>(stride);
    layer_.mu = directions.mu.data();
    layer_.weight = directions.weight.data();
    layer_.s = directions.s.data();
    for (SimdMatrix* m :
         {&layer_.scatter_odd, &layer_.scatter_even, &layer_.Y, &layer_.Z, &layer_.reflection,
          &layer_.transmission, &layer_.spare[0], &layer_.spare[1]}) {
        m->d = take(n);
        m->K = take(n * stride);
    }
    layer_.gap_diagonal = take(n);
    layer_.absorbed = take(n);
    layer_.elimination = take(N * elimination_stride);
    layer_.elimination_stride = static_cast<int>(elimination_stride);
    for (Pack*& vector : layer_.vector) vector = take(n);

    PhaseSeries phase{
        {}, moments.data(), static_cast<int>(moment_count), take(2 * moment_count * n)};
    for (int lane = 0; lane < lane_count; ++lane) {  // idle lanes repeat the last task
        const DoublingTask& task = tasks[static_cast<std::size_t>(std::min(lane, tasks_ - 1))];
        phase.mode[lane] = task.mode;
        layer_.albedo[lane] = task.albedo;
        layer_.co_albedo[lane] = task.co_albedo;
        layer_.half_depth[lane] = task.thin_depth / 2;
        layer_.conserving[lane] = task.mode == 0 ? 1 : 0;
        layer_.any_conserving |= task.mode == 0;
        conservative_[lane] = task.mode == 0 && task.co_albedo == 0;
    }
    steps_.phase_kernels(phase, layer_);
    steps_.thin_layer(layer_);
}

void DoublingLadder::double_depth() {
    // The gap is carried from tau = 1 on; lanes differ little in depth, the largest decides.
    double deepest = 0;
    for (int lane = 0; lane < tasks_; ++lane) deepest = std::max(deepest, layer_.half_depth[lane]);
    if (!layer_.has_gap && deepest >= 0.25) steps_.use_gap(layer_);
    steps_.double_depth(layer_);
}

bool DoublingLadder::is_converged() const {
    if (!layer_.has_gap) return false;
    for (int i = 0; i < layer_.directions; ++i)
        for (int j = 0; j < layer_.directions; ++j)
            for (int lane = 0; lane < lane_count; ++lane) {
                const double limit = conservative_[lane] ? 1e-9 : 1e-17;
                if (std::abs(layer_.Y.K[i * layer_.stride + j][lane]) >
                    limit * directions_.s(i) * directions_.s(j))
                    return false;
            }
    return true;
}

void DoublingLadder::double_to_infinity() {
    const int most = max_doublings_to_infinity(2 * layer_.half_depth[0]);
    for (int k = 0; !is_converged(); ++k) {
        if (k == most)
            throw std::runtime_error("solve: infinite depth not reached after " +
                                     std::to_string(most) + " doublings");
        double_depth();
    }
}

void DoublingLadder::extract() { steps_.extract(layer_); }

Eigen::MatrixXd lane_matrix(const SimdLayer& layer, const Pack* K, int lane) {
    Eigen::MatrixXd matrix(layer.directions, layer.directions);
    for (int i = 0; i < layer.directions; ++i)
        for (int j = 0; j < layer.directions; ++j) matrix(j, i) = K[i * layer.stride + j][lane];
    return matrix;
}

ModeMatrices DoublingLadder::matrices(int lane) const {
    return {lane_matrix(layer_, layer_.reflection.K, lane),
            lane_matrix(layer_, layer_.transmission.K, lane)};
}

PhaseKernels DoublingLadder::kernels(int lane) const {
    const Eigen::VectorXd unscale =
        (2 * directions_.mu.array() / directions_.s.array() / std::sqrt(2.0)).matrix();
    const Eigen::MatrixXd even = unscale.asDiagonal() *
                                 lane_matrix(layer_, layer_.scatter_even.K, lane) *
                                 unscale.asDiagonal();
    const Eigen::MatrixXd odd = unscale.asDiagonal() *
                                lane_matrix(layer_, layer_.scatter_odd.K, lane) *
                                unscale.asDiagonal();
    return {even + odd, even - odd};
}

}  // namespace stratus
