// What layers scatter in scenes, against the solver and against closed forms.
#include <stratus/scene/layer_light.h>

#include <stratus/bake/stack_file.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/scene/render.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "indices.h"
#include "layer_fluxes.h"
#include "refusal.h"
#include "small_scene.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stratus::test {
namespace {

constexpr double tolerance = 5e-3;  // of the tables here

constexpr Geometry over_ground{0.8, 0.3, 0.4};

/// A channel of a layer of this depth.
LayerSolution solved(const SceneLayer& layer, std::size_t channel, double depth,
                     const LowerBoundary& boundary = {}) {
    return solve_layer(layer.channels.empty() ? layer.components[0] : layer.channels[channel],
                       layer.albedo[channel], depth * layer.extinction[channel],
                       {over_ground.mu_in, over_ground.mu_out}, {}, boundary);
}

/// What the layer scatters and what passes through it from the ground sum to the light over a Lambert surface.
void expect_light_over_ground(const Scene& scene, const LayerLight& light, double depth) {
    const Rgb ground = the_planet(scene).surface.colour;
    const Matter matter{depth, scene.layer.albedo, 1};
    const Rgb3 from_layer = light.reflection(matter, over_ground);
    const Rgb3 from_ground =
        light.total_transmittance(matter, 0.3) * light.ground(matter, 0.8, ground);
    const double ground_albedo[] = {ground.r, ground.g, ground.b};
    for (const auto c : three_channels) {
        const LayerSolution both =
            solved(scene.layer, c, depth, LowerBoundary::surface(ground_albedo[c]));
        EXPECT_NEAR((from_layer[c] + from_ground[c]) / both.reflection(0, 1, 0.4).total, 1,
                    1.5 * tolerance)
            << "depth " << depth << " ground " << ground_albedo[c];
    }
}

TEST(LayerLight, MatchesTheSolver) {
    Scene scene = small_planet(0, 3, 0.95);
    the_planet(scene).surface.colour = {0.2f, 0.6f, 1.0f};
    scene.tolerance = tolerance;
    for (const Rgb3& extinction : {Rgb3{1, 1, 1}, Rgb3{0.125, 0.5, 1}})
        for (const bool varied : {false, true}) {
            scene.layer.extinction = extinction;
            scene.layer.optical_depth.pattern =
                varied ? DepthMap::Pattern::clouds : DepthMap::Pattern::plain;
            const BakedLight light = light_of_all_directions(scene);
            for (const double depth :
                 varied ? std::vector<double>{0.004, 0.05, 0.3, 2.9} : std::vector<double>{3})
                expect_light_over_ground(scene, light, depth);
            const Matter matter{3, scene.layer.albedo, 1};
            const Rgb3 reflected = light.reflection(matter, over_ground),
                       transmitted = light.transmission(matter, over_ground),
                       beam = light.beam(matter, 0.8), albedo = light.plane_albedo(matter, 0.8);
            for (const auto c : three_channels) {
                SCOPED_TRACE(c);
                const LayerSolution free = solved(scene.layer, c, 3);
                EXPECT_NEAR(reflected[c] / free.reflection(0, 1, 0.4).total, 1, tolerance);
                EXPECT_NEAR(transmitted[c] / free.transmission(0, 1, 0.4).total, 1, tolerance);
                EXPECT_NEAR(beam[c], std::exp(-3 * extinction[c] / 0.8), 1e-15);
                EXPECT_NEAR(albedo[c] / free.plane_albedo(0), 1, tolerance);
            }
        }
}

TEST(LayerLight, OfThinMatterOfSeveralDepthsIsTheSolvers) {
    constexpr double law_of_thin_layers = 0.02;  // its error in the orders n >= 2
    Scene scene = small_slab(0.01, 1);
    scene.effects.single = false;
    scene.tolerance = tolerance;
    const auto expect_multiple = [&](double thinner) {
        const BakedLight light = light_of_all_directions(scene);
        const Rgb3 found = light.reflection({0.01 * thinner, scene.layer.albedo, 1}, over_ground);
        for (const auto c : three_channels)
            EXPECT_NEAR(
                found[c] / solved(scene.layer, c, 0.01 * thinner).reflection(0, 1, 0.4).multiple, 1,
                law_of_thin_layers)
                << c;
    };
    scene.layer.extinction = {1, 0.5, 0.1};
    expect_multiple(1);
    scene.layer.extinction = {1, 1, 1};
    cover_with_clouds(scene);
    expect_multiple(0.2);
}

TEST(LayerLight, ChannelsHaveTheirOwnPhaseFunctionsAndDepths) {
    Scene scene = small_planet(0, 3, 1);
    scene.layer.channels = {PhaseFunction::isotropic(), PhaseFunction::henyey_greenstein(0.6),
                            PhaseFunction::henyey_greenstein(-0.3)};
    scene.layer.components = {scene.layer.channels[1]};
    scene.layer.albedo = {0.95, 0.6, 0.99};
    scene.layer.extinction = {0.5, 1, 1.5};
    the_planet(scene).surface.colour = {0.25f, 0.5f, 1.0f};
    scene.tolerance = tolerance;
    for (const bool varied : {false, true}) {
        if (varied) cover_with_clouds(scene);
        const BakedLight light(scene);
        const Rgb3 reflected = light.reflection({3, scene.layer.albedo, 1}, over_ground);
        for (const auto c : three_channels) {
            const LayerSolution free = solved(scene.layer, c, 3);
            EXPECT_NEAR(reflected[c] / free.reflection(0, 1, 0.4).total, 1, tolerance) << c;
        }
        expect_light_over_ground(scene, light, 3);
    }
}

TEST(LayerLight, ColoursThatAreAlikeAreSummedAsOne) {
    Scene scene = small_planet(0, 2, 1);
    scene.effects.multiple = false;
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.6);
    scene.layer.channels = {forward, forward, PhaseFunction::isotropic()};
    scene.layer.components = {forward};
    scene.layer.albedo = {0.9, 0.9, 0.9};
    const LayerLight light(scene, nullptr);
    ASSERT_TRUE(light.has_sums());
    const Geometry geometry{0.8, 0.3, 0.4};
    Rgb3 sum{};
    LightSum sums(light);
    sums.into(sum);
    sums.add(Side::reflection, geometry, {0.5, 2, 4});
    sums.finish();
    const double share[] = {0.5, 2, 4}, cosine = cos_scattering_angle_reflected(geometry);
    for (const auto c : three_channels) {
        const double phase = scene.layer.channels[c](cosine);
        EXPECT_NEAR(sum[c] / share[c], single_reflection(phase, 0.9, 2, 0.8, 0.3), 1e-6) << c;
    }
}

