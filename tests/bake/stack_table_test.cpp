// Tables of stacks: every way to look one up, against the solver and against closed forms.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/stack_file.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/stack.h>

#include "all_near.h"
#include "refusal.h"
#include "small_recipe.h"
#include "small_table.h"
#include "temporary_folder.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

constexpr double tolerance = 2e-3;

std::string layer(const std::string& phase_function, double albedo, const std::string& depth) {
    return "[[layers]]\nphase_function = '" + phase_function +
           "'\nalbedo = " + std::to_string(albedo) + "\noptical_depth = " + depth + "\n";
}

const std::string air = layer("rayleigh", 1, "0.3"),
                  haze = layer("henyey_greenstein:g=0.7", 0.9, "1.5");

Recipe stack_recipe(const std::string& layers) {
    return parse_recipe("tolerance = " + std::to_string(tolerance) + "\n" + layers);
}

const Table& haze_under_air() {
    static const Table baked = bake(stack_recipe(air + haze));
    return baked;
}

std::vector<Geometry> random_geometries(int count) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> root(0.05, 1), azimuth(0, pi);
    std::vector<Geometry> all;
    for (int n = 0; n < count; ++n) {
        const double in = root(random), out = root(random);
        all.push_back({in * in, out * out, azimuth(random)});
    }
    return all;
}

/// Of a table, by lookups and by a bound slice.
void expect_solved(const Table& table) {
    const TableView view = table.view();
    const StackLayer mean = mean_layer(table.layers);
    const Slice slice = bind(view, mean.optical_depth, mean.albedo);
    const std::vector<Geometry> geometries = random_geometries(60);
    std::vector<double> mu;
    for (const Geometry& at : geometries) mu.insert(mu.end(), {at.mu_in, at.mu_out});
    const StackSolution stack = solve_stack(table.layers, table.lower_boundary, mu, {.nodes = 48});
    double brightest[2] = {};
    for (const auto n : indices(geometries)) {
        const int at = static_cast<int>(2 * n);
        const double azimuth = geometries[n].azimuth;
        brightest[0] = std::max(brightest[0], stack.reflection(at, at + 1, azimuth).total);
        brightest[1] = std::max(brightest[1], stack.transmission(at, at + 1, azimuth).total);
    }
    for (const auto n : indices(geometries)) {
        const Geometry& at = geometries[n];
        const int in = static_cast<int>(2 * n);
        for (const Side side : both_sides) {
            const bool reflected = side == Side::reflection;
            if (!reflected && stack.is_opaque()) continue;
            const SolvedValue solved = reflected ? stack.reflection(in, in + 1, at.azimuth)
                                                 : stack.transmission(in, in + 1, at.azimuth);
            const Scattered found = reflected
                                        ? reflection(view, mean.albedo, mean.optical_depth, at)
                                        : transmission(view, mean.albedo, mean.optical_depth, at);
            const double scale = std::max(solved.total, 0.01 * brightest[reflected ? 0 : 1]);
            const bool tabulates = !table.lower_boundary.has_closed_form();
            const double ground =
                tabulates && reflected
                    ? single_reflection_of_boundary(table.lower_boundary, mean.optical_depth, at)
                    : 0;
            EXPECT_NEAR(found.single, solved.single - ground, 1e-12 * scale);
            EXPECT_NEAR(found.total(), solved.total, tolerance * scale)
                << at.mu_in << ' ' << at.mu_out;
            EXPECT_NEAR(value_of(slice, side, at), solved.total, 2 * tolerance * scale)
                << at.mu_in << ' ' << at.mu_out;
        }
    }
}

TEST(StackTable, MatchesTheSolver) { expect_solved(haze_under_air()); }

TEST(StackTable, OverASurfaceMatchesTheSolver) {
    expect_solved(bake(stack_recipe(air + haze + "[below]\nlambert_albedo = 0.4\n")));
}

TEST(StackTable, OverASemiInfiniteLayerMatchesTheSolver) {
    expect_solved(bake(
        stack_recipe(air + haze + "[below]\nphase_function = 'lambert_sphere'\nalbedo = 0.7\n")));
}

