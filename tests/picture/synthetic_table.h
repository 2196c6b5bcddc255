// A small table of made-up but plausible samples, for tests of what is done with tables: no solver
// is needed.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/base/constants.h>
#include <stratus/phase/phase_function.h>
#include <stratus/table/table.h>

#include "../table/small_table.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace stratus::test {

struct SyntheticOptions {
    std::string phase_function = "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5";
    double lowest_depth = 0.01, highest_depth = 8;
    int finite_depths = 11;
    bool and_infinity = false;
    double lowest_albedo = 0, highest_albedo = 1;
    int albedos = 8;
    int azimuths = 5;
    bool reflection = true, transmission = true;
};

/// Roughly Chandrasekhar's H function of isotropic scattering.
inline double rough_h(double mu, double albedo) {
    return (1 + 2 * mu) / (1 + 2 * mu * std::sqrt(1 - albedo));
}

/// Orders n >= 2 of a layer, roughly: those of an endless one, growing as tau^2 in thin layers.
inline double rough_multiple_reflection(double albedo, double depth, double mu, double mu0) {
    const double endless =
        albedo / 4 * (rough_h(mu, albedo) * rough_h(mu0, albedo) - 1) / (mu + mu0);
    return std::isinf(depth) ? endless : endless * depth / (depth + 1.4) * -std::expm1(-depth);
}

/// Orders n >= 2 below a layer, roughly: rising as tau^2, falling as diffusion has it.
inline double rough_multiple_transmission(double albedo, double depth, double mu, double mu0) {
    if (std::isinf(depth)) return 0;
    const double decay = std::exp(-std::sqrt(3 * (1 - albedo)) * depth);
    return albedo * albedo * rough_h(mu, albedo) * rough_h(mu0, albedo) / 4 * decay * depth *
           depth / std::pow(depth + 1.4, 3);
}

inline Table make_synthetic_table(const SyntheticOptions& options = {}) {
    Table table;
    table.phase_function = parse_phase_function(options.phase_function);
    table.albedo = make_axis(table.albedo.scale, options.lowest_albedo, options.highest_albedo,
                             options.albedos);
    table.optical_depth =
        make_axis(table.optical_depth.scale, options.lowest_depth, options.highest_depth,
                  options.finite_depths, options.and_infinity);
    table.mu_in = make_axis(table.mu_in.scale, 0.01, 1, 8);
    table.mu_out = table.mu_in;
    table.azimuth =
        make_axis(table.azimuth.scale, 0, options.azimuths > 1 ? pi : 0, options.azimuths);
    const double g = table.phase_function.asymmetry();
    table.extrapolation_length = 0.7104 / (1 - g);
    for (const double albedo : table.albedo.values) {
        table.diffusion_exponent.push_back(std::sqrt(3 * (1 - albedo) * (1 - albedo * g)));
        for (const double depth : table.optical_depth.values) {
            table.spherical_albedo.push_back(
                static_cast<float>(albedo * -std::expm1(-std::min(depth, 50.0)) / 2));
            for (const double mu_in : table.mu_in.values) {
                table.plane_albedo.push_back(
                    static_cast<float>(albedo / 2 * -std::expm1(-std::min(depth / mu_in, 50.0))));
                if (options.transmission)
                    table.diffuse_transmittance.push_back(
                        static_cast<float>(rough_multiple_transmission(albedo, depth, 0.5, mu_in)));
            }
        }
    }
    const auto turned = [&](const auto& rough) {
        return tabulate(table, [&](const SamplePoint& p) {
            const double turn =
                options.azimuths > 1
                    ? 1 + 0.3 * std::sqrt((1 - p.mu_in) * (1 - p.mu_out)) * std::cos(p.azimuth)
                    : 1;
            return turn * rough(p.albedo, p.optical_depth, p.mu_out, p.mu_in);
        });
    };
    if (options.reflection) table.reflection_multiple = turned(rough_multiple_reflection);
    if (options.transmission) table.transmission_multiple = turned(rough_multiple_transmission);
    table.tolerance = 1e-3;
    table.measured_error = 8.1e-4;
    table.attributes["title"] = "Saturn's rings, double Henyey-Greenstein";
    table.attributes["program_version"] = "0.0.0-synthetic";
    table.attributes["recipe"] = "title = \"made up for tests\"\ntolerance = 1e-3\n";
    prepare(table);
    return table;
}

}  // namespace stratus::test
