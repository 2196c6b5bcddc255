// Photons agree with the solver and the closed forms within their standard errors.
#include <stratus/base/constants.h>
#include <stratus/transfer/reference/solvers.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "refusal.h"
#include "shell_photons.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>
#include <vector>

namespace stratus {
namespace {

const std::vector<double> photon_cosines{0.15, 0.5, 0.9, 1.0};
const std::vector<Geometry> geometries{
    {0.5, 0.9, 0}, {0.5, 0.5, 2}, {0.5, 0.15, 1}, {0.15, 0.5, pi}, {0.5, 1.0, 0}};

int index_of(double mu) {
    for (const auto i : indices(photon_cosines))
        if (photon_cosines[i] == mu) return static_cast<int>(i);
    return -1;
}

PhotonOptions with_photons(std::uint64_t photons, std::uint64_t seed = 1) {
    PhotonOptions options;
    options.photons = photons;
    options.seed = seed;
    return options;
}

/// Within 4 standard errors, exceeded by chance once in 16000 values; a few hundred are compared.
/// Values without error (a standard error of 0) must agree to rounding.
void expect_meets(const Estimate& estimate, double expected, const std::string& what) {
    EXPECT_NEAR(estimate.value, expected, 4 * estimate.standard_error + 1e-14)
        << what << ", standard error " << estimate.standard_error;
}

// ---- against the solver ------------------------------------------------------------------------

struct LitLayer {
    const char* name;
    const char* phase_function;
    double albedo;
    double optical_depth;
};

void expect_radiances(const PhotonSolution& photons, const LayerSolution& layer) {
    for (const PhotonGeometry& at : photons.geometries) {
        const int in = index_of(at.geometry.mu_in), out = index_of(at.geometry.mu_out);
        const auto meets = [](const PhotonValue& value, const SolvedValue& expected,
                              const std::string& what) {
            expect_meets({value.value.total, value.standard_error}, expected.total, what);
            EXPECT_EQ(value.value.single, expected.single);
            EXPECT_EQ(value.value.total, value.value.single + value.value.multiple);
        };
        meets(at.reflection, layer.reflection(in, out, at.geometry.azimuth), "R");
        meets(at.transmission, layer.transmission(in, out, at.geometry.azimuth), "T");
        EXPECT_GT(at.reflection.standard_error, 0);
    }
}

class PhotonsInALayer : public testing::TestWithParam<LitLayer> {
  protected:
    PhotonSolution solve(const PhotonOptions& options) const {
        return solve_photons(phase_function, of.albedo, of.optical_depth, geometries, options);
    }