TEST(StackTable, OverAnOceanMatchesTheSolver) {
    expect_solved(bake(stack_recipe(air + "[below]\nground = 'ocean:wind=20'\n")));
}

// A table of the lower layer is the ground of the upper one.
TEST(StackTable, IsTheGroundOfWhatLiesOnIt) {
    const TemporaryFolder folder;
    const Recipe below = stack_recipe(haze + "[below]\nlambert_albedo = 0.4\n");
    const std::vector<char> packed = pack(bake(below));
    set_content(folder / "haze.stratus", std::string(packed.begin(), packed.end()));
    const LowerBoundary table = read_ground("table:file=haze.stratus", folder.path().string());
    const std::vector<double> mu{0.2, 0.5, 0.9};
    const std::vector<StackLayer> top = parse_stack(air).layers;
    const StackSolution over_table = solve_stack(top, table, mu),
                        whole = solve_stack(parse_stack(air + haze).layers,
                                            LowerBoundary::surface(0.4), mu);
    for (int in = 0; in < 3; ++in) {
        for (int out = 0; out < 3; ++out) {
            const double expected = whole.reflection(in, out, 1).total;
            EXPECT_NEAR(over_table.reflection(in, out, 1).total, expected,
                        2 * tolerance * expected);
        }
        EXPECT_NEAR(over_table.plane_albedo(in), whole.plane_albedo(in),
                    tolerance * whole.plane_albedo(in));
    }
    const Recipe dust = parse_recipe(
        "phase_function = 'isotropic'\ntolerance = 1e-2\nsides = ['reflection']\n"
        "optical_depth = { min = inf, max = inf }\nalbedo = { min = 0.5, max = 1.0 }\n");
    const std::vector<char> deep = pack(bake(dust));
    set_content(folder / "dust.stratus", std::string(deep.begin(), deep.end()));
    for (const double albedo : {0.0, 0.8}) {
        const std::string text = "table:file=dust.stratus,albedo=" + std::to_string(albedo);
        const StackSolution on_dust =
            solve_stack(top, LowerBoundary::layer(PhaseFunction::isotropic(), albedo), mu);
        EXPECT_NEAR(solve_stack(top, read_ground(text, folder.path().string()), mu).plane_albedo(1),
                    on_dust.plane_albedo(1), 1e-2 * on_dust.plane_albedo(1));
    }
    const auto refused = [&](const char* text, const char* part) {
        expect_refusal([&] { read_ground(text, folder.path().string()); }, part);
    };
    refused("table:file=haze.stratus,optical_depth=9", "optical_depth must be");
    refused("table:file=haze.stratus,albedo=0.1", "albedo must be");
    refused("table:name=haze.stratus", "parameter of table must be file");
    refused("table:file=dust.stratus,albedo=0.8,albedo=0.9", "albedo must stand once");
    refused("table:file=dust.stratus,albedo=0.8;", "nothing may follow, got ';'");
    refused("table:file=dust.stratus,albedo=0,optical_depth=-1", "in [0, inf], got -1");
    const std::vector<char> veil = pack(bake(
        parse_recipe("phase_function = 'isotropic'\ntolerance = 5e-2\nsides = ['reflection']\n"
                     "optical_depth = { min = 1, max = 2 }\nalbedo = { min = 0.8, max = 1 }\n")));
    set_content(folder / "veil.stratus", std::string(veil.begin(), veil.end()));
    refused("table:file=veil.stratus,optical_depth=0.1,albedo=0.9", "the table's first");
    Table dark = bake(dust);
    dark.highest_order = 2;
    const std::vector<char> of_two_orders = pack(dark);
    set_content(folder / "dust.stratus", std::string(of_two_orders.begin(), of_two_orders.end()));
    refused("table:file=dust.stratus,albedo=0.8", "of all orders");
    expect_refusal(
        [&] {
            parse_recipe("tolerance = 1e-2\n" + air + "[below]\nground = 'table:file=" +
                         (folder / "haze.stratus").string() + "'\n");
        },
        "ocean or rpv in recipes");
}

