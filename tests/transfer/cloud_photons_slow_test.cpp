// The solver against photons where a water cloud's peaks are narrow: T in the aureole, R at the
// glory.
#include <stratus/base/constants.h>
#include <stratus/io/table_file.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace stratus {
namespace {

constexpr const char* cloud = "moments:file=water_cloud_10um_moments.csv";
constexpr const char* drizzle = "mie:radius=50um,variance=0.1,wavelength=0.55um";

/// As few as a cloud needs: the peak is cut off early, and the path law carries it.
constexpr int nodes = 24;

const std::vector<double> cloud_cosines{0.7, 0.72, 0.66, 0.76};  // the first is mu_in

struct Exit {
    int out;  // index into cloud_cosines
    double azimuth_deg;
};
const std::vector<Exit> aureole{{0, 0.5}, {1, 0}, {2, 1}, {0, 4}, {0, 8}};
const std::vector<Exit> glory{{0, 180}, {0, 178}, {3, 180}};

struct Cloud {
    const char* name;
    const char* phase_function;
    double albedo, optical_depth;
};

class CloudFromPhotons : public testing::TestWithParam<Cloud> {};

TEST_P(CloudFromPhotons, HasTheSolversAureoleAndGlory) {
    const auto [name, text, albedo, optical_depth] = GetParam();
    const PhaseFunction phase_function = read_phase_function(text, STRATUS_REFERENCE_FOLDER);
    const LayerSolution layer =
        solve_layer(phase_function, albedo, optical_depth, cloud_cosines, {.nodes = nodes});

    std::vector<Geometry> geometries;
    for (const auto& directions : {aureole, glory})
        for (const auto& [out, azimuth_deg] : directions)
            geometries.push_back({cloud_cosines[0], cloud_cosines[static_cast<std::size_t>(out)],
                                  radians(azimuth_deg)});
    const PhotonSolution photons = solve_photons(phase_function, albedo, optical_depth, geometries,
                                                 {.photons = 100'000, .backward_collisions = 8});

    for (const auto i : indices(geometries)) {
        const PhotonGeometry& at = photons.geometries[i];
        const bool transmitted = i < aureole.size();
        const PhotonValue& met = transmitted ? at.transmission : at.reflection;
        const int out = transmitted ? aureole[i].out : glory[i - aureole.size()].out;
        const double azimuth = at.geometry.azimuth;
        const double expected = transmitted ? layer.transmission(0, out, azimuth).total
                                            : layer.reflection(0, out, azimuth).total;
        EXPECT_NEAR(met.value.total, expected, 4 * met.standard_error + 0.01 * expected)
            << (transmitted ? "T" : "R") << " at mu_out " << at.geometry.mu_out << ", azimuth "
            << degrees(azimuth) << " degrees, standard error " << met.standard_error;
        EXPECT_LT(met.standard_error, 0.008 * expected);
    }
}

INSTANTIATE_TEST_SUITE_P(Cloud, CloudFromPhotons,
                         testing::Values(Cloud{"Thin", cloud, 0.9, 0.5},
                                         Cloud{"Thick", cloud, 1, 4},
                                         Cloud{"Drizzle", drizzle, 1, 2}),
                         row_name);

}  // namespace
}  // namespace stratus
