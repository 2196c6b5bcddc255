// Tables that leave the path law to lookups: every way to look one up, against the solver.
#include <stratus/bake/bake.h>
#include <stratus/bsdf/slice.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/solve.h>

#include "small_recipe.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

Recipe path_law_recipe(const std::string& phase_function, const std::string& more = "") {
    return parse_recipe("phase_function = '" + phase_function +
                        "'\n"
                        "tolerance = 1e-3\n"
                        "optical_depth = { min = 0.5, max = 4.0 }\n"
                        "albedo = { min = 0.9, max = 1.0 }\n" +
                        more +
                        "[discretisation]\n"
                        "nodes = 24\n"
                        "modes = 36\n"
                        "mu_samples = 28\n"
                        "azimuth_samples = 25\n"
                        "azimuth_scale = 'square_root'\n"
                        "optical_depth_samples_per_octave = 3\n"
                        "albedo_samples = 5\n");
}

const Table& table() {
    static const Table baked = solve_table(path_law_recipe("henyey_greenstein:g=0.9"));
    return baked;
}

const std::vector<Geometry> geometries{{0.7, 0.7, 0.02}, {0.7, 0.72, 0.1},  {0.3, 0.9, 0.4},
                                       {0.9, 0.91, 0},   {0.25, 0.25, 0.2}, {0.5, 0.6, 3.1},
                                       {1, 0.95, 1},     {0.2, 0.8, 2}};

/// The same layer, solved with more nodes.
double solved(Side side, double albedo, double tau, const Geometry& at, int orders = 0) {
    const LayerSolution layer =
        solve_layer(PhaseFunction::henyey_greenstein(0.9), albedo, tau, {at.mu_in, at.mu_out},
                    {.nodes = 64, .orders = orders, .mode_tolerance = 1e-6});
    return side == Side::reflection ? layer.reflection(0, 1, at.azimuth).total
                                    : layer.transmission(0, 1, at.azimuth).total;
}

TEST(PathLawTable, LeavesThePeakToLookups) {
    ASSERT_NE(table().path_law, nullptr);
    // around straight on what is left in the table is smooth
    const TableView view = table().view();
    const auto parts = [&](double azimuth) {
        const Geometry at{0.8, 0.8, azimuth};
        const double law = (*view.path_law)(Side::transmission, 1, 1, at, 0);
        return std::pair(law, transmission(view, 1, 1, at).multiple - law);
    };
    const auto [law, rest] = parts(0);
    const auto [law_aside, rest_aside] = parts(0.1);
    EXPECT_GT(std::abs(law - law_aside), 5 * std::abs(rest - rest_aside));
    const double expected = solved(Side::transmission, 1, 1, {0.8, 0.8, 0});
    EXPECT_NEAR(transmission(view, 1, 1, {0.8, 0.8, 0}).total(), expected, 5e-3 * expected);
}

TEST(PathLawTable, LookupsMeetTheSolver) {
    for (const double albedo : {0.93, 1.0})
        for (const double tau : {0.7, 3.0})
            for (const Geometry& at : geometries)
                for (const Side side : both_sides) {
                    const double expected = solved(side, albedo, tau, at);
                    const auto look_up = side == Side::reflection ? reflection : transmission;
                    EXPECT_NEAR(look_up(table().view(), albedo, tau, at).total(), expected,
                                1e-2 * expected)
                        << tau << ' ' << at.mu_in << ' ' << at.mu_out << ' ' << at.azimuth;
                }
}

TEST(PathLawTable, SlicesColoursAndTexturesMeetLookups) {
    const TableView view = table().view();
    const PackedTable packed(pack(table()));
    const double depths[] = {0.7, 1.5, 3.0}, albedos[] = {0.92, 0.97, 1.0};
    const RgbSlice colours = bind_rgb(view, depths, albedos);
    for (int c = 0; c < 3; ++c) {
        const double tau = depths[c], albedo = albedos[c];
        const Slice slice = bind(view, tau, albedo);
        for (const Geometry& at : geometries) {
            const auto in = static_cast<float>(at.mu_in), out = static_cast<float>(at.mu_out),
                       azimuth = static_cast<float>(at.azimuth);
            const double up = reflection(view, albedo, tau, at).total();
            const double down = transmission(view, albedo, tau, at).total();
            EXPECT_NEAR(slice.reflection(in, out, azimuth), up, 4e-3 * up) << at.azimuth;
            EXPECT_NEAR(slice.transmission(in, out, azimuth), down, 4e-3 * down) << at.azimuth;
            const auto of_channel = [c](const Rgb& rgb) {
                return c == 0 ? rgb.r : c == 1 ? rgb.g : rgb.b;
            };
            EXPECT_NEAR(of_channel(colours.reflection(in, out, azimuth)), up, 4e-3 * up);
            EXPECT_NEAR(of_channel(colours.transmission(in, out, azimuth)), down, 4e-3 * down);
            EXPECT_NEAR(packed.reflection(albedo, tau, at).total(), up, 6e-3 * up);
            EXPECT_NEAR(packed.transmission(albedo, tau, at).total(), down, 6e-3 * down);
            // many at once
            float one = 0;
            slice.transmission(1, &in, &out, &azimuth, &one);
            EXPECT_NEAR(one, slice.transmission(in, out, azimuth), 2e-6 * down);
            const float w = static_cast<float>(albedo), depth = static_cast<float>(tau);
            packed.transmission({&w, &depth, &in, &out, &azimuth, 1}, &one);
            EXPECT_NEAR(one, packed.transmission(albedo, tau, at).total(), 1e-5 * down);
        }
    }
}

