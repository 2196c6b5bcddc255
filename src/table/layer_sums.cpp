#include "layer_sums.h"

#include <stratus/base/size.h>

#include "kernels/vectors.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <numeric>
#include <random>
#include <set>
#include <utility>

namespace stratus {

const VectorKernels& vector_kernels() noexcept { return chosen_functions<VectorKernels>(); }
namespace {

constexpr std::size_t first_directions = 300;  // of a sketch, random
constexpr int worst_directions = 8;            // that each function adds to it
constexpr int apart = 25;                      // of the worst, one in so many: not neighbours
constexpr int most_rounds = 5;                 // of looking for layers that the functions miss
constexpr std::size_t most_missed = 64;        // layers seen in full in one round
constexpr std::size_t few_missed = 10;  // functions to each that is still missed after a round

constexpr int pilot_albedos = 7, pilot_depths = 14, pilot_members = 5;

// Layers are too unlike each other for sums of a few functions where the pilots alone take more functions than
// this share of their number, or than `most_of_pilots` (layers that these miss bring up to two thirds as many
// again), where all take `most_spanning`, or where the sketch has fewer directions to each.
constexpr double largest_share_of_pilots = 0.54;
constexpr std::size_t most_of_pilots = 95, most_spanning = 150, fewest_directions = 5;
constexpr int thinned_azimuths = 8;  // steps, of the sketch that then stands for all directions
constexpr std::size_t most_thinned = 1000;  // of its directions: 30 to each function of a block

/// Up to `most` of `count` places, evenly, the last among them.
std::vector<int> spread(int count, int most) {
    std::set<int> places;
    const int used = std::min(count, most);
    for (int n = 0; n < used; ++n)
        places.insert(used == 1 ? count - 1 : (n * (count - 1) + (used - 1) / 2) / (used - 1));
    return {places.begin(), places.end()};
}

void subtract_sum(const Vectors& function, const std::vector<float>& coefficient,
                  std::vector<float>& values) {
    for (std::size_t k = 0; k < function.size(); ++k) subtract(coefficient[k], function[k], values);
}

std::vector<float> weighted_sum(const Vectors& function, const std::vector<float>& coefficient) {
    std::vector<float> sum(function[0].size(), 0.0f);
    for (std::size_t k = 0; k < function.size(); ++k) subtract(-coefficient[k], function[k], sum);
    return sum;
}

std::vector<float> picked(const std::vector<float>& values, const DirectionList& at) {
    std::vector<float> some;
    some.reserve(at.size());
    for (const std::size_t n : at) some.push_back(values[n]);
    return some;
}

double norm(const std::vector<double>& values) {
    return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0));
}

/// Back substitution of all columns of Q^T W.
Vectors inverted(std::vector<std::vector<double>>& q, const std::vector<std::vector<double>>& r,
                 const std::vector<float>& weight) {
    for (std::size_t k = q.size(); k-- > 0;) {
        for (std::size_t later = k + 1; later < q.size(); ++later)
            for (std::size_t s = 0; s < weight.size(); ++s) q[k][s] -= r[later][k] * q[later][s];
        for (double& value : q[k]) value /= r[k][k];
    }
    Vectors rows;
    for (const std::vector<double>& row : q) {
        rows.emplace_back();
        for (std::size_t s = 0; s < weight.size(); ++s)
            rows.back().push_back(static_cast<float>(row[s] * double{weight[s]}));
    }
    return rows;
}