TEST(LayerFluxes, AreThoseOfTheTableAtItsSamplesForOwnAndOtherAlbedos) {
    Scene scene = small_planet(0, 4, 1);
    scene.layer.albedo = {0.6, 0.9, 0.98};
    the_planet(scene).surface.colour = {0.5f, 0.5f, 0.5f};
    cover_with_clouds(scene);
    scene.tolerance = 2e-2;
    const auto baked = bake_layer_table(*needed_recipe(scene, LightPath::fluxes));
    const Table& table = baked->headers[0];
    const std::size_t albedos = table.albedo.values.size(),
                      depths = table.optical_depth.values.size(),
                      cosines = table.mu_in.values.size();
    ASSERT_GT(albedos, 1u);
    const std::size_t a = albedos / 2, d = depths - 2, m = 1;
    const double albedo = table.albedo.values[a];
    for (const bool own : {false, true}) {
        const double given = own ? albedo : 0.5;
        const LayerFluxes fluxes(baked->headers, {given, given, given});
        LayerFluxes::Place place;
        fluxes.set_cosine(place, table.mu_in.values[m]);
        for (const std::size_t depth : {d, std::size_t{0}}) {
            const std::size_t row = a * depths + depth;
            fluxes.set_optical_depth(place, table.optical_depth.values[depth]);
            fluxes.set_albedo(place, 0, albedo);
            EXPECT_NEAR(fluxes.at(place, LayerFluxes::spherical_albedo),
                        double{table.spherical_albedo[row]}, 1e-6);
            EXPECT_NEAR(fluxes.at(place, LayerFluxes::plane_albedo),
                        double{table.plane_albedo[row * cosines + m]}, 1e-6);
            EXPECT_NEAR(fluxes.at(place, LayerFluxes::diffuse_transmittance),
                        double{table.diffuse_transmittance[row * cosines + m]}, 1e-6);
        }
    }
}

