// Standard deviations are what they say: in 80 fits to noisy light of known layers, errors are as large as they say, whatever
// is fitted by whichever model.
#include "observed_clouds.h"
#include "row_name.h"

#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

namespace stratus::test {
namespace {

constexpr int layers = 20, noises_per_layer = 4;

/// Fits to noise of one kind: their errors, and how well they fit.
struct Fits {
    std::array<double, fit_parameters> squares{};  // of errors, in standard deviations
    double chi_square = 0, degrees = 0;
    int improbable = 0, refused = 0;

    void add(const Fit& fit, const std::array<double, fit_parameters>& truth) {
        for (std::size_t p = 0; p < fit_parameters; ++p)
            squares[p] += std::pow((fit.estimate[p].value - truth[p]) / fit.estimate[p].sigma, 2);
        chi_square += fit.chi_square;
        degrees += fit.degrees_of_freedom;
        improbable += fit.probability < 0.1;
        refused += !fit.remarks.empty();
    }

    void expect_nominal(const LayerModel& model,
                        const std::array<bool, fit_parameters>& free) const {
        for (std::size_t p = 0; p < fit_parameters; ++p) {
            if (!free[p]) continue;
            // a chi-square of 80 degrees is outside these limits in one run of a thousand
            EXPECT_GE(squares[p], 44.7) << fit_parameter_names(model)[p];
            EXPECT_LE(squares[p], 128.3) << fit_parameter_names(model)[p];
        }
        // to five standard deviations
        EXPECT_NEAR(chi_square / degrees, 1, 5 * std::sqrt(2 / degrees));
        EXPECT_NEAR(improbable, 8, 5 * std::sqrt(80 * 0.1 * 0.9));
        EXPECT_LE(refused, 1);  // a probability below 1e-3
    }
};

/// What is fitted, and by what.
struct Mode {
    std::string name;
    std::function<std::unique_ptr<LayerModel>()> model;
    std::vector<Observation> views;
    Circumstances circumstances{};
    std::vector<FitParameter> held{};
    bool one_kind = false;
    bool g2_free = false;
};

std::unique_ptr<LayerModel> ring_table_model() { return table_model(ring_table().view()); }

std::unique_ptr<LayerModel> one_kind_table_model() {
    static const Table table = [] {
        Recipe recipe = ring_recipe();
        recipe.family.clear();
        return solve_table(recipe);
    }();
    return table_model(table.view());
}

const PhaseFunction spheres = PhaseFunction::lambert_sphere();
const PhaseFunction lobe = PhaseFunction::henyey_greenstein(0.4);  // where fits of g2 begin

/// Few nodes: the solver's error is far below 1 % of noise, and the fits are many.
std::unique_ptr<LayerModel> solver_of_few_nodes() { return solver_model(spheres, lobe, 8); }

std::vector<Mode> modes() {
    const std::vector<Observation> both = views(true), lit = views(false);
    const std::vector<Observation> occulted = lit_views_and_occultations();
    std::vector<Observation> few;
    for (const double mu_out : {0.35, 0.8})
        for (const double azimuth : {0.2, 1.4, 3.0})
            for (const Light light : {Light::reflected, Light::transmitted})
                few.push_back({{0.4, mu_out, azimuth}, light, 0, 0});
    Circumstances dense;
    dense.density = 0.1;
    dense.opposition = Opposition::hapke(0.8, 0.05);
    Circumstances once;
    once.single_alone = true;
    const auto single = [] { return single_scattering_model(spheres, lobe); };
    return {
        {"Table", ring_table_model, both},
        {"TableWithW2Held", ring_table_model, both, {}, {fit_w2}},
        {"TableWithDepthHeld", ring_table_model, lit, {}, {fit_optical_depth}},
        {"TableOfOneKind", one_kind_table_model, both, {}, {}, true},
        {"LitSideAndOccultations", ring_table_model, occulted},
        {"DenseWithOpposition", ring_table_model, both, dense},
        {"SingleScattering", single, both, once, {}, false, true},
        {"SingleScatteringOfDenseLayers", single, occulted, {true, 0.1, dense.opposition}},
        {"Solver", solver_of_few_nodes, few, {}, {fit_w1}, false, true},
        {"Occultations", beam_model, occultations()},
    };
}

Ring random_ring(const Mode& mode, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double albedo = 0.4 + 0.55 * uniform(random);
    const double share = mode.one_kind ? 1 : 0.15 + 0.7 * uniform(random);
    const double depth = 0.1 * std::pow(20, uniform(random));
    const double g2 = mode.g2_free                      ? 0.3 + 0.4 * uniform(random)
                      : mode.circumstances.single_alone ? 0.4
                                                        : 0.5;
    return {albedo * share, albedo * (1 - share), depth, g2};
}

FitOptions make_options(const Mode& mode, const Ring& ring) {
    FitOptions options;
    options.density = mode.circumstances.density;
    options.opposition = mode.circumstances.opposition;
    options.free_g2 = mode.g2_free;
    for (const FitParameter p : mode.held) {
        if (p == fit_optical_depth) options.optical_depth = ring.optical_depth;
        if (p == fit_w1) options.w1 = ring.w1;
        if (p == fit_w2) options.w2 = ring.w2;
    }
    return options;
}

class FitCoverage : public testing::TestWithParam<Mode> {};

TEST_P(FitCoverage, IsNominal) {
    const Mode& mode = GetParam();
    const std::unique_ptr<LayerModel> model = mode.model();
    std::mt19937 random(1982);
    std::array<bool, fit_parameters> free{};
    Fits fits;
    for (int r = 0; r < layers; ++r) {
        const Ring ring = random_ring(mode, random);
        std::vector<Observation> views = mode.views;
        solve_views(ring, views, mode.circumstances);
        const FitOptions options = make_options(mode, ring);
        free = free_parameters(*model, views, options);
        const std::array<double, fit_parameters> truth{ring.optical_depth, ring.w1, ring.w2, 0,
                                                       ring.g2};
        for (int n = 0; n < noises_per_layer; ++n) {
            const std::vector<Observation> observed = with_noise(views, random);
            const Fit fit = fit_layer(*model, observed, options);
            fits.add(fit, truth);

            // not a local minimum
            const std::vector<double> of_truth =
                model->brightness({truth[0], truth[1], truth[2], truth[3], truth[4]}, observed,
                                  options.density, options.opposition);
            double chi_square_of_truth = 0;
            for (const auto i : indices(observed))
                chi_square_of_truth +=
                    std::pow((of_truth[i] - observed[i].brightness) / observed[i].sigma, 2);
            EXPECT_LE(fit.chi_square, chi_square_of_truth * (1 + 1e-9));
        }
    }
    fits.expect_nominal(*model, free);
}

INSTANTIATE_TEST_SUITE_P(Of, FitCoverage, testing::ValuesIn(modes()), row_name);

// Between the depths of a scan chi-square falls to 0 in a valley less than two steps from another.
TEST(FitOfFewObservations, FindsTheLayerInANarrowValley) {
    const auto model = solver_model(
        parse_phase_function("0.6*henyey_greenstein:g=0.6 + 0.4*henyey_greenstein:g=-0.3"),
        std::nullopt, 16);
    const auto unlit = Light::transmitted;
    const Observations four{{{0.869, 0.92, 2.44}, unlit, 0, 0},
                            {{0.8298, 0.7828, 1.7317}, unlit, 0, 0},
                            {{0.4206, 0.5004, 0.2917}, unlit, 0, 0},
                            {{0.2708, 0.9991, 0.0193}, unlit, 0, 0}};
    const Observations two{{{0.1785, 0.3341, 2.4787}, Light::reflected, 0, 0},
                           {{0.8835, 0.6943, 0.9979}, unlit, 0, 0}};
    for (auto [views, w, depth] : {std::tuple(four, 0.893, 4.18), std::tuple(two, 0.9007, 1.58)}) {
        set_brightness(views, model->brightness({depth, w, 0, 0, 0}, views));
        const Fit fit = fit_layer(*model, views);
        EXPECT_NEAR(fit.w1().value, w, fit.w1().sigma);
        EXPECT_NEAR(fit.optical_depth().value, depth, fit.optical_depth().sigma);
    }
}

TEST(FitCoverageOfClouds, IsNominal) {
    const auto model = table_model(droplet_table().view());
    std::mt19937 random(1990);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::array<bool, fit_parameters> free{};
    Fits fits;
    for (int c = 0; c < layers; ++c) {
        const Cloud cloud{0.4 * std::pow(7, uniform(random)), 0.86 + 0.11 * uniform(random),
                          0.24 * std::pow(1.8, uniform(random))};
        const std::vector<Observation> exact = seen(cloud, cloud_views(true));
        free = free_parameters(*model, exact, {});
        std::array<double, fit_parameters> truth{};
        truth[fit_optical_depth] = cloud.optical_depth;
        truth[fit_w1] = cloud.w;
        truth[fit_radius] = cloud.radius;
        for (int n = 0; n < noises_per_layer; ++n)
            fits.add(fit_layer(*model, with_noise(exact, random)), truth);
    }
    fits.expect_nominal(*model, free);
}

}  // namespace
}  // namespace stratus::test
