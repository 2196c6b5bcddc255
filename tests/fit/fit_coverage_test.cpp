#include "observed_rings.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

using test::Ring;

constexpr int rings = 20, noises_per_ring = 10;

/// Of 200 normal variates 95.45 % lie within two standard deviations; the count is outside these
/// limits in one run of a thousand (binomial).
constexpr int min_within = 181, max_within = 199;

double chi_square_of(const Ring& ring, const std::vector<Observation>& observed) {
    const double albedo = ring.w1 + ring.w2;
    const TableView mixed = test::ring_table().view().at_mixture(ring.w1 / albedo);
    double sum = 0;
    for (const Observation& view : observed)
        sum += std::pow(
            (brightness(mixed, albedo, ring.optical_depth, view) - view.brightness) / view.sigma,
            2);
    return sum;
}

TEST(Fit, StandardDeviationsHaveNominalCoverage) {
    std::mt19937 random(1982);
    std::uniform_real_distribution<double> uniform(0, 1);
    int w1 = 0, w2 = 0, depth = 0;
    double chi_square = 0;
    for (int r = 0; r < rings; ++r) {
        const double albedo = 0.4 + 0.55 * uniform(random), share = 0.15 + 0.7 * uniform(random);
        const Ring ring{albedo * share, albedo * (1 - share), 0.1 * std::pow(20, uniform(random))};
        std::vector<Observation> views = test::views(true);
        test::solve_views(ring, views);
        for (int n = 0; n < noises_per_ring; ++n) {
            const std::vector<Observation> observed = test::with_noise(views, random);
            const Fit fit = fit_layer(test::ring_table().view(), observed);
            const auto is_within = [](const Estimate& found, double truth) {
                return std::abs(found.value - truth) <= 2 * found.sigma;
            };
            w1 += is_within(fit.w1, ring.w1);
            w2 += is_within(fit.w2, ring.w2);
            depth += is_within(fit.optical_depth, ring.optical_depth);
            chi_square += fit.chi_square / fit.degrees_of_freedom;
            EXPECT_LE(fit.chi_square, chi_square_of(ring, observed));  // not a local minimum
            EXPECT_TRUE(fit.remarks.empty()) << fit.remarks.front();
        }
    }
    for (const int count : {w1, w2, depth}) {
        EXPECT_GE(count, min_within);
        EXPECT_LE(count, max_within);
    }
    // of 9000 degrees of freedom, to five standard deviations
    EXPECT_NEAR(chi_square / (rings * noises_per_ring), 1, 5 * std::sqrt(2.0 / 9000));
}

}  // namespace
}  // namespace stratus