TEST(LayerFluxes, AreTheSolversBetweenTheSamplesOfTheTableAndInThinnerLayers) {
    Recipe recipe;
    recipe.tolerance = 2e-3;
    recipe.mu_out = {1, 1};
    recipe.discretisation.modes = recipe.discretisation.azimuth_samples = 1;
    struct Case {
        Range depths, albedos;
        std::vector<std::pair<double, double>> layers;  // optical depth, albedo
    };
    for (const Case& each : std::vector<Case>{
             {{10, 10}, {0.9, 1}, {{10, 0.97}, {10, 0.9}}},
             {{0.02, 40}, {0.9, 0.9}, {{1e-4, 0.9}, {0.003, 0.9}, {0.05, 0.9}, {12, 0.9}, {32, 0.9}}},
             {{2, 2}, {0, 1}, {{2, 0.05}, {2, 0.3}, {2, 0.97}}},
             {{0.5, infinity}, {0.9, 1}, {{7, 0.97}, {40, 1}, {100, 0.9999}}},
         }) {
        recipe.optical_depth = each.depths;
        recipe.albedo = each.albedos;
        const auto baked = bake_layer_table(recipe);
        for (const auto& [depth, albedo] : each.layers)
            for (const bool own : {false, true}) {
                SCOPED_TRACE(testing::Message() << "depth " << depth << " albedo " << albedo);
                const double given = own ? albedo : 0.93, mu = 0.7;
                const LayerFluxes fluxes(baked->headers, {given, given, given});
                LayerFluxes::Place place;
                fluxes.set_cosine(place, mu);
                fluxes.set_optical_depth(place, depth);
                fluxes.set_albedo(place, 0, albedo);
                const LayerSolution free =
                    solve_layer(recipe.phase_function, albedo, depth, {mu}, {});
                EXPECT_NEAR(fluxes.at(place, LayerFluxes::diffuse_transmittance) /
                                free.diffuse_transmittance(0),
                            1, recipe.tolerance);
                EXPECT_NEAR(fluxes.at(place, LayerFluxes::plane_albedo) / free.plane_albedo(0), 1,
                            recipe.tolerance);
                EXPECT_NEAR(fluxes.at(place, LayerFluxes::spherical_albedo) / free.spherical_albedo,
                            1, recipe.tolerance);
            }
    }
}

TEST(LayerLight, ChannelsScatterTheBackgroundByTheirOwnPhaseFunctions) {
    Scene scene = once(small_slab(2, 1));
    scene.layer.channels = {PhaseFunction::isotropic(), PhaseFunction::henyey_greenstein(0.6),
                            PhaseFunction::rayleigh()};
    scene.layer.components = {scene.layer.channels[1]};
    scene.layer.albedo = {0.5, 0.6, 0.7};
    scene.layer.extinction = {0.5, 1, 1.5};
    const LayerLight light(scene, nullptr);
    const Rgb3 seen = light.background(*uniform_matter(scene), 0.4);
    for (const auto c : three_channels) {
        const double depth = 2 * scene.layer.extinction[c];
        const SingleDiffuseTransmittance once(scene.layer.channels[c]);
        EXPECT_DOUBLE_EQ(seen[c], std::exp(-depth / 0.4) + scene.layer.albedo[c] * once(depth, 0.4))
            << c;
    }
}

TEST(LayerLight, SingleScatteringIsTheClosedForm) {
    const Scene scene = once(small_rings(1));
    const LayerLight light(scene, nullptr);
    const Geometry geometry{0.6, 0.5, 2.5};
    const Matter matter{1.2, {0.8, 0.4, 0}, 0.25};
    auto phase = [&](double cosine) {
        return 0.25 * scene.layer.components[0](cosine) + 0.75 * scene.layer.components[1](cosine);
    };
    const double R = single_reflection(phase(cos_scattering_angle_reflected(geometry)), 0.8, 1.2,
                                       0.6, 0.5),
                 T = single_transmission(phase(cos_scattering_angle_transmitted(geometry)), 0.8,
                                         1.2, 0.6, 0.5);
    EXPECT_NEAR(light.reflection(matter, geometry)[0], R, 1e-15);
    EXPECT_NEAR(light.reflection(matter, geometry)[1], R / 2, 1e-15);
    EXPECT_EQ(light.reflection(matter, geometry)[2], 0);
    EXPECT_NEAR(light.transmission(matter, geometry)[0], T, 1e-15);
}