/// Weighted least squares at the directions of a sketch: returns the rows of P, whose products with values v are
/// the coefficients of functions. P = R^-1 Q^T W of W F = Q R: F the functions at these directions, W the
/// weights of these, Q by Gram-Schmidt, twice for the sake of rounding.
Vectors least_squares(const Vectors& function, const std::vector<float>& weight) {
    std::vector<std::vector<double>> q, r;
    for (const std::vector<float>& column : function) {
        std::vector<double> left(weight.size()), shares(q.size(), 0.0);
        for (std::size_t s = 0; s < left.size(); ++s)
            left[s] = double{weight[s]} * double{column[s]};
        const double before = norm(left);
        for (int twice = 0; twice < 2; ++twice)
            for (std::size_t k = 0; k < q.size(); ++k) {
                const double share =
                    std::inner_product(left.begin(), left.end(), q[k].begin(), 0.0);
                shares[k] += share;
                for (std::size_t s = 0; s < left.size(); ++s) left[s] -= share * q[k][s];
            }
        const double after = norm(left);
        const bool depends = after <= 1e-9 * before;  // on those before: it gets no share
        for (double& value : left) value = depends ? 0 : value / after;
        shares.push_back(depends ? 1 : after);
        q.push_back(std::move(left));
        r.push_back(std::move(shares));
    }
    return inverted(q, r, weight);
}

/// The search on one side.
class SideSearch {
  public:
    SideSearch(const Table& table, Side side, double allowed)
        : allowed_(static_cast<float>(allowed)) {
        for (std::size_t m = 0; m < table.member_count(); ++m)
            sums_.shapes.emplace_back(table, side, m);
        everywhere_ = sums_.numbers().all();
        sums_.values.resize(table.layer_count());
        sums_.importance.resize(table.layer_count());
    }

    const DirectionList& sketch() const { return sums_.sketch; }

    /// A layer's samples at all directions.
    void see_in_full(std::size_t layer, std::vector<float> samples) {
        const LayerShapes& shapes = sums_.shapes_of(layer);
        shapes.divide(layer, everywhere_, samples);
        std::vector<float> of_layer = shapes.importance(layer, everywhere_, samples);
        const std::lock_guard<std::mutex> lock(mutex_);
        full_[layer] = {std::move(samples), std::move(of_layer), 0};
    }

    /// Makes room for all layers at the sketch at once, not between what is freed as they are solved.
    void expect_sketch() {
        for (Vectors* const all : {&sums_.values, &sums_.importance})
            for (std::vector<float>& of_layer : *all) of_layer.resize(sums_.sketch.size());
    }

    /// A layer's samples at the sketch.
    void see_in_sketch(std::size_t layer, std::vector<float> samples) {
        const LayerShapes& shapes = sums_.shapes_of(layer);
        shapes.divide(layer, sums_.sketch, samples);
        const std::vector<float> of_layer = shapes.importance(layer, sums_.sketch, samples);
        std::copy(of_layer.begin(), of_layer.end(), sums_.importance[layer].begin());
        std::copy(samples.begin(), samples.end(), sums_.values[layer].begin());
    }

    /// Functions for all layers that were seen in full, and a sketch that shows them unless it is to
    /// stay as it is.
    void search(bool grows) {
        if (settled_) full_.clear();
        if (full_.empty()) return;
        note_importance();
        if (sums_.sketch.empty()) begin_sketch();
        for (Seen* worst = fitted(); worst != nullptr; worst = fitted())
            while (worst != nullptr) worst = subtracted(add_function(*worst, grows));
        const double most = std::min(largest_share_of_pilots * static_cast<double>(full_.size()),
                                     static_cast<double>(most_of_pilots));
        if (grows) are_unlike_ = static_cast<double>(sums_.function.size()) > most;
        full_.clear();
        if (grows) std::sort(sums_.sketch.begin(), sums_.sketch.end());
    }

    /// Does without functions of all layers where there are too many, or layers that they miss: the
    /// sketch is then spread evenly over all directions.
    ///
    /// Returns whether it does from now on: all layers are then to be sketched again.
    bool settle() {
        const std::size_t functions = sums_.function.size();
        if (settled_ || (!are_unlike_ && !misses_ && functions < most_spanning &&
                         functions * fewest_directions <= sums_.sketch.size()))
            return false;
        settled_ = true;
        sums_.function.clear();
        sums_.sketch.clear();
        const std::size_t azimuths = size(sums_.numbers().azimuths());
        const std::size_t step = std::max<std::size_t>(1, (azimuths - 1) / thinned_azimuths);
        const std::size_t thinned = everywhere_.size() / azimuths * ((azimuths - 1) / step + 1);
        const std::size_t apart = (thinned + most_thinned - 1) / most_thinned;
        for (const std::size_t n : everywhere_) {  // neighbouring pairs at other azimuths
            const std::size_t pair = n / azimuths, azimuth = n % azimuths;
            if (azimuth % step == 0 && (pair + azimuth / step) % apart == 0)
                sums_.sketch.push_back(n);
        }
        return true;
    }

