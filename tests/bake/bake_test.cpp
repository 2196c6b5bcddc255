#include <stratus/bake/bake.h>

#include <stratus/bake/accuracy.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>
#include <stratus/transfer/solve.h>

#include "all_near.h"
#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// What a stored float loses of a flux.
constexpr double float_rounding = 6e-8;

TEST(Bake, CoversTheRangesAsked) {
    const Table table = bake(rayleigh_recipe());
    EXPECT_EQ(table.albedo.values.front(), 0.5);
    EXPECT_EQ(table.albedo.values.back(), 1);
    EXPECT_LE(table.optical_depth.values.front(), 0.25);
    EXPECT_GT(table.optical_depth.values[1], 0.25);  // no more than needed
    EXPECT_EQ(table.optical_depth.values.back(), 2);
    EXPECT_EQ(table.mu_in.values, table.mu_out.values);
    EXPECT_EQ(table.mu_in.values.front(), 1e-4);
    EXPECT_EQ(table.mu_in.values.back(), 1);
    EXPECT_EQ(table.azimuth.values.front(), 0);
    EXPECT_EQ(table.azimuth.values.back(), pi);
}

TEST(Bake, StoresBothSidesAndAllFluxesByAnExplicitDiscretisation) {
    const Table table = bake(explicit_recipe());
    const std::size_t layers = table.albedo.values.size() * table.optical_depth.values.size();
    EXPECT_EQ(table.reflection_multiple.size(), layers * block_size(table));
    EXPECT_EQ(table.transmission_multiple.size(), layers * block_size(table));
    EXPECT_EQ(table.plane_albedo.size(), layers * table.mu_in.values.size());
    EXPECT_EQ(table.diffuse_transmittance.size(), layers * table.mu_in.values.size());
    EXPECT_EQ(table.spherical_albedo.size(), layers);
    EXPECT_EQ(table.diffusion_exponent.size(), table.albedo.values.size());
    EXPECT_EQ(table.diffusion_exponent.back(), 0);  // w = 1
    EXPECT_NEAR(table.extrapolation_length, 1.4208921792 / (1 - 0.4), 1e-9);
    EXPECT_EQ(table.tolerance, 1e-2);
    EXPECT_EQ(table.highest_order, 0);
    EXPECT_EQ(table.albedo.values.size(), 3u);
    EXPECT_EQ(table.optical_depth.values.size(), 11u);  // two octaves of five, ends included
    EXPECT_EQ(table.mu_in.values.size(), 11u);
    EXPECT_EQ(table.azimuth.values.size(), 6u);
    EXPECT_EQ(table.attributes.at("nodes"), "9");
    EXPECT_EQ(table.attributes.at("modes"), "7");
}

TEST(Bake, StopsTheSeriesAtTheRecipesOrder) {
    Recipe recipe = explicit_recipe();
    recipe.orders = 3;
    recipe.discretisation.azimuth_samples = 12;
    recipe.discretisation.mu_samples = 24;
    Table table = bake(recipe);
    EXPECT_EQ(table.highest_order, 3);
    VerifyOptions few;
    few.samples = 200;  // orders cost more than their sum
    const Verification verification = verify(table, few);
    EXPECT_TRUE(verification.meets(2e-2)) << verification.samples.back().error;
    EXPECT_EQ(verification.energy_defect, -1);  // w = 1 does not close without the higher orders

    // Against the orders one by one: lookups differ from those of all orders by what is left out.
    double expected = 0;
    for (const LayerSolution& order :
         solve_orders(recipe.phase_function, 1, 2, {0.4, 0.9}, {.orders = 3}))
        expected += order.reflection(0, 1, 1).total;
    const Scattered found = reflection(table.view(), 1, 2, {0.4, 0.9, 1});
    EXPECT_NEAR(found.total(), expected, 1e-2 * expected);
}