TEST(LayerLight, IsZeroForAnEmptyLayer) {
    const Scene scene = small_slab(0, 1);
    const LayerLight light(scene, nullptr);
    const Matter nothing{0, {1, 1, 1}, 1};
    EXPECT_EQ(light.reflection(nothing, {0.5, 0.5, 0})[0], 0);
    EXPECT_EQ(light.transmission(nothing, {0.5, 0.5, 0})[0], 0);
    EXPECT_EQ(light.beam(nothing, 0.1)[1], 1);
}

TEST(LayerLight, AppliesEachEffect) {
    Scene scene = once(small_slab(1, 0.8));
    scene.layer.density = 0.5;
    scene.layer.opposition = Opposition::hapke(1, 0.1);
    const Matter matter = *uniform_matter(scene);
    const Geometry geometry{0.5, 0.5, pi};  // phase angle 0
    auto reflection = [&] { return LayerLight(scene, nullptr).reflection(matter, geometry)[0]; };
    const double phase = 1.5;  // Rayleigh, straight back
    // The bump has a cusp at phase angle 0, where slices have three digits of the angle; the rest
    // is single precision.
    EXPECT_NEAR(reflection() / (2 * single_reflection(phase, 0.8, 2, 0.5, 0.5)), 1, 5e-3);
    scene.effects.opposition = false;
    EXPECT_NEAR(reflection(), single_reflection(phase, 0.8, 2, 0.5, 0.5), 1e-6);
    scene.effects.density = false;
    EXPECT_NEAR(reflection(), single_reflection(phase, 0.8, 1, 0.5, 0.5), 1e-6);
    EXPECT_NEAR(LayerLight(scene, nullptr).beam(matter, 0.5)[1], std::exp(-2), 1e-15);
    scene.effects.reflection = false;
    EXPECT_EQ(reflection(), 0);
    scene.effects.reflection = true;
    scene.effects.single = false;
    EXPECT_EQ(reflection(), 0);
}

TEST(LayerLight, HasBlinnsOppositionWhereTheLayerVariesToo) {
    Scene scene = once(small_slab(1, 0.8));
    scene.layer.density = 0.2;
    scene.layer.opposition = Opposition::blinn(0.2);
    const Matter matter = *uniform_matter(scene);
    const LayerLight uniform(scene, nullptr);
    cover_with_clouds(scene);
    const LayerLight varied(scene, nullptr);
    const Opposition seen = seen_opposition(scene.layer.opposition, 0.2);
    for (const Geometry& at :
         {Geometry{0.5, 0.5, 3}, Geometry{0.7, 0.9, 2.8}, Geometry{0.1, 1, 1}}) {
        const double c = cos_scattering_angle_reflected(at);
        const double expected =
            single_reflection(scene.layer.components[0](c), 0.8, 1 / 0.8, at.mu_in, at.mu_out) *
            opposition_factor(seen, c, 1 / 0.8, at.mu_in, at.mu_out);
        EXPECT_NEAR(uniform.reflection(matter, at)[0], expected, 1e-3 * expected);
        EXPECT_NEAR(varied.reflection(matter, at)[0], expected, 1e-3 * expected);
    }
}

TEST(LayerLight, RefusesHigherOrdersWithoutATable) {
    const Scene scene = small_slab(1, 0.8);
    expect_refusal([&] { LayerLight(scene, nullptr); }, {"tables", "n >= 2"});
}

/// The scene's layer as a stack.
void stack(Scene& scene, std::vector<StackLayer> layers) {
    const StackLayer mean = mean_layer(layers);
    scene.layer.components = {mean.phase_function};
    scene.layer.albedo.fill(mean.albedo);
    scene.layer.optical_depth.max = mean.optical_depth;
    scene.layer.stacks = {std::move(layers)};
}

const std::vector<StackLayer> haze_under_air{{PhaseFunction::rayleigh(), 1, 0.3},
                                             {PhaseFunction::henyey_greenstein(0.6), 0.9, 2}};

