// Narrow peaks, the solver against photons: R and T of clouds in the aureole, at the glory and at
// grazing angles. Photons know nothing of nodes, truncation or the light that peaks scatter twice.
//
//     aureole_bench [NODES [PHOTONS]]      solver nodes (24), photons for each mu_in (400000)
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace stratus;

struct Cloud {
    const char *name, *phase;
    double albedo, optical_depth;
};

struct Region {
    const char* name;
    Side side;
    std::vector<Geometry> directions;  // azimuths in degrees
};

const std::vector<Region> regions{{"aureole",
                                   Side::transmission,
                                   {{0.7, 0.7, 0.5},
                                    {0.7, 0.7, 1.5},
                                    {0.7, 0.7, 4},
                                    {0.7, 0.7, 8},
                                    {0.7, 0.7, 13},
                                    {0.7, 0.72, 0},
                                    {0.7, 0.75, 2},
                                    {0.7, 0.8, 0},
                                    {0.7, 0.66, 1},
                                    {0.7, 0.6, 5}}},
                                  {"glory",
                                   Side::reflection,
                                   {{0.7, 0.7, 180},
                                    {0.7, 0.7, 179},
                                    {0.7, 0.7, 178},
                                    {0.7, 0.7, 176},
                                    {0.7, 0.7, 172},
                                    {0.7, 0.7, 165},
                                    {0.7, 0.72, 180},
                                    {0.7, 0.76, 180},
                                    {0.7, 0.66, 179},
                                    {0.7, 0.6, 180}}},
                                  {"grazing",
                                   Side::reflection,
                                   {{0.02, 0.02, 1},
                                    {0.02, 0.02, 3},
                                    {0.02, 0.05, 0},
                                    {0.05, 0.05, 1},
                                    {0.05, 0.05, 5},
                                    {0.05, 0.1, 0},
                                    {0.05, 0.15, 10},
                                    {0.15, 0.1, 3},
                                    {0.15, 0.15, 1},
                                    {0.15, 0.15, 6}}}};

double scattering_angle_deg(Side side, const Geometry& at) {
    return degrees(std::acos(cos_scattering_angle(side, at)));
}

void compare(const Cloud& cloud, int nodes, std::uint64_t count) {
    const PhaseFunction phase_function = read_phase_function(cloud.phase, STRATUS_REFERENCE_FOLDER);
    std::vector<Geometry> geometries;
    std::vector<double> cosines;
    for (const Region& region : regions)
        for (Geometry at : region.directions) {
            at.azimuth = radians(at.azimuth);
            geometries.push_back(at);
            for (const double mu : {at.mu_in, at.mu_out})
                if (std::find(cosines.begin(), cosines.end(), mu) == cosines.end())
                    cosines.push_back(mu);
        }
    const auto index_of = [&](double mu) {
        return static_cast<int>(std::find(cosines.begin(), cosines.end(), mu) - cosines.begin());
    };

    SolverOptions solver;
    solver.nodes = nodes;
    const LayerSolution layer =
        solve_layer(phase_function, cloud.albedo, cloud.optical_depth, cosines, solver);
    PhotonOptions options;
    options.photons = count;
    options.backward_collisions = 8;
    options.parallel_for = [](int n, const std::function<void(int)>& body) {
        parallel_for(n, 0, body);
    };
    const PhotonSolution photons =
        solve_photons(phase_function, cloud.albedo, cloud.optical_depth, geometries, options);

    std::printf(
        "\n%s, w = %g, tau = %g\n\n"
        "| | mu_in | mu_out | azimuth | Theta | photons | error, %% | %d nodes | off, %% | "
        "off, errors |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        cloud.name, cloud.albedo, cloud.optical_depth, nodes);
    std::size_t i = 0;
    for (const Region& region : regions)
        for (const Geometry& asked : region.directions) {
            const PhotonGeometry& met = photons.geometries[i++];
            const Geometry& at = met.geometry;
            const int in = index_of(at.mu_in), out = index_of(at.mu_out);
            const bool reflected = region.side == Side::reflection;
            const PhotonValue& value = reflected ? met.reflection : met.transmission;
            const double expected = value.value.total;
            const double solved = reflected ? layer.reflection(in, out, at.azimuth).total
                                            : layer.transmission(in, out, at.azimuth).total;
            std::printf(
                "| %c %s | %.2f | %.2f | %.1f | %.2f | %.5g | %.2f | %.5g | %+.2f | %+.1f |\n",
                reflected ? 'R' : 'T', region.name, at.mu_in, at.mu_out, asked.azimuth,
                scattering_angle_deg(region.side, at), expected,
                100 * value.standard_error / expected, solved, 100 * (solved / expected - 1),
                (solved - expected) / value.standard_error);
        }
    std::fflush(stdout);
}

/// Argument `position`, a whole number in [least, most], or what it is by default.
long long number(int argc, char** argv, int position, const char* name, long long least,
                 long long most, long long otherwise) {
    if (position >= argc) return otherwise;
    char* end = nullptr;
    const long long given = std::strtoll(argv[position], &end, 10);
    const std::string range =
        "a whole number in [" + std::to_string(least) + ", " + std::to_string(most) + "]";
    if (end == argv[position] || *end != '\0' || given < least || given > most)
        throw std::invalid_argument("aureole_bench: " + std::string(name) + " must be " + range +
                                    ", got " + argv[position]);
    return given;
}

}  // namespace

int main(int argc, char** argv) {
    const char* const water_cloud = "moments:file=water_cloud_10um_moments.csv";
    const Cloud clouds[] = {{"Water cloud, droplets of 10 um", water_cloud, 1, 4},
                            {"Water cloud, droplets of 10 um", water_cloud, 0.9, 0.5},
                            {"HG 0.95", "henyey_greenstein:g=0.95", 1, 2}};
    try {
        const auto nodes = static_cast<int>(number(argc, argv, 1, "NODES", 1, 512, 24));
        const auto photons = static_cast<std::uint64_t>(
            number(argc, argv, 2, "PHOTONS", 2, 1'000'000'000'000, 400'000));
        for (const Cloud& cloud : clouds) compare(cloud, nodes, photons);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
