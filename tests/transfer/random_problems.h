// Layers, stacks and geometries drawn at random, the same on every machine: for the estimates of
// errors, whose references were computed once (bench/tolerance_bench.cpp).
#pragma once

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/phase/phase_function.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace stratus::test {

/// Kinds of phase function; several: a stack of any.
inline const std::vector<std::string> random_kinds{"smooth",   "peaked",   "narrow",
                                                   "backward", "droplets", "several"};

struct RandomProblem {
    std::string kind;
    std::vector<StackLayer> layers;
    LowerBoundary boundary;
    std::vector<Geometry> geometries;
};

class RandomDraw {
  public:
    explicit RandomDraw(std::uint64_t seed) : engine_(seed) {}

    double between(double low, double high) {
        return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11), -53);
    }
    /// Evenly in the logarithm.
    double magnitude(double low, double high) {
        return std::exp(between(std::log(low), std::log(high)));
    }
    bool one_in(int count) { return between(0, count) < 1; }

  private:
    std::mt19937_64 engine_;
};

inline PhaseFunction random_phase_function(RandomDraw& draw, const std::string& kind) {
    if (kind == "peaked") return PhaseFunction::henyey_greenstein(draw.between(0.8, 0.97));
    if (kind == "narrow") return PhaseFunction::henyey_greenstein(1 - draw.magnitude(1e-3, 0.03));
    if (kind == "backward") return PhaseFunction::henyey_greenstein(draw.magnitude(0.02, 0.2) - 1);
    if (kind == "droplets")
        return parse_phase_function("mie:radius=" + shortest_text(draw.magnitude(0.1, 30)) +
                                    "um,variance=0.1,wavelength=0.55um");
    if (draw.one_in(4)) return PhaseFunction::rayleigh();
    const double g = draw.between(-0.8, 0.8);
    if (draw.one_in(2)) return PhaseFunction::henyey_greenstein(g);
    return PhaseFunction::sum({{0.6, PhaseFunction::henyey_greenstein(g)},
                               {0.4, PhaseFunction::henyey_greenstein(draw.between(-0.8, 0.8))}});
}

/// `most`: below 1, all cosines lie between 0.02 and it.
inline RandomProblem random_problem(std::uint64_t seed, double most = 1) {
    RandomDraw draw(seed);
    RandomProblem problem;
    problem.kind = random_kinds[seed % random_kinds.size()];
    const bool is_stack = problem.kind == "several";
    const int layers = is_stack ? 2 + draw.one_in(2) : 1;
    for (int k = 0; k < layers; ++k) {
        const std::string kind =
            is_stack ? random_kinds[static_cast<std::size_t>(draw.between(0, 5))] : problem.kind;
        const PhaseFunction phase_function = random_phase_function(draw, kind);
        const double albedo = draw.one_in(3) ? 1 : 1 - draw.magnitude(1e-4, 0.7);
        problem.layers.push_back({phase_function, albedo, draw.magnitude(0.03, 30)});
    }
    if (draw.one_in(4)) problem.boundary = LowerBoundary::surface(draw.between(0, 1));
    const double least = draw.one_in(3) || most < 1 ? 0.02 : 0.15;
    for (int i = 0; i < 4; ++i) {
        const double in = draw.between(least, most), out = draw.between(least, most);
        problem.geometries.push_back({in, out, draw.one_in(4) ? 0 : draw.between(0, pi)});
    }
    return problem;
}

}  // namespace stratus::test
