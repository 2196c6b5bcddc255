// Synthetic observations of clouds, from the solver rather than a table: small droplets in two colours.
#pragma once

#include "observed_rings.h"

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

/// Views whose wavelengths are known, as bright as a cloud is in their colours.
inline std::vector<Observation> seen(const Cloud& cloud, const std::vector<Observation>& spectrum) {
    std::vector<Observation> all;
    for (const double wavelength : wavelengths) {
        std::vector<Observation> of_colour;
        for (const Observation& at : spectrum)
            if (at.known[1] == wavelength) of_colour.push_back(at);
        solve_views(droplets(cloud.radius, wavelength), cloud.w, cloud.optical_depth, of_colour);
        all.insert(all.end(), of_colour.begin(), of_colour.end());
    }
    return all;
}

}  // namespace stratus::test
