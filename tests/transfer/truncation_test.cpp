#include <stratus/transfer/truncation.h>

#include <stratus/transfer/solve.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace stratus {
namespace {

const PhaseFunction truncated_peak = PhaseFunction::henyey_greenstein(0.9);

TEST(TruncatePeak, TruncatesALateMomentAndKeepsTheLowerHalf) {
    const Truncation truncation = truncate_peak(truncated_peak, 16);
    EXPECT_DOUBLE_EQ(truncation.fraction, std::pow(0.9, 14));
    EXPECT_TRUE(truncation.narrow);
    ASSERT_EQ(truncation.moments.size(), 16u);
    EXPECT_EQ(truncation.moments[0], 1);
    for (std::size_t l = 0; l < 7; ++l)  // chi = f + (1 - f) chi*
        EXPECT_NEAR(truncation.fraction + (1 - truncation.fraction) * truncation.moments[l],
                    std::pow(0.9, l), 1e-15);
}

TEST(TruncatePeak, LeavesMomentsThatDecaySmoothly) {
    const int L = 64;
    std::vector<double> moments = truncate_peak(truncated_peak, L).moments;
    moments.push_back(0);  // beyond L
    moments.push_back(0);
    for (std::size_t l = 0; l < L; ++l) {
        EXPECT_GE(moments[l], 0);
        EXPECT_GT(moments[l], moments[l + 1]) << l;
        EXPECT_GE(moments[l] - 2 * moments[l + 1] + moments[l + 2], -1e-15) << l;  // no kink
    }
}

TEST(TruncatePeak, KeepsAbsorptionAndTheSimilarityOfDepths) {
    const Truncation truncation = truncate_peak(truncated_peak, 16);
    for (const double w : {0.0, 0.3, 0.9, 1 - 1e-9, 1.0}) {
        const double tau = 3, scaled = truncation.optical_depth(tau, w);
        EXPECT_NEAR((1 - truncation.albedo(w)) * scaled, (1 - w) * tau, 1e-14);
        EXPECT_NEAR(truncation.albedo(w) * scaled, (1 - truncation.fraction) * w * tau, 1e-14);
        // transport depth: (1 - w g) tau
        EXPECT_NEAR((1 - truncation.albedo(w) * truncation.moments[1]) * scaled,
                    (1 - w * 0.9) * tau, 1e-14);
        EXPECT_NEAR(truncation.single_scattering_albedo(w) * (1 - truncation.fraction),
                    truncation.albedo(w), 1e-15);
        EXPECT_NEAR(truncation.co_albedo(w), 1 - truncation.albedo(w), 1e-15);
    }
}

TEST(TruncatePeak, KeepsConservationExact) {
    const Truncation truncation = truncate_peak(truncated_peak, 16);
    EXPECT_EQ(truncation.albedo(1), 1);
    EXPECT_EQ(truncation.co_albedo(1), 0);
    // 1 - w* from 1 - w, not as a difference from 1
    EXPECT_NEAR(truncation.co_albedo(1 - 1e-12) * (1 - truncation.fraction) / 1e-12, 1, 1e-3);
}

TEST(TruncatePeak, EndsTheSeriesOfABackwardPeakSmoothly) {
    const PhaseFunction backward = PhaseFunction::henyey_greenstein(-0.9);
    const Truncation truncation = truncate_peak(backward, 20);
    EXPECT_TRUE(truncation.backward);
    EXPECT_EQ(truncation.fraction, 0);
    const std::vector<double> moments = backward.moments(20);
    for (std::size_t l = 0; l < 20; ++l) {
        const double kept = truncation.moments[l] / moments[l];
        if (l <= 8)
            EXPECT_EQ(kept, 1) << l;
        else
            EXPECT_LT(kept, truncation.moments[l - 1] / moments[l - 1]) << l;
    }
    EXPECT_LT(std::abs(truncation.moments[19]), 0.01 * std::abs(moments[19]));
}

TEST(TruncatePeak, IsTheIdentityForSmoothPhaseFunctionsAndWideBackwardPeaks) {
    for (const PhaseFunction& phase_function :
         {PhaseFunction::isotropic(), PhaseFunction::rayleigh(),
          PhaseFunction::henyey_greenstein(0.1), PhaseFunction::henyey_greenstein(-0.5)}) {
        const int count = 16;  // chi_16 of the backward peak is positive, chi_17 is not
        const Truncation truncation = truncate_peak(phase_function, count);
        EXPECT_EQ(truncation.fraction, 0);
        EXPECT_EQ(truncation.moments, phase_function.moments(count));
        EXPECT_EQ(truncation.optical_depth(3, 0.7), 3);
        EXPECT_EQ(truncation.albedo(0.7), 0.7);
        EXPECT_EQ(truncation.single_scattering_albedo(0.7), 0.7);
    }
}

TEST(SolveLayer, RefusesAnUnresolvedBackwardPeak) {
    expect_refusal<std::runtime_error>(
        [] { solve_layer(PhaseFunction::henyey_greenstein(-0.99), 0.9, 2, {}, with_nodes(8)); },
        "nodes must be more");
}

TEST(NoTruncation, KeepsMomentsUnchanged) {
    const Truncation truncation = no_truncation(truncated_peak, 16);
    EXPECT_EQ(truncation.fraction, 0);
    EXPECT_EQ(truncation.moments, truncated_peak.moments(16));
}

}  // namespace
}  // namespace stratus
