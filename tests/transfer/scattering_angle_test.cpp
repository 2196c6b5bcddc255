// Tabulated phase functions keep their values, and sampled scattering angles their moments.
#include "reference/photon_path.h"

#include <stratus/io/table_file.h>

#include "usual_layers.h"

#include <map>
#include <string>

namespace stratus {
namespace {

/// A cloud of water droplets whose peak of 7400 takes 768 moments.
const char* const water_cloud = "moments:file=water_cloud_10um_moments.csv";

PhaseFunction read_beside_reference(const std::string& text) {
    return read_phase_function(text, STRATUS_REFERENCE_FOLDER);
}

/// Largest relative error at 5000 angles, more of them where peaks are.
double largest_error(const PhaseFunction& exact) {
    const PhaseValues values(exact);
    double worst = 0;
    for (int i = 0; i <= 5000; ++i) {
        const double x = i / 5000.0, c = std::cos(pi * x * x);
        for (const double cosine : {c, -c})
            worst = std::max(worst, std::abs(values(cosine) / exact(cosine) - 1));
    }
    return worst;
}

TEST(PhaseValues, OfLegendreSeriesKeepSevenDigitsOfTheirSum) {
    for (const char* const series :
         {water_cloud, "moments:file=haze_l_moments.csv", "moments:chi=1 0.4 0.1",
          "0.3*moments:file=water_cloud_10um_moments.csv + 0.7*henyey_greenstein:g=0.8"})
        EXPECT_LT(largest_error(read_beside_reference(series)), 1e-7) << series;  // 2e-8 measured
}

TEST(PhaseValues, OfASeriesCutOffAreWithinAShareOfItsLastMoment) {
    const std::vector<double> chi = moments_cut_off();
    const PhaseFunction exact = PhaseFunction::from_moments(chi);
    const PhaseValues values(exact);
    for (double c = -1; c <= 1; c += 1.0 / 2048)
        EXPECT_NEAR(values(c), exact(c), 1e-6 * 75 * chi.back()) << c;
}

TEST(PhaseValues, OfClosedFormsAreExact) {
    for (const char* const closed :
         {"isotropic", "rayleigh", "henyey_greenstein:g=0.999", "lambert_sphere",
          "0.5*henyey_greenstein:g=0.9 + 0.5*rayleigh"})
        EXPECT_EQ(largest_error(read_beside_reference(closed)), 0) << closed;
}

class AngleSamplerOf : public testing::TestWithParam<const char*> {
  protected:
    const PhaseFunction phase_function = read_beside_reference(GetParam());
    const PhaseValues phase{phase_function};
    const AngleSampler sampler{phase};
    Random random{7, 0, 0};

    struct Drawn {
        double cosine, weight;
    };
    Drawn draw() {
        const double bin_number = random();
        const auto [v, density] = sampler.sample(bin_number, random());
        EXPECT_NEAR(density, sampler.density(v), 1e-9 * density);
        return {1 - 2 * v, phase(1 - 2 * v) / density};
    }
};

TEST_P(AngleSamplerOf, KeepsTheMoments) {
    constexpr int count = 400'000;
    std::map<unsigned, Tally> tallies{{1, {}}, {2, {}}, {20, {}}, {100, {}}};
    for (int i = 0; i < count; ++i) {
        const auto [cosine, weight] = draw();
        for (auto& [order, tally] : tallies) tally.add(weight * std::legendre(order, cosine));
    }
    const std::vector<double> chi = phase_function.moments(101);
    for (const auto& [order, tally] : tallies) {
        const Estimate met = tally.estimate(count);
        EXPECT_NEAR(met.value, chi[order], 4 * met.standard_error) << order;
        EXPECT_LT(met.standard_error, 2e-3) << order;
    }
}

TEST_P(AngleSamplerOf, DrawsNearlyFromThePhaseFunction) {
    // Weights near 1: photons differ by where they go, not by what they weigh.
    Tally weights;
    constexpr int count = 100'000;
    for (int i = 0; i < count; ++i) weights.add(draw().weight);
    EXPECT_LT(weights.estimate(count).standard_error * std::sqrt(count), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Phase, AngleSamplerOf,
                         testing::Values(water_cloud, "isotropic", "rayleigh",
                                         "henyey_greenstein:g=0.95", "henyey_greenstein:g=0.999"),
                         [](const auto& row) { return "Row" + std::to_string(row.index); });

}  // namespace
}  // namespace stratus
