// The C interface of the solver and the bake beside the C++ functions.
#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>
#include <stratus/stratus_baker.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "indices.h"
#include "../io/temporary_folder.h"
#include "expect_refused.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace stratus {
namespace {

const stratus_layer haze_over_cloud[2] = {{"rayleigh", 1, 0.1},
                                          {"henyey_greenstein:g=0.7", 0.9, 4}};

std::vector<StackLayer> in_cpp(const stratus_layer* layers, std::size_t count) {
    std::vector<StackLayer> all;
    for (std::size_t i = 0; i < count; ++i)
        all.push_back({parse_phase_function(layers[i].phase_function), layers[i].albedo,
                       layers[i].optical_depth});
    return all;
}

stratus_problem make_problem(const stratus_layer* layers, std::size_t count, int nodes = 12) {
    stratus_problem problem{};
    problem.size = sizeof problem;
    problem.layers = layers;
    problem.layer_count = count;
    problem.nodes = nodes;
    return problem;
}

/// R and T of a solution whose cosines are those of the geometries, two each.
template <class Solution>
void expect_same(const Solution& solution, const std::vector<stratus_geometry>& geometries,
                 const std::vector<stratus_solved>& r, const std::vector<stratus_solved>& t) {
    for (const auto i : indices(geometries)) {
        const int in = static_cast<int>(2 * i);
        const auto R = solution.reflection(in, in + 1, geometries[i].azimuth);
        const auto T = solution.transmission(in, in + 1, geometries[i].azimuth);
        EXPECT_DOUBLE_EQ(r[i].single, R.single);
        EXPECT_NEAR(r[i].single + r[i].multiple, R.total, 1e-12 * R.total) << i;
        EXPECT_DOUBLE_EQ(t[i].single, T.single);
        EXPECT_NEAR(t[i].single + t[i].multiple, T.total, 1e-12 * T.total) << i;
    }
}

TEST(SolverInC, SolvesLayersAndStacks) {
    // More cosines than are solved at once.
    std::vector<stratus_geometry> geometries;
    std::vector<double> mu;
    for (int i = 0; i < 40; ++i) {
        geometries.push_back({0.01 + 0.02 * i, 0.995 - 0.021 * i, 0.07 * i});
        mu.insert(mu.end(), {geometries.back().mu_in, geometries.back().mu_out});
    }
    std::vector<stratus_solved> r(geometries.size()), t(geometries.size());
    SolverOptions options;
    options.nodes = 12;
    const auto solve = [&](const stratus_problem& problem) {
        check_ok(stratus_solve(&problem, geometries.size(), geometries.data(), r.data(), t.data()));
    };
    stratus_problem problem = make_problem(haze_over_cloud, 2);
    solve(problem);
    expect_same(solve_stack(in_cpp(haze_over_cloud, 2), {}, mu, options), geometries, r, t);
    problem = make_problem(haze_over_cloud + 1, 1);
    problem.orders = 3;
    options.orders = 3;
    solve(problem);
    const StackLayer cloud = in_cpp(haze_over_cloud, 2)[1];
    expect_same(solve_layer(cloud.phase_function, cloud.albedo, cloud.optical_depth, mu, options),
                geometries, r, t);
    EXPECT_GT(r[3].error, 0);
    EXPECT_LT(r[3].error, 0.1 * r[3].multiple);
    problem.orders = options.orders = 0;
    problem.below = STRATUS_LAYER_BELOW;
    problem.below_albedo = 0.8;
    problem.below_phase_function = "isotropic";
    solve(problem);
    expect_same(solve_layer(cloud.phase_function, cloud.albedo, cloud.optical_depth, mu, options,
                            LowerBoundary::layer(PhaseFunction::isotropic(), 0.8)),
                geometries, r, t);
    EXPECT_EQ(t[3].single, 0);
    const std::vector<stratus_solved> before = r;
    check_ok(stratus_solve(&problem, 2, geometries.data(), nullptr, t.data()));
    check_ok(stratus_solve(&problem, 2, geometries.data(), r.data(), nullptr));
    EXPECT_NEAR(r[1].multiple, before[1].multiple, 1e-12);
}

TEST(SolverInC, GivesFluxesThatConserveEnergy) {
    const stratus_layer white[2] = {{"rayleigh", 1, 0.5}, {"henyey_greenstein:g=0.5", 1, 1}};
    stratus_problem problem = make_problem(white, 2);
    const double mu[3] = {0.1, 0.5, 1};
    double albedo[3], diffuse[3];
    stratus_fluxes uniform{};
    uniform.size = sizeof uniform;
    check_ok(stratus_solve_fluxes(&problem, 3, mu, albedo, diffuse, &uniform));
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(albedo[i] + diffuse[i] + std::exp(-1.5 / mu[i]), 1, 1e-12) << i;
    EXPECT_NEAR(uniform.spherical_albedo + uniform.total_transmittance, 1, 1e-12);
    EXPECT_EQ(uniform.ground_absorptance, 0);
    problem.below = STRATUS_SURFACE_BELOW;
    problem.below_albedo = 0.25;
    check_ok(stratus_solve_fluxes(&problem, 0, nullptr, nullptr, nullptr, &uniform));
    EXPECT_NEAR(uniform.spherical_albedo + uniform.ground_absorptance, 1, 1e-12);
    EXPECT_NEAR(uniform.total_transmittance * 0.75, uniform.ground_absorptance, 1e-12);
    check_ok(stratus_solve_fluxes(&problem, 1, mu, nullptr, diffuse, nullptr));
}

TEST(SolverInC, SolvesTheLightInside) {
    const stratus_problem problem = make_problem(haze_over_cloud, 2, 24);
    const double mu[2] = {0.3, 1}, levels[3] = {0, 0.1, 4.1};
    stratus_level_light light[3][2];
    double error = -1, albedo[2], diffuse[2];
    check_ok(stratus_solve_levels(&problem, 3, levels, 2, mu, light[0], &error));
    check_ok(stratus_solve_fluxes(&problem, 2, mu, albedo, diffuse, nullptr));
    EXPECT_GE(error, 0);
    for (int i = 0; i < 2; ++i) {
        const auto net = [&](int level) {
            const stratus_level_light& at = light[level][i];
            return at.direct_flux + at.diffuse_flux - at.upward_flux;
        };
        EXPECT_NEAR(light[0][i].upward_flux, albedo[i], 1e-12);
        EXPECT_NEAR(light[2][i].diffuse_flux, diffuse[i], 1e-12);
        EXPECT_NEAR(light[1][i].direct_flux, std::exp(-0.1 / mu[i]), 1e-14);
        EXPECT_NEAR(net(0), net(1), 1e-12);  // the haze absorbs nothing
        EXPECT_GT(net(1), net(2) + 0.1);
        EXPECT_NEAR(light[1][i].heating_rate, 0.1 * light[1][i].actinic_flux, 1e-12);  // 1 - w
    }
}

TEST(SolverInC, HasGroundsBelow) {
    const std::vector<stratus_geometry> geometries{{0.5, 0.7, 3}, {0.9, 0.2, 0.4}};
    const std::vector<double> mu{0.5, 0.7, 0.9, 0.2};
    stratus_problem problem = make_problem(haze_over_cloud, 1);
    std::vector<stratus_solved> r(2), t(2);
    for (const char* ground : {"ocean:wind=7", "rpv:rho0=0.1,k=0.8,theta=-0.1"}) {
        problem.below = STRATUS_GROUND_BELOW;
        problem.below_ground = ground;
        check_ok(stratus_solve(&problem, 2, geometries.data(), r.data(), t.data()));
        expect_same(solve_stack(in_cpp(haze_over_cloud, 1), read_ground(ground), mu, {.nodes = 12}),
                    geometries, r, t);
    }
    problem.below = STRATUS_NOTHING_BELOW;
    problem.size = offsetof(stratus_problem, below_ground);  // of an older header
    check_ok(stratus_solve(&problem, 2, geometries.data(), r.data(), t.data()));
}

TEST(SolverInC, RefusesInWords) {
    stratus_problem problem = make_problem(haze_over_cloud, 2);
    const stratus_geometry good{0.5, 0.5, 0}, flat{0, 0.5, 0}, nowhere{0.5, 0.5, infinity};
    stratus_solved r{7, 7, 7};
    const auto refused = [&](const stratus_problem* of, const stratus_geometry* at,
                             const char* part) {
        expect_refused(stratus_solve(of, 1, at, &r, nullptr), part);
        EXPECT_EQ(r.single, 7);
    };
    refused(nullptr, &good, "stratus_solve: problem must be given");
    refused(&problem, nullptr, "geometries must be given");
    refused(&problem, &flat, "mu_in must be in (0, 1], got 0");
    refused(&problem, &nowhere, "azimuth must be finite, got inf");
    const auto refused_with = [&](auto change, const char* part) {
        stratus_problem bad = problem;
        change(bad);
        refused(&bad, &good, part);
    };
    refused_with([](stratus_problem& of) { of.size -= 4; }, "problem.size");
    refused_with([](stratus_problem& of) { of.layer_count = 0; }, "layer_count");
    refused_with([](stratus_problem& of) { of.layers = nullptr; }, "layers must be given");
    refused_with([](stratus_problem& of) { of.below = 4; }, "problem.below must be nothing");
    refused_with([](stratus_problem& of) { of.below = 1, of.below_albedo = 2; },
                 "problem.below_albedo must be in [0, 1], got 2");
    refused_with([](stratus_problem& of) { of.below = 2; }, "below_phase_function must be given");
    refused_with([](stratus_problem& of) { of.below = 3; }, "below_ground must be given");
    refused_with([](stratus_problem& of) { of.below = 3, of.below_ground = "ocean:wind=900"; },
                 "got 900");
    stratus_level_light inside{};
    const double deep = 5, steep = 1;
    expect_refused(stratus_solve_levels(&problem, 1, &deep, 1, &steep, &inside, nullptr), "got 5");
    stratus_problem few_orders = problem;
    few_orders.orders = 2;
    expect_refused(stratus_solve_levels(&few_orders, 1, &steep, 1, &steep, &inside, nullptr),
                   "orders");
    expect_refused(stratus_solve_levels(&problem, 1, &steep, 1, &steep, nullptr, nullptr),
                   "every array must be given");
    refused_with([](stratus_problem& of) { of.nodes = 513; }, "nodes must be in [1, 512], got 513");
    refused_with([](stratus_problem& of) { of.orders = 201; }, "orders must be in [0, 200]");
    stratus_layer endless[2] = {{"rayleigh", 1, infinity}, {"isotropic", 1, 1}};
    refused_with([&](stratus_problem& of) { of.layers = endless; }, "got inf");
    endless[0] = {"rayleig", 1, 1};
    refused_with([&](stratus_problem& of) { of.layers = endless; }, "rayleig");
    stratus_fluxes uniform{};
    expect_refused(stratus_solve_fluxes(&problem, 0, nullptr, nullptr, nullptr, &uniform),
                   "uniform.size");
    expect_refused(stratus_solve_fluxes(&problem, 1, nullptr, nullptr, nullptr, nullptr),
                   "every array must be given");
}

const char* const small_recipe =
    "title = 'From C'\n"
    "phase_function = 'henyey_greenstein:g=0.4'\n"
    "tolerance = 1e-2\n"
    "optical_depth = { min = 0.5, max = 2.0 }\n"
    "albedo = { min = 0.75, max = 1.0 }\n"
    "[discretisation]\n"
    "nodes = 9\n"
    "modes = 7\n"
    "mu_samples = 11\n"
    "azimuth_samples = 6\n"
    "optical_depth_samples_per_octave = 5\n"
    "albedo_samples = 4\n";

/// What callbacks were told.
struct Told {
    int calls = 0, notes = 0;
    double most = 0;
    int stop_at = 0;  // 0: never