    /// The layers, at most so many, whose functions all others need, by what the sketch shows; none
    /// where it is no use to look for them any more.
    std::vector<int> missed(int round) {
        std::vector<int> missed;
        misses_ = false;
        if (!sums_.is_spanned() || sums_.function.size() >= most_spanning) return missed;
        fit();
        Vectors left = sums_.values;
        std::vector<float> error(left.size(), 0.0f);
        for (std::size_t layer = 0; layer < left.size(); ++layer) {
            subtract_sum(at_sketch_, coefficients(left[layer]), left[layer]);
            error[layer] = largest_product(left[layer], sums_.importance[layer]);
        }
        while (missed.size() < most_missed) {
            const auto worst = std::max_element(error.begin(), error.end());
            if (*worst <= allowed_) break;
            const auto pivot = size(worst - error.begin());
            missed.push_back(static_cast<int>(pivot));
            remove_direction(left[pivot], left, error);
        }
        misses_ = !missed.empty();
        const bool are_few = missed.size() * few_missed <= sums_.function.size();
        if (round > 0 && (!are_few || round == most_rounds)) missed.clear();
        return missed;
    }

    LayerSums take() {
        Vectors& values = sums_.values;
        for (std::size_t layer = 0; layer < values.size(); ++layer) {
            const std::size_t serves = served_by(layer);
            if (serves != layer) values[layer] = values[serves];
        }
        if (!sums_.is_spanned()) return std::move(sums_);
        fit();
        for (std::vector<float>& of_layer : values) {
            sums_.coefficient.push_back(coefficients(of_layer));
            of_layer = weighted_sum(at_sketch_, sums_.coefficient.back());
        }
        return std::move(sums_);
    }

  private:
    /// A layer that was seen in full, at all directions.
    struct Seen {
        std::vector<float> left;  // by the functions
        std::vector<float> importance;
        float error;
    };

    /// Itself, or in place of a layer that is too near the end of float's range a neighbour.
    std::size_t served_by(std::size_t layer) const {
        const std::size_t albedos = sums_.table().albedo.values.size(),
                          depths = sums_.table().optical_depth.values.size();
        for (std::size_t same_depth = layer;; same_depth += depths) {
            if (sums_.shapes_of(layer).is_resolved(same_depth)) return same_depth;
            if ((same_depth / depths + 1) % albedos == 0) break;
        }
        return layer % depths > 0 ? served_by(layer - 1) : layer;
    }

    void note_importance() {
        greatest_.resize(everywhere_.size(), 0.0f);
        for (const auto& [layer, seen] : full_)
            for (std::size_t n = 0; n < greatest_.size(); ++n)
                greatest_[n] = std::max(greatest_[n], seen.importance[n]);
    }

    /// Directions all over, and those that tell how large a layer's values are.
    void begin_sketch() {
        std::set<std::size_t> directions;
        const DirectionNumbers& numbers = sums_.numbers();
        const std::size_t azimuths = size(numbers.azimuths());
        for (const int i : spread(numbers.ins(), 6))
            for (const int j : spread(numbers.partners(i), 6))
                for (const int k : spread(numbers.azimuths(), 3))
                    directions.insert(numbers.pair(i, j) * azimuths + size(k));
        std::mt19937 random(1);
        const std::size_t wanted =
            std::min(everywhere_.size(), directions.size() + first_directions);
        while (directions.size() < wanted) directions.insert(random() % everywhere_.size());
        sums_.sketch.assign(directions.begin(), directions.end());
    }

    /// Least squares at the sketch as it is.
    void fit() {
        at_sketch_.clear();
        for (const std::vector<float>& function : sums_.function)
            at_sketch_.push_back(picked(function, sums_.sketch));
        fit_ = least_squares(at_sketch_, picked(greatest_, sums_.sketch));
    }

