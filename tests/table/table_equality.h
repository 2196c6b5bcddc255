// Whether two tables are the same, to the last bit.
#pragma once

#include <stratus/table/table.h>

#include "../base/indices.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace stratus::test {

/// Equality of bits, so that -0 is not 0.
template <class Number>
void expect_same_bits(const std::vector<Number>& a, const std::vector<Number>& b,
                      const std::string& name) {
    ASSERT_EQ(a.size(), b.size()) << name;
    EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Number)) == 0)
        << name;
}

inline void expect_same(const Axis& a, const Axis& b, const std::string& name) {
    EXPECT_EQ(a.scale, b.scale) << name;
    expect_same_bits(a.values, b.values, name);
}

inline void expect_same(const LowerBoundary& a, const LowerBoundary& b) {
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_EQ(a.phase_function.text(), b.phase_function.text());
}

/// Axes and every number that was solved for, to the last bit.
inline void expect_same_bits(const Table& a, const Table& b) {
    EXPECT_EQ(a.phase_function.text(), b.phase_function.text());
    EXPECT_EQ(a.second_phase_function.text(), b.second_phase_function.text());
    expect_same(a.lower_boundary, b.lower_boundary);
    ASSERT_EQ(a.family.size(), b.family.size());
    for (const auto k : indices(a.family)) {
        EXPECT_EQ(a.family[k].parameter, b.family[k].parameter);
        EXPECT_EQ(a.family[k].is_discrete, b.family[k].is_discrete);
        expect_same(a.family[k].axis, b.family[k].axis, a.family[k].name());
    }
    expect_same_bits(a.extrapolation_lengths, b.extrapolation_lengths, "extrapolation_lengths");
    expect_same(a.albedo, b.albedo, "albedo");
    expect_same(a.optical_depth, b.optical_depth, "optical_depth");
    expect_same(a.mu_in, b.mu_in, "mu_in");
    expect_same(a.mu_out, b.mu_out, "mu_out");
    expect_same(a.azimuth, b.azimuth, "azimuth");
    expect_same_bits(a.reflection_multiple, b.reflection_multiple, "reflection_multiple");
    expect_same_bits(a.transmission_multiple, b.transmission_multiple, "transmission_multiple");
    expect_same_bits(a.plane_albedo, b.plane_albedo, "plane_albedo");
    expect_same_bits(a.diffuse_transmittance, b.diffuse_transmittance, "diffuse_transmittance");
    expect_same_bits(a.spherical_albedo, b.spherical_albedo, "spherical_albedo");
    expect_same_bits(a.diffusion_exponent, b.diffusion_exponent, "diffusion_exponent");
    EXPECT_EQ(a.extrapolation_length, b.extrapolation_length);
    EXPECT_EQ(a.measured_error, b.measured_error);
}

}  // namespace stratus::test