TEST(Bake, MeetsItsToleranceJustBeyondTheDeepestDepthOfFewOrders) {
    const Table table =
        bake(parse_recipe("phase_function = 'isotropic'\n"
                          "tolerance = 1e-2\n"
                          "optical_depth = { min = 0.7, max = inf }\n"
                          "albedo = { min = 0.9, max = 1.0 }\n"
                          "mu_in = { min = 0.5, max = 1.0 }\n"
                          "mu_out = { min = 0.5, max = 1.0 }\n"
                          "sides = ['transmission']\n"
                          "orders = 8\n"));
    const TableView view = table.view();
    for (const double further : {0.5, 1.0, 1.5, 3.0, 10.0}) {
        const double tau = view.optical_depth.highest + further;
        const double expected =
            solve_layer(PhaseFunction::isotropic(), 1, tau, {0.9, 0.95}, {.orders = 8})
                .transmission(1, 0, 1)
                .total;
        EXPECT_NEAR(transmission(view, 1, tau, {0.95, 0.9, 1}).total(), expected,
                    1e-2 * std::max(expected, 1e-8))
            << tau;
    }
}

TEST(Bake, StoresOnlyTheSideAsked) {
    Recipe recipe = explicit_recipe();
    recipe.transmission = false;
    const Table reflecting = bake(recipe);
    EXPECT_TRUE(reflecting.transmission_multiple.empty());
    EXPECT_TRUE(reflecting.diffuse_transmittance.empty());
    recipe.transmission = true;
    recipe.reflection = false;
    const Table transmitting = bake(recipe);
    EXPECT_TRUE(transmitting.reflection_multiple.empty());
    const Table both = bake(explicit_recipe());
    expect_same_bits(reflecting.reflection_multiple, both.reflection_multiple, "reflection");
    expect_same_bits(transmitting.transmission_multiple, both.transmission_multiple,
                     "transmission");
}

/// Of a table that must meet its tolerance, at points of which the bake checked none.
double energy_defect_of_met(const Table& table) {
    const Verification verification = verify(table, {.seed = 77});
    EXPECT_TRUE(verification.meets(table.tolerance))
        << table.phase_function.text() << ": worst " << verification.samples.back().error;
    EXPECT_LE(verification.furnace_defect, table.tolerance);
    return verification.energy_defect;
}

TEST(Bake, MeetsItsToleranceAtOtherPoints) {
    for (const Recipe& recipe : {rayleigh_recipe(), deep_recipe()}) {
        const Table table = bake(recipe);
        EXPECT_GT(table.measured_error, 0);
        EXPECT_LE(table.measured_error, 5 * recipe.tolerance);
        const double defect = energy_defect_of_met(table);
        EXPECT_GE(defect, 0);  // there are samples at w = 1
        EXPECT_LE(defect, 3 * float_rounding);
    }
}

/// A bake straight into a packed table: how often it was checked, and what it says if it misses.
struct NotedBake {
    int checks = 0;
    std::string missed;

    explicit NotedBake(const std::string& recipe) {
        std::vector<char> file;
        BakeOptions options;
        options.packed = &file;
        options.note = [&](const std::string& line) { checks += line.starts_with("checked at"); };
        options.missed = [&](const std::string& sentence) { missed = sentence; };
        bake(parse_recipe(recipe), options);
    }
};

/// Its first choices miss the tolerance a little, and the next stricter share changes none of them.
TEST(Bake, IsBakedAgainAsSoonAsStricterSharesChangeAChoice) {
    const NotedBake baked(
        "phase_function = 'rayleigh'\n"
        "tolerance = 0.0073\n"
        "optical_depth = { min = 0.468, max = 0.65 }\n"
        "albedo = { min = 0.0, max = 0.5 }\n"
        "[below]\n"
        "lambert_albedo = 0.42\n");
    EXPECT_EQ(baked.missed, "");
    EXPECT_GT(baked.checks, 1);
}