    const LitLayer& of = GetParam();
    const PhaseFunction phase_function = parse_phase_function(of.phase_function);
};

TEST_P(PhotonsInALayer, MatchTheClosedFormOfOrderOne) {
    PhotonOptions options = with_photons(20'000);
    options.highest_order = 1;
    for (const PhotonGeometry& at : solve(options).geometries) {
        expect_meets(at.reflection.single, at.reflection.value.single, "R1");
        expect_meets(at.transmission.single, at.transmission.value.single, "T1");
        EXPECT_GT(at.reflection.single.standard_error, 0);
    }
}

TEST_P(PhotonsInALayer, MatchTheSolver) {
    const PhotonSolution photons = solve(with_photons(10'000));
    const LayerSolution layer =
        solve_layer(phase_function, of.albedo, of.optical_depth, photon_cosines);
    expect_radiances(photons, layer);
    for (const auto b : indices(photons.mu_in)) {
        const int in = index_of(photons.mu_in[b]);
        expect_meets(photons.plane[b].albedo, layer.plane_albedo(in), "plane albedo");
        expect_meets(photons.plane[b].transmittance, layer.diffuse_transmittance(in),
                     "diffuse transmittance");
    }
    Estimate through = photons.uniform.transmittance;
    through.value += photons.uniform.direct_transmittance;
    expect_meets(photons.uniform.albedo, layer.spherical_albedo, "spherical albedo");
    expect_meets(through, layer.total_transmittance, "total transmittance");
}

TEST_P(PhotonsInALayer, MatchTheSolverFromBothEnds) {
    PhotonOptions options = with_photons(5000);
    options.backward_collisions = 3;
    expect_radiances(solve(options),
                     solve_layer(phase_function, of.albedo, of.optical_depth, photon_cosines));
}

TEST_P(PhotonsInALayer, ConserveEnergy) {
    const PhotonSolution photons = solve(with_photons(3000));
    std::vector<PhotonFluxes> all = photons.plane;
    all.push_back(photons.uniform);
    for (const PhotonFluxes& fluxes : all) {
        // The error of a sum is at most the sum of errors.
        Estimate sum{fluxes.direct_transmittance, 0};
        for (const Estimate& part : {fluxes.albedo, fluxes.transmittance, fluxes.absorptance}) {
            sum.value += part.value;
            sum.standard_error += part.standard_error;
        }
        expect_meets(sum, 1, "energy");
    }
}

/// Broader phase functions are compared with all other methods in agreement_test.
std::vector<LitLayer> lit_layers() {
    std::vector<LitLayer> all;
    for (const double albedo : {0.5, 0.99, 1.0})
        for (const double optical_depth : {0.05, 1.0, 8.0, infinity})
            if (albedo < 1 || optical_depth < infinity)
                all.push_back({"forward", "henyey_greenstein:g=0.75", albedo, optical_depth});
    return all;
}

INSTANTIATE_TEST_SUITE_P(Layer, PhotonsInALayer, testing::ValuesIn(lit_layers()),
                         [](const auto& row) {
                             return row.param.name + std::to_string(row.index);
                         });

// ---- properties --------------------------------------------------------------------------------

TEST(Photons, KeepRelativeAccuracyInThinLayers) {
    // At tau = 1e-6 only one analog photon in 1e11 would collide twice.
    const Geometry at{0.5, 0.9, 1};
    const PhotonValue R =
        solve_photons({}, 1, 1e-6, {at}, with_photons(20'000)).geometries[0].reflection;
    const SolvedValue expected = solve_layer({}, 1, 1e-6, {0.5, 0.9}).reflection(0, 1, 1);
    expect_meets({R.value.multiple, R.standard_error}, expected.multiple, "orders n >= 2");
    EXPECT_LT(R.standard_error, 0.2 * expected.multiple);
}

TEST(Photons, AcceptNegativeSeriesAndTables) {
    // A truncated series with negative lobes, and a table with a peak and a kink.
    const PhaseFunction series = PhaseFunction::from_moments(moments_cut_off());
    double least = 0;
    for (double c = -1; c <= 1; c += 1.0 / 512) least = std::min(least, series(c));
    ASSERT_LT(least, 0);
    const PhaseFunction table =
        PhaseFunction::tabulated({0, 2, 60, 150, 179, 180}, {3, 1, 0.2, 1, 40, 50});
    for (const PhaseFunction& phase_function : {series, table})
        expect_radiances(solve_photons(phase_function, 0.95, 2, geometries, with_photons(20'000)),
                         solve_layer(phase_function, 0.95, 2, photon_cosines, with_nodes(96)));
}

TEST(Photons, ConserveEnergyUnderANarrowPeak) {
    const PhotonSolution photons = solve_photons(PhaseFunction::henyey_greenstein(0.99), 1, 8,
                                                 {{0.5, 1, 0}}, with_photons(20'000));
    SolverOptions options = with_nodes(64);
    options.modes = 1;
    const LayerSolution layer =
        solve_layer(PhaseFunction::henyey_greenstein(0.99), 1, 8, {0.5}, options);
    expect_meets(photons.plane[0].albedo, layer.plane_albedo(0), "plane albedo");
    expect_meets(photons.uniform.albedo, layer.spherical_albedo, "spherical albedo");
}

TEST(Photons, StopAfterTheRequestedOrder) {
    PhotonOptions options = with_photons(20'000);
    options.highest_order = 1;
    const Geometry at{0.5, 0.9, 1};
    PhotonValue R = solve_photons({}, 0.9, 1, {at}, options).geometries[0].reflection;
    EXPECT_EQ(R.value.multiple, 0);
    EXPECT_EQ(R.standard_error, 0);
    EXPECT_GT(R.single.value, 0);
    // Order n is proportional to w^n: order 2 at albedo 1/2 is a quarter of that at albedo 1.
    options.highest_order = 2;
    const PhotonValue whole = solve_photons({}, 1, 1, {at}, options).geometries[0].reflection;
    const PhotonValue half = solve_photons({}, 0.5, 1, {at}, options).geometries[0].reflection;
    EXPECT_NEAR(half.value.multiple, whole.value.multiple / 4, 1e-15);
    // and paths in a conservative infinite layer end too
    EXPECT_GT(solve_photons({}, 1, infinity, {at}, options).geometries[0].reflection.value.multiple,
              whole.value.multiple);
}

TEST(Photons, FromBothEndsEqualNextEventEstimationOrderByOrder) {
    // as long as paths from the exits have a share in every order, in some, and in thin layers
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.5);
    for (const double optical_depth : {0.05, 2.0})
        for (const int n : {2, 3, 5}) {
            PhotonOptions options = with_photons(20'000);
            options.highest_order = n;
            const PhotonSolution expected =
                solve_photons(phase_function, 0.9, optical_depth, geometries, options);
            options.backward_collisions = 3;
            options.seed = 2;
            const PhotonSolution met =
                solve_photons(phase_function, 0.9, optical_depth, geometries, options);
            for (const auto i : indices(geometries))
                for (const auto side :
                     {&PhotonGeometry::reflection, &PhotonGeometry::transmission}) {
                    const PhotonValue &a = met.geometries[i].*side,
                                      &b = expected.geometries[i].*side;
                    EXPECT_NEAR(a.value.multiple, b.value.multiple,
                                4 * std::hypot(a.standard_error, b.standard_error));
                    EXPECT_LT(a.standard_error, 0.1 * a.value.multiple);
                }
        }
}

TEST(Photons, FromBothEndsHaveSmallErrorsUnderANarrowPeak) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.95);
    const Geometry backward{0.7, 0.7, 3.1};
    PhotonOptions options = with_photons(20'000);
    const PhotonValue next_event =
        solve_photons(phase_function, 1, 2, {backward}, options).geometries[0].reflection;
    options.backward_collisions = 8;
    const PhotonValue both_ends =
        solve_photons(phase_function, 1, 2, {backward}, options).geometries[0].reflection;
    EXPECT_LT(both_ends.standard_error, 0.2 * next_event.standard_error);
}

TEST(Photons, VanishWithoutScattering) {
    const Geometry at{0.5, 0.9, 1};
    const PhotonSolution empty = solve_photons({}, 1, 0, {at});
    EXPECT_EQ(empty.geometries[0].reflection.value.total, 0);
    EXPECT_EQ(empty.geometries[0].transmission.value.total, 0);
    EXPECT_EQ(empty.plane[0].direct_transmittance, 1);
    EXPECT_EQ(empty.plane[0].absorptance.value, 0);
    EXPECT_EQ(empty.uniform.direct_transmittance, 1);
    const PhotonSolution black = solve_photons({}, 0, 2, {at});
    EXPECT_EQ(black.geometries[0].reflection.value.total, 0);
    EXPECT_EQ(black.plane[0].direct_transmittance, std::exp(-4.0));
    EXPECT_EQ(black.plane[0].absorptance.value, 1 - std::exp(-4.0));
    EXPECT_EQ(black.plane[0].absorptance.standard_error, 0);
}

/// All random numbers of a solution.
std::vector<double> numbers(const PhotonSolution& of) {
    std::vector<double> all;
    const auto append = [&](const Estimate& estimate) {
        all.push_back(estimate.value);
        all.push_back(estimate.standard_error);
    };
    for (const PhotonGeometry& at : of.geometries)
        for (const PhotonValue& value : {at.reflection, at.transmission}) {
            append({value.value.total, value.standard_error});
            append(value.single);
        }
    std::vector<PhotonFluxes> fluxes = of.plane;
    fluxes.push_back(of.uniform);
    for (const PhotonFluxes& each : fluxes) {
        append(each.albedo);
        append(each.transmittance);
        append(each.absorptance);
    }
    return all;
}

TEST(Photons, AreDeterministicOnAnyThreads) {
    const auto solve = [](const ParallelFor& parallel_for) {
        PhotonOptions options = with_photons(10'001);  // batches of unequal size
        options.parallel_for = parallel_for;
        options.backward_collisions = 2;
        return numbers(solve_photons(PhaseFunction::rayleigh(), 0.9, 1, geometries, options));
    };
    const std::vector<double> serial = solve({});
    EXPECT_EQ(serial, solve([](int count, const std::function<void(int)>& body) {
                  for (int i = count; i-- > 0;) body(i);
              }));
    for (const int threads : {2, 5})
        EXPECT_EQ(serial, solve([threads](int count, const std::function<void(int)>& body) {
                      std::vector<std::thread> all;
                      for (int t = 0; t < threads; ++t)
                          all.emplace_back([&, t] {
                              for (int i = t; i < count; i += threads) body(i);
                          });
                      for (std::thread& each : all) each.join();
                  }));
}

TEST(Photons, AreIndependentOfOtherBeams) {
    const PhotonSolution all = solve_photons({}, 0.9, 1, geometries, with_photons(3000));
    const PhotonSolution one = solve_photons({}, 0.9, 1, {geometries[3]}, with_photons(3000));
    EXPECT_EQ(one.geometries[0].reflection.value.total, all.geometries[3].reflection.value.total);
}

TEST(Photons, DependOnTheSeed) {
    const auto of_seed = [](std::uint64_t seed) {
        return solve_photons({}, 0.9, 1, geometries, with_photons(2000, seed))
            .geometries[0]
            .reflection.value.total;
    };
    EXPECT_NE(of_seed(1), of_seed(2));
    EXPECT_NE(of_seed(1), of_seed(1 + (std::uint64_t{1} << 32)));
}

class PhotonsFollowedBack : public testing::TestWithParam<int> {};

TEST_P(PhotonsFollowedBack, HaveTheirStatedStandardErrors) {
    // (estimate - exact) / (standard error) over 400 seeds: mean 0 with an error of 0.05, variance
    // 1 with one of 0.07; four of those are allowed.
    constexpr unsigned seeds = 400;
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.5);
    const Geometry at{0.5, 0.9, 1};
    const LayerSolution layer = solve_layer(phase_function, 0.9, 1, {0.5, 0.9});
    const double exact[] = {layer.reflection(0, 1, 1).total,   layer.reflection(0, 1, 1).single,
                            layer.transmission(0, 1, 1).total, layer.plane_albedo(0),
                            layer.diffuse_transmittance(0),    layer.spherical_albedo};
    Tally pulls[6];
    for (unsigned seed = 0; seed < seeds; ++seed) {
        PhotonOptions options = with_photons(2000, 100u + seed);
        options.backward_collisions = GetParam();
        const PhotonSolution photons = solve_photons(phase_function, 0.9, 1, {at}, options);
        const auto& [geometry, R, T] = photons.geometries[0];
        const Estimate met[] = {{R.value.total, R.standard_error}, R.single,
                                {T.value.total, T.standard_error}, photons.plane[0].albedo,
                                photons.plane[0].transmittance,    photons.uniform.albedo};
        for (int i = 0; i < 6; ++i) pulls[i].add((met[i].value - exact[i]) / met[i].standard_error);
    }
    for (const Tally& pull : pulls) {
        EXPECT_NEAR(pull.sum / seeds, 0, 0.2) << &pull - pulls;
        EXPECT_NEAR(pull.squares / seeds, 1, 0.28) << &pull - pulls;
    }
}

INSTANTIATE_TEST_SUITE_P(Collisions, PhotonsFollowedBack, testing::Values(0, 4));

// ---- refusals ----------------------------------------------------------------------------------

TEST(Photons, RefuseArgumentsOutOfRange) {
    const Geometry at{0.5, 0.5, 0};
    const auto refused = [](double albedo, double optical_depth, const Geometry& geometry,
                            const char* reason, const PhotonOptions& options = {}) {
        expect_refusal([&] { solve_photons({}, albedo, optical_depth, {geometry}, options); },
                       reason);
    };
    refused(1.5, 1, at, "photons: albedo must be in [0, 1], got 1.5");
    refused(-0.5, 1, at, "photons: albedo must be in [0, 1], got -0.5");
    refused(NAN, 1, at, "photons: albedo must be in [0, 1], got nan");
    refused(0.5, -1, at, "photons: optical_depth must be in [0, inf], got -1");
    refused(0.5, NAN, at, "photons: optical_depth must be in [0, inf], got nan");
    refused(1, infinity, at,
            "photons: optical_depth must be finite at albedo 1 (paths in an infinite layer have no "
            "mean length), got inf");
    refused(0.5, 1, {0, 0.5, 0}, "photons: mu_in must be in (0, 1], got 0");
    refused(0.5, 1, {0.5, 1.25, 0}, "photons: mu_out must be in (0, 1], got 1.25");
    refused(0.5, 1, {0.5, 0.5, infinity}, "photons: azimuth must be finite, got inf");
    refused(0.5, 1, at, "photons: photons must be >= 2, got 1", with_photons(1));
    refused(0.5, 1, at, "photons: highest_order must be >= 0, got -1", {.highest_order = -1});
    for (const int count : {-1, 101}) {
        refused(0.5, 1, at, "photons: backward_collisions must be in [0, 100], got",
                {.backward_collisions = count});
    }
}

// Far from limb and terminator a shell of little height is plane.
TEST(ShellPhotons, OfLittleHeightAreThoseOfAPlaneLayer) {
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.5);
    const double impact = 0.6, angle = 0.9;  // of the sun from the eye, on the ray's side
    const ShellLight light =
        shell_photons(phase, 0.9, 2, 1e-5, {impact, {std::sin(angle), 0, std::cos(angle)}}, 40000);
    const double mu_out = std::sqrt(1 - impact * impact),
                 mu_in = std::cos(angle - std::asin(impact));
    // The sun's and the eye's azimuths are opposite where the normal lies between both directions.
    const double azimuth = std::asin(impact) < angle ? 0 : pi;
    const LayerSolution layer = solve_layer(phase, 0.9, 2, {mu_in, mu_out});
    const SolvedValue expected = layer.reflection(0, 1, azimuth);
    EXPECT_NEAR(light.single.value, mu_in * expected.single, 4 * light.single.standard_error);
    EXPECT_NEAR(light.multiple.value, mu_in * (expected.total - expected.single),
                4 * light.multiple.standard_error);
    EXPECT_LT(light.multiple.standard_error, 0.02 * light.multiple.value);
}

TEST(ShellPhotons, AreNoneInTheShadowAndOfNoAlbedo) {
    const PhaseFunction phase = PhaseFunction::isotropic();
    EXPECT_EQ(shell_photons(phase, 1, 1, 0.01, {0, {0, 0, -1}}, 100).single.value, 0);
    EXPECT_EQ(shell_photons(phase, 0, 1, 0.01, {0.5, {0, 0, 1}}, 100).multiple.value, 0);
    EXPECT_GT(shell_photons(phase, 1, 1, 0.01, {1.005, {0, 0, -1}}, 100).single.value, 0)
        << "beside the planet the sun shines through";
}

}  // namespace
}  // namespace stratus