    /// Coefficients of values at the sketch, by the fit.
    std::vector<float> coefficients(const std::vector<float>& values) const {
        std::vector<float> found;
        for (const std::vector<float>& row : fit_) found.push_back(dot(row, values));
        return found;
    }

    /// The layer of those seen in full that misses most; null where none does, or no more functions
    /// are to be found.
    Seen* worst() {
        const auto most = std::max_element(
            full_.begin(), full_.end(),
            [](const auto& a, const auto& b) { return a.second.error < b.second.error; });
        const bool misses = most->second.error > allowed_;
        return misses && sums_.function.size() < most_spanning ? &most->second : nullptr;
    }

    /// Leaves of each layer what least squares at the sketch do; returns the worst.
    Seen* fitted() {
        fit();
        for (auto& [layer, seen] : full_) {
            subtract_sum(sums_.function, coefficients(picked(seen.left, sums_.sketch)), seen.left);
            seen.error = largest_product(seen.left, seen.importance);
        }
        return worst();
    }

    /// Makes a function of what is left of a layer; the sketch grows by the directions where most is.
    const std::vector<float>& add_function(const Seen& seen, bool grows) {
        std::vector<float> left = seen.left;
        const float largest = largest_product(left, greatest_);
        for (float& value : left) value /= largest;
        if (grows) add_directions(left);
        sums_.function.push_back(std::move(left));
        return sums_.function.back();
    }

    /// Takes a function out of each layer, by least squares at all directions; returns the worst.
    Seen* subtracted(const std::vector<float>& function) {
        std::vector<float> weighted = function;
        for (std::size_t n = 0; n < weighted.size(); ++n)
            weighted[n] *= greatest_[n] * greatest_[n];
        const float square = dot(weighted, function);
        for (auto& [layer, seen] : full_) {
            subtract(dot(weighted, seen.left) / square, function, seen.left);
            seen.error = largest_product(seen.left, seen.importance);
        }
        return worst();
    }

    void add_directions(const std::vector<float>& left) {
        DirectionList order = everywhere_;
        const std::size_t looked_at = std::min(order.size(), size(worst_directions * apart));
        const auto is_worse = [&](std::size_t a, std::size_t b) {
            const float of_a = std::abs(left[a] * greatest_[a]),
                        of_b = std::abs(left[b] * greatest_[b]);
            return of_a != of_b ? of_a > of_b : a < b;
        };
        std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(looked_at),
                          order.end(), is_worse);
        for (std::size_t n = 0; n < looked_at; n += size(apart))
            if (std::find(sums_.sketch.begin(), sums_.sketch.end(), order[n]) == sums_.sketch.end())
                sums_.sketch.push_back(order[n]);
    }

    /// Takes what is left of one layer at the sketch out of what is left of all.
    void remove_direction(std::vector<float> pivot, Vectors& left,
                          std::vector<float>& error) const {
        std::vector<float> weighted = pivot;
        for (std::size_t s = 0; s < weighted.size(); ++s) {
            const float weight = greatest_[sums_.sketch[s]];
            weighted[s] *= weight * weight;
        }
        const float square = dot(weighted, pivot);
        for (std::size_t layer = 0; layer < left.size(); ++layer) {
            if (square > 0) subtract(dot(weighted, left[layer]) / square, pivot, left[layer]);
            error[layer] = largest_product(left[layer], sums_.importance[layer]);
        }
    }

    float allowed_;
    LayerSums sums_;
    DirectionList everywhere_;
    std::mutex mutex_;
    std::map<std::size_t, Seen> full_;
    bool are_unlike_ = false, misses_ = false, settled_ = false;
    std::vector<float> greatest_;  // importance of each direction to any pilot
    Vectors at_sketch_;            // functions
    Vectors fit_;
};