/// Two samples, a straight line between them, would miss by 1.6 times the tolerance however often baked.
TEST(Bake, InterpolatesDepthsByCubicsHoweverNarrowTheirRange) {
    const NotedBake baked(
        "phase_function = 'henyey_greenstein:g=0.3'\n"
        "family.g = [0.116, 0.398]\n"
        "tolerance = 0.0029\n"
        "optical_depth = { min = 0.664, max = 0.748 }\n"
        "albedo = { min = 0.0, max = 1.0 }\n");
    EXPECT_EQ(baked.missed, "");
    EXPECT_EQ(baked.checks, 1);
}

/// Deep layers transmit least where they are dark, but not black.
TEST(Bake, ChoosesDepthsForDarkLayersToo) {
    const NotedBake baked(
        "phase_function = 'isotropic'\n"
        "tolerance = 0.0015\n"
        "optical_depth = { min = 0.885, max = 90.2 }\n"
        "albedo = { min = 0.0, max = 1.0 }\n"
        "mu_in = { min = 0.487, max = 0.975 }\n"
        "azimuth_deg = { min = 48.8, max = 146.4 }\n");
    EXPECT_EQ(baked.missed, "");
    EXPECT_EQ(baked.checks, 1);
}

TEST(Bake, MeetsItsToleranceAtGrazingAnglesOverALawOfGrounds) {
    const NotedBake baked(
        "tolerance = 0.0043\n"
        "[[layers]]\n"
        "phase_function = 'lambert_sphere'\n"
        "albedo = 1.0\n"
        "optical_depth = 0.759\n"
        "[[layers]]\n"
        "phase_function = 'rayleigh'\n"
        "albedo = 1.0\n"
        "optical_depth = 0.19\n"
        "[below]\n"
        "ground = 'rpv:rho0=0.202,k=0.93,theta=0.18,rho_c=1'\n");
    EXPECT_EQ(baked.missed, "");
}

Recipe over(const LowerBoundary& boundary, Recipe recipe) {
    recipe.lower_boundary = boundary;
    recipe.transmission = false;
    return recipe;
}

TEST(Bake, MeetsItsToleranceOverGround) {
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.6);
    for (const Recipe& recipe : {over(LowerBoundary::surface(0.4), rayleigh_recipe()),
                                 over(LowerBoundary::surface(1), deep_recipe()),
                                 over(LowerBoundary::layer(forward, 0.9), rayleigh_recipe()),
                                 over(LowerBoundary::layer(forward, 0.9), deep_recipe())}) {
        const Table table = bake(recipe);
        EXPECT_EQ(table.lower_boundary.kind, recipe.lower_boundary.kind);
        EXPECT_TRUE(table.transmission_multiple.empty());
        EXPECT_TRUE(table.diffuse_transmittance.empty());
        EXPECT_EQ(energy_defect_of_met(table), -1);  // the ground takes in what is missing
    }
}

TEST(Bake, OverBlackGroundEqualsTheBareLayer) {
    Recipe recipe = explicit_recipe();
    recipe.discretisation.albedo_samples = 5;
    const Table bare = bake(over({}, recipe));
    const Table black = bake(over(LowerBoundary::surface(0), recipe));
    // a sum more or less, before samples are rounded to a 500th of the tolerance
    expect_all_near(black.reflection_multiple, bare.reflection_multiple, 4e-5);
    expect_all_near(black.plane_albedo, bare.plane_albedo, 0, float_rounding);
    const Geometry at{0.3, 0.7, 1};
    for (const double tau : bare.optical_depth.values) {
        const Scattered found = reflection(black.view(), 0.9, tau, at);
        const Scattered expected = reflection(bare.view(), 0.9, tau, at);
        EXPECT_EQ(found.single, expected.single);
        // two ways to interpolate between albedos
        EXPECT_NEAR(found.total() / expected.total(), 1, recipe.tolerance);
    }
}