TEST(StackTable, OverAThinBlackLayerHasAsManyCosinesAsItTakes) {
    Recipe recipe = stack_recipe(layer("rayleigh", 1, "0.112") + layer("isotropic", 1, "4.64") +
                                 layer("henyey_greenstein:g=0.823", 0.039, "0.0185"));
    recipe.tolerance = 3.4e-3;
    recipe.reflection = false;
    const Table table = bake(recipe);
    EXPECT_GT(table.mu_out.values.size(), 56u);
    EXPECT_TRUE(verify(table, {400}).meets(recipe.tolerance));
}

TEST(StackTable, OfInfiniteDepthMatchesTheSolver) {
    const Table deep = bake(stack_recipe(air + layer("lambert_sphere", 0.9, "inf")));
    EXPECT_TRUE(deep.transmission_multiple.empty());
    expect_solved(deep);
}

TEST(StackTable, OfTwoLikeLayersIsOneOfTwiceTheDepth) {
    const std::string choices =
        "[discretisation]\nnodes = 16\nmodes = 16\nmu_samples = 20\nazimuth_samples = 13\n"
        "azimuth_scale = 'linear'\n";
    const Table two = solve_table(stack_recipe(haze + haze + choices));
    Recipe one = parse_recipe(
        "phase_function = 'henyey_greenstein:g=0.7'\ntolerance = " + std::to_string(tolerance) +
        "\noptical_depth = { min = 3.0, max = 3.0 }\nalbedo = { min = 0.9, max = 0.9 }\n" +
        choices + "optical_depth_samples_per_octave = 1\nalbedo_samples = 1\n");
    const Table single = solve_table(one);
    // Samples are rounded to a thousandth of the tolerance.
    for (const auto side : {&Table::reflection_multiple, &Table::transmission_multiple})
        expect_all_near(two.*side, single.*side, 0.01 * tolerance);
    for (const auto flux : {&Table::plane_albedo, &Table::diffuse_transmittance})
        expect_all_near(two.*flux, single.*flux, 0, 1e-6);
    EXPECT_NEAR(two.spherical_albedo_below, two.spherical_albedo[0], 1e-6);
}

TEST(StackTable, LosesNothingWithoutAbsorption) {
    const Table table = bake(stack_recipe(air + layer("henyey_greenstein:g=0.7", 1, "1.5")));
    const double depth = mean_layer(table.layers).optical_depth;
    for (const auto i : indices(table.mu_in.values))
        EXPECT_NEAR(double{table.plane_albedo[i]} + double{table.diffuse_transmittance[i]} +
                        direct_transmittance(depth, table.mu_in.values[i]),
                    1, 1e-6);
    const Verification checked = verify(table);
    EXPECT_TRUE(checked.meets(tolerance));
    EXPECT_LT(checked.energy_defect, 1e-6);
    EXPECT_GE(checked.energy_defect, 0);
    EXPECT_LT(checked.furnace_defect, tolerance);
}

/// What lies behind a stack is lit and seen by its fluxes, whichever sides are tabulated.
TEST(StackTable, OfReflectionAloneHoldsWhatPassesThrough) {
    Recipe recipe = stack_recipe(air + haze);
    recipe.transmission = false;
    const Table table = bake(recipe);
    SolverOptions options;
    options.nodes = 64;
    options.modes = 1;
    const LayerSolution solved =
        as_one_layer(solve_stack(table.layers, {}, table.mu_in.values, options));
    ASSERT_EQ(table.diffuse_transmittance.size(), table.mu_in.values.size());
    for (const auto i : indices(table.mu_in.values))
        EXPECT_NEAR(table.diffuse_transmittance[i],
                    solved.diffuse_transmittance(static_cast<Eigen::Index>(i)), 1e-4)
            << "mu_in " << table.mu_in.values[i];
    recipe = stack_recipe(air + haze + "[below]\nlambert_albedo = 0.3\n");
    EXPECT_TRUE(bake(recipe).diffuse_transmittance.empty());
    recipe = stack_recipe(air + layer("henyey_greenstein:g=0.7", 0.9, "inf"));
    recipe.transmission = false;
    EXPECT_TRUE(bake(recipe).diffuse_transmittance.empty());
}

