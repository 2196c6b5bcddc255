// Stacks against photons that know nothing of layers' matrices, truncation or paths.
#include <stratus/base/constants.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "indices.h"
#include "reference/photon_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace stratus {
namespace {

class StackPhotons {
  public:
    /// `ground`: a surface or one with a law.
    StackPhotons(const std::vector<StackLayer>& layers, const LowerBoundary& ground,
                 std::uint64_t seed)
        : layers_(layers), ground_(ground), random_(seed, 0, 0) {
        for (const StackLayer& layer : layers) {
            depth_ += layer.optical_depth;
            phases_.emplace_back(layer.phase_function);
            angles_.emplace_back(phases_.back());
        }
    }

    /// Follows one photon more, for R at each geometry, all of one mu_in, and the plane albedo.
    void follow(const std::vector<Geometry>& exits, std::vector<Tally>& tallies, Tally& albedo) {
        std::vector<double> seen(exits.size(), 0.0);
        const double mu = exits[0].mu_in;
        Direction along{std::sqrt(1 - mu * mu), 0, -mu};
        double depth = 0, weight = 1;
        while (weight != 0) {
            depth += std::log1p(-random_()) * along.z;
            if (depth < 0) break;
            const bool is_ground = depth >= depth_;
            if (is_ground) depth = depth_;
            const std::size_t k = layer_at(depth);
            if (!is_ground) weight *= layers_[k].albedo;
            for (const auto e : indices(exits)) {
                const double out = exits[e].mu_out, sine = std::sqrt(1 - out * out);
                const Direction exit{sine * std::cos(exits[e].azimuth),
                                     sine * std::sin(exits[e].azimuth), out};
                // Radiance over mu0 F / pi: phi/4 of what collides; a ground sends out mu R of it.
                const double share =
                    is_ground ? reflected(along, exit) : phases_[k](dot(along, exit)) / (4 * out);
                seen[e] += weight * share * std::exp(-depth / out);
            }
            const Direction arrived = along;
            const double azimuth = 2 * pi * random_();
            if (is_ground) {
                along = scattered({0, 0, 1}, (1 - std::sqrt(1 - random_())) / 2, azimuth);
                weight *= reflected(arrived, along);
            } else {
                const double bin_number = random_();
                const AngleSampler::Sample angle = angles_[k].sample(bin_number, random_());
                along = scattered(arrived, angle.v, azimuth);
                weight *= phases_[k](1 - 2 * angle.v) / angle.density;
            }
            if (weight < 0.05) weight = random_() < 0.5 ? 2 * weight : 0;
        }
        for (const auto e : indices(exits)) tallies[e].add(seen[e]);
        albedo.add(weight);
    }

  private:
    std::size_t layer_at(double depth) const {
        std::size_t k = 0;
        for (; k + 1 < layers_.size() && depth > layers_[k].optical_depth; ++k)
            depth -= layers_[k].optical_depth;
        return k;
    }

    /// R of the ground.
    double reflected(const Direction& in, const Direction& out) const {
        const double azimuth = std::atan2(in.x * out.y - in.y * out.x, in.x * out.x + in.y * out.y);
        return single_reflection_of_boundary(ground_, 0, {-in.z, out.z, azimuth});
    }

    const std::vector<StackLayer>& layers_;
    const LowerBoundary& ground_;
    double depth_ = 0;
    std::vector<PhaseValues> phases_;
    std::vector<AngleSampler> angles_;
    Random random_;
};

/// Compares at two incidences; the errors of photons are at most `most_error` of each value, and
/// `most_albedo_error`, which a law's weights at grazing angles widen.
void expect_photons_agree(const std::vector<StackLayer>& layers, const LowerBoundary& ground,
                          std::uint64_t photon_count, double most_error, double most_albedo_error) {
    for (const double mu_in : {0.25, 0.8}) {
        std::vector<Geometry> exits;
        for (const double mu_out : {0.3, 0.9})
            for (const double azimuth : {1.5, 3.0}) exits.push_back({mu_in, mu_out, azimuth});
        StackPhotons photons(layers, ground, 1);
        std::vector<Tally> tallies(exits.size());
        Tally albedo_tally;
        for (std::uint64_t n = 0; n < photon_count; ++n)
            photons.follow(exits, tallies, albedo_tally);
        const Estimate albedo = albedo_tally.estimate(photon_count);
        SolverOptions options;
        options.tolerance = 1e-4;
        const SolvedGeometries solved = solve_geometries(layers, ground, exits, options);
        for (const auto e : indices(exits)) {
            const Estimate met = tallies[e].estimate(photon_count);
            EXPECT_LT(met.standard_error, most_error * met.value);
            EXPECT_NEAR(solved.at[e].reflection.total, met.value, 3.5 * met.standard_error)
                << mu_in << ' ' << exits[e].mu_out << ' ' << exits[e].azimuth;
        }
        EXPECT_LT(albedo.standard_error, most_albedo_error);
        EXPECT_NEAR(solve_fluxes(layers, ground, {mu_in}, options).plane_albedo[0], albedo.value,
                    3.5 * albedo.standard_error);
    }
}

TEST(StackPhotons, AgreeWithStacksOfUnlikeClouds) {
    const PhaseFunction two_lobes =
        PhaseFunction::sum({{0.6, PhaseFunction::henyey_greenstein(0.9)},
                            {0.4, PhaseFunction::henyey_greenstein(-0.3)}});
    expect_photons_agree({{PhaseFunction::henyey_greenstein(0.97), 0.99, 1},
                          {two_lobes, 1, 2},
                          {PhaseFunction::rayleigh(), 0.95, 0.5}},
                         LowerBoundary::surface(0.3), 1'600'000, 2e-2, 5e-4);
}

TEST(StackPhotons, AgreeOverGroundsWithLaws) {
    for (const char* ground : {"ocean:wind=12", "rpv:rho0=0.3,k=0.8,theta=-0.2"})
        expect_photons_agree({{PhaseFunction::henyey_greenstein(0.6), 0.98, 0.3}},
                             read_ground(ground), 500'000, 1e-2, 2e-3);
}

}  // namespace
}  // namespace stratus