TEST(Bake, OverGroundAgreesBetweenSchemes) {
    const LowerBoundary ground = LowerBoundary::layer(PhaseFunction::henyey_greenstein(-0.3), 0.8);
    const Table harmonic = bake(over(ground, explicit_recipe()));
    const Table classic = bake(over(ground, explicit_recipe("classic")));
    expect_all_near(classic.reflection_multiple, harmonic.reflection_multiple, 1e-4);
}

TEST(Bake, IsReproducedByItsResolvedRecipe) {
    for (const Recipe& recipe : {rayleigh_recipe(), deep_recipe()}) {
        const Table table = bake(recipe);
        const std::string& resolved = table.attributes.at("resolved_recipe");
        const Table again = bake(parse_recipe(resolved));
        expect_same_bits(table, again);
        EXPECT_EQ(again.attributes.at("resolved_recipe"), resolved);
        EXPECT_EQ(again.attributes.at("recipe"), resolved);
        EXPECT_EQ(table.attributes.at("recipe"), recipe.text);
    }
}

/// Every sample and flux of a table against single layers, by the nodes and modes of the bake.
void expect_solved_layers(const Table& table, const Recipe& recipe) {
    const std::vector<double>& mu = table.mu_in.values;
    const std::size_t azimuths = table.azimuth.values.size();
    std::size_t row = 0;
    for (const double w : table.albedo.values)
        for (const double tau : table.optical_depth.values) {
            const LayerSolution layer =
                solve_layer(recipe.phase_function, w, tau, mu,
                            {.nodes = std::stoi(table.attributes.at("nodes")),
                             .modes = std::stoi(table.attributes.at("modes")),
                             .scheme = recipe.discretisation.scheme});
            EXPECT_NEAR(table.spherical_albedo[row] / layer.spherical_albedo, 1, float_rounding);
            for (const auto i : indices(mu)) {
                const auto in = static_cast<int>(i);
                EXPECT_NEAR(table.plane_albedo[row * mu.size() + i] / layer.plane_albedo(in), 1,
                            float_rounding);
                const double transmitted = layer.diffuse_transmittance(in);
                EXPECT_NEAR(table.diffuse_transmittance[row * mu.size() + i], transmitted,
                            float_rounding * transmitted);
                for (const auto j : indices(mu))
                    for (std::size_t k = 0; k < azimuths; ++k) {
                        const std::size_t at =
                            row * block_size(table) + (i * mu.size() + j) * azimuths + k;
                        const double azimuth = table.azimuth.values[k];
                        const SolvedValue R = layer.reflection(in, static_cast<int>(j), azimuth);
                        const SolvedValue T = layer.transmission(in, static_cast<int>(j), azimuth);
                        // a thousandth of the tolerance goes in bits left out; what single
                        // scattering rounds away is relative to the total
                        EXPECT_NEAR(
                            table.reflection_multiple[at], R.multiple,
                            1e-3 * table.tolerance * std::abs(R.multiple) + 1e-13 * R.total);
                        EXPECT_NEAR(
                            table.transmission_multiple[at], T.multiple,
                            1e-3 * table.tolerance * std::abs(T.multiple) + 1e-13 * T.total);
                    }
            }
            ++row;
        }
}

TEST(Bake, StoresTheSolversValues) {
    for (const Recipe& recipe : {explicit_recipe(), deep_recipe()})
        expect_solved_layers(bake(recipe), recipe);
}

TEST(Bake, StoresTheClassicSchemesValues) {
    const Recipe recipe = explicit_recipe("classic");
    expect_solved_layers(bake(recipe), recipe);
}