TEST(LayerLight, OfAStackMatchesTheSolver) {
    Scene scene = small_slab(1, 1);
    stack(scene, haze_under_air);
    scene.tolerance = tolerance;
    const Geometry geometry{0.7, 0.4, 1.1};
    const StackSolution solved = solve_stack(haze_under_air, {}, {0.7, 0.4});
    const double beam = std::exp(-2.3 / 0.4);
    for (const bool multiple : {false, true}) {
        scene.effects.multiple = multiple;
        const std::optional<Recipe> needed = needed_recipe(scene);
        ASSERT_EQ(needed.has_value(), multiple);
        const auto tables = needed ? bake_layer_tables(of_all_directions(*needed)) : nullptr;
        const LayerLight light(scene, tables.get());
        const Matter matter = *uniform_matter(scene);
        const SolvedValue reflected = solved.reflection(0, 1, 1.1),
                          transmitted = solved.transmission(0, 1, 1.1);
        EXPECT_NEAR(
            light.reflection(matter, geometry)[1] / (multiple ? reflected.total : reflected.single),
            1, tolerance);
        EXPECT_NEAR(light.transmission(matter, geometry)[1] /
                        (multiple ? transmitted.total : transmitted.single),
                    1, tolerance);
        const double background = light.background(matter, 0.4)[1];
        if (multiple)
            EXPECT_NEAR(background, beam + solved.diffuse_transmittance(1), tolerance);
        else
            EXPECT_LT(background, beam + solved.diffuse_transmittance(1));
        EXPECT_GT(background, beam);
        EXPECT_EQ(light.background({0, matter.albedo, 1}, 0.4)[1], 1);  // beyond its edges
    }
}

TEST(LayerLight, OfAColouredStackMatchesTheSolverFromEitherSide) {
    const TemporaryFolder folder;
    set_content(folder / "stack.toml",
                "[[layers]]\nphase_function = 'rayleigh'\nalbedo = 1\n"
                "optical_depth = [0.2, 0.4, 0.4]\n"
                "[[layers]]\nphase_function = ['isotropic', 'henyey_greenstein:g=0.5', "
                "'henyey_greenstein:g=0.5']\nalbedo = [0.9, 0.6, 0.6]\noptical_depth = 2\n");
    const std::vector<Stack> stacks = read_coloured_stack(folder / "stack.toml");
    for (const bool beneath : {false, true})
        for (const bool same_side : {true, false}) {
            const std::string sun = beneath ? "-30" : "30",
                              eye = beneath == same_side ? "-50" : "50";
            const Scene scene =
                parse_scene(
                    "[picture]\nwidth = 1\nheight = 1\n[camera]\ndistance = 9.0\n"
                    "orthographic_width = 1.0\nelevation_deg = " +
                        eye + "\n[sun]\nazimuth_deg = 60.0\nelevation_deg = " + sun +
                        "\n[layer]\nstack = 'stack.toml'\n[slab]\n",
                    folder.path().string())
                    .panels[0];
            ASSERT_EQ(shared_recipes(channel_scenes(scene)).size(), 2u) << "green is blue";
            const Image picture = render(scene, BakedLight(scene));
            const Geometry at =
                scattering_geometry({0, 0, 1}, scene.to_sun, -scene.camera.forward());
            for (const auto c : three_channels) {
                std::vector<StackLayer> lit = stacks[c].layers;
                if (beneath && same_side) std::ranges::reverse(lit);
                const StackSolution solved = solve_stack(lit, {}, {at.mu_in, at.mu_out});
                // T from beneath is that from above the other way round.
                const double expected = same_side ? solved.reflection(0, 1, at.azimuth).total
                                        : beneath ? solved.transmission(1, 0, at.azimuth).total
                                                  : solved.transmission(0, 1, at.azimuth).total;
                EXPECT_NEAR(double{picture.rgb[c]} / (at.mu_in * expected), 1, scene.tolerance)
                    << sun << " " << eye << " " << c;
            }
        }
}

TEST(LayerLight, OfAStackOverGroundMatchesTheSolver) {
    Scene scene = small_planet(0, 1, 1);
    stack(scene, haze_under_air);
    auto& ground = the_planet(scene).surface.colour;
    ground = {0.2f, 0.6f, 1.0f};
    scene.tolerance = tolerance;
    const BakedLight light(scene);
    const Matter matter = *uniform_matter(scene);
    const Rgb3 found = light.reflection(matter, {0.8, 0.3, 0.4}) +
                       light.total_transmittance(matter, 0.3) * light.ground(matter, 0.8, ground);
    const double albedo[] = {0.2, 0.6, 1.0};
    for (const auto c : three_channels) {
        const StackSolution both =
            solve_stack(haze_under_air, LowerBoundary::surface(albedo[c]), {0.8, 0.3});
        EXPECT_NEAR(found[c] / both.reflection(0, 1, 0.4).total, 1, 1.5 * tolerance);
    }
}

}  // namespace
}  // namespace stratus::test
