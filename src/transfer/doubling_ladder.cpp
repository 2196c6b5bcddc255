#include "doubling_ladder.h"

#include <stratus/base/size.h>

#include "options.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace stratus {

namespace {

/// Numbers to a register, of the widest kind.
template <class Number>
constexpr int in_register = lane_count / lanes_per<Number>;

/// Rows begin at a register's boundary, an odd number of registers apart: those a power of two apart
/// would compete for the same few cache sets.
template <class Number>
int padded_stride(int columns) {
    constexpr int width = in_register<Number>;
    return ((columns + width - 1) / width | 1) * width;
}

/// Numbers handed out one after another. Vectors are zeroed, and rows of doubles, whose last register
/// reaches beyond their columns; rows of Packs end with one, and are written before they are read.
template <class Number>
class Handout {
  public:
    explicit Handout(double* memory) : next_(reinterpret_cast<Number*>(memory)) {}

    Number* rows(long count, long stride) {
        Number* start = next_;
        next_ += count * stride;
        if constexpr (!is_pack<Number>) std::fill(start, next_, Number{});
        return start;
    }
    Number* vector(int size) {
        Number* start = rows(1, padded_stride<Number>(size));
        if constexpr (is_pack<Number>) std::fill(start, next_, Number{});
        return start;
    }
    SimdMatrix<Number> matrix(const SimdLayer<Number>& layer) {
        return {vector(layer.directions), rows(layer.directions, layer.stride)};
    }

