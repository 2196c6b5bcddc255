// Synthetic observations of clouds, from the solver rather than a table: small droplets in two colours.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/fit/fit.h>
#include <stratus/transfer/solve.h>

#include <cmath>
#include <vector>

namespace stratus::test {

inline constexpr double wavelengths[] = {0.45, 0.65};

/// A family of radii, thin to thick.
inline const Table& droplet_table() {
    static const Table table =
        solve_table(parse_recipe("phase_function = 'mie:radius=0.3um,variance=0.1,index=1.33+0i'\n"
                                 "tolerance = 2e-3\n"
                                 "optical_depth = { min = 0.25, max = 4 }\n"
                                 "albedo = { min = 0.8, max = 1.0 }\n"
                                 "[family]\n"
                                 "radius = ['0.2um', '0.5um']\n"
                                 "wavelength = { values = ['450nm', '650nm'] }\n"
                                 "[discretisation]\n"
                                 "nodes = 16\n"
                                 "modes = 16\n"
                                 "mu_samples = 20\n"
                                 "azimuth_samples = 16\n"
                                 "optical_depth_samples_per_octave = 2\n"
                                 "albedo_samples = 5\n"
                                 "radius_samples = 9\n"));
    return table;
}

struct Cloud {
    double optical_depth, w, radius;
};

inline PhaseFunction droplets(double radius, double wavelength) {
    Droplets of;
    of.effective_radius = radius;
    of.effective_variance = 0.1;
    of.wavelength = wavelength;
    of.material = Droplets::Material::other;
    of.index = 1.33;
    return PhaseFunction(Mie(of));
}

/// Geometries of both sides, once for each colour; with its wavelength where it is a spectrum.
inline std::vector<Observation> cloud_views(bool is_spectrum) {
    std::vector<Observation> all;
    for (const double wavelength : wavelengths)
        for (const double mu_out : {0.3, 0.8})
            for (const double azimuth : {0.3, 1.6, 2.9})
                for (const Light light : {Light::reflected, Light::transmitted}) {
                    all.push_back({{0.7, mu_out, azimuth}, light, 0, 0});
                    if (is_spectrum) all.back().known = {NAN, wavelength};
                }
    return all;
}

/// Sets the exact brightness, and a standard deviation of 1 % of it.
inline void solve_cloud_views(const PhaseFunction& phase_function, const Cloud& cloud,
                              double wavelength, std::vector<Observation>& all) {
    std::vector<double> mu;
    for (const Observation& at : all) mu.insert(mu.end(), {at.geometry.mu_in, at.geometry.mu_out});
    const LayerSolution solution =
        solve_layer(phase_function, cloud.w, cloud.optical_depth, mu, SolverOptions{.nodes = 24});
    for (std::size_t i = 0; i < all.size(); ++i) {
        Observation& at = all[i];
        if (at.known.size() > 1 && at.known[1] != wavelength) continue;
        const int in = static_cast<int>(2 * i), out = in + 1;
        const double azimuth = at.geometry.azimuth;
        at.brightness = at.geometry.mu_in * (at.light == Light::reflected
                                                 ? solution.reflection(in, out, azimuth).total
                                                 : solution.transmission(in, out, azimuth).total);
        at.sigma = 0.01 * at.brightness;
    }
}

inline std::vector<Observation> seen(const Cloud& cloud, std::vector<Observation> all) {
    for (const double wavelength : wavelengths)
        solve_cloud_views(droplets(cloud.radius, wavelength), cloud, wavelength, all);
    return all;
}

}  // namespace stratus::test
