// What the tests of all formats share: materials, random geometries with the solver's own values,
// and how far a file is from them.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/material/material.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "temporary_folder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

namespace stratus::test {

inline Stack layer(const std::string& phase, double albedo, double optical_depth) {
    return {{{parse_phase_function(phase), albedo, optical_depth}}, {}};
}

inline Stack over(Stack stack, double ground) {
    stack.lower_boundary = LowerBoundary::surface(ground);
    return stack;
}

/// The file of a material, as bytes.
inline std::string written(const Material& material, MaterialFormat format,
                           std::string* json = nullptr) {
    const TemporaryFolder folder;
    const MaterialFile file = make_material(material, format);
    write_material(file, folder / "material.out");
    if (json) *json = content(folder / "material.json");
    return content(folder / "material.out");
}

/// A geometry and what the solver says of it.
struct Expected {
    Geometry geometry;
    double reflection, transmission, reflection_below;
};

/// Random cosines in [least, 1], evenly drawn, and azimuths in [0, pi]. Each pair of cosines is
/// solved as `stratus solve` does it, twenty to a solution.
inline std::vector<Expected> random_geometries(const Stack& stack, int count, double least,
                                               unsigned seed = 1) {
    std::mt19937 random(seed);
    const auto draw = [&](double from, double to) {
        return from + (to - from) * (static_cast<double>(random()) + 0.5) / 4294967296.0;
    };
    SolverOptions options;
    options.nodes = 40;
    std::vector<Expected> all;
    while (static_cast<int>(all.size()) < count) {
        std::vector<double> mu;
        for (int k = 0; k < 40; ++k) mu.push_back(draw(least, 1));
        const bool one = stack.layers.size() == 1;
        const StackLayer& first = stack.layers.front();
        const auto keep = [&](const auto& solution, const auto& below) {
            for (int k = 0; k < 40 && static_cast<int>(all.size()) < count; k += 2) {
                const double azimuth = draw(0, pi);
                all.push_back({{mu[static_cast<std::size_t>(k)],
                                mu[static_cast<std::size_t>(k + 1)], azimuth},
                               solution.reflection(k, k + 1, azimuth).total,
                               solution.transmission(k, k + 1, azimuth).total,
                               below.reflection(k, k + 1, azimuth).total});
            }
        };
        if (one) {
            const LayerSolution solution =
                solve_layer(first.phase_function, first.albedo, first.optical_depth, mu, options,
                            stack.lower_boundary);
            keep(solution, solution);
        } else {
            const StackSolution solution =
                solve_stack(stack.layers, stack.lower_boundary, mu, options);
            const std::vector<StackLayer> upside_down(stack.layers.rbegin(), stack.layers.rend());
            keep(solution,
                 solution.is_opaque() ? solution : solve_stack(upside_down, {}, mu, options));
        }
    }
    return all;
}

/// The share of light that R, of mu_out and azimuth, sends out; as many cosines near the horizon.
template <class Reflection>
double sent_out(const Reflection& R) {
    constexpr int cosines = 300, azimuths = 100;
    double sum = 0;
    for (int i = 0; i < cosines; ++i)
        for (int a = 0; a < azimuths; ++a) {
            const double x = (i + 0.5) / cosines, mu = x * x;
            sum += R(mu, (a + 0.5) * pi / azimuths) * mu * 2 * x;
        }
    return 2 * sum / (cosines * azimuths);
}

/// Relative errors, sorted.
class Errors {
  public:
    void add(double found, double expected) { all_.push_back(std::abs(found / expected - 1)); }

    double quantile(double share) {
        std::ranges::sort(all_);
        return all_.empty()
                   ? NAN
                   : all_[static_cast<std::size_t>(share * static_cast<double>(all_.size() - 1))];
    }

  private:
    std::vector<double> all_;
};

}  // namespace stratus::test