/// Depths all over the table, octaves apart: a baker solves them at once.
std::vector<int> pilot_depth_samples(const AxisView& depth) {
    const int octave = std::max(1, static_cast<int>(std::lround(depth.inverse_step)));
    std::vector<int> samples;
    for (int d = (depth.count - 1) % octave; d >= 0 && d < depth.count; d += octave)
        samples.push_back(d);
    if (depth.ends_at_infinity) samples.push_back(depth.count);
    std::vector<int> some;
    for (const int n : spread(int_size(samples), pilot_depths)) some.push_back(samples[size(n)]);
    return some;
}

/// Layers all over the table.
std::vector<int> pilot_layers(const Table& table) {
    const auto count = [](const Axis& axis) { return int_size(axis.values); };
    const std::vector<int> depths = pilot_depth_samples(table.optical_depth.view());
    std::vector<int> layers;
    for (const int member : spread(static_cast<int>(table.member_count()), pilot_members))
        for (const int albedo : spread(count(table.albedo), pilot_albedos))
            for (const int depth : depths)
                layers.push_back(
                    (member * count(table.albedo) + albedo) * count(table.optical_depth) + depth);
    return layers;
}

}  // namespace

std::vector<float> LayerSums::in_full(int layer) const {
    return is_spanned() ? weighted_sum(function, coefficient[size(layer)]) : full.at(layer);
}

PerSide<LayerSums> find_layer_sums(const Table& table, const PerSide<bool>& sides, double allowed,
                                   LayerSamples& samples) {
    PerSide<SideSearch> search{{table, Side::reflection, allowed},
                               {table, Side::transmission, allowed}};
    const auto see_in_full = [&](int layer, Side side, std::vector<float> values) {
        search[side].see_in_full(size(layer), std::move(values));
    };
    const auto for_each_side = [&](const auto& use) {
        for (const Side side : both_sides)
            if (sides[side]) use(side, search[side]);
    };
    const auto search_both = [&](bool grows) {
        for_each_side([&](Side, SideSearch& of_side) { of_side.search(grows); });
    };
    samples.in_full(pilot_layers(table), see_in_full);
    search_both(true);
    for_each_side([](Side, SideSearch& of_side) {
        of_side.settle();
        of_side.expect_sketch();
    });
    const auto see_in_sketch = [&](int layer, Side side, std::vector<float> values) {
        if (!values.empty()) search[side].see_in_sketch(size(layer), std::move(values));
    };
    samples.at({search.reflection.sketch(), search.transmission.sketch()}, see_in_sketch);
    for (int round = 0;; ++round) {
        std::set<int> missed;
        for_each_side([&](Side, SideSearch& of_side) {
            for (const int layer : of_side.missed(round)) missed.insert(layer);
        });
        if (samples.in_full({missed.begin(), missed.end()}, see_in_full) == 0) break;
        search_both(false);
    }
    PerSide<DirectionList> again;
    for_each_side([&](Side side, SideSearch& of_side) {
        if (!of_side.settle()) return;
        of_side.expect_sketch();
        again[side] = of_side.sketch();
    });
    samples.at(again, see_in_sketch);
    PerSide<LayerSums> sums;
    for_each_side([&](Side side, SideSearch& of_side) { sums[side] = of_side.take(); });
    return sums;
}

void see_in_full(const PerSide<std::map<int, int>>& pivots, PerSide<LayerSums>& sums,
                 LayerSamples& samples) {
    std::set<int> asked_for;
    for (const Side side : both_sides) {
        if (pivots[side].empty() || sums[side].is_spanned()) continue;
        for (const auto& [layer, blocks] : pivots[side]) {
            sums[side].full[layer];
            asked_for.insert(layer);
        }
    }
    samples.in_full({asked_for.begin(), asked_for.end()},
                    [&](int layer, Side side, std::vector<float> values) {
                        auto& full = sums[side].full;
                        const auto place = full.find(layer);
                        if (place != full.end()) place->second = std::move(values);
                    });
    for (LayerSums* const side : {&sums.reflection, &sums.transmission}) {
        if (side->full.empty()) continue;
        const DirectionList everywhere = side->numbers().all();
        for (auto& [layer, values] : side->full)
            side->shapes_of(size(layer)).divide(size(layer), everywhere, values);
    }
}

}  // namespace stratus
