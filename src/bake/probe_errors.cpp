#include <stratus/bake/axes.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/layer/diffusion.h>

#include "choices.h"
#include "piece_of_work.h"

namespace stratus {

namespace {

/// The numbers of all shares, by share.
std::vector<std::vector<double>> gather(const Probes& probes, const std::vector<double>& numbers) {
    return gather(probes.options.log, numbers, probes.share.count);
}

}  // namespace

Errors errors_of_layers(const Probes& probes, std::size_t albedos, std::size_t depths,
                        const MeasureLayer& measure) {
    std::vector<Errors> of_layer(albedos * depths);
    parallel_for(int_size(of_layer), probes.options.threads, [&](int n) {
        stop_if_asked(probes.options.log);
        const auto at = size(n);
        measure(at / depths, at % depths, of_layer[at]);
    });
    return joined(std::move(of_layer));
}

Errors joined(std::vector<Errors> lists) {
    std::size_t count = 0;
    for (const Errors& errors : lists) count += errors.size();
    Errors all;
    all.reserve(count);
    for (Errors& errors : lists) {
        all.insert(all.end(), errors.begin(), errors.end());
        errors = {};
    }
    return all;
}

std::vector<double> quantiles_of_all(const Probes& probes, std::vector<Errors> lists,
                                     double share) {
    std::vector<double> weights;
    for (const Errors& errors : lists) {
        double sum = 0;
        for (const ProbedError& each : errors) sum += double{each.weight};
        weights.push_back(sum);
    }
    std::vector<double> exceeding(lists.size(), 0.0);  // the weight that may exceed each quantile
    for (const std::vector<double>& of_share : gather(probes, weights))
        for (std::size_t n = 0; n < lists.size(); ++n)
            exceeding[n] += (1 - share) * (1 + 1e-9) * of_share[n];
    // Leaves the largest errors, descending, up to the first that the weights of the others reach.
    const auto keep_largest = [](Errors& errors, double weight) {
        std::size_t kept = 0, sorted = 0;
        for (; kept < errors.size() && weight >= 0; weight -= double{errors[kept++].weight}) {
            if (kept < sorted) continue;
            sorted = std::min(errors.size(), 4 * sorted + 64);
            std::ranges::partial_sort(errors.data() + kept, errors.data() + sorted,
                                      errors.data() + errors.size(), std::ranges::greater{},
                                      &ProbedError::error);
        }
        errors.resize(kept);
    };
    std::vector<double> largest;  // of each list how many, then errors and weights
    for (std::size_t n = 0; n < lists.size(); ++n) {
        keep_largest(lists[n], exceeding[n]);
        largest.push_back(static_cast<double>(lists[n].size()));
        for (const auto& [error, weight] : lists[n]) {
            largest.push_back(double{error});
            largest.push_back(double{weight});
        }
    }
    lists.assign(lists.size(), {});
    for (const std::vector<double>& of_share : gather(probes, largest)) {
        const double* next = of_share.data();
        for (Errors& all : lists)
            for (auto left = static_cast<std::size_t>(*next++); left > 0; --left, next += 2)
                all.push_back({static_cast<float>(next[0]), static_cast<float>(next[1])});
    }
    std::vector<double> quantiles;
    for (std::size_t n = 0; n < lists.size(); ++n) {
        double quantile = 0;
        for (const double times : {1.0, largest_over_tolerance}) {
            keep_largest(lists[n], exceeding[n] / times);
            if (!lists[n].empty())
                quantile = std::max(quantile, double{lists[n].back().error} / times);
        }
        quantiles.push_back(quantile);
    }
    return quantiles;
}

double quantile_of_all(const Probes& probes, Errors errors, double share) {
    std::vector<Errors> alone;
    alone.push_back(std::move(errors));
    return quantiles_of_all(probes, std::move(alone), share)[0];
}

double measure_layers(const Probes& probes, std::size_t albedos, std::size_t depths,
                      const MeasureLayer& measure) {
    return quantile_of_all(probes, errors_of_layers(probes, albedos, depths, measure),
                           probed_share);
}

namespace {

/// The lengths of the parts of [low, high] that are nearest to each place, 0 for places outside; 1 where
/// there is no way between the ends.
std::vector<double> nearest_lengths(const std::vector<double>& places, double low, double high) {
    const auto is_inside = [&](double place) { return place >= low && place <= high; };
    std::vector<double> sorted;
    std::ranges::copy_if(places, std::back_inserter(sorted), is_inside);
    std::ranges::sort(sorted);
    std::vector<double> lengths;
    for (const double place : places) {
        if (!is_inside(place)) {
            lengths.push_back(0);
            continue;
        }
        const auto here = std::ranges::lower_bound(sorted, place);
        const double first = here == sorted.begin() ? low : (*std::prev(here) + place) / 2;
        const double last = std::next(here) == sorted.end() ? high : (place + *std::next(here)) / 2;
        lengths.push_back(low < high ? last - first : 1);
    }
    return lengths;
}

}  // namespace

DirectionWeights::DirectionWeights(const Recipe& recipe, const DirectionGrid& directions)
    : directions_(directions) {
    if (directions.path_law() == nullptr) return;
    const auto weights = [&](Range range, const std::vector<int>& of_cosines) {
        std::vector<double> roots;
        for (const int at : of_cosines) roots.push_back(std::sqrt(directions.mu()[size(at)]));
        return nearest_lengths(roots, std::sqrt(std::max(range.min, least_judged_cosine)),
                               std::sqrt(range.max));
    };
    in_ = weights(recipe.mu_in, directions.pairs().in);
    out_ = weights(recipe.mu_out, directions.pairs().out);
    const bool all_around = !is_narrow(recipe.azimuth, all_azimuths);
    azimuth_ = nearest_lengths(directions.azimuth(), all_around ? 0 : radians(recipe.azimuth.min),
                               all_around ? pi : radians(recipe.azimuth.max));
    if (!is_peaked(recipe.phase_function)) return;
    for (const Side side : both_sides) {
        double all = 0, forward = 0;
        for_each_direction(directions, [&](int i, int j, int k) {
            all += even(i, j, k);
            if (is_forward(side, i, j, k)) forward += even(i, j, k);
        });
        constexpr double share = 0.1;
        if (forward > 0)
            forward_[side] = std::max(1.0, share / (1 - share) * (all - forward) / forward);
    }
}

double DirectionWeights::even(int i, int j, int k) const {
    if (in_.empty()) return 1;
    const double ways = directions_.pairs().are_symmetric() && i < j ? 2 : 1;
    return ways * in_[size(i)] * out_[size(j)] * azimuth_[size(k)];
}

bool DirectionWeights::is_forward(Side side, int i, int j, int k) const {
    static const double least = std::cos(radians(forward_cone));
    return directions_.cos_scattering_angle(side)[directions_.at(i, j, k)] > least;
}

double DirectionWeights::operator()(Side side, int i, int j, int k) const {
    return even(i, j, k) * (is_forward(side, i, j, k) ? forward_[side] : 1);
}

void add_blend_errors(const Recipe& recipe, const ProbedLayer& expected,
                      const DirectionGrid& directions, const Blend& blend, Errors& errors,
                      const std::vector<double>* along) {
    const CosinePairs& pairs = directions.pairs();
    add_errors(recipe, expected, directions, errors, [&](Side side, int i, int j, int k) {
        const std::size_t at = directions.at(i, j, k);
        const auto in = size(pairs.in[size(i)]), out = size(pairs.out[size(j)]);
        double found = 0;
        for (std::size_t p = 0; p < Blend::size; ++p) {
            const double weight = blend.weight[side][p];
            if (weight == 0) continue;
            const double share = along ? weight * along[p][in] * along[p][out] : weight;
            found += share * blend.sample[p]->side[side].tabulated[at];
        }
        return found;
    });
}

double intercepted(const Recipe& recipe, double optical_depth, double mu) {
    return recipe.lower_boundary.is_present() ? 1 : intercepted_share(optical_depth, mu);
}

double sample_scale(const Probes& probes, Side side, double optical_depth, double exponent) {
    if (probes.recipe.lower_boundary.is_present()) return 1;
    return diffusion_scale(side, optical_depth, exponent, probes.extrapolation_length);
}

}  // namespace stratus