    stratus_bake_options options() {
        stratus_bake_options options{};
        options.size = sizeof options;
        options.user = this;
        options.progress = [](void* user, double done, const char* stage) {
            Told& told = *static_cast<Told*>(user);
            EXPECT_GE(done, 0);
            EXPECT_LE(done, 1);
            EXPECT_STRNE(stage, "");
            told.most = std::max(told.most, done);
            return ++told.calls == told.stop_at ? 1 : 0;
        };
        options.note = [](void* user, const char* line) {
            EXPECT_STRNE(line, "");
            ++static_cast<Told*>(user)->notes;
        };
        return options;
    }
};

TEST(BakerInC, BakesPacksAndWritesTheTablesOfCpp) {
    Told told;
    const stratus_bake_options options = told.options();
    stratus_table* table = nullptr;
    check_ok(stratus_bake(small_recipe, &options, &table));
    EXPECT_GT(told.calls, 1);
    EXPECT_GT(told.notes, 0);
    EXPECT_EQ(told.most, 1);
    EXPECT_STREQ(stratus_table_text(table, "title"), "From C");
    const Table same = bake(parse_recipe(small_recipe));
    const stratus_point point{1.2, 0.9, 0.5, 0.7, 1};
    stratus_scattered r{};
    check_ok(stratus_table_reflection(table, 1, &point, &r));
    EXPECT_EQ(r.multiple, reflection(same.view(), 0.9, 1.2, {0.5, 0.7, 1}).multiple);

    stratus_table *packed = nullptr, *read = nullptr;
    check_ok(stratus_table_pack(table, &packed));
    const PackedTable same_packed(pack(same));
    const float depth = 1.2f, albedo = 0.9f, mu_in = 0.5f, mu_out = 0.7f, azimuth = 1;
    float total = 0, expected = 0;
    check_ok(stratus_table_reflection_many(packed, 1, &depth, &albedo, &mu_in, &mu_out, &azimuth,
                                           &total));
    same_packed.reflection({&albedo, &depth, &mu_in, &mu_out, &azimuth, 1}, &expected);
    EXPECT_EQ(total, expected);

    const test::TemporaryFolder folder;
    for (const char* name : {"t.h5", "t.exr", "t.stratus"}) {
        check_ok(stratus_table_write(table, (folder / name).c_str()));
        check_ok(stratus_table_open((folder / name).c_str(), &read));
        stratus_scattered again{};
        check_ok(stratus_table_reflection(read, 1, &point, &again));
        // Of a packed one four tenths of the tolerance.
        const double allowed = name[2] == 's' ? 4e-3 : 0;
        EXPECT_NEAR(again.multiple / r.multiple, 1, allowed) << name;
        stratus_table_close(read);
    }
    EXPECT_EQ(folder.size(), 3u);
    expect_refused(stratus_table_write(table, (folder / "t.txt").c_str()), ".exr");
    expect_refused(stratus_table_write(table, (folder / "absent" / "t.stratus").c_str()), "absent",
                   STRATUS_FAILED);
    expect_refused(stratus_table_write(packed, (folder / "p.stratus").c_str()),
                   "table must be one with samples, got a packed one");
    expect_refused(stratus_table_pack(packed, &read), "a packed one");
    EXPECT_EQ(read, nullptr);
    stratus_table_close(packed);
    stratus_table_close(table);
}

TEST(BakerInC, BakesStacks) {
    const std::string recipe =
        "tolerance = 2e-2\n"
        "[[layers]]\nphase_function = 'rayleigh'\nalbedo = 1.0\noptical_depth = 0.1\n"
        "[[layers]]\nphase_function = 'henyey_greenstein:g=0.7'\nalbedo = 0.9\noptical_depth = "
        "4.0\n"
        "[discretisation]\nnodes = 12\nmodes = 10\nmu_samples = 20\nazimuth_samples = 12\n";
    stratus_table* table = nullptr;
    check_ok(stratus_bake(recipe.c_str(), nullptr, &table));
    std::size_t count = 0;
    const stratus_layer* const layers = stratus_table_layers(table, &count);
    ASSERT_EQ(count, 2u);
    EXPECT_STREQ(layers[0].phase_function, "rayleigh");
    EXPECT_EQ(layers[1].optical_depth, 4);
    const stratus_table_info info = described(table);
    EXPECT_EQ(info.is_stack, 1);
    // The table against the solver, through the layers that it tells of.
    const stratus_problem problem = make_problem(layers, count, 24);
    const stratus_geometry geometry{0.8, 0.4, 1};
    const stratus_point point{info.optical_depth.lowest, info.albedo.lowest, 0.8, 0.4, 1};
    stratus_scattered met{};
    stratus_solved solved{};
    check_ok(stratus_table_transmission(table, 1, &point, &met));
    check_ok(stratus_solve(&problem, 1, &geometry, nullptr, &solved));
    EXPECT_NEAR(met.single + met.multiple, solved.single + solved.multiple,
                2e-2 * (solved.single + solved.multiple));
    stratus_slice* slice = nullptr;
    check_ok(stratus_slice_bind(table, 1, &info.optical_depth.lowest, &info.albedo.lowest, nullptr,
                                &slice));
    stratus_slice_free(slice);
    stratus_table_close(table);
}

TEST(BakerInC, StopsWhenToldTo) {
    Told told;
    told.stop_at = 2;
    const stratus_bake_options options = told.options();
    int unused = 0;
    auto* table = reinterpret_cast<stratus_table*>(&unused);
    expect_refused(stratus_bake(small_recipe, &options, &table),
                   "stratus_bake: stopped by the program", STRATUS_STOPPED);
    EXPECT_EQ(table, nullptr);
    EXPECT_LT(told.most, 1);
}

TEST(BakerInC, RefusesInWords) {
    stratus_table* table = nullptr;
    const auto refused = [&](const char* recipe, const stratus_bake_options* options,
                             const char* part) {
        expect_refused(stratus_bake(recipe, options, &table), part);
        EXPECT_EQ(table, nullptr);
    };
    refused(nullptr, nullptr, "stratus_bake: recipe must be given");
    refused("tolerance = 2", nullptr, "recipe: phase_function must be present");
    stratus_bake_options options{};
    refused(small_recipe, &options, "options.size");
    options.size = sizeof options;
    options.threads = -1;
    refused(small_recipe, &options, "options.threads must be in [0, 1024], got -1");
    options.threads = 0;
    options.folder = "nowhere";
    expect_refused(stratus_bake("phase_function = 'tabulated:file=moon.csv'", &options, &table),
                   "nowhere/moon.csv", STRATUS_FAILED);
    expect_refused(stratus_table_write(nullptr, "t.h5"), "table must be given");
    expect_refused(stratus_bake(small_recipe, nullptr, nullptr), "table must be given");
}

}  // namespace
}  // namespace stratus
