#include "layer_sums.h"

#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "layer_blend.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

// Below it errors count less; a stack may be all dark, but the square of 1 / floor must stay a float.
constexpr float faintest = 1e-8f, faintest_of_stacks = 1e-18f;

/// Errors are relative to no less than a share of the largest value at cosines of this and more.
constexpr double floor_cosine = 0.1;

/// True where a layer of the table, or the one below it, has a narrow peak: errors are then not relative to
/// what is scattered straight on, as those of verify (error_floor of bake/accuracy.h).
bool has_narrow_peaks(const Table& table, const PhaseFunction& phase_function) {
    const LowerBoundary& below = table.lower_boundary;
    bool found = below.is_layer() && has_narrow_peak(below.phase_function);
    for (const StackLayer& layer : table.layers) found |= has_narrow_peak(layer.phase_function);
    return found || (!table.is_stack() && has_narrow_peak(phase_function));
}

}  // namespace

LayerShapes::LayerShapes(const Table& table, Side side, std::size_t member)
    : table_(table), numbers_(table.view()), side_(side) {
    const TableView view = table.view();
    const PhaseFunction phase_function = phase_function_of_member(table, member);
    is_peaked_ = has_narrow_peaks(table, phase_function);
    if (table.path_law != nullptr)
        path_law_ = table.has_family() ? PathOrders::of_any(phase_function) : table.path_law;
    for (int i = 0; i < numbers_.ins(); ++i)
        for (int j = 0; j < numbers_.partners(i); ++j) {
            pairs_.push_back({i, j});
            for (int k = 0; k < numbers_.azimuths(); ++k) {
                const Geometry at{view.mu_in.value(i), view.mu_out.value(j), view.azimuth.value(k)};
                cosine_.push_back(cos_scattering_angle(side, at));
                phase_.push_back(phase_function(cosine_.back()));
            }
        }
}

float LayerShapes::weight(std::size_t layer) const {
    return (side_ == Side::reflection ? table_.reflection_weight
                                      : table_.transmission_weight)[layer];
}

float LayerShapes::weight(std::size_t layer, const Pair& pair) const {
    const std::size_t ins = table_.mu_in.values.size(), outs = table_.mu_out.values.size(),
                      depth = layer % table_.optical_depth.values.size();
    return weight(layer) * table_.mu_in_weight[depth * ins + size(pair.in)] *
           table_.mu_out_weight[depth * outs + size(pair.out)];
}

template <class Use>
void LayerShapes::for_each(const DirectionList& at, const Use& use) const {
    const std::size_t azimuths = size(numbers_.azimuths());
    for (std::size_t n = 0; n < at.size(); ++n) use(n, pairs_[at[n] / azimuths]);
}

void LayerShapes::divide(std::size_t layer, const DirectionList& at,
                         std::vector<float>& samples) const {
    for_each(at, [&](std::size_t n, const Pair& pair) { samples[n] *= weight(layer, pair); });
}

/// Returns the weights of the first orders of the path law, which lookups add to the samples. Errors
/// count a little more without the others.
PathWeights LayerShapes::weights_along_path(double w, double tau, double mu, double other) const {
    constexpr int most_orders = 48;
    const int orders = std::min(path_law_->order_count(), most_orders),
              highest = table_.highest_order;
    PathWeights weights =
        path_weights(side_, highest > 0 ? std::min(orders, highest + 1) : orders, tau, mu, other);
    double power = 1;
    for (int n = 0; n < weights.count; ++n, power *= w) weights.of_order[n] *= power;
    return weights;
}

/// Less than 90 degrees of azimuth, where a narrow peak alone would be more than all the rest.
bool LayerShapes::is_forward(std::size_t direction) const {
    const std::size_t azimuths = size(numbers_.azimuths());
    return azimuths > 1 && table_.azimuth.values[direction % azimuths] < pi / 2;
}

double LayerShapes::lesser_cosine(std::size_t direction) const {
    const Pair& pair = pairs_[direction / size(numbers_.azimuths())];
    return std::min(table_.mu_in.values[size(pair.in)], table_.mu_out.values[size(pair.out)]);
}

/// Returns how much errors count beside a path law, which misses at grazing angles, where no more functions
/// make up for it.
float LayerShapes::share_of_grazing(std::size_t direction) const {
    constexpr double steep = 0.15, least = 0.03;
    return static_cast<float>(std::clamp(lesser_cosine(direction) / steep, least, 1.0));
}

std::vector<float> LayerShapes::importance(std::size_t layer, const DirectionList& at,
                                           const std::vector<float>& shape) const {
    std::vector<float> found(at.size(), 0.0f), totals(at.size());
    const std::vector<double>&albedos = table_.albedo.values, &depths = table_.optical_depth.values;
    const double w = albedos[layer / depths.size() % albedos.size()],
                 tau = depths[layer % depths.size()];
    if (!is_resolved(layer) || is_scattered_once(table_.view(), w, tau)) return found;
    const LowerBoundary& below = table_.lower_boundary;
    float largest = 0;
    const Pair* before = nullptr;
    float factor = 1;  // what the samples of a pair were divided by
    double mu = 0, other = 0, order = 0;
    PathWeights along_path;
    bool has_weights = false;  // of the pair
    for_each(at, [&](std::size_t n, const Pair& pair) {
        if (&pair != before) {
            before = &pair;
            mu = table_.mu_in.values[size(pair.in)];
            other = table_.mu_out.values[size(pair.out)];
            factor = 1 / weight(layer, pair);
            order = single_scattering(side_, 1, w, tau, mu, other);
            has_weights = false;
        }
        const Geometry here{mu, other, table_.azimuth.values[at[n] % size(numbers_.azimuths())]};
        double single = order * phase_[at[n]];
        if (table_.is_stack()) single = stack_single_scattering(side_, table_.layers, here);
        if (below.has_closed_form()) single += single_reflection_of_boundary(below, tau, here);
        if (path_law_ && shape[n] < 0) {  // the path law is larger than what the samples take back
            if (!has_weights) along_path = weights_along_path(w, tau, mu, other);
            has_weights = true;
            single += (*path_law_)(along_path, 1 - cosine_[at[n]], 1 + cosine_[at[n]]);
        }
        found[n] = path_law_ ? factor * share_of_grazing(at[n]) : factor;
        totals[n] = factor * shape[n] + static_cast<float>(single);
        if (is_peaked_ && is_forward(at[n])) return;
        if (lesser_cosine(at[n]) >= floor_cosine) largest = std::max(largest, totals[n]);
    });
    const float floor = std::max(static_cast<float>(darkest_share) * largest,
                                 table_.is_stack() ? faintest_of_stacks : faintest);
    for (std::size_t n = 0; n < at.size(); ++n) found[n] /= std::max(totals[n], floor);
    return found;
}

}  // namespace stratus
