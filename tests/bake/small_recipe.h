// Recipes small enough to bake in every test.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/table/table.h>

#include "../base/all_near.h"
#include "../table/table_equality.h"

#include <string>

namespace stratus::test {

/// Every choice left open; depends on azimuth.
inline Recipe rayleigh_recipe() {
    return parse_recipe(
        "title = 'Rayleigh'\n"
        "phase_function = 'rayleigh'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 0.25, max = 2.0 }\n"
        "albedo = { min = 0.5, max = 1.0 }\n");
}

/// One layer of forward-peaked scattering; every choice left open.
inline Recipe peaked_recipe() {
    return parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.85'\n"
        "tolerance = 2e-2\n"
        "optical_depth = { min = 1.0, max = 1.0 }\n"
        "albedo = { min = 1.0, max = 1.0 }\n"
        "sides = ['transmission']\n");
}

/// Every choice left open; ends at infinity.
inline Recipe deep_recipe() {
    return parse_recipe(
        "phase_function = 'isotropic'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 0.5, max = inf }\n"
        "albedo = { min = 0.5, max = 1.0 }\n");
}

/// Every choice spelled out, in numbers that no measurement would come to.
inline Recipe explicit_recipe(const std::string& scheme = "harmonic") {
    return parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.4'\n"
        "tolerance = 1e-2\n"
        "optical_depth = { min = 0.5, max = 2.0 }\n"
        "albedo = { min = 0.75, max = 1.0 }\n"
        "[discretisation]\n"
        "nodes = 9\n"
        "modes = 7\n"
        "mu_samples = 11\n"
        "azimuth_samples = 6\n"
        "optical_depth_samples_per_octave = 5\n"
        "albedo_samples = 3\n"
        "scheme = '" +
        scheme + "'\n");
}

inline void expect_range(const Range& range, double min, double max) {
    EXPECT_EQ(range.min, min);
    EXPECT_EQ(range.max, max);
}

/// Samples between one albedo and depth: where they begin and how many they are.
inline std::size_t block_size(const Table& table) {
    return table.mu_in.values.size() * table.mu_out.values.size() * table.azimuth.values.size();
}

inline void expect_same(const Discretisation& a, const Discretisation& b) {
    for (const auto count :
         {&Discretisation::nodes, &Discretisation::modes, &Discretisation::mu_samples,
          &Discretisation::azimuth_samples, &Discretisation::optical_depth_samples_per_octave,
          &Discretisation::albedo_samples})
        EXPECT_EQ(a.*count, b.*count);
    EXPECT_EQ(a.deepest_optical_depth, b.deepest_optical_depth);
    EXPECT_EQ(a.scheme, b.scheme);
    EXPECT_EQ(a.azimuth_scale, b.azimuth_scale);
    EXPECT_EQ(a.albedo_scale, b.albedo_scale);
    EXPECT_EQ(a.family_samples, b.family_samples);
}

}  // namespace stratus::test