TEST(PathLawTable, EffectsKeepTheirMeaning) {
    const TableView view = table().view();
    Effects once, more;
    once.multiple = false;
    more.single = false;
    const Slice all = bind(view, 2, 1), single = bind(view, 2, 1, once),
                multiple = bind(view, 2, 1, more);
    const float sum =
        single.transmission(0.7f, 0.72f, 0.1f) + multiple.transmission(0.7f, 0.72f, 0.1f);
    EXPECT_NEAR(sum, all.transmission(0.7f, 0.72f, 0.1f), 1e-5f * sum);
    const double expected = single_transmission(
        view.phase(cos_scattering_angle_transmitted({0.7, 0.72, 0.1})), 1, 2, 0.7, 0.72);
    EXPECT_NEAR(single.transmission(0.7f, 0.72f, 0.1f), expected, 1e-4 * expected);
    // nothing scatters: nothing is left of the law
    EXPECT_EQ(bind(view, 2, 0).transmission(0.7f, 0.72f, 0.1f), 0);
    // not-a-number never becomes an index
    const PackedTable packed(pack(table()));
    for (const double bad : {NAN, -NAN}) {
        const auto of = static_cast<float>(bad);
        for (const Geometry& at : {Geometry{bad, 0.5, 1}, Geometry{0.5, 0.5, bad}}) {
            transmission(view, 1, 2, at);
            reflection(view, bad, 2, at);
            packed.transmission(1, 2, at);
        }
        all.transmission(of, 0.5f, 1);
        all.reflection(0.5f, 0.5f, of);
    }
    // beyond what any layer in the table has, and very deep
    const Slice deep = bind(view, 4e5, 1, {}, OutsideTable::clamp);
    EXPECT_TRUE(std::isfinite(deep.transmission(0.01f, 1, 0)));
    EXPECT_TRUE(std::isfinite(deep.reflection(0.01f, 0.01f, 0)));
}

TEST(PathLawTable, EndsWithTheHighestOrder) {
    const Table table = solve_table(path_law_recipe("henyey_greenstein:g=0.9", "orders = 3\n"));
    const Geometry at{0.7, 0.72, 0.1};
    const double expected = solved(Side::transmission, 1, 2, at, 3);
    EXPECT_NEAR(transmission(table.view(), 1, 2, at).total(), expected, 5e-3 * expected);
    EXPECT_NEAR(bind(table.view(), 2, 1).transmission(0.7f, 0.72f, 0.1f), expected,
                5e-3 * expected);
    const double all = solved(Side::transmission, 1, 2, at);
    EXPECT_GT(all - expected, 2e-2 * all);  // which the test can tell apart
}

TEST(PathLawTable, ComesBackFromFiles) {
    const test::TemporaryFolder folder;
    for (const char* name : {"table.h5", "table.exr"}) {
        write_table(table(), folder.path() / name);
        const Table read = read_table(folder.path() / name);
        ASSERT_NE(read.path_law, nullptr);
        const Geometry at{0.7, 0.72, 0.1};
        EXPECT_EQ(transmission(read.view(), 0.95, 1, at).total(),
                  transmission(table().view(), 0.95, 1, at).total());
    }
}

TEST(PathLawTable, IsForNarrowPeaksAloneThatNothingElseDisturbs) {
    const std::string peaked = "henyey_greenstein:g=0.9";
    EXPECT_EQ(solve_table(path_law_recipe("henyey_greenstein:g=0.5")).path_law, nullptr);
    EXPECT_EQ(solve_table(path_law_recipe(peaked, "[below]\nlambert_albedo = 0.3\n")).path_law,
              nullptr);
}

}  // namespace
}  // namespace stratus
