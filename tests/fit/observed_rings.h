// Synthetic observations of rings, from the solver rather than a table.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/fit/fit.h>
#include <stratus/transfer/solve.h>

#include <cmath>
#include <random>
#include <vector>

namespace stratus::test {

struct Ring {
    double w1, w2, optical_depth;
    double g2 = 0.5;  // of the second kind of particles; the first are Lambert spheres
};

/// What the light of a synthetic ring is made of.
struct Circumstances {
    bool single_alone = false;
    double density = 0;
    Opposition opposition{};
};

inline Recipe ring_recipe() {
    return parse_recipe(
        "phase_function = 'lambert_sphere'\n"
        "second_phase_function = 'henyey_greenstein:g=0.5'\n"
        "tolerance = 2e-3\n"
        "optical_depth = { min = 0.05, max = 8 }\n"
        "albedo = { min = 0.1, max = 1.0 }\n"
        "[discretisation]\n"
        "nodes = 16\n"
        "modes = 10\n"
        "mu_samples = 22\n"
        "azimuth_samples = 9\n"
        "optical_depth_samples_per_octave = 2\n"
        "albedo_samples = 15\n"
        "mixture_samples = 7\n");
}

inline const Table& ring_table() {
    static const Table table = solve_table(ring_recipe());
    return table;
}

/// Geometries: two directions of incidence, many of view, of both sides or the lit one alone.
inline std::vector<Observation> views(bool both_sides) {
    std::vector<Observation> views;
    for (const double mu_in : {0.12, 0.4})
        for (const double mu_out : {0.1, 0.35, 0.8})
            for (const double azimuth : {0.2, 1.4, 2.2, 3.0})
                for (const Light light : {Light::reflected, Light::transmitted})
                    if (both_sides || light == Light::reflected)
                        views.push_back({{mu_in, mu_out, azimuth}, light, 0, 0});
    return views;
}

/// Occultations of two stars.
inline std::vector<Observation> occultations() {
    return {{{1, 0.5, 0}, Light::beam, 0, 0}, {{1, 0.25, 0}, Light::beam, 0, 0}};
}

inline std::vector<Observation> lit_views_and_occultations() {
    std::vector<Observation> all = views(false);
    for (const Observation& star : occultations()) all.push_back(star);
    return all;
}

/// Sets the brightness of views, and their standard deviations to a share of it.
inline void set_brightness(std::vector<Observation>& views, const std::vector<double>& brightness,
                           double noise = 0.01) {
    for (std::size_t i = 0; i < views.size(); ++i) {
        views[i].brightness = brightness[i];
        views[i].sigma = noise * brightness[i];
    }
}

/// Sets the exact brightness of a layer, and a standard deviation of 1 % of it.
inline void solve_views(const PhaseFunction& phase_function, double albedo, double optical_depth,
                        std::vector<Observation>& views, const Circumstances& circumstances = {}) {
    const double depth = optical_depth / (1 - circumstances.density);
    std::vector<double> mu, brightness;
    for (const Observation& view : views) {
        mu.push_back(view.geometry.mu_in);
        mu.push_back(view.geometry.mu_out);
    }
    const LayerSolution solution = solve_layer(phase_function, albedo, depth, mu, {.nodes = 24});
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Observation& view = views[i];
        const auto& [mu_in, mu_out, azimuth] = view.geometry;
        const int in = static_cast<int>(2 * i), out = in + 1;
        if (view.light == Light::beam) {
            brightness.push_back(std::exp(-depth / mu_out));
        } else {
            const bool lit = view.light == Light::reflected;
            const SolvedValue value = lit ? solution.reflection(in, out, azimuth)
                                          : solution.transmission(in, out, azimuth);
            const double factor =
                lit ? opposition_factor(circumstances.opposition,
                                        cos_scattering_angle_reflected(view.geometry), depth, mu_in,
                                        mu_out)
                    : 1;
            brightness.push_back(mu_in * (factor * value.single +
                                          (circumstances.single_alone ? 0 : value.multiple)));
        }
    }
    set_brightness(views, brightness);
}

inline void solve_views(const Ring& ring, std::vector<Observation>& views,
                        const Circumstances& circumstances = {}) {
    const double albedo = ring.w1 + ring.w2;
    solve_views(PhaseFunction::mixture(ring.w1 / albedo, PhaseFunction::lambert_sphere(),
                                       PhaseFunction::henyey_greenstein(ring.g2)),
                albedo, ring.optical_depth, views, circumstances);
}

inline std::vector<Observation> with_noise(std::vector<Observation> views, std::mt19937& random) {
    for (Observation& view : views)
        view.brightness = std::normal_distribution(view.brightness, view.sigma)(random);
    return views;
}

}  // namespace stratus::test
