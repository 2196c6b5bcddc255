// Rings whose two components mix, against the solver.
#include <stratus/scene/layer_light.h>
#include <stratus/transfer/solve.h>

#include "small_scene.h"

#include <gtest/gtest.h>

namespace stratus {
namespace {

TEST(LayerLight, OfAMixtureMatchesTheSolver) {
    Scene scene = small_rings(1);
    the_rings(scene).profile = {{1.5, 2.5}, {1, 1.5}, {0.9, 0}, {0.1, 0.9}};
    constexpr double tolerance = 5e-3;
    scene.tolerance = tolerance;
    const BakedLight light = light_of_all_directions(scene);
    for (const double mixture : {0.05, 0.37, 0.6, 0.88}) {
        const Geometry geometry{0.6, 0.5, 2.5};
        const Matter matter{1.2, {0.95, 0.95, 0.9}, mixture};
        const PhaseFunction phase =
            PhaseFunction::mixture(mixture, scene.layer.components[0], scene.layer.components[1]);
        const LayerSolution layer =
            solve_layer(phase, 0.95, 1.2, {geometry.mu_in, geometry.mu_out});
        const double R = layer.reflection(0, 1, 2.5).total, T = layer.transmission(0, 1, 2.5).total;
        // The table's tolerance, and half as much again for the packed table's functions.
        EXPECT_NEAR(light.reflection(matter, geometry)[0] / R, 1, 1.5 * tolerance) << mixture;
        EXPECT_NEAR(light.transmission(matter, geometry)[0] / T, 1, 1.5 * tolerance) << mixture;
    }
}

}  // namespace
}  // namespace stratus
