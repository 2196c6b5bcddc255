// Tables of any shape, with random samples, for the tests of io.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/table/table.h>

#include "../table/table_equality.h"

#include "../base/uniform.h"

#include <gtest/gtest.h>

namespace stratus::test {

struct Shape {
    int albedos = 3;
    int finite_depths = 4;
    bool infinite_depth = true;
    int cosines_in = 3;
    int cosines_out = 2;
    int azimuths = 5;
    bool reflection = true;
    bool transmission = true;
    int mixtures = 0;
};

/// Samples an axis evenly in its own scale.
inline void sample_axis(Axis& axis, double first, double last, int count,
                        bool and_infinity = false) {
    axis = make_axis(axis.scale, first, count == 1 ? first : last, count, and_infinity);
}

/// A table that `prepare` accepts, with random samples.
inline Table sample_table(const Shape& shape = {}) {
    Table table;
    table.phase_function =
        parse_phase_function("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
    sample_axis(table.albedo, 0, 1, shape.albedos);
    sample_axis(table.optical_depth, 0.01, 8.0, shape.finite_depths, shape.infinite_depth);
    sample_axis(table.mu_in, 0.03, 1, shape.cosines_in);
    sample_axis(table.mu_out, 0.03, 1, shape.cosines_out);
    sample_axis(table.azimuth, 0, pi, shape.azimuths);
    if (shape.mixtures > 0) {
        table.family = {{PhaseParameter::mixture, {}, false}};
        sample_axis(table.family[0].axis, 0.125, 1, shape.mixtures);
        table.second_phase_function = PhaseFunction::henyey_greenstein(1.0 / 3);
        for (int m = 0; m < shape.mixtures; ++m)
            table.extrapolation_lengths.push_back(0.8 + m / 7.0);
    }

    Uniform<float> sample(1982, -1e-3F, 2.0F);
    const auto fill = [&](auto& values, std::size_t count) {
        values.resize(count);
        for (auto& value : values) value = sample();
    };
    const std::size_t albedos = table.member_count() * table.albedo.values.size();
    const std::size_t layers = albedos * table.optical_depth.values.size();
    const std::size_t fluxes = layers * table.mu_in.values.size();
    if (shape.reflection) fill(table.reflection_multiple, table.sample_count());
    if (shape.transmission) fill(table.transmission_multiple, table.sample_count());
    if (shape.transmission) fill(table.diffuse_transmittance, fluxes);
    fill(table.plane_albedo, fluxes);
    fill(table.spherical_albedo, layers);
    for (std::size_t i = 0; i < albedos; ++i)
        table.diffusion_exponent.push_back(1.0 / static_cast<double>(3 + i));
    table.extrapolation_length = 0.1 + 0.2;
    table.tolerance = 1e-3;
    table.measured_error = 1.0 / 1234.5;
    table.highest_order = 7;
    table.attributes = {{"title", "Saturn's rings, \u03c9 and \u03c4"},
                        {"recipe", "tolerance = 1e-3\n[discretisation]\nnodes = 8\n"},
                        {"empty", ""},
                        {"a name that is longer than the thirty-one bytes of short names", "x"}};
    prepare(table);
    return table;
}

/// Expects everything that files hold to be identical.
inline void expect_same(const Table& a, const Table& b) {
    expect_same_bits(a, b);
    EXPECT_EQ(a.tolerance, b.tolerance);
    EXPECT_EQ(a.highest_order, b.highest_order);
    EXPECT_EQ(a.attributes, b.attributes);
}

}  // namespace stratus::test
