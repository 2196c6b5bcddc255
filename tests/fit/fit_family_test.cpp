// Fits by tables of families: radii of droplets from spectra, asymmetries, and what is refused. The
// observed light is the solver's own, of droplets between the samples of the table.
#include <stratus/fit/fit.h>

#include "indices.h"
#include "observed_clouds.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

const Table& lobe_table() {
    static const Table table =
        solve_table(parse_recipe("phase_function = 'henyey_greenstein:g=0'\n"
                                 "tolerance = 2e-3\n"
                                 "optical_depth = { min = 0.25, max = 4 }\n"
                                 "albedo = { min = 0.8, max = 1.0 }\n"
                                 "[family]\n"
                                 "g = [0.2, 0.7]\n"
                                 "[discretisation]\n"
                                 "nodes = 16\n"
                                 "modes = 16\n"
                                 "mu_samples = 20\n"
                                 "azimuth_samples = 14\n"
                                 "optical_depth_samples_per_octave = 2\n"
                                 "albedo_samples = 5\n"
                                 "g_samples = 7\n"));
    return table;
}

bool has_remark(const Fit& fit, const std::string& text) {
    return std::ranges::any_of(fit.remarks, [&](const std::string& remark) {
        return remark.find(text) != std::string::npos;
    });
}

TEST(FitFamily, FindsTheRadiusBetweenSamplesFromASpectrum) {
    const auto model = table_model(droplet_table().view());
    for (const Cloud& cloud : {Cloud{1.3, 0.93, 0.27}, Cloud{0.6, 0.98, 0.43}}) {
        const Fit fit = fit_layer(*model, seen(cloud, cloud_views(true)));
        EXPECT_NEAR(fit.radius().value, cloud.radius, 2e-3 * cloud.radius);
        EXPECT_NEAR(fit.w1().value, cloud.w, 2e-3);
        EXPECT_NEAR(fit.optical_depth().value, cloud.optical_depth, 5e-3 * cloud.optical_depth);
        EXPECT_LT(fit.chi_square, 1);
        EXPECT_EQ(fit.degrees_of_freedom, 21);
        EXPECT_EQ(fit.estimate[fit_wavelength].sigma, 0);
        EXPECT_TRUE(fit.remarks.empty()) << fit.remarks.front();
    }
}

/// Droplets whose light swings with the logarithm of their radius, as glories and bows make it.
struct SwingingDroplets : LayerModel {
    static constexpr double swings[] = {3, 4.3, 7.1, 8.4, 10.7};

    int kinds() const override { return 1; }
    ParameterRanges ranges() const override { return {{1, 32}, {1, 1}, {1, 1}, {0, 0}}; }
    bool has(Light) const override { return true; }
    FamilyAxes family() const override {
        return {{PhaseParameter::radius, {AxisScale::logarithmic, {4, 32}}}};
    }
    std::vector<Scattered> scattered(const LayerParameters& layer,
                                     const Observations& observations) const override {
        std::vector<Scattered> values;
        for (const auto n : indices(observations)) {
            const double phase = swings[n] * std::log2(layer.radius);
            values.push_back({0, layer.optical_depth * (1 + 0.5 * std::sin(phase))});
        }
        return values;
    }
};

TEST(FitFamily, FindsTheRadiusAmongManyValleys) {
    const SwingingDroplets model;
    for (const double radius : {4.3, 6.1, 9.7, 14.2, 21.5, 28.0, 30.9}) {
        LayerParameters layer;
        layer.optical_depth = 3.3;
        layer.w1 = 1;
        layer.radius = radius;
        std::vector<Observation> observations(5, {{1, 1, 0}});
        const std::vector<double> brightness = model.brightness(layer, observations);
        for (const auto n : indices(observations)) {
            observations[n].brightness = brightness[n];
            observations[n].sigma = 3e-3 * brightness[n];
        }
        EXPECT_NEAR(fit_layer(model, observations).radius().value, radius, 1e-3 * radius);
    }
}

// T. Nakajima and M. D. King, J. Atmos. Sci. 47, 1990: depth and radius from two wavelengths alone.
TEST(FitFamily, TwoWavelengthsGiveDepthAndRadius) {
    const Cloud cloud{1.2, 0.95, 0.31};
    std::vector<Observation> two;
    for (const double wavelength : wavelengths)
        two.push_back({{0.7, 0.8, 1.6}, Light::reflected, 0, 0, {NAN, wavelength}});
    FitOptions options;
    options.w1 = cloud.w;
    const Fit fit = fit_layer(droplet_table().view(), seen(cloud, two), options);
    EXPECT_EQ(fit.degrees_of_freedom, 0);
    EXPECT_LT(fit.chi_square, 1e-6);
    EXPECT_NEAR(fit.radius().value, cloud.radius, 5e-3 * cloud.radius);
    EXPECT_NEAR(fit.optical_depth().value, cloud.optical_depth, 5e-3 * cloud.optical_depth);
    EXPECT_GT(fit.radius().sigma, 0);
}

TEST(FitFamily, HoldsRadiusAndWavelength) {
    const Cloud cloud{1, 0.95, 0.3};
    std::vector<Observation> one = cloud_views(false);
    solve_views(droplets(cloud.radius, 0.65), cloud.w, cloud.optical_depth, one);
    FitOptions options;
    options.radius = 0.3;
    options.wavelength = 0.65;
    const Fit held = fit_layer(droplet_table().view(), one, options);
    EXPECT_EQ(held.radius().value, 0.3);
    EXPECT_EQ(held.radius().sigma, 0);
    EXPECT_NEAR(held.w1().value, cloud.w, 2e-3);
    EXPECT_EQ(held.degrees_of_freedom, 22);
    options.radius = 0.4;
    EXPECT_TRUE(has_remark(fit_layer(droplet_table().view(), one, options), "refused"));
}