  private:
    Number* next_;
};

template <class Number>
PackMemory allocated(long count) {
    return PackMemory(size(count) * sizeof(Number) / sizeof(double));
}

template <class Number>
long size_of_matrix(const SimdLayer<Number>& layer) {
    return padded_stride<Number>(layer.directions) +
           static_cast<long>(layer.directions) * layer.stride;
}

template <class Number>
void set_size(SimdLayer<Number>& layer, int gauss, int directions) {
    layer.gauss = gauss;
    layer.directions = directions;
    layer.stride = padded_stride<Number>(directions);
    constexpr int width = in_register<Number>;
    layer.right_side = (gauss + width - 1) / width * width;
    layer.elimination_stride = padded_stride<Number>(layer.right_side + directions + 1);
}

/// Where cosines count as grazing: the higher, the more doublings are spared, and the more
/// scattering mixes both groups. `strength`: the largest share of light scattered into a term of the
/// phase function's series.
double grazing_limit(double strength) { return 0.006 / std::sqrt(std::max(strength, 1e-3)); }

double scattering_strength(const std::vector<DoublingTask>& tasks,
                           const std::vector<double>& moments) {
    double strength = 0;
    for (const DoublingTask& task : tasks)
        for (auto l = size(task.mode); l < moments.size(); ++l)
            strength = std::max(strength, task.albedo * std::abs(moments[l]));
    return strength;
}

/// Doublings spared that pay for parting the directions, of so many.
constexpr int worthwhile_doublings = 4, worthwhile_directions = 12;

/// Grazing directions are those below the widest gap between cosines of about `limit`; none where
/// a depth takes so few doublings that it does not pay to part them.
DirectionGroups group_directions(const Directions& directions, double optical_depth, double limit) {
    std::vector<double> mu(directions.mu.begin(), directions.mu.end());
    std::ranges::sort(mu);
    std::size_t first_steep = 0;
    double widest = 1;
    for (std::size_t i = 1; i < mu.size(); ++i)
        if (mu[i - 1] < limit && mu[i] > 0.4 * limit && mu[i] / mu[i - 1] > widest) {
            widest = mu[i] / mu[i - 1];
            first_steep = i;
        }
    DirectionGroups groups;
    if (first_steep == 0 || directions.size() < worthwhile_directions ||
        directions.mu.head(directions.nodes).maxCoeff() < mu[first_steep] ||
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

}  // namespace

template <class Number>
void DoublingLadder<Number>::allocate(const std::vector<double>& moments,
                                      PhaseSeries<Number>& phase) {
    set_size(layer_, directions_.nodes, directions_.size());
    const int n = layer_.directions;
    const long moment_count = count_modes(moments);  // the rest is zero
    memory_ = allocated<Number>(
        8 * size_of_matrix(layer_) + static_cast<long>(layer_.gauss) * layer_.elimination_stride +
        (3 + 3) * padded_stride<Number>(n) + 2 * moment_count * layer_.stride);
    Handout<Number> memory(memory_.get());
    for (SimdMatrix<Number>* m :
         {&layer_.scatter_odd, &layer_.scatter_even, &layer_.Y, &layer_.Z, &layer_.reflection,
          &layer_.transmission, &layer_.spare[0], &layer_.spare[1]})
        *m = memory.matrix(layer_);
    layer_.elimination = memory.rows(layer_.gauss, layer_.elimination_stride);
    for (Number** vector : {&layer_.gap_diagonal, &layer_.absorbed, &layer_.uniform,
                            &layer_.vector[0], &layer_.vector[1], &layer_.vector[2]})
        *vector = memory.vector(n);
    layer_.mu = directions_.mu.data();
    layer_.weight = directions_.weight.data();
    layer_.s = directions_.s.data();
    phase.moments = moments.data();
    phase.moment_count = static_cast<int>(moment_count);
    phase.legendre = memory.rows(2 * moment_count, layer_.stride);
}

/// Memory of a group beside the layer as a whole, whose own serves its thin start.
template <class Number>
void DoublingLadder<Number>::allocate(const DirectionGroups& groups) {
    const auto prepare = [this](const DirectionGroups::Group& from, SimdLayer<Number>& layer) {
        layer = layer_;
        set_size(layer, from.gauss, int_size(from.places));
        layer.mu = from.mu.data();
        layer.weight = nullptr;
        layer.s = from.s.data();
        layer.albedo = Number{} + 1.0;  // in its scattering
    };
    SimdLayer<Number>&grazing = groups_.grazing, &steep = groups_.steep;
    prepare(groups.grazing, grazing);
    prepare(groups.steep, steep);
    grazing.conserving = Number{};
    grazing.any_conserving = false;
    steep.scatter_odd = layer_.Y;
    steep.scatter_even = layer_.Z;
    groups_.grazing_at = groups.grazing.places.data();
    groups_.steep_at = groups.steep.places.data();
    groups_.row_stride = padded_stride<Number>(steep.directions);
    groups_.column_stride = padded_stride<Number>(grazing.directions);

    const long rows = static_cast<long>(grazing.directions) * groups_.row_stride;
    const long columns = static_cast<long>(steep.directions) * groups_.column_stride;
    const long square = static_cast<long>(grazing.directions) * grazing.stride;
    memory_of_groups_ = allocated<Number>(2 * size_of_matrix(steep) + 4 * size_of_matrix(grazing) +
                                          3L * (groups_.row_stride + groups_.column_stride) +
                                          8 * columns + 5 * rows + 3 * square);
    Handout<Number> memory(memory_of_groups_.get());
    for (SimdMatrix<Number>* m : {&steep.Y, &steep.Z}) *m = memory.matrix(steep);
    for (SimdMatrix<Number>* m :
         {&grazing.Y, &grazing.Z, &grazing.scatter_odd, &grazing.scatter_even})
        *m = memory.matrix(grazing);
    for (SimdLayer<Number>* layer : {&steep, &grazing})
        for (Number** vector : {&layer->gap_diagonal, &layer->absorbed, &layer->uniform})
            *vector = memory.vector(layer->directions);
    for (Number*& of : groups_.columns) of = memory.rows(1, columns);
    for (Number*& of : groups_.rows) of = memory.rows(1, rows);
    for (Number*& of : groups_.squares) of = memory.rows(1, square);
}

template <class Number>
DoublingLadder<Number>::DoublingLadder(const Directions& directions,
                                       const std::vector<double>& moments,
                                       const std::vector<DoublingTask>& tasks,
                                       bool between_requested, bool completed)
    : directions_(directions),
      steps_(chosen_functions<DoublingSteps<Number>>()),
      tasks_(int_size(tasks)) {
    PhaseSeries<Number> phase{};
    phase.completed = completed;
    allocate(moments, phase);
    Number first_depth{};
    double deepest = 0;
    for (int lane = 0; lane < lanes_per<Number>; ++lane) {  // idle lanes repeat the last task
        const DoublingTask& task = tasks[size(std::min(lane, tasks_ - 1))];
        phase.mode[lane] = task.mode;
        set_lane(layer_.albedo, lane, task.albedo);
        set_lane(first_depth, lane, task.first_depth);
        deepest = std::max(deepest, task.first_depth);
        set_lane(layer_.conserving, lane, task.mode == 0 ? 1 : 0);
        layer_.any_conserving |= task.mode == 0;
        conservative_[lane] = task.mode == 0 && task.co_albedo == 0;
        for (int i = 0; i < layer_.directions; ++i) {
            set_lane(layer_.uniform[i], lane, directions.s(i));
            if (task.mode == 0)
                set_lane(layer_.absorbed[i], lane,
                         task.co_albedo * (directions.s(i) / directions.mu(i)));
        }
    }
    if (between_requested && !layer_.any_conserving && layer_.gauss < layer_.directions) {
        first_ = layer_.gauss;
        layer_.first_extracted = first_ / lane_count * lane_count;
    }
    steps_.phase_kernels(phase, layer_);
    directions_of_groups_ =
        group_directions(directions, deepest, grazing_limit(scattering_strength(tasks, moments)));
    if (!directions_of_groups_.grazing.places.empty()) {
        allocate(directions_of_groups_);
        if (steps_.decouple(layer_, groups_)) doubled_ = {&groups_.grazing, &groups_.steep};
    }
    if (doubled_.empty()) doubled_ = {&layer_};
    for (SimdLayer<Number>* layer : doubled_) {
        const int doublings =
            count_doublings(*std::min_element(layer->mu, layer->mu + layer->directions), deepest);
        for (int lane = 0; lane < lanes_per<Number>; ++lane)
            set_lane(layer->half_depth, lane,
                     std::ldexp(extract_lane(first_depth, lane), -doublings - 1));
        steps_.thin_layer(*layer);
        for (int k = 0; k < doublings; ++k) double_depth(*layer);
    }
}

template <class Number>
void DoublingLadder<Number>::double_depth(SimdLayer<Number>& layer) const {
    // The gap is carried from tau = 1 on; lanes differ little in depth, the largest decides.
    double deepest = 0;
    for (int lane = 0; lane < tasks_; ++lane)
        deepest = std::max(deepest, extract_lane(layer.half_depth, lane));
    if (!layer.has_gap && deepest >= 0.25) steps_.use_gap(layer);
    steps_.double_depth(layer);
}

template <class Number>
void DoublingLadder<Number>::double_depth() {
    for (SimdLayer<Number>* layer : doubled_) double_depth(*layer);
}

template <class Number>
bool DoublingLadder<Number>::is_converged() const {
    for (const SimdLayer<Number>* layer : doubled_) {
        if (!layer->has_gap) return false;
        for (int i = 0; i < layer->directions; ++i)
            for (int j = 0; j < layer->directions; ++j)
                for (int lane = 0; lane < lanes_per<Number>; ++lane) {
                    const double limit = conservative_[lane] ? 1e-9 : 1e-17;
                    if (std::abs(extract_lane(layer->Y.K[i * layer->stride + j], lane)) >
                        limit * layer->s[i] * layer->s[j])
                        return false;
                }
    }
    return true;
}

template <class Number>
void DoublingLadder<Number>::extract() {
    if (doubled_.size() > 1) steps_.couple(groups_, layer_);
    steps_.extract(layer_);
}

namespace {

/// Two matrices for each lane, of the pairs of elements values(i, j, lane) for i and j from `first` to
/// before `end`: rows in turn, so that the cache holds one for all its lanes.
template <class Values>
std::vector<ModeMatrices> lane_matrices(int first, int end, int lanes, Values values) {
    std::vector<ModeMatrices> all(size(lanes));
    for (auto& [one, other] : all) {
        one.resize(end - first, end - first);
        other.resize(end - first, end - first);
    }
    for (int i = first; i < end; ++i)
        for (int lane = 0; lane < lanes; ++lane) {
            auto& [one, other] = all[size(lane)];
            for (int j = first; j < end; ++j)
                std::tie(one(j - first, i - first), other(j - first, i - first)) =
                    values(i, j, lane);
        }
    return all;
}

}  // namespace

template <class Number>
std::vector<ModeMatrices> DoublingLadder<Number>::matrices() const {
    return lane_matrices(first_, layer_.directions, tasks_, [this](int i, int j, int lane) {
        const long at = i * layer_.stride + j;
        // The doublings leave rounding where nothing is scattered.
        if (extract_lane(layer_.albedo, lane) == 0) return std::pair(0.0, 0.0);
        return std::pair(extract_lane(layer_.reflection.K[at], lane),
                         extract_lane(layer_.transmission.K[at], lane));
    });
}

template <class Number>
std::vector<PhaseKernels> DoublingLadder<Number>::kernels() const {
    const Eigen::VectorXd unscale =
        (2 * directions_.mu.array() / directions_.s.array() / std::sqrt(2.0)).matrix();
    return lane_matrices(first_, layer_.directions, tasks_, [&](int i, int j, int lane) {
        const long at = i * layer_.stride + j;
        const double even = unscale(j) * extract_lane(layer_.scatter_even.K[at], lane) * unscale(i);
        const double odd = unscale(j) * extract_lane(layer_.scatter_odd.K[at], lane) * unscale(i);
        return std::pair(even - odd, even + odd);
    });
}

template class DoublingLadder<Pack>;
template class DoublingLadder<double>;

}  // namespace stratus
