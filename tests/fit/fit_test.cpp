#include <stratus/fit/fit.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/constants.h>

#include "observed_rings.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace stratus {
namespace {

using test::Ring;
using test::ring_table;

std::vector<Observation> seen(const Ring& ring, std::vector<Observation> views) {
    test::solve_views(ring, views);
    return views;
}

Fit fit_of(const Ring& ring, const std::vector<Observation>& views) {
    return fit_layer(ring_table().view(), seen(ring, views));
}

/// The remark that begins so; empty when there is none.
std::string remark(const Fit& fit, const std::string& beginning) {
    const auto found = std::ranges::find_if(
        fit.remarks, [&](const std::string& text) { return text.starts_with(beginning); });
    return found == fit.remarks.end() ? "" : *found;
}

TEST(Fit, RecoversTheLayerWithoutNoise) {
    for (const Ring& ring : {Ring{0.5, 0.3, 0.7}, Ring{0.1, 0.4, 0.1}, Ring{0.8, 0.15, 1.8}}) {
        const Fit fit = fit_of(ring, test::views(true));
        constexpr double table_error = 2e-3;  // usually a tenth of it
        EXPECT_NEAR(fit.w1().value, ring.w1, table_error);
        EXPECT_NEAR(fit.w2().value, ring.w2, table_error);
        EXPECT_NEAR(fit.optical_depth().value, ring.optical_depth,
                    table_error * ring.optical_depth);
        EXPECT_LT(fit.chi_square, 1);
        EXPECT_EQ(fit.degrees_of_freedom, 45);
        EXPECT_TRUE(fit.remarks.empty()) << fit.remarks.front();
    }
}

TEST(Fit, RecoversTheLayerFromThreeToFiveObservationsOrRemarks) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    int others = 0;
    for (int n = 0; n < 80; ++n) {
        const double albedo = 0.3 + 0.65 * uniform(random), share = uniform(random);
        const Ring ring{albedo * share, albedo * (1 - share), 0.1 * std::pow(40, uniform(random))};
        std::vector<Observation> views;
        for (int i = 0; i < 3 + n % 3; ++i) {
            const double mu_in = 0.1 + 0.8 * uniform(random), mu_out = 0.1 + 0.9 * uniform(random);
            const double azimuth = pi * uniform(random);
            views.push_back(
                {{mu_in, mu_out, azimuth},
                 n % 2 == 1 && uniform(random) < 0.5 ? Light::transmitted : Light::reflected,
                 0,
                 0});
        }
        const Fit fit = fit_of(ring, views);
        EXPECT_LT(fit.chi_square, 0.5) << n;  // the true layer's is the error of the table
        const bool found =
            std::abs(fit.w1().value - ring.w1) < 0.02 &&
            std::abs(fit.w2().value - ring.w2) < 0.02 &&
            std::abs(std::log(fit.optical_depth().value / ring.optical_depth)) < 0.05;
        EXPECT_TRUE(found || !fit.remarks.empty()) << n;
        others += remark(fit, "w1 = ").ends_with("fits as well") ? 1 : 0;
    }
    EXPECT_GE(others, 1);
    EXPECT_LE(others, 10);
}

TEST(Fit, ErrorsFallAsTheRootOfTheNumberOfObservations) {
    const std::vector<Observation> once = seen({0.5, 0.3, 0.7}, test::views(true));
    std::vector<Observation> four_times;
    for (int n = 0; n < 4; ++n) four_times.insert(four_times.end(), once.begin(), once.end());
    const Fit a = fit_layer(ring_table().view(), once);
    const Fit b = fit_layer(ring_table().view(), four_times);
    EXPECT_NEAR(b.w1().sigma, a.w1().sigma / 2, 1e-3 * a.w1().sigma);
    EXPECT_NEAR(b.optical_depth().sigma, a.optical_depth().sigma / 2,
                1e-3 * a.optical_depth().sigma);
}

TEST(Fit, RemarksThatTheLitSideOfADeepLayerLeavesItsDepthOpen) {
    const Ring ring{0.5, 0.2, 6};
    const Fit fit = fit_of(ring, test::views(false));
    const std::string text =
        remark(fit, "optical_depth not determined by these geometries (above ");
    ASSERT_NE(text, "") << fit.remarks.size();
    const double limit = std::stod(text.substr(text.find("above ") + 6));
    EXPECT_GT(limit, 1);  // the light that depth 1 transmits would be missing
    EXPECT_LT(limit, ring.optical_depth);
    EXPECT_NEAR(fit.w1().value, ring.w1, 2 * fit.w1().sigma);  // still determined
    EXPECT_LT(fit.w1().sigma, 0.02);
    EXPECT_EQ(remark(fit_of({0.5, 0.2, 6}, test::views(true)), "optical_depth"), "");
}