TEST(StackTable, ShowsABackgroundFromAbove) {
    const Table& table = haze_under_air();
    const StackLayer mean = mean_layer(table.layers);
    const StackSolution stack = solve_stack(table.layers, {}, {0.3, 0.8});
    const Slice slice = bind(table.view(), mean.optical_depth, mean.albedo);
    Effects once;
    once.multiple = false;
    const Slice single = bind(table.view(), mean.optical_depth, mean.albedo, once);
    const Slice tableless(table.layers, once);
    for (const int k : {0, 1}) {
        const auto mu = static_cast<float>(stack.mu(k));
        const double beam = direct_transmittance(mean.optical_depth, stack.mu(k));
        EXPECT_NEAR(slice.direct(mu), beam, 1e-6);
        EXPECT_NEAR(slice.background(mu), beam + stack.diffuse_transmittance(k), 1e-3);
        // Once: the mean of T over the hemisphere of directions in which light leaves.
        double sum = 0;
        constexpr int count = 200;
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j) {
                const double out = (i + 0.5) / count;
                sum += 2 * out / count / count *
                       stack_single_scattering(Side::transmission, table.layers,
                                               {stack.mu(k), out, pi * (j + 0.5) / count});
            }
        EXPECT_NEAR(single.background(mu), beam + sum, 1e-3);
        EXPECT_EQ(tableless.background(mu), single.background(mu));
    }
    for (const Geometry& at : random_geometries(20)) {
        EXPECT_EQ(value_of(tableless, Side::reflection, at),
                  value_of(single, Side::reflection, at));
        const double expected = stack_single_scattering(Side::transmission, table.layers, at);
        EXPECT_NEAR(value_of(tableless, Side::transmission, at), expected, 3e-5 * expected);
    }
}

TEST(StackTable, MakesABsdfThatIsLitFromAbove) {
    const Table& table = haze_under_air();
    const StackLayer mean = mean_layer(table.layers);
    const double depths[] = {mean.optical_depth, mean.optical_depth, mean.optical_depth},
                 albedos[] = {mean.albedo, mean.albedo, mean.albedo};
    const Bsdf bsdf(bind(table.view(), mean.optical_depth, mean.albedo));
    const RgbBsdf coloured(bind_rgb(table.view(), depths, albedos));
    const std::size_t at = table.mu_in.values.size() / 2;
    const auto mu = static_cast<float>(table.mu_in.values[at]);
    EXPECT_NEAR(bsdf.albedo(mu).reflected, table.plane_albedo[at], 0.01);
    EXPECT_NEAR(bsdf.albedo(mu).transmitted, table.diffuse_transmittance[at], 0.01);
    const Vector above{0.6f, 0, 0.8f}, below{0, 0.6f, -0.8f};
    EXPECT_GT(bsdf.eval(above, below), 0);
    EXPECT_NEAR(coloured.eval(above, below).g, bsdf.eval(above, below), 1e-6);
    EXPECT_EQ(bsdf.eval(below, above), 0);
    EXPECT_EQ(bsdf.eval(below, {0.6f, 0, -0.8f}), 0);
    Uniform<float> u(3);
    double through = 0;
    constexpr int count = 20000;
    for (int n = 0; n < count; ++n) {
        const auto next = bsdf.sample(above, u(), u(), u());
        if (next.pdf > 0 && next.wo.z < 0)
            through += double{next.value} * std::abs(double{next.wo.z}) / double{next.pdf} / count;
    }
    EXPECT_NEAR(through, bsdf.albedo(above).transmitted, 0.01);
}

TEST(StackTable, IsTheSameFromAFileAndFromItsResolvedRecipe) {
    const Table& table = haze_under_air();
    const TemporaryFolder folder;
    for (const char* name : {"stack.h5", "stack.exr"}) {
        write_table(table, folder / name);
        const Table read = read_table(folder / name);
        expect_same_bits(read, table);
        EXPECT_EQ(read.spherical_albedo_below, table.spherical_albedo_below);
        ASSERT_EQ(read.layers.size(), table.layers.size());
        for (const auto k : indices(table.layers)) {
            EXPECT_EQ(read.layers[k].phase_function.text(), table.layers[k].phase_function.text());
            EXPECT_EQ(read.layers[k].albedo, table.layers[k].albedo);
            EXPECT_EQ(read.layers[k].optical_depth, table.layers[k].optical_depth);
        }
    }
    expect_same_bits(bake(parse_recipe(table.attributes.at("resolved_recipe"))), table);
}

