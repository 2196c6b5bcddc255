// Recipes small enough to bake in every test.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <stratus/bake/recipe.h>
#include <stratus/runtime/table.h>

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

template <class Number>
void expect_same_bits(const std::vector<Number>& a, const std::vector<Number>& b,
                      const char* name) {
    ASSERT_EQ(a.size(), b.size()) << name;
    EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Number)) == 0)
        << name;
}

/// Axes and every number that was solved for, to the last bit.
inline void expect_same_bits(const Table& a, const Table& b) {
    EXPECT_EQ(a.phase_function.text(), b.phase_function.text());
    expect_same_bits(a.albedo.values, b.albedo.values, "albedo");
    expect_same_bits(a.optical_depth.values, b.optical_depth.values, "optical_depth");
    expect_same_bits(a.mu_in.values, b.mu_in.values, "mu_in");
    expect_same_bits(a.mu_out.values, b.mu_out.values, "mu_out");
    expect_same_bits(a.azimuth.values, b.azimuth.values, "azimuth");
    expect_same_bits(a.reflection_multiple, b.reflection_multiple, "reflection_multiple");
    expect_same_bits(a.transmission_multiple, b.transmission_multiple, "transmission_multiple");
    expect_same_bits(a.plane_albedo, b.plane_albedo, "plane_albedo");
    expect_same_bits(a.diffuse_transmittance, b.diffuse_transmittance, "diffuse_transmittance");
    expect_same_bits(a.spherical_albedo, b.spherical_albedo, "spherical_albedo");
    expect_same_bits(a.diffusion_exponent, b.diffusion_exponent, "diffusion_exponent");
    EXPECT_EQ(a.extrapolation_length, b.extrapolation_length);
    EXPECT_EQ(a.measured_error, b.measured_error);
}

/// Samples between one albedo and depth: where they begin and how many they are.
inline std::size_t block_size(const Table& table) {
    return table.mu_in.values.size() * table.mu_out.values.size() * table.azimuth.values.size();
}

}  // namespace stratus::test