TEST(Fit, RemarksThatOneScatteringAngleDoesNotSeparateTwoAlbedos) {
    std::vector<Observation> views;
    for (const double mu : {0.2, 0.35, 0.5}) {
        const double cos_azimuth = (0.25 + mu * mu) / (1 - mu * mu);
        views.push_back({{mu, mu, std::acos(cos_azimuth)}, Light::reflected, 0, 0});
        ASSERT_NEAR(cos_scattering_angle_reflected(views.back().geometry), 0.25, 1e-12);
    }
    const Fit fit = fit_of({0.3, 0.3, 0.1}, views);
    EXPECT_NE(remark(fit, "w1 and w2 not determined by these geometries"), "");
}

TEST(Fit, RemarksThatDepthAndAlbedoOfAThinLayerAreDegenerate) {
    std::vector<Observation> views;
    for (const double azimuth : {0.1, 1.5, 3.0})
        for (const double mu_out : {0.8, 0.9, 1.0})
            views.push_back({{0.9, mu_out, azimuth}, Light::reflected, 0, 0});
    const Fit fit = fit_of({0.3, 0.3, 0.06}, views);
    EXPECT_NE(remark(fit, "optical_depth not determined by these geometries"), "");
}

TEST(Fit, RemarksOnTheEdgeOfARange) {
    std::vector<Observation> views = seen({0.6, 0.4, 1}, test::views(true));
    for (Observation& view : views)
        view.brightness *= view.light == Light::transmitted ? 1 : 1.1;  // brighter than any layer
    const Fit fit = fit_layer(ring_table().view(), views);
    EXPECT_NE(remark(fit, "w1 + w2 at the edge of its range (1)"), "");
    EXPECT_GT(fit.chi_square, fit.degrees_of_freedom);
    const Fit pure = fit_of({0.7, 0, 1}, test::views(true));
    EXPECT_NEAR(pure.w2().value, 0, 1e-3);
}

TEST(Fit, IsReproducibleToTheBit) {
    const std::vector<Observation> views = seen({0.5, 0.3, 0.7}, test::views(true));
    const Fit a = fit_layer(ring_table().view(), views), b = fit_layer(ring_table().view(), views);
    EXPECT_EQ(a.w1().value, b.w1().value);
    EXPECT_EQ(a.optical_depth().sigma, b.optical_depth().sigma);
}

void expect_fit_refusal(const std::function<void(std::vector<Observation>&)>& change,
                        const std::vector<const char*>& fragments) {
    std::vector<Observation> views = test::views(true);
    for (Observation& view : views) view.brightness = view.sigma = 0.1;
    change(views);
    expect_refusal<std::invalid_argument>([&] { fit_layer(ring_table().view(), views); },
                                          fragments);
}

TEST(Fit, RefusesObservationsOutOfRange) {
    using Views = std::vector<Observation>;
    expect_fit_refusal([](Views& v) { v.resize(2); }, {"fit_layer", "observations", "three", "2"});
    expect_fit_refusal([](Views& v) { v[3].geometry.mu_in = 0; }, {"mu_in", "(0, 1]", "got 0"});
    expect_fit_refusal([](Views& v) { v[3].geometry.mu_out = 1.1; }, {"mu_out", "(0, 1]", "1.1"});
    expect_fit_refusal([&](Views& v) { v[3].geometry.azimuth = infinity; }, {"azimuth", "inf"});
    expect_fit_refusal([](Views& v) { v[3].brightness = std::nan(""); }, {"brightness", "nan"});
    expect_fit_refusal([](Views& v) { v[3].sigma = 0; }, {"sigma", "(0, inf)", "got 0"});
}

TEST(Fit, RefusesTablesWithoutTheSideOrAMixture) {
    std::vector<Observation> views = test::views(true);
    for (Observation& view : views) view.brightness = view.sigma = 0.1;
    Table lit = ring_table();
    lit.transmission_multiple.clear();
    expect_refusal<std::invalid_argument>([&] { fit_layer(lit.view(), views); },
                                          {"observed side", "holds", "transmission"});
    Recipe one = test::ring_recipe();
    one.mixture.reset();
    one.discretisation.mu_samples = one.discretisation.albedo_samples = 4;
    const Table plain = solve_table(one);
    expect_refusal<std::invalid_argument>([&] { fit_layer(plain.view(), views); },
                                          {"table", "mixture axis", "without"});
}

}  // namespace
}  // namespace stratus
