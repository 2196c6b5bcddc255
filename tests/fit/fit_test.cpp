#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/fit/fit.h>

#include "indices.h"
#include "least_squares.h"
#include "observed_rings.h"
#include "refusal.h"
#include "uniform.h"

#include <boost/math/special_functions/gamma.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace stratus::test {
namespace {

std::vector<Observation> seen_ring(const Ring& ring, std::vector<Observation> views) {
    solve_views(ring, views);
    return views;
}

Fit fit_of(const Ring& ring, const std::vector<Observation>& views) {
    return fit_layer(ring_table().view(), seen_ring(ring, views));
}

/// The remark that begins so; empty when there is none.
std::string remark(const Fit& fit, const std::string& beginning) {
    const auto found = std::ranges::find_if(
        fit.remarks, [&](const std::string& text) { return text.starts_with(beginning); });
    return found == fit.remarks.end() ? "" : *found;
}

TEST(Fit, RecoversTheLayerWithoutNoise) {
    for (const Ring& ring : {Ring{0.5, 0.3, 0.7}, Ring{0.1, 0.4, 0.1}, Ring{0.8, 0.15, 1.8}}) {
        const Fit fit = fit_of(ring, views(true));
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
    Uniform uniform(5);
    int others = 0;
    for (int n = 0; n < 80; ++n) {
        const double albedo = 0.3 + 0.65 * uniform(), share = uniform();
        const Ring ring{albedo * share, albedo * (1 - share), 0.1 * std::pow(40, uniform())};
        std::vector<Observation> views;
        for (int i = 0; i < 3 + n % 3; ++i) {
            const double mu_in = 0.1 + 0.8 * uniform(), mu_out = 0.1 + 0.9 * uniform();
            const double azimuth = pi * uniform();
            views.push_back({{mu_in, mu_out, azimuth},
                             n % 2 == 1 && uniform() < 0.5 ? Light::transmitted : Light::reflected,
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
    const std::vector<Observation> once = seen_ring({0.5, 0.3, 0.7}, views(true));
    std::vector<Observation> four_times;
    for (int n = 0; n < 4; ++n) four_times.insert(four_times.end(), once.begin(), once.end());
    const Fit a = fit_layer(ring_table().view(), once);
    const Fit b = fit_layer(ring_table().view(), four_times);
    EXPECT_NEAR(b.w1().sigma, a.w1().sigma / 2, 1e-3 * a.w1().sigma);
    EXPECT_NEAR(b.optical_depth().sigma, a.optical_depth().sigma / 2,
                1e-3 * a.optical_depth().sigma);
}

TEST(Fit, TellsWhatTheModelMakesOfEachObservation) {
    std::vector<Observation> seen = seen_ring({0.5, 0.3, 0.7}, views(true));
    for (const auto i : indices(seen))
        seen[i].brightness += (i % 3 == 0 ? 1.5 : -0.5) * seen[i].sigma;
    const Fit fit = fit_layer(ring_table().view(), seen);
    ASSERT_EQ(fit.brightness.size(), seen.size());
    const LayerParameters layer{fit.optical_depth().value, fit.w1().value, fit.w2().value};
    const std::vector<double> model = table_model(ring_table().view())->brightness(layer, seen);
    double chi_square = 0;
    for (const auto i : indices(seen)) {
        EXPECT_NEAR(fit.brightness[i], model[i], 1e-12);
        chi_square += std::pow((seen[i].brightness - fit.brightness[i]) / seen[i].sigma, 2);
    }
    EXPECT_NEAR(fit.chi_square, chi_square, 1e-9 * chi_square);
    EXPECT_NEAR(fit.correlation(fit_w1, fit_w1), 1, 1e-14);
    EXPECT_NEAR(fit.correlation(fit_w1, fit_w2) * fit.w1().sigma * fit.w2().sigma,
                fit.covariance[fit_w1][fit_w2], 1e-14);
    EXPECT_EQ(fit.correlation(fit_w1, fit_g1), 0);  // which was held
}

TEST(Fit, RemarksThatTheLitSideOfADeepLayerLeavesItsDepthOpen) {
    const Ring ring{0.5, 0.2, 6};
    const Fit fit = fit_of(ring, views(false));
    const std::string text =
        remark(fit, "optical_depth not determined by these geometries (above ");
    ASSERT_NE(text, "") << fit.remarks.size();
    const double limit = std::stod(text.substr(text.find("above ") + 6));
    EXPECT_GT(limit, 1);  // the light that depth 1 transmits would be missing
    EXPECT_LT(limit, ring.optical_depth);
    EXPECT_NEAR(fit.w1().value, ring.w1, 2 * fit.w1().sigma);  // still determined
    EXPECT_LT(fit.w1().sigma, 0.02);
    EXPECT_EQ(remark(fit_of({0.5, 0.2, 6}, views(true)), "optical_depth"), "");
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

// Only w tau is known of it, whose spread about a small w is far less than the values w may have.
TEST(Fit, RemarksThatTheAlbedoOfAThinLayerIsOpenHoweverSmallItsDeviation) {
    const auto model = single_scattering_model(PhaseFunction::henyey_greenstein(0.4), std::nullopt);
    const std::vector<Observation> directions{{{0.3, 0.5, 0.5}, Light::reflected, 0, 1},
                                              {{0.9, 0.4, 2}, Light::reflected, 0, 1},
                                              {{0.5, 0.8, 1}, Light::transmitted, 0, 1},
                                              {{0.7, 0.3, 3}, Light::transmitted, 0, 1}};
    const auto seen = [&](const LayerParameters& layer, double noise) {
        std::vector<Observation> observed = directions;
        const std::vector<double> brightness = model->brightness(layer, observed);
        for (const auto i : indices(observed)) {
            observed[i].brightness = brightness[i];
            observed[i].sigma = noise * brightness[i];
        }
        return observed;
    };
    const LayerParameters thin{0.01, 0.06, 0, 0.4};
    const Fit open = fit_layer(*model, seen(thin, 0.007));
    EXPECT_NEAR(open.w1().value, 0.06, 0.01);
    EXPECT_LT(open.w1().sigma, 0.1);
    EXPECT_NE(remark(open, "w not determined by these geometries"), "");
    const Fit known = fit_layer(*model, seen(thin, 0.001));
    EXPECT_TRUE(known.remarks.empty()) << known.remarks.front();
}

TEST(Fit, RemarksOnTheEdgeOfARange) {
    std::vector<Observation> views = seen_ring({0.6, 0.4, 1}, test::views(true));
    for (Observation& view : views)
        view.brightness *= view.light == Light::transmitted ? 1 : 1.1;  // brighter than any layer
    const Fit fit = fit_layer(ring_table().view(), views);
    EXPECT_NE(remark(fit, "w1 + w2 at the edge of its range (1)"), "");
    EXPECT_GT(fit.chi_square, fit.degrees_of_freedom);
    const Fit pure = fit_of({0.7, 0, 1}, test::views(true));
    EXPECT_NEAR(pure.w2().value, 0, 1e-3);
}

/// A table of depths from 1 on; `more`: of its recipe.
Table deep_table(const std::string& deepest, const std::string& more = "") {
    return solve_table(
        parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                     "tolerance = 5e-3\n"
                     "optical_depth = { min = 1, max = " +
                     deepest + " }\nalbedo = { min = 0.3, max = 1 }\n" + more +
                     "[discretisation]\nnodes = 12\nmodes = 8\nmu_samples = 16\n"
                     "azimuth_samples = 8\nalbedo_samples = 6\n"));
}

TEST(Fit, RemarksOnTheErrorOfLayersThinnerThanTheTable) {
    const Table table = deep_table("8", "[below]\nlambert_albedo = 0.5\n");
    const auto model = table_model(table.view());
    std::vector<Observation> views = test::views(false);
    const auto remark_at = [&](double depth, double noise, double density = 0) {
        set_brightness(views, model->brightness({depth, 0.7, 0}, views, density), noise);
        return remark(fit_layer(*model, views, {.optical_depth = depth, .density = density}),
                      "the error of extrapolating the table to so thin a layer reaches ");
    };
    expect_holds(remark_at(0.1, 0.01), " standard deviations of an observation");
    EXPECT_EQ(remark_at(1, 0.01), "");
    EXPECT_EQ(remark_at(0.9, 0.01, 0.1), "");
    EXPECT_EQ(remark_at(0.1, 10), "");  // far below the noise
}

TEST(Fit, OccultationsAloneDetermineTheDepth) {
    constexpr double mu = 0.4, seen = 0.3, sigma = 0.01;
    const std::vector<Observation> star{{{1, mu, 0}, Light::beam, seen, sigma}};
    for (const double density : {0.0, 0.2}) {
        const Fit fit = fit_layer(*beam_model(), star, {.density = density});
        const double expected = -mu * std::log(seen) * (1 - density);
        EXPECT_NEAR(fit.optical_depth().value, expected, 1e-6 * expected);
        const double expected_sigma = mu * sigma / seen * (1 - density);
        EXPECT_NEAR(fit.optical_depth().sigma, expected_sigma, 1e-3 * expected_sigma);
        EXPECT_EQ(fit.degrees_of_freedom, 0);
        EXPECT_NEAR(fit.probability, 1, 1e-6);
        EXPECT_TRUE(fit.remarks.empty()) << fit.remarks.front();
    }
}

TEST(Fit, OccultationsGiveTheDepthThatTheLitSideLeavesOpen) {
    const Ring ring{0.5, 0.2, 6};
    const Fit fit = fit_of(ring, lit_views_and_occultations());
    EXPECT_EQ(remark(fit, "optical_depth"), "");
    EXPECT_NEAR(fit.optical_depth().value, ring.optical_depth, 2e-3);
    EXPECT_LT(fit.optical_depth().sigma, 0.005);  // 1 % at mu = 0.25 is 0.0025
}

TEST(Fit, HoldingAParameterAtItsBestFitConditionsTheCovariance) {
    const std::vector<Observation> views = seen_ring({0.5, 0.3, 0.7}, test::views(true));
    const Fit all = fit_layer(ring_table().view(), views);
    struct Held {
        FitOptions options;
        int parameter;
    };
    for (const auto& [options, h] :
         {Held{{.optical_depth = all.optical_depth().value}, fit_optical_depth},
          Held{{.w1 = all.w1().value}, fit_w1}, Held{{.w2 = all.w2().value}, fit_w2}}) {
        const auto held = static_cast<std::size_t>(h);
        const Fit fit = fit_layer(ring_table().view(), views, options);
        EXPECT_EQ(fit.degrees_of_freedom, all.degrees_of_freedom + 1);
        EXPECT_EQ(fit.estimate[held].value, all.estimate[held].value);
        for (std::size_t p = 0; p < 3; ++p) {
            EXPECT_NEAR(fit.estimate[p].value, all.estimate[p].value, 1e-5);
            for (std::size_t q = 0; q < 3; ++q) {
                // the covariance of a normal distribution, given one of its variates
                const double expected = all.covariance[p][q] - all.covariance[p][held] *
                                                                   all.covariance[held][q] /
                                                                   all.covariance[held][held];
                const double scale = all.estimate[p].sigma * all.estimate[q].sigma;
                EXPECT_NEAR(fit.covariance[p][q], expected, 1e-3 * scale);
            }
        }
    }
}

TEST(Fit, HoldsAllParametersAndJudgesThem) {
    const std::vector<Observation> views = seen_ring({0.5, 0.3, 0.7}, test::views(true));
    const Fit right =
        fit_layer(ring_table().view(), views, {.optical_depth = 0.7, .w1 = 0.5, .w2 = 0.3});
    EXPECT_EQ(right.degrees_of_freedom, 48);
    EXPECT_LT(right.chi_square, 1);
    EXPECT_TRUE(right.remarks.empty());
    const Fit wrong =
        fit_layer(ring_table().view(), views, {.optical_depth = 0.8, .w1 = 0.5, .w2 = 0.3});
    EXPECT_LT(wrong.probability, 1e-6);
    EXPECT_NE(remark(wrong, "refused: chi_square "), "");
}

TEST(Fit, RemarksThatChiSquareRefusesTheModel) {
    // Two stars, one through twice the depth of the other.
    const auto fit_to = [](double other) {
        const std::vector<Observation> stars{
            {{1, 0.5, 0}, Light::beam, std::exp(-1 / 0.5), 0.01},
            {{1, 0.5, 0}, Light::beam, std::exp(-1 / 0.5) + other, 0.01}};
        return fit_layer(*beam_model(), stars);
    };
    const Fit refused = fit_to(0.01 * std::sqrt(2.0 * 70));  // chi-square 70 for their mean
    EXPECT_NEAR(refused.chi_square, 70, 1e-3);
    EXPECT_EQ(remark(refused, "refused"),
              "refused: chi_square 70 for 1 degree of freedom (probability 5.9e-17)");
    EXPECT_TRUE(fit_to(0.01 * std::sqrt(2.0 * 10)).remarks.empty());   // probability 1.6e-3
    EXPECT_FALSE(fit_to(0.01 * std::sqrt(2.0 * 11)).remarks.empty());  // probability 0.9e-3
}

TEST(Fit, FindsAsymmetriesBySingleScattering) {
    const auto model = single_scattering_model(PhaseFunction::lambert_sphere(),
                                               PhaseFunction::henyey_greenstein(0.1));
    FitOptions options;
    options.free_g2 = true;
    for (const Ring& ring : {Ring{0.3, 0.4, 0.5, 0.6}, Ring{0.6, 0.2, 0.2, -0.5}}) {
        std::vector<Observation> views = test::views(true);
        solve_views(ring, views, {true});
        const Fit fit = fit_layer(*model, views, options);
        EXPECT_NEAR(fit.g2().value, ring.g2, 1e-5);
        EXPECT_NEAR(fit.w1().value, ring.w1, 1e-5);
        EXPECT_NEAR(fit.w2().value, ring.w2, 1e-5);
        EXPECT_NEAR(fit.optical_depth().value, ring.optical_depth, 1e-5);
    }
}

TEST(Fit, FindsAsymmetriesByTheSolver) {
    const auto model = solver_model(PhaseFunction::henyey_greenstein(-0.2), std::nullopt, 12);
    const double g = 0.35, w = 0.9, depth = 0.8;
    std::vector<Observation> views = test::views(true);
    set_brightness(views, model->brightness({depth, w, 0, g, 0}, views));
    const Fit fit = fit_layer(*model, views, {.free_g1 = true});
    EXPECT_NEAR(fit.g1().value, g, 1e-4);
    EXPECT_NEAR(fit.w1().value, w, 1e-4);
    EXPECT_NEAR(fit.optical_depth().value, depth, 1e-4);
    EXPECT_EQ(fit.w2().value, 0);
}

// What eight nodes say of a narrow lobe is wrong by more than the noise.
TEST(Fit, TakesAsManyNodesAsObservationsNeed) {
    const PhaseFunction lobe = PhaseFunction::henyey_greenstein(0.85);
    const double w = 0.95, depth = 2;
    std::vector<Observation> views = test::views(true);
    const std::vector<double> bright =
        solver_model(lobe, std::nullopt, 96)->brightness({depth, w, 0, 0.85, 0}, views);
    const auto model = solver_model(lobe, std::nullopt, 8);
    const auto fitted = [&](double noise, const FitOptions& options) {
        set_brightness(views, bright, noise);
        return fit_layer(*model, views, options);
    };
    const Fit fit = fitted(1e-3, {});
    EXPECT_GT(model->error({depth, w, 0, 0.85, 0}, views), 1);
    EXPECT_NEAR(fit.w1().value, w, 0.1 * fit.w1().sigma);
    EXPECT_NEAR(fit.optical_depth().value, depth, 0.1 * fit.optical_depth().sigma);
    EXPECT_TRUE(fit.remarks.empty());
    const std::vector<std::string> remarks =
        fitted(1e-13, {.optical_depth = depth, .w1 = w}).remarks;
    ASSERT_FALSE(remarks.empty());
    expect_holds(remarks.back(), "the solver's error reaches");
}

// Slices, which pictures are made of, take density and opposition on another way.
TEST(LayerModel, SeesDensityAndOppositionAsSlicesDo) {
    const Ring ring{0.5, 0.3, 0.7};
    Effects effects;
    effects.density = 0.15;
    effects.opposition = Opposition::hapke(0.7, 0.1);
    const TableView mixed = ring_table().view().at({ring.w1 / (ring.w1 + ring.w2)});
    const Slice slice = bind(mixed, ring.optical_depth, ring.w1 + ring.w2, effects);
    std::vector<Observation> views = test::views(true);
    views.push_back({{0.4, 0.45, pi}, Light::reflected, 0, 0});  // 3 degrees of phase angle
    views.push_back({{0.4, 0.4, 0}, Light::beam, 0, 0});
    const std::vector<double> brightness =
        table_model(ring_table().view())
            ->brightness({ring.optical_depth, ring.w1, ring.w2}, views, effects.density,
                         effects.opposition);
    for (const auto i : indices(views)) {
        const auto in = static_cast<float>(views[i].geometry.mu_in),
                   out = static_cast<float>(views[i].geometry.mu_out),
                   azimuth = static_cast<float>(views[i].geometry.azimuth);
        const double expected = views[i].light == Light::beam ? double{slice.direct(out)}
                                : views[i].light == Light::reflected
                                    ? in * double{slice.reflection(in, out, azimuth)}
                                    : in * double{slice.transmission(in, out, azimuth)};
        EXPECT_NEAR(brightness[i], expected, 2e-3 * expected) << i;  // the table's tolerance
    }
}

TEST(Fit, IsReproducibleToTheBit) {
    const std::vector<Observation> views = seen_ring({0.5, 0.3, 0.7}, test::views(true));
    const Fit a = fit_layer(ring_table().view(), views), b = fit_layer(ring_table().view(), views);
    EXPECT_EQ(a.w1().value, b.w1().value);
    EXPECT_EQ(a.optical_depth().sigma, b.optical_depth().sigma);
}

/// Views of some brightness, which is never fitted.
std::vector<Observation> bright_views() {
    std::vector<Observation> views = test::views(true);
    for (Observation& view : views) view.brightness = view.sigma = 0.1;
    return views;
}

void expect_refusal_by(const LayerModel& model, const std::vector<Observation>& views,
                       const FitOptions& options, const Fragments& fragments) {
    expect_refusal([&] { fit_layer(model, views, options); }, fragments);
}

TEST(Fit, RefusesObservationsOutOfRange) {
    using Views = std::vector<Observation>;
    const auto refused = [](void (*change)(Views&), const Fragments& fragments) {
        Views views = bright_views();
        change(views);
        expect_refusal_by(*table_model(ring_table().view()), views, {}, fragments);
    };
    refused([](Views& v) { v.resize(2); },
            "fit_layer: observations must be at least 3, one for each free parameter, got 2");
    refused([](Views& v) { v[3].geometry.mu_in = 0; }, {"mu_in", "(0, 1]", "got 0"});
    refused([](Views& v) { v[3].geometry.mu_out = 1.1; }, "mu_out must be in (0, 1], got 1.1");
    refused([](Views& v) { v[3].geometry.azimuth = infinity; }, "azimuth must be finite, got inf");
    refused([](Views& v) { v[3].brightness = NAN; }, "brightness must be finite, got nan");
    refused([](Views& v) { v[3].sigma = 0; }, "sigma must be in (0, inf), got 0");
    refused([](Views& v) { v[3].brightness = 1e308; },
            "brightness / sigma must be in [-1e100, 1e100], so that its square is a number");
    refused([](Views& v) { v[3].sigma = 1e-300; }, "sigma must be in [1e-100, 1e100]");
}

TEST(Fit, RefusesTablesWithoutSomeOfTheLight) {
    Table lit = ring_table();
    lit.transmission_multiple.clear();
    expect_refusal_by(*table_model(lit.view()), bright_views(), {},
                      "observed light must be such as the model knows, got transmitted");
    Table of_two_orders = ring_table();
    of_two_orders.highest_order = 2;
    expect_refusal([&] { table_model(of_two_orders.view()); },
                   "table must be of all orders of scattering, got orders up to 2");
}

TEST(Fit, RefusesOptionsOutOfRange) {
    const auto refused = [](const FitOptions& options, const Fragments& fragments) {
        expect_refusal_by(*table_model(ring_table().view()), bright_views(), options, fragments);
    };
    refused({.w1 = 1.1}, "fit_layer: w1 held must be in [0, 1], got 1.1");
    refused({.w2 = -0.1}, "w2 held must be in [0, 1], got -0.1");
    refused({.w1 = 0.03, .w2 = 0.03}, "w1 + w2 held must be in the model's [0.1, 1], got 0.06");
    refused({.w1 = 0.6, .w2 = 0.6}, "w1 + w2 held must be in the model's [0.1, 1], got 1.2");
    refused({.optical_depth = 9}, {"optical_depth held", ", 8]", "got 9"});
    refused({.optical_depth = -1}, {"optical_depth held", "got -1"});
    refused({.density = 1}, "density must be in [0, 1), got 1");
    refused({.opposition = {Opposition::Law::hapke, -1, 1}},
            "opposition.width must be in (0, inf), or 0 with a density above 0, got -1");
    refused({.free_g2 = true}, {"g2", "Henyey-Greenstein", "got free"});
    refused({.g1 = 0.5}, {"g1", "Henyey-Greenstein", "got 0.5"});
}

TEST(Fit, RefusesDirectionsOutsideATable) {
    const Table table = deep_table(
        "8", "mu_in = { min = 0.3, max = 0.7 }\nazimuth_deg = { min = 20, max = 130 }\n");
    const auto model = table_model(table.view());
    const auto seen = [](double mu_in, double azimuth, Light light = Light::reflected) {
        const std::vector<Observation> twice(2, {{mu_in, 0.5, azimuth}, light, 0.1, 0.1});
        return twice;
    };
    expect_refusal_by(*model, seen(0.95, 1), {}, "mu_in must be in [0.3, 0.7] of the table");
    expect_refusal_by(*model, seen(0.5, 3), {},
                      {"azimuth must be in [20, 130] degrees of the table, got 171.8"});
    EXPECT_NO_THROW(fit_layer(*model, seen(0.7, -1)));
    EXPECT_NO_THROW(fit_layer(*model, seen(0.95, 3, Light::beam)));
}

TEST(Fit, RefusesToHoldDepthsThatATableDoesNotKnow) {
    const Table single = deep_table("1"),
                ground = deep_table("8", "[below]\nground = 'rpv:rho0=0.1,k=0.7,theta=-0.2'\n");
    std::vector<Observation> views = test::views(false);
    for (Observation& view : views) view.brightness = view.sigma = 0.1;
    const char* const sentence = "optical_depth held must be one that the model knows, such as in ";
    expect_refusal_by(*table_model(single.view()), views, {.optical_depth = 0.3},
                      {sentence, "[1, 1], got 0.3"});
    expect_refusal_by(*table_model(ground.view()), views, {.optical_depth = 0.3},
                      {sentence, "[1, 8], got 0.3"});
    const Fit diluted = fit_layer(single.view(), views, {.optical_depth = 0.7, .density = 1 - 0.7});
    EXPECT_EQ(diluted.optical_depth().value, 0.7);
}

TEST(Fit, RefusesWhatOtherModelsDoNotKnow) {
    std::vector<Observation> views = bright_views();
    expect_refusal_by(*beam_model(), views, {},
                      "observed light must be such as the model knows, got reflected");
    const auto one = single_scattering_model(PhaseFunction::henyey_greenstein(0.5), std::nullopt);
    const auto refused = [&](const FitOptions& options, const Fragments& fragments) {
        expect_refusal_by(*one, views, options, fragments);
    };
    refused({.w2 = 0.1}, "w2 must be left out with particles of one kind, got 0.1");
    refused({.free_g2 = true}, "g2 must be left out");
    refused({.g1 = 0.99}, "g held must be in [-0.95, 0.95], got 0.99");
    refused({.g1 = 0.99, .free_g1 = true}, "g must be either held or free");
    views.resize(1);
    refused({}, "observations must be at least 2, one for each free parameter, got 1");
    EXPECT_EQ(fit_layer(*one, views, {.optical_depth = 0.5}).degrees_of_freedom, 0);
}

TEST(ChiSquare, IsTheUpperGammaFunction) {
    for (const int degrees : {1, 2, 3, 7, 48, 501})
        for (const double chi_square : {0.01, 0.7, 5.0, 70.0, 450.0, 700.0}) {
            const double expected = boost::math::gamma_q(degrees / 2.0, chi_square / 2);
            EXPECT_NEAR(chi_square_probability(chi_square, degrees), expected,
                        1e-8 * expected + 1e-12)
                << degrees << ' ' << chi_square;
        }
}

TEST(ChiSquare, EndsAtOneAndZero) {
    for (const int degrees : {1, 2, 9, 10}) {
        EXPECT_EQ(chi_square_probability(0, degrees), 1);
        EXPECT_EQ(chi_square_probability(infinity, degrees), 0);
        EXPECT_EQ(chi_square_probability(1e5, degrees), 0);
    }
    EXPECT_NEAR(chi_square_probability(1e5, 100000), 0.5, 1e-3);  // no overflow on the way
}

/// Single scattering of w = 0.762, tau = 0.730 and g = 0.772 with noise of 5e-4: w and g trade along a narrow
/// curved valley, which takes a hundred steps.
TEST(Fit, FollowsANarrowValleyToItsEnd) {
    struct Row {
        Light light;
        double mu_out, degrees, brightness, sigma;
    };
    std::vector<Observation> observations;
    for (const Row& row : std::vector<Row>{
             {Light::reflected, 0.944671237, 161.442794, 0.00457553906, 2.37195458e-06},
             {Light::transmitted, 0.40190339, 143.803848, 0.00442120794, 2.32669251e-06},
             {Light::reflected, 0.827404781, 176.971307, 0.00425302676, 2.27513235e-06},
             {Light::reflected, 0.868286298, 150.480016, 0.00450387223, 2.34950661e-06},
             {Light::reflected, 0.803109518, 105.908118, 0.0062146598, 2.86416903e-06},
             {Light::transmitted, 0.277755556, 124.295481, 0.00488429521, 2.46501363e-06}})
        observations.push_back({{0.306698696, row.mu_out, radians(row.degrees)},
                                row.light,
                                row.brightness,
                                row.sigma});
    const auto model = single_scattering_model(PhaseFunction::henyey_greenstein(0.3), {});
    FitOptions options;
    options.free_g1 = true;
    const Fit fit = fit_layer(*model, observations, options);
    EXPECT_NEAR(fit.chi_square, 2.53, 0.01);  // the least, by other programs from many starts
    EXPECT_NEAR(fit.g1().value, 0.772, 2 * fit.g1().sigma);
    EXPECT_NEAR(fit.w1().value, 0.762, 2 * fit.w1().sigma);
}

TEST(Fit, SeesALayerAlongADirectionWhateverElseIsObserved) {
    const auto model = solver_model(PhaseFunction::rayleigh(), {}, 8);  // of so few nodes, in parts
    std::vector<Observation> observations;
    for (int k = 0; k < 40; ++k)
        observations.push_back({{0.1 + 0.02 * k, 0.98 - 0.01 * k, 0.1 * k},
                                k % 10 == 3  ? Light::beam
                                : k % 3 == 0 ? Light::transmitted
                                             : Light::reflected,
                                0.1,
                                0.001});
    LayerParameters layer;
    layer.w1 = 0.9;
    layer.optical_depth = 1.5;
    const std::vector<double> all = model->brightness(layer, observations);
    for (std::size_t k = 0; k < observations.size(); ++k) {
        const double alone = model->brightness(layer, {observations[k]})[0];
        EXPECT_NEAR(all[k], alone, 1e-9 * alone) << k;
    }
}

TEST(Fit, RefusesWhatNoLayerGivesEvenWithoutDegreesOfFreedom) {
    Observation beam{};
    beam.light = Light::beam;
    beam.geometry.mu_out = 0.5;
    beam.brightness = 30;  // percent by mistake
    beam.sigma = 1;
    const Fit fit = fit_layer(*beam_model(), {beam});
    EXPECT_EQ(fit.degrees_of_freedom, 0);
    EXPECT_LT(fit.probability, 1e-100);
    EXPECT_NE(remark(fit, "refused: chi_square 841 for 0 degrees of freedom"), "");

    // The least is within the range, where light no longer changes with depth.
    beam.brightness = -10;
    EXPECT_LT(fit_layer(*beam_model(), {beam}).probability, 1e-20);
    Observation through{{0.5, 0.5, 0.5}, Light::transmitted, 0.5, 0.001};
    FitOptions options;
    options.w1 = 0.9;
    const auto model = single_scattering_model(PhaseFunction::rayleigh(), {});
    EXPECT_LT(fit_layer(*model, {through}, options).probability, 1e-20);
}

}  // namespace
}  // namespace stratus::test
