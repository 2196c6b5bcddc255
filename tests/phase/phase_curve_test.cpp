#include <stratus/phase/phase_curve.h>

#include "phase/kernels/phase_values.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

/// Through a light path straight up, whose scattering angle is what both vectors have between them.
double value_of(const PhaseCurve& curve, double angle) {
    const LightPath path{{1, 1},
                         {static_cast<float>(2 * std::pow(std::sin(angle / 2), 2)),
                          static_cast<float>(2 * std::pow(std::cos(angle / 2), 2))},
                         0};
    const PhaseCurveView view = curve.view();
    switch (curve.form()) {
        case PhaseForm::constant: return phase_value<PhaseForm::constant>(view, path);
        case PhaseForm::polynomial: return phase_value<PhaseForm::polynomial>(view, path);
        case PhaseForm::one_lobe: return phase_value<PhaseForm::one_lobe>(view, path);
        case PhaseForm::two_lobes: return phase_value<PhaseForm::two_lobes>(view, path);
        default: return phase_value<PhaseForm::sampled>(view, path);
    }
}

/// Largest relative difference from the function itself.
double largest_error(const char* text) {
    const PhaseFunction phase = parse_phase_function(text);
    const PhaseCurve curve(phase);
    double largest = 0;
    for (int i = 0; i <= 20000; ++i) {
        const double angle = 3.14159265358979 * i / 20000, expected = phase(std::cos(angle));
        largest = std::max(largest, std::abs(value_of(curve, angle) - expected) / expected);
    }
    return largest;
}

TEST(PhaseCurve, HasAClosedFormWhereAllTermsDo) {
    for (const char* const text : {"isotropic", "rayleigh", "anisotropic:x=-0.7",
                                   "henyey_greenstein:g=0.75", "henyey_greenstein:g=-0.6",
                                   "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5",
                                   "0.3*rayleigh + 0.2*isotropic + 0.5*henyey_greenstein:g=0.4"}) {
        EXPECT_EQ(PhaseCurve(parse_phase_function(text)).sample_count(), 0u) << text;
        EXPECT_LT(largest_error(text), 1e-6) << text;
    }
}

TEST(PhaseCurve, IsAccurateInSharpPeaks) {
    EXPECT_LT(largest_error("henyey_greenstein:g=0.99"), 2e-6);
    EXPECT_LT(largest_error("henyey_greenstein:g=-0.99"), 2e-6);
}

TEST(PhaseCurve, SamplesFunctionsWithoutClosedForm) {
    // Straight lines between samples are good to 1e-6; the Lambert sphere is 0 straight on.
    const char* const tabulated = "tabulated:points=0 3/20 2/60 1/120 0.5/180 0.8";
    EXPECT_GT(PhaseCurve(parse_phase_function(tabulated)).sample_count(), 0u);
    EXPECT_LT(largest_error(tabulated), 2e-6);
    EXPECT_LT(largest_error("moments:chi=1 0.5 0.2"), 2e-6);
    EXPECT_LT(largest_error("0.4*henyey_greenstein:g=0.9 + 0.3*henyey_greenstein:g=0.5 + "
                            "0.3*henyey_greenstein:g=-0.3"),
              2e-6);
    EXPECT_LT(largest_error("0.5*lambert_sphere + 0.5*isotropic"), 2e-6);
}

TEST(PhaseCurve, IsIsotropicByDefault) { EXPECT_EQ(value_of(PhaseCurve(), 1), 1); }

TEST(PhaseCurve, SamplesSeveralFunctionsSideBySide) {
    const PhaseCurve curve = PhaseCurve::sampled(2, [](double c, double* value) {
        value[0] = 2 + c;
        value[1] = 3 - c * c;
    });
    const LightPath path{{1, 1}, {0.25f, 1.75f}, 0};  // cos Theta = 0.75
    float value[2];
    sampled_values<2>(curve.view(), path, value);
    EXPECT_NEAR(value[0], 2.75, 1e-5);
    EXPECT_NEAR(value[1], 3 - 0.75 * 0.75, 1e-5);
}

}  // namespace
}  // namespace stratus
