#include <stratus/bake/parallel.h>
#include <stratus/layer/diffusion.h>

#include "choices.h"
#include "piece_of_work.h"

namespace stratus {

namespace {

/// The numbers of all shares, by share.
std::vector<std::vector<double>> gather(const Probes& probes, const std::vector<double>& numbers) {
    return gather(probes.options.log, numbers, probes.shares);
}

}  // namespace

Errors errors_of_layers(
    const Probes& probes, std::size_t albedos, std::size_t depths,
    const std::function<void(std::size_t albedo, std::size_t depth, Errors& errors)>& measure) {
    std::vector<Errors> of_layer(albedos * depths);
    parallel_for(static_cast<int>(of_layer.size()), probes.options.threads, [&](int n) {
        stop_if_asked(probes.options.log);
        const auto at = static_cast<std::size_t>(n);
        measure(at / depths, at % depths, of_layer[at]);
    });
    return joined(of_layer);
}

Errors joined(const std::vector<Errors>& lists) {
    Errors all;
    for (const Errors& errors : lists) all.insert(all.end(), errors.begin(), errors.end());
    return all;
}

std::vector<double> quantiles_of_all(const Probes& probes, std::vector<Errors> lists,
                                     double share) {
    std::vector<double> counts;
    for (const Errors& errors : lists) counts.push_back(static_cast<double>(errors.size()));
    const std::vector<std::vector<double>> counts_of_share = gather(probes, counts);
    std::vector<std::size_t> places;  // of the quantiles, among all errors in descending order
    std::vector<double> largest;
    for (std::size_t n = 0; n < lists.size(); ++n) {
        std::size_t count = 0;
        for (const auto& of_one : counts_of_share) count += static_cast<std::size_t>(of_one[n]);
        places.push_back(count > 0 ? count - 1 - quantile_place(count, share) : 0);
        Errors& errors = lists[n];
        if (places[n] + 1 < errors.size()) {
            const auto end = errors.begin() + static_cast<std::ptrdiff_t>(places[n] + 1);
            std::ranges::nth_element(errors, end, std::greater{});
            errors.erase(end, errors.end());
        }
        largest.insert(largest.end(), errors.begin(), errors.end());
    }
    const std::vector<std::vector<double>> largest_of_share = gather(probes, largest);
    std::vector<const double*> next;
    for (const auto& of_one : largest_of_share) next.push_back(of_one.data());
    std::vector<double> quantiles;
    for (std::size_t n = 0; n < lists.size(); ++n) {
        Errors all;
        for (std::size_t s = 0; s < next.size(); ++s) {
            const auto told =
                std::min(places[n] + 1, static_cast<std::size_t>(counts_of_share[s][n]));
            all.insert(all.end(), next[s], next[s] + told);
            next[s] += told;
        }
        if (!all.empty())
            std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(places[n]),
                                     std::greater{});
        quantiles.push_back(all.empty() ? 0 : all[places[n]]);
    }
    return quantiles;
}

double quantile_of_all(const Probes& probes, Errors errors, double share) {
    std::vector<Errors> alone;
    alone.push_back(std::move(errors));
    return quantiles_of_all(probes, std::move(alone), share)[0];
}

double measure_layers(
    const Probes& probes, std::size_t albedos, std::size_t depths,
    const std::function<void(std::size_t albedo, std::size_t depth, Errors& errors)>& measure) {
    return quantile_of_all(probes, errors_of_layers(probes, albedos, depths, measure),
                           probed_share);
}

void add_blend_errors(const Recipe& recipe, const ProbedLayer& expected,
                      const DirectionGrid& directions, const Blend& blend, Errors& errors,
                      const std::vector<double>* along) {
    const CosinePairs& pairs = directions.pairs();
    add_errors(recipe, expected, directions, errors, [&](Side side, int i, int j, int k) {
        const std::size_t at = directions.at(i, j, k);
        const auto in = static_cast<std::size_t>(pairs.in[static_cast<std::size_t>(i)]),
                   out = static_cast<std::size_t>(pairs.out[static_cast<std::size_t>(j)]);
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
    return side == Side::reflection
               ? reflection_scale(optical_depth, exponent, probes.extrapolation_length)
               : transmission_scale(optical_depth, exponent, probes.extrapolation_length);
}

}  // namespace stratus