TEST(Bake, EndsAtInfinityWhereAsked) {
    const Recipe recipe = deep_recipe();
    const Table table = bake(recipe);
    ASSERT_EQ(table.optical_depth.values.back(), infinity);
    EXPECT_TRUE(table.optical_depth.view().ends_at_infinity);
    EXPECT_EQ(table.azimuth.values, std::vector<double>{0});  // isotropic
    const TableView view = table.view();
    for (const double w : {0.6, 0.9, 1.0}) {
        const double deepest = table.optical_depth.view().highest;
        for (const double tau : {2 * deepest, 20 * deepest, infinity}) {
            const LayerSolution layer = solve_layer(recipe.phase_function, w, tau, {0.3, 0.8});
            const double R = layer.reflection(0, 1, 0).total;
            EXPECT_NEAR(reflection(view, w, tau, {0.3, 0.8, 0}).total(), R, recipe.tolerance * R)
                << w << ' ' << tau;
        }
    }
    EXPECT_EQ(transmission(view, 0.9, infinity, {0.3, 0.8, 0}).total(), 0);
}

TEST(Bake, EndsAtInfinityWhereNoDeeperFiniteSampleIsNeeded) {
    Recipe recipe = deep_recipe();
    recipe.optical_depth = {100, infinity};
    const Table table = bake(recipe);
    const TableView view = table.view();
    EXPECT_TRUE(view.optical_depth.ends_at_infinity);
    EXPECT_EQ(view.optical_depth.highest, 100);
    for (const double tau : {100.0, 400.0, infinity}) {
        const double R =
            solve_layer(recipe.phase_function, 1, tau, {0.3, 0.8}).reflection(0, 1, 0).total;
        EXPECT_NEAR(reflection(view, 1, tau, {0.3, 0.8, 0}).total(), R, recipe.tolerance * R)
            << tau;
    }
}

TEST(Bake, HoldsInfinityAlone) {
    Recipe recipe = deep_recipe();
    recipe.optical_depth = {infinity, infinity};
    recipe.transmission = false;
    const Table table = bake(recipe);
    EXPECT_EQ(table.optical_depth.values, std::vector<double>{infinity});
    const double R =
        solve_layer(recipe.phase_function, 0.9, infinity, {0.3, 0.8}).reflection(0, 1, 0).total;
    EXPECT_NEAR(reflection(table.view(), 0.9, infinity, {0.3, 0.8, 0}).total(), R,
                recipe.tolerance * R);
}

TEST(Bake, HoldsASingleLayer) {
    Recipe recipe = rayleigh_recipe();
    recipe.albedo = {0.9, 0.9};
    recipe.optical_depth = {1, 1};
    const Table table = bake(recipe);
    EXPECT_EQ(table.albedo.values, std::vector<double>{0.9});
    EXPECT_EQ(table.optical_depth.values, std::vector<double>{1});
    EXPECT_LE(table.measured_error, 5 * recipe.tolerance);
    // One depth tells nothing of thinner layers.
    expect_refusal([&] { bind(table.view(), 0.5, 0.9); }, "optical_depth must be in [1, 1]");
    EXPECT_EQ(thin_layer_error(table.view(), Side::reflection, 0.9, 0.5, {0.5, 0.5, 1}), 1);
}

TEST(Bake, HasConventionAttributes) {
    const Table table = bake(explicit_recipe());
    for (const char* name :
         {"convention_reflection", "convention_transmission", "convention_multiple",
          "convention_azimuth", "convention_phase_function", "convention_fluxes", "program_version",
          "recipe", "resolved_recipe", "measured_error_median", "measured_error_99.9_percent"}) {
        ASSERT_TRUE(table.attributes.count(name)) << name;
        EXPECT_FALSE(table.attributes.at(name).empty()) << name;
    }
}

TEST(Bake, ReportsProgressUpToTheEnd) {
    std::vector<std::pair<std::string, double>> reports;
    BakeOptions options;
    options.threads = 2;
    options.progress = [&](double done, const std::string& stage) {
        reports.emplace_back(stage, done);
    };
    bake(explicit_recipe(), options);
    for (const char* stage : {"baking", "checking"}) {
        double last = 0;
        for (const auto& [of, done] : reports)
            if (of == stage) {
                EXPECT_GT(done, last) << stage;
                last = done;
            }
        EXPECT_EQ(last, 1) << stage;
    }
}

}  // namespace
}  // namespace stratus::test
