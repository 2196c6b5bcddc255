// Stacks against an analog Monte Carlo, which neither doubles nor adds.
#include <stratus/runtime/constants.h>
#include <stratus/transfer/stack.h>

#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace stratus {
namespace {

struct Fate {
    double reflected = 0, transmitted = 0, absorbed_below = 0;  // shares of the photons
};

/// Analog Monte Carlo of isotropic and Rayleigh layers over a Lambert surface.
Fate trace(const std::vector<StackLayer>& layers, double surface, double mu_in, int photons) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> uniform(0, 1);
    double bottom = 0;
    for (const StackLayer& layer : layers) bottom += layer.optical_depth;
    auto layer_at = [&](double depth) {
        std::size_t k = 0;
        while (k + 1 < layers.size() && depth > layers[k].optical_depth)
            depth -= layers[k++].optical_depth;
        return k;
    };
    Fate fate;
    const double share = 1.0 / photons;
    for (int n = 0; n < photons; ++n) {
        double depth = 0, mu = mu_in;  // mu > 0: downward
        while (true) {
            depth -= mu * std::log(1 - uniform(random));
            if (depth < 0) {
                fate.reflected += share;
                break;
            }
            if (depth > bottom) {
                if (surface < 0) {
                    fate.transmitted += share;
                    break;
                }
                if (uniform(random) >= surface) {
                    fate.absorbed_below += share;
                    break;
                }
                depth = bottom;
                mu = -std::sqrt(1 - uniform(random));
                continue;
            }
            const StackLayer& layer = layers[layer_at(depth)];
            if (uniform(random) >= layer.albedo) break;
            double cosine = 2 * uniform(random) - 1;
            while (2 * uniform(random) > layer.phase_function(cosine))
                cosine = 2 * uniform(random) - 1;
            const double azimuth = 2 * pi * uniform(random);
            mu = mu * cosine + std::sqrt((1 - mu * mu) * (1 - cosine * cosine)) * std::cos(azimuth);
        }
    }
    return fate;
}

TEST(Stack, MatchesPhotonFluxes) {
    const std::vector<StackLayer> layers{{rayleigh, 0.95, 0.4}, {isotropic, 0.7, 1.1}};
    const int photons = 200000;
    const double error = 4 * std::sqrt(0.25 / photons);  // four standard errors
    for (const double mu_in : {0.3, 1.0}) {
        const StackSolution free = solve_stack(layers, nothing, {mu_in});
        const Fate fate = trace(layers, -1, mu_in, photons);
        EXPECT_NEAR(free.plane_albedo(0), fate.reflected, error);
        EXPECT_NEAR(free.diffuse_transmittance(0) + direct_transmittance(1.5, mu_in),
                    fate.transmitted, error);
        const StackSolution over = solve_stack(layers, LowerBoundary::surface(0.6), {mu_in});
        const Fate grounded = trace(layers, 0.6, mu_in, photons);
        EXPECT_NEAR(over.plane_albedo(0), grounded.reflected, error);
        EXPECT_NEAR(over.ground_absorptance(0), grounded.absorbed_below, error);
    }
}

}  // namespace
}  // namespace stratus
