#include "doubling_ladder.h"

#include "depth_regime.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>

namespace stratus {

namespace {

/// Packs handed out one after another, zeroed.
class Packs {
  public:
    explicit Packs(double* memory) : next_(reinterpret_cast<Pack*>(memory)) {}

    Pack* take(long count) {
        Pack* start = next_;
        next_ += count;
        return start;
    }
    SimdMatrix matrix(const SimdLayer& layer) {
        return {take(layer.directions), take(static_cast<long>(layer.directions) * layer.stride)};
    }

  private:
    Pack* next_;
};

double* zeroed(long packs) {
    const std::size_t bytes = static_cast<std::size_t>(packs) * sizeof(Pack);
    void* memory = std::aligned_alloc(alignof(Pack), bytes);
    if (!memory) throw std::bad_alloc();
    return static_cast<double*>(std::memset(memory, 0, bytes));
}

long size_of_matrix(const SimdLayer& layer) { return layer.directions * (1L + layer.stride); }

/// Odd strides: rows a power of two apart would compete for the same few cache sets.
int odd(int stride) { return stride | 1; }

void set_size(SimdLayer& layer, int gauss, int directions) {
    layer.gauss = gauss;
    layer.directions = directions;
    layer.stride = odd(directions);
    layer.elimination_stride = odd(gauss + directions + 1);
}

/// Where cosines count as grazing: the higher, the more doublings are spared, and the more
/// scattering mixes both groups. `strength`: the largest share of light scattered into a term of the
/// phase function's series.
double grazing_limit(double strength) { return 0.006 / std::sqrt(std::max(strength, 1e-3)); }

double strength_of(const std::vector<DoublingTask>& tasks, const std::vector<double>& moments) {
    double strength = 0;
    for (const DoublingTask& task : tasks)
        for (auto l = static_cast<std::size_t>(task.mode); l < moments.size(); ++l)
            strength = std::max(strength, task.albedo * std::abs(moments[l]));
    return strength;
}

/// Doublings spared that pay for parting the directions.
constexpr int worthwhile_doublings = 4;

}  // namespace

DirectionGroups group_directions(const Directions& directions, double optical_depth, double limit) {
    std::vector<double> mu(directions.mu.begin(), directions.mu.end());
    std::sort(mu.begin(), mu.end());
    std::size_t first_steep = 0;
    double widest = 1;
    for (std::size_t i = 1; i < mu.size(); ++i)
        if (mu[i - 1] < limit && mu[i] > 0.4 * limit && mu[i] / mu[i - 1] > widest) {
            widest = mu[i] / mu[i - 1];
            first_steep = i;
        }
    DirectionGroups groups;
    if (first_steep == 0 || directions.mu.head(directions.nodes).maxCoeff() < mu[first_steep] ||
        count_doublings(mu[0], optical_depth) - count_doublings(mu[first_steep], optical_depth) <
            worthwhile_doublings)
        return groups;
    for (int i = 0; i < directions.size(); ++i) {
        auto& group = directions.mu(i) < mu[first_steep] ? groups.grazing : groups.steep;
        group.places.push_back(i);
        group.mu.push_back(directions.mu(i));
        group.s.push_back(directions.s(i));
        group.gauss += i < directions.nodes;
    }
    return groups;
}

void DoublingLadder::allocate(const std::vector<double>& moments, PhaseSeries& phase) {
    set_size(layer_, directions_.nodes, directions_.size());
    const long n = layer_.directions;
    const auto moment_count = static_cast<long>(moments.size());
    const long elimination = static_cast<long>(layer_.gauss) * layer_.elimination_stride;
    memory_.reset(
        zeroed(8 * size_of_matrix(layer_) + elimination + (3 + 3) * n + 2 * moment_count * n));
    Packs packs(memory_.get());
    for (SimdMatrix* m :
         {&layer_.scatter_odd, &layer_.scatter_even, &layer_.Y, &layer_.Z, &layer_.reflection,
          &layer_.transmission, &layer_.spare[0], &layer_.spare[1]})
        *m = packs.matrix(layer_);
    layer_.elimination = packs.take(elimination);
    for (Pack** vector : {&layer_.gap_diagonal, &layer_.absorbed, &layer_.uniform,
                          &layer_.vector[0], &layer_.vector[1], &layer_.vector[2]})
        *vector = packs.take(n);
    layer_.mu = directions_.mu.data();
    layer_.weight = directions_.weight.data();
    layer_.s = directions_.s.data();
    phase.moments = moments.data();
    phase.moment_count = static_cast<int>(moment_count);
    phase.legendre = packs.take(2 * moment_count * n);
}

/// What a group needs beside the layer as a whole, whose memory serves its thin start.
void DoublingLadder::allocate(const DirectionGroups& groups) {
    const auto prepare = [this](const DirectionGroups::Group& from, SimdLayer& layer) {
        layer = layer_;
        set_size(layer, from.gauss, static_cast<int>(from.places.size()));
        layer.mu = from.mu.data();
        layer.weight = nullptr;
        layer.s = from.s.data();
        layer.albedo = Pack{} + 1.0;  // in its scattering
    };
    SimdLayer &grazing = groups_.grazing, &steep = groups_.steep;
    prepare(groups.grazing, grazing);
    prepare(groups.steep, steep);
    grazing.conserving = Pack{};
    grazing.any_conserving = false;
    steep.scatter_odd = layer_.Y;
    steep.scatter_even = layer_.Z;
    groups_.grazing_at = groups.grazing.places.data();
    groups_.steep_at = groups.steep.places.data();
    groups_.row_stride = odd(steep.directions);
    groups_.column_stride = odd(grazing.directions);

    const long rows = static_cast<long>(grazing.directions) * groups_.row_stride;
    const long columns = static_cast<long>(steep.directions) * groups_.column_stride;
    const long square = static_cast<long>(grazing.directions) * grazing.stride;
    memory_of_groups_.reset(zeroed(2 * size_of_matrix(steep) + 4 * size_of_matrix(grazing) +
                                   3L * (steep.directions + grazing.directions) + 8 * columns +
                                   5 * rows + 3 * square));
    Packs packs(memory_of_groups_.get());
    for (SimdMatrix* m : {&steep.Y, &steep.Z}) *m = packs.matrix(steep);
    for (SimdMatrix* m : {&grazing.Y, &grazing.Z, &grazing.scatter_odd, &grazing.scatter_even})
        *m = packs.matrix(grazing);
    for (SimdLayer* layer : {&steep, &grazing})
        for (Pack** vector : {&layer->gap_diagonal, &layer->absorbed, &layer->uniform})
            *vector = packs.take(layer->directions);
    for (Pack** of : {&groups_.U_columns, &groups_.V_columns}) *of = packs.take(columns);
    for (Pack*& of : groups_.columns) of = packs.take(columns);
    for (Pack** of : {&groups_.U, &groups_.V}) *of = packs.take(rows);
    for (Pack*& of : groups_.rows) of = packs.take(rows);
    for (Pack*& of : groups_.squares) of = packs.take(square);
}

DoublingLadder::DoublingLadder(const Directions& directions, const std::vector<double>& moments,
                               const std::vector<DoublingTask>& tasks, const DoublingSteps& steps)
    : directions_(directions), steps_(steps), tasks_(static_cast<int>(tasks.size())) {
    PhaseSeries phase{};
    allocate(moments, phase);
    Pack first_depth{};
    double deepest = 0;
    for (int lane = 0; lane < lane_count; ++lane) {  // idle lanes repeat the last task
        const DoublingTask& task = tasks[static_cast<std::size_t>(std::min(lane, tasks_ - 1))];
        phase.mode[lane] = task.mode;
        layer_.albedo[lane] = task.albedo;
        first_depth[lane] = task.first_depth;
        deepest = std::max(deepest, task.first_depth);
        layer_.conserving[lane] = task.mode == 0 ? 1 : 0;
        layer_.any_conserving |= task.mode == 0;
        conservative_[lane] = task.mode == 0 && task.co_albedo == 0;
        for (int i = 0; i < layer_.directions; ++i) {
            layer_.uniform[i][lane] = directions.s(i);
            layer_.absorbed[i][lane] =
                task.mode == 0 ? task.co_albedo * (directions.s(i) / directions.mu(i)) : 0;
        }
    }
    steps_.phase_kernels(phase, layer_);
    directions_of_groups_ =
        group_directions(directions, deepest, grazing_limit(strength_of(tasks, moments)));
    if (!directions_of_groups_.grazing.places.empty()) {
        allocate(directions_of_groups_);
        if (steps_.decouple(layer_, groups_)) doubled_ = {&groups_.grazing, &groups_.steep};
    }
    if (doubled_.empty()) doubled_ = {&layer_};
    for (SimdLayer* layer : doubled_) {
        const int doublings =
            count_doublings(*std::min_element(layer->mu, layer->mu + layer->directions), deepest);
        for (int lane = 0; lane < lane_count; ++lane)
            layer->half_depth[lane] = std::ldexp(first_depth[lane], -doublings - 1);
        steps_.thin_layer(*layer);
        for (int k = 0; k < doublings; ++k) double_depth(*layer);
    }
}

void DoublingLadder::double_depth(SimdLayer& layer) const {
    // The gap is carried from tau = 1 on; lanes differ little in depth, the largest decides.
    double deepest = 0;
    for (int lane = 0; lane < tasks_; ++lane) deepest = std::max(deepest, layer.half_depth[lane]);
    if (!layer.has_gap && deepest >= 0.25) steps_.use_gap(layer);
    steps_.double_depth(layer);
}

void DoublingLadder::double_depth() {
    for (SimdLayer* layer : doubled_) double_depth(*layer);
}

bool DoublingLadder::is_converged() const {
    for (const SimdLayer* layer : doubled_) {
        if (!layer->has_gap) return false;
        for (int i = 0; i < layer->directions; ++i)
            for (int j = 0; j < layer->directions; ++j)
                for (int lane = 0; lane < lane_count; ++lane) {
                    const double limit = conservative_[lane] ? 1e-9 : 1e-17;
                    if (std::abs(layer->Y.K[i * layer->stride + j][lane]) >
                        limit * layer->s[i] * layer->s[j])
                        return false;
                }
    }
    return true;
}

void DoublingLadder::double_to_infinity() {
    const int most = max_doublings_to_infinity(2 * doubled_[0]->half_depth[0]);
    for (int k = 0; !is_converged(); ++k) {
        if (k == most)
            throw std::runtime_error("solve: infinite depth not reached after " +
                                     std::to_string(most) + " doublings");
        double_depth();
    }
}

void DoublingLadder::extract() {
    if (doubled_.size() > 1) steps_.couple(groups_, layer_);
    steps_.extract(layer_);
}

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