TEST(FitFamily, FindsAsymmetriesOfATable) {
    const auto model = table_model(lobe_table().view());
    const Cloud cloud{1.4, 0.94, 0};
    constexpr double g = 0.47;  // between samples
    std::vector<Observation> observed = cloud_views(false);
    solve_views(PhaseFunction::henyey_greenstein(g), cloud.w, cloud.optical_depth, observed);
    FitOptions options;
    EXPECT_EQ(free_parameter_count(*model, observed, options), 3u);
    options.free_g1 = true;  // as of other models
    const Fit fit = fit_layer(*model, observed, options);
    EXPECT_NEAR(fit.g1().value, g, 2e-3);
    EXPECT_NEAR(fit.w1().value, cloud.w, 2e-3);
    EXPECT_NEAR(fit.optical_depth().value, cloud.optical_depth, 5e-3 * cloud.optical_depth);
    EXPECT_TRUE(fit.remarks.empty()) << fit.remarks.front();

    const auto slow = solver_model(PhaseFunction::henyey_greenstein(0.3), std::nullopt, 16);
    const Fit solved = fit_layer(*slow, observed, options);
    EXPECT_NEAR(fit.g1().value, solved.g1().value, 2e-3);
    EXPECT_NEAR(fit.g1().sigma, solved.g1().sigma, 0.02 * solved.g1().sigma);
    EXPECT_NEAR(fit.covariance[fit_w1][fit_g1], solved.covariance[fit_w1][fit_g1],
                0.02 * fit.w1().sigma * fit.g1().sigma);
}

TEST(FitFamily, RemarksOnEdgesAndOnRadiiLeftOpen) {
    const Cloud small{1, 0.95, 0.15};  // smaller than any in the table
    EXPECT_TRUE(has_remark(fit_layer(droplet_table().view(), seen(small, cloud_views(true))),
                           "radius at the edge of its range (0.2)"));
    const Cloud cloud{1, 0.95, 0.3};
    std::vector<Observation> faint = seen(cloud, cloud_views(true));
    for (Observation& at : faint) at.sigma = at.brightness;
    EXPECT_TRUE(has_remark(fit_layer(droplet_table().view(), faint), "radius not determined"));
}

TEST(FitFamily, PredictsWhatLookupsOfTheMemberGive) {
    const auto model = table_model(droplet_table().view());
    std::vector<Observation> all = cloud_views(true);
    LayerParameters layer{1.1, 0.9};
    layer.radius = 0.3333;
    const std::vector<double> brightness = model->brightness(layer, all);
    for (const auto i : indices(all)) {
        const TableView view = droplet_table().view().at({layer.radius, all[i].known[1]});
        const auto look_up = all[i].light == Light::reflected ? reflection : transmission;
        const double expected =
            all[i].geometry.mu_in *
            look_up(view, layer.w1, layer.optical_depth, all[i].geometry).total();
        EXPECT_NEAR(brightness[i], expected, 2e-4 * expected) << i;
    }
}

void expect_family_refusal(const Table& table, const FitOptions& options,
                           const std::vector<Observation>& observed, const Fragments& fragments) {
    expect_refusal([&] { fit_layer(table.view(), observed, options); }, fragments);
}

TEST(FitFamily, RefusesWhatTheFamilyDoesNotHold) {
    std::vector<Observation> spectrum = cloud_views(true), plain = cloud_views(false);
    for (auto* const all : {&spectrum, &plain})
        for (Observation& at : *all) at.brightness = at.sigma = 0.1;
    const Table &drops = droplet_table(), &lobes = lobe_table();
    expect_family_refusal(drops, {}, plain,
                          {"wavelength must be held or known of the observations",
                           "one of 0.45, 0.65 um of the table", "got neither"});
    expect_family_refusal(drops, {.wavelength = 0.5}, plain,
                          "wavelength held must be one of 0.45, 0.65 um of the table, got 0.5");
    expect_family_refusal(drops, {.wavelength = 0.5}, spectrum,
                          "wavelength must be either held or known of the observations, got both");
    expect_family_refusal(drops, {.radius = 0.6}, spectrum,
                          "radius held must be in [0.2, 0.5] um of the table, got 0.6");
    expect_family_refusal(lobes, {.radius = 0.6}, plain,
                          "radius must be left out unless a table's family varies it, got 0.6");
    expect_family_refusal(drops, {.g1 = 0.5}, spectrum, {"g", "Henyey-Greenstein", "0.5"});
    expect_family_refusal(lobes, {.g1 = 0.8}, plain,
                          "g held must be in [0.2, 0.7] of the table, got 0.8");
    spectrum.front().known[1] = 0.5;
    expect_family_refusal(drops, {}, spectrum,
                          "wavelength must be one of 0.45, 0.65 um of the table, got 0.5");
    spectrum.front().known = {};
    expect_family_refusal(drops, {}, spectrum,
                          "wavelength must be known of all 24 observations, or of none, got 23");
    expect_family_refusal(lobes, {}, spectrum, {"values known of an observation", "1", "got 2"});
}

}  // namespace
}  // namespace stratus::test