TEST(StackTable, IsOfItsStackAlone) {
    const Table& table = haze_under_air();
    const StackLayer mean = mean_layer(table.layers);
    const auto refused = [&](double depth, double albedo, const Effects& effects,
                             const Fragments& fragments) {
        expect_refusal([&] { bind(table.view(), depth, albedo, effects); }, fragments);
    };
    refused(1.7, mean.albedo, {}, {"optical_depth", "1.8", "that of the stack", "1.7"});
    refused(mean.optical_depth, 0.5, {}, {"albedo", "that of the stack", "0.5"});
    refused(0, mean.albedo, {}, {"optical_depth", "that of the stack"});
    Effects dense, opposed;
    dense.density = 0.1;
    opposed.opposition = Opposition::blinn(0.1);
    refused(mean.optical_depth, mean.albedo, dense, {"density", "of a stack", "0.1"});
    refused(mean.optical_depth, mean.albedo, opposed, {"opposition", "of a stack"});
    const Slice clamped = bind(table.view(), 1, 0.5, {}, OutsideTable::clamp);
    EXPECT_TRUE(clamped.clamped());
    EXPECT_EQ(clamped.reflection(0.5f, 0.6f, 1),
              bind(table.view(), mean.optical_depth, mean.albedo).reflection(0.5f, 0.6f, 1));
}

TEST(StackTable, IsTheSamePacked) {
    const Table& table = haze_under_air();
    const PackedTable packed(pack(table));
    ASSERT_EQ(packed.header().layers.size(), table.layers.size());
    const StackLayer mean = mean_layer(table.layers);
    const Slice slice = bind(packed.view(), mean.optical_depth, mean.albedo);
    for (const Geometry& at : {Geometry{0.9, 0.2, 1}, Geometry{0.3, 0.7, 3}})
        for (const Side side : both_sides) {
            const bool reflects = side == Side::reflection;
            const Scattered expected = (reflects ? reflection : transmission)(
                table.view(), mean.albedo, mean.optical_depth, at);
            const Scattered found = reflects
                                        ? packed.reflection(mean.albedo, mean.optical_depth, at)
                                        : packed.transmission(mean.albedo, mean.optical_depth, at);
            const double allowed = table.tolerance * expected.total();
            EXPECT_EQ(found.single, expected.single);
            EXPECT_NEAR(found.total(), expected.total(), allowed);
            EXPECT_NEAR(value_of(slice, side, at), expected.total(), allowed);
        }
    EXPECT_EQ(packed.header().spherical_albedo_below, table.spherical_albedo_below);
}

TEST(StackRecipe, IsAStackFile) {
    const Recipe recipe = parse_recipe(air + haze);
    EXPECT_EQ(recipe.tolerance, 1e-3);
    EXPECT_EQ(recipe.optical_depth.min, 1.8);
    EXPECT_NEAR(recipe.albedo.max, (0.3 + 0.9 * 1.5) / 1.8, 1e-15);
    EXPECT_TRUE(recipe.transmission);
    EXPECT_FALSE(parse_recipe(air + "[below]\nlambert_albedo = 0.3\n").transmission);
    EXPECT_FALSE(parse_recipe(air + layer("isotropic", 0.5, "inf")).transmission);
    expect_refusal([] { parse_recipe("albedo = 1\n" + air); }, {"line 1", "unknown key 'albedo'"});
    expect_refusal([] { parse_recipe("orders = 4\n" + air); }, {"line 1", "unknown key 'orders'"});
    expect_refusal(
        [] {
            parse_recipe("sides = ['transmission']\n" + air + "[below]\nlambert_albedo = 0.3\n");
        },
        {"line 1", "sides", "[below]"});
    expect_refusal([] { parse_recipe(layer("isotropic", 1, "0.0")); },
                   {"line 1", "optical depth of all layers", "1e-06", "got 0"});
}

}  // namespace
}  // namespace stratus::test
