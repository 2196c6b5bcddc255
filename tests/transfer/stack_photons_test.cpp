// Stacks against photons that know nothing of layers' matrices, truncation or paths.
#include <stratus/base/constants.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace stratus {
namespace {

struct Ray {
    double x, y, z;  // a unit vector; z points out of the lit side
};

double dot(const Ray& a, const Ray& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

class StackPhotons {
  public:
    /// `ground`: a surface or one with a law.
    StackPhotons(const std::vector<StackLayer>& layers, const LowerBoundary& ground,
                 std::uint64_t seed)
        : layers_(layers), ground_(ground), engine_(seed) {
        for (const StackLayer& layer : layers) depth_ += layer.optical_depth;
    }

    struct Tally {
        double sum = 0, squares = 0;
        int count = 0;

        void add(double value) {
            sum += value;
            squares += value * value;
            ++count;
        }
        double mean() const { return sum / count; }
        double error() const { return std::sqrt((squares / count - mean() * mean()) / count); }
    };

    /// Of one photon more: R at each geometry, all of one mu_in, and the plane albedo.
    void follow(const std::vector<Geometry>& exits, std::vector<Tally>& tallies, Tally& albedo) {
        std::vector<double> seen(exits.size(), 0.0);
        const double mu = exits[0].mu_in;
        Ray ray{std::sqrt(1 - mu * mu), 0, -mu};
        double depth = 0, weight = 1;
        while (weight != 0) {
            depth -= std::log1p(-uniform()) * -ray.z;
            if (depth < 0) break;
            const bool is_ground = depth >= depth_;
            if (is_ground) depth = depth_;
            const StackLayer* const layer = is_ground ? nullptr : &at(depth);
            if (layer != nullptr) weight *= layer->albedo;
            for (std::size_t e = 0; e < exits.size(); ++e) {
                const double out = exits[e].mu_out, sine = std::sqrt(1 - out * out);
                const Ray exit{sine * std::cos(exits[e].azimuth), sine * std::sin(exits[e].azimuth),
                               out};
                // Radiance over mu0 F / pi: phi/4 of what collides; a ground sends out mu R of it.
                const double share = layer != nullptr
                                         ? layer->phase_function(dot(ray, exit)) / (4 * out)
                                         : reflected(ray, exit);
                seen[e] += weight * share * std::exp(-depth / out);
            }
            const Ray arrived = ray;
            ray = layer != nullptr ? turned(ray, cosine(layer->phase_function)) : upward();
            if (layer == nullptr) weight *= reflected(arrived, ray);
            if (weight < 0.05) weight = uniform() < 0.5 ? 2 * weight : 0;
        }
        for (std::size_t e = 0; e < exits.size(); ++e) tallies[e].add(seen[e]);
        albedo.add(weight);
    }

  private:
    double uniform() { return std::ldexp(static_cast<double>(engine_() >> 11), -53); }

    const StackLayer& at(double depth) const {
        std::size_t k = 0;
        for (; k + 1 < layers_.size() && depth > layers_[k].optical_depth; ++k)
            depth -= layers_[k].optical_depth;
        return layers_[k];
    }

    /// Drawn in proportion to the phase function, a sum of Henyey-Greenstein and Rayleigh.
    double cosine(const PhaseFunction& phase_function) {
        double pick = uniform();
        for (const auto& [share, kind] : phase_function.terms()) {
            pick -= share;
            if (pick > 0) continue;
            if (const auto* lobe = std::get_if<HenyeyGreenstein>(&kind)) {
                const double g = lobe->g, s = (1 - g * g) / (1 - g + 2 * g * uniform());
                return (1 + g * g - s * s) / (2 * g);
            }
            while (true) {  // Rayleigh, by rejection
                const double c = 2 * uniform() - 1;
                if (2 * uniform() < 1 + c * c) return c;
            }
        }
        return 1;
    }

    /// R of the ground.
    double reflected(const Ray& in, const Ray& out) const {
        const double azimuth = std::atan2(in.x * out.y - in.y * out.x, in.x * out.x + in.y * out.y);
        return single_reflection_of_boundary(ground_, 0, {-in.z, out.z, azimuth});
    }

    Ray turned(const Ray& ray, double cosine) {
        const double angle = 2 * pi * uniform(),
                     sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        const Ray any = std::abs(ray.z) < 0.9 ? Ray{0, 0, 1} : Ray{1, 0, 0};
        Ray e{any.y * ray.z - any.z * ray.y, any.z * ray.x - any.x * ray.z,
              any.x * ray.y - any.y * ray.x};
        const double length = std::sqrt(dot(e, e));
        e = {e.x / length, e.y / length, e.z / length};
        const Ray f{ray.y * e.z - ray.z * e.y, ray.z * e.x - ray.x * e.z,
                    ray.x * e.y - ray.y * e.x};
        const double a = sine * std::cos(angle), b = sine * std::sin(angle);
        return {cosine * ray.x + a * e.x + b * f.x, cosine * ray.y + a * e.y + b * f.y,
                cosine * ray.z + a * e.z + b * f.z};
    }

    Ray upward() {
        const double mu = std::sqrt(1 - uniform()), angle = 2 * pi * uniform();
        const double sine = std::sqrt(1 - mu * mu);
        return {sine * std::cos(angle), sine * std::sin(angle), mu};
    }

    const std::vector<StackLayer>& layers_;
    const LowerBoundary& ground_;
    double depth_ = 0;
    std::mt19937_64 engine_;
};

/// Compares at two incidences; the errors of photons are at most `most_error` of each value, and
/// `most_albedo_error`, which a law's weights at grazing angles widen.
void expect_photons_agree(const std::vector<StackLayer>& layers, const LowerBoundary& ground,
                          int photon_count, double most_error, double most_albedo_error) {
    for (const double mu_in : {0.25, 0.8}) {
        std::vector<Geometry> exits;
        for (const double mu_out : {0.3, 0.9})
            for (const double azimuth : {1.5, 3.0}) exits.push_back({mu_in, mu_out, azimuth});
        StackPhotons photons(layers, ground, 1);
        std::vector<StackPhotons::Tally> tallies(exits.size());
        StackPhotons::Tally albedo;
        for (int i = 0; i < photon_count; ++i) photons.follow(exits, tallies, albedo);
        SolverOptions options;
        options.tolerance = 1e-4;
        const SolvedGeometries solved = solve_geometries(layers, ground, exits, options);
        for (std::size_t e = 0; e < exits.size(); ++e) {
            EXPECT_LT(tallies[e].error(), most_error * tallies[e].mean());
            EXPECT_NEAR(solved.at[e].reflection.total, tallies[e].mean(), 3.5 * tallies[e].error())
                << mu_in << ' ' << exits[e].mu_out << ' ' << exits[e].azimuth;
        }
        EXPECT_LT(albedo.error(), most_albedo_error);
        EXPECT_NEAR(solve_fluxes(layers, ground, {mu_in}, options).plane_albedo[0], albedo.mean(),
                    3.5 * albedo.error());
    }
}

TEST(StackPhotons, AgreeWithStacksOfUnlikeClouds) {
    const PhaseFunction two_lobes =
        PhaseFunction::sum({{0.6, PhaseFunction::henyey_greenstein(0.9)},
                            {0.4, PhaseFunction::henyey_greenstein(-0.3)}});
    expect_photons_agree({{PhaseFunction::henyey_greenstein(0.97), 0.99, 1},
                          {two_lobes, 1, 2},
                          {PhaseFunction::rayleigh(), 0.95, 0.5}},
                         LowerBoundary::surface(0.3), 2'000'000, 2e-2, 5e-4);
}

TEST(StackPhotons, AgreeOverGroundsWithLaws) {
    for (const char* ground : {"ocean:wind=12", "rpv:rho0=0.3,k=0.8,theta=-0.2"})
        expect_photons_agree({{PhaseFunction::henyey_greenstein(0.6), 0.98, 0.3}},
                             read_ground(ground), 500'000, 1e-2, 2e-3);
}

}  // namespace
}  // namespace stratus
