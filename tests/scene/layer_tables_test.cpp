#include <stratus/base/constants.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/render.h>

#include "all_near.h"
#include "refusal.h"
#include "small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace stratus {
namespace {

void expect_range(const Range& range, double min, double max) {
    EXPECT_EQ(range.min, min);
    EXPECT_EQ(range.max, max);
}

TEST(NeededRecipe, HasOnlyReflectionForASemiInfiniteLayer) {
    const auto recipe = needed_recipe(small_planet(0, infinity, 0.4));
    ASSERT_TRUE(recipe);
    EXPECT_EQ(recipe->optical_depth.min, infinity);
    expect_range(recipe->albedo, 0.4, 0.4);
    EXPECT_TRUE(recipe->reflection);
    EXPECT_FALSE(recipe->transmission);
    EXPECT_EQ(recipe->phase_function.text(), "rayleigh");
}

TEST(NeededRecipe, IsEmptyWithoutMultipleScattering) {
    EXPECT_TRUE(needed_recipes(once(small_planet(0, 2, 0.4))).empty());
    EXPECT_TRUE(needed_recipes(small_planet(0, 0, 0.4)).empty());
    EXPECT_TRUE(needed_recipes(small_planet(0, 2, 0)).empty());
}

TEST(NeededRecipe, HasTheSidesThatTheSceneUses) {
    Scene planet = small_planet(0, 2, 0.4);
    EXPECT_FALSE(needed_recipe(planet)->transmission);
    EXPECT_FALSE(needed_recipe(planet, LightPath::fluxes)) << "what passes is lost";
    the_planet(planet).surface.colour = {0.5f, 0.5f, 0.5f};
    EXPECT_TRUE(needed_recipe(planet, LightPath::fluxes)->transmission) << "it lights the ground";
    Scene slab = small_slab(2, 0.4);
    EXPECT_FALSE(needed_recipe(slab)->transmission);
    EXPECT_TRUE(needed_recipe(slab, LightPath::fluxes)->transmission)
        << "the background shines through";
    slab.effects.transmission = false;
    EXPECT_FALSE(needed_recipe(slab, LightPath::fluxes)->transmission);
    slab.effects.transmission = true;
    slab.effects.reflection = false;
    EXPECT_FALSE(needed_recipe(slab)) << "of the lit side";
    EXPECT_TRUE(needed_recipe(slab, LightPath::fluxes));
    slab.effects.reflection = true;
    slab.background.colour = {0, 0, 0};
    EXPECT_FALSE(needed_recipe(slab)->transmission) << "of the far side";
    EXPECT_FALSE(needed_recipe(slab, LightPath::fluxes)) << "nothing shines through";
    slab.to_sun = direction_at(radians(-50), 1);
    EXPECT_TRUE(needed_recipe(slab)->transmission);
    EXPECT_FALSE(needed_recipe(slab)->reflection);
    slab.background.colour = {1, 1, 1};
    EXPECT_EQ(needed_recipe(slab)->mu_in.min, 0) << "with T, it holds the fluxes, too";
    EXPECT_FALSE(needed_recipe(slab, LightPath::fluxes));
    slab.background.colour = {0, 0, 0};
    slab.effects.transmission = false;
    EXPECT_TRUE(needed_recipes(slab).empty()) << "seen from its unlit side";
}

TEST(NeededRecipe, CoversAllDepthsAndAlbedos) {
    Scene scene = small_rings(2);
    auto& rings = the_rings(scene);
    rings.profile.optical_depth[1] = 0.5;
    rings.profile.w2[0] = 0.35;
    scene.layer.albedo = {1, 0.5, 0.25};
    const auto recipe = needed_recipe(scene);
    expect_range(recipe->optical_depth, 0.5, 2);
    expect_range(recipe->albedo, 0.15, 0.85);
    scene.layer.density = 0.5;
    EXPECT_EQ(needed_recipe(scene)->optical_depth.max, 4);
    scene.effects.density = false;
    EXPECT_EQ(needed_recipe(scene)->optical_depth.max, 2);
}

TEST(NeededRecipe, HasSeveralDepthsWhereThinMatterVaries) {
    expect_range(needed_recipe(small_slab(0.02, 0.4))->optical_depth, 0.02, 0.02);
    Scene clouds = small_slab(0.02, 0.4);
    cover_with_clouds(clouds);
    expect_range(needed_recipe(clouds)->optical_depth, 0.01, 0.02);
    Scene rings = small_rings(0.02);
    the_rings(rings).profile.optical_depth[1] = 0.002;
    expect_range(needed_recipe(rings)->optical_depth, 0.01, 0.02);
    expect_range(needed_recipe(small_slab(1e-7, 0.4))->optical_depth, 1e-6, 2e-6);
}

TEST(NeededRecipe, CoversTheEdgesOfRingsDownToEmptyRows) {
    Scene scene = small_rings(1);
    RingProfile& profile = the_rings(scene).profile;
    profile = {
        {1.5, 1.6, 2.2, 2.5}, {0, 0, 4, 4}, {0.875, 0.125, 0.25, 0.25}, {0, 0.125, 0.5, 0.5}};
    const auto recipe = needed_recipe(scene);
    expect_range(recipe->optical_depth, 0.02, 4);
    expect_range(recipe->albedo, 0.25, 0.75);
    ASSERT_TRUE(is_mixture_alone(*recipe));
    expect_range(*mixture_range(*recipe), 1.0 / 3, 0.5);
    profile.w1[1] = profile.w2[1] = 0;
    const auto dark = needed_recipe(scene);
    expect_range(dark->albedo, 0, 0.75);
    EXPECT_EQ(mixture_range(*dark), nullptr) << "black matter has none of its own";
    std::ranges::reverse(profile.optical_depth);
    expect_range(needed_recipe(scene)->optical_depth, 0.02, 4);
    profile.optical_depth = {0, 0, 0, 0};
    EXPECT_FALSE(needed_recipe(scene)) << "empty rows alone";
}

TEST(NeededRecipe, OfRingsThatThinOutHoldsTheirLight) {
    Scene rising = small_rings(1);
    rising.tolerance = 0.01;
    the_rings(rising).profile = {{1.5, 2.5}, {0, 4}, {0.3, 0.3}, {0.6, 0.6}};
    const BakedLight light(rising);
    const Geometry geometry =
        scattering_geometry({0, 0, 1}, rising.to_sun, -rising.camera.forward());
    for (const double depth : {0.1, 0.5, 1.5}) {
        Scene even = rising;
        even.subject = small_rings(depth).subject;
        the_rings(even).profile.w1 = {0.3, 0.3};
        the_rings(even).profile.w2 = {0.6, 0.6};
        const Matter matter{depth, {0.9, 0.9, 0.9}, 1.0 / 3};
        const double expected = BakedLight(even).reflection(matter, geometry)[0];
        EXPECT_NEAR(light.reflection(matter, geometry)[0], expected, 0.01 * expected) << depth;
    }
}

TEST(NeededRecipe, HasTheOneCosineOfAPointSun) {
    Scene slab = small_slab(2, 0.4);
    slab.background.colour = {0, 0, 0};
    const double mu_in = std::abs(slab.to_sun.z);
    expect_range(needed_recipe(slab)->mu_in, mu_in, mu_in);
    slab.sun_diameter = radians(2);
    const Range of_disk = needed_recipe(slab)->mu_in;
    EXPECT_LT(of_disk.min, mu_in - 0.005);
    EXPECT_GT(of_disk.max, mu_in + 0.005);
    slab.background.colour = {1, 1, 1};
    EXPECT_EQ(needed_recipe(slab, LightPath::fluxes)->mu_in.min, 0) << "fluxes towards the eye";
    slab.background.colour = {0, 0, 0};
    the_slab(slab).surface = Texture{};
    the_slab(slab).surface->colour = {0.5f, 0.5f, 0.5f};
    EXPECT_EQ(needed_recipe(slab, LightPath::fluxes)->mu_in.min, 0) << "ground";
    EXPECT_GT(needed_recipe(slab)->mu_in.min, 0);
    slab.effects.background = false;
    EXPECT_FALSE(needed_recipe(slab, LightPath::fluxes));
    EXPECT_EQ(needed_recipe(small_planet(0, 2, 0.4))->mu_in.min, 0);
}

TEST(NeededRecipe, OfFluxesHasAllCosinesAndNoAzimuth) {
    Scene rings = small_rings(1);
    rings.background.colour = {1, 1, 1};
    Scene planet = small_planet(0, 2, 0.4);
    the_planet(planet).surface.colour = {0.5f, 0.5f, 0.5f};
    for (const Scene& scene : {rings, planet}) {
        const auto recipe = needed_recipe(scene, LightPath::fluxes);
        ASSERT_TRUE(recipe);
        expect_range(recipe->mu_in, 0, 1);
        EXPECT_EQ(recipe->mu_out.min, recipe->mu_out.max);
        EXPECT_EQ(recipe->discretisation.modes, 1);
        EXPECT_FALSE(needed_recipe(scene)->transmission) << "nothing of it is seen";
    }
    EXPECT_EQ(needed_recipe(rings)->mu_in.min, needed_recipe(rings)->mu_in.max) << "a point sun";
    rings.effects.background = false;
    EXPECT_FALSE(needed_recipe(rings, LightPath::fluxes));
    planet.layer.optical_depth.max = infinity;
    EXPECT_FALSE(needed_recipe(planet, LightPath::fluxes)) << "nothing passes";
}

/// Its directions are those that sunlight does not take; it is a small part of a picture.
TEST(NeededRecipe, OfShineIsCoarserThanThatOfSunlight) {
    Scene rings = small_rings(1);
    EXPECT_FALSE(needed_recipe(rings, LightPath::shine));
    shine_on_one_another(rings, true);
    const auto shine = needed_recipe(rings, LightPath::shine);
    ASSERT_TRUE(shine);
    expect_range(shine->mu_in, 0, 1);
    for (const double cosine : {rings.to_sun.z, -rings.camera.forward().z}) {
        EXPECT_LE(shine->mu_out.min, cosine);
        EXPECT_GE(shine->mu_out.max, cosine);
    }
    EXPECT_TRUE(shine->reflection && shine->transmission);
    EXPECT_GT(shine->tolerance, rings.tolerance);
    const auto sunlight = needed_recipe(rings);
    EXPECT_EQ(sunlight->mu_in.min, sunlight->mu_in.max);
    EXPECT_EQ(sunlight->tolerance, rings.tolerance);
    the_rings(rings).surface.colour = {0, 0, 0};
    EXPECT_FALSE(needed_recipe(rings, LightPath::shine)) << "a black planet";
}

/// Small ranges that hold the camera's one direction.
TEST(NeededRecipe, HasTheDirectionsOfView) {
    Scene slab = small_slab(2, 0.4);
    slab.background.colour = {0, 0, 0};
    Scene rings = small_rings(1);
    for (const Scene& scene : {slab, rings}) {
        const Recipe recipe = *needed_recipe(scene);
        const Geometry seen = scattering_geometry({0, 0, 1}, scene.to_sun, -scene.camera.forward());
        EXPECT_LT(recipe.mu_out.min, seen.mu_out);
        EXPECT_GT(recipe.mu_out.max, seen.mu_out);
        EXPECT_LT(recipe.mu_out.max - recipe.mu_out.min, 0.11);
        EXPECT_LE(recipe.azimuth.min, degrees(seen.azimuth));
        EXPECT_GE(recipe.azimuth.max, degrees(seen.azimuth));
        EXPECT_LT(recipe.azimuth.max - recipe.azimuth.min, 11);
    }
    const Recipe of_globe = *needed_recipe(small_planet(30, 2, 0.4));
    for (const Range& cosines : {of_globe.mu_in, of_globe.mu_out}) expect_range(cosines, 0, 1);
    EXPECT_EQ(of_globe.azimuth.max, 180);
    slab.effects.azimuth = false;
    EXPECT_EQ(needed_recipe(slab)->azimuth.max, 180) << "nothing depends on it";
    slab.camera.orthographic = false;
    slab.camera.width = radians(120);
    expect_range(needed_recipe(slab)->mu_out, 0, 1);  // a wide view
}

TEST(NeededRecipe, IsThatOfACameraThatMovesALittle) {
    Scene scene = small_rings(1), moved = scene;
    scene.camera.position = 10.0 * direction_at(radians(39), radians(2));
    moved.camera.position = 10.0 * direction_at(radians(40), radians(4));
    EXPECT_EQ(resolved_text(*needed_recipe(scene)), resolved_text(*needed_recipe(moved)));
}

TEST(NeededRecipe, OfTheDirectionsOfViewGivesTheSamePicture) {
    for (Scene scene : {small_slab(2, 0.9), small_rings(2)}) {
        scene.background.colour = {0, 0, 0};
        scene.tolerance = 1e-2;
        Recipe recipe = *needed_recipe(scene);
        ASSERT_EQ(recipe.mu_in.min, recipe.mu_in.max);
        const auto narrow = bake_layer_tables(recipe);
        ASSERT_LT(recipe.azimuth.max - recipe.azimuth.min, 90);
        const auto all = bake_layer_tables(of_all_directions(recipe));
        EXPECT_EQ(narrow->paths[0]->headers[0].mu_in.values.size(), 1u);
        const Image found = render(scene, LayerLight(scene, narrow.get())),
                    expected = render(scene, LayerLight(scene, all.get()));
        float brightest = 0;
        for (const float value : expected.rgb) brightest = std::max(brightest, value);
        EXPECT_GT(brightest, 0);
        for (const auto n : indices(expected.rgb))
            EXPECT_NEAR(found.rgb[n], expected.rgb[n],
                        2 * scene.tolerance * std::max(expected.rgb[n], 0.1f * brightest));
    }
}

TEST(CommonRecipe, CoversBothScenes) {
    Recipe thin = *needed_recipe(small_slab(0.5, 0.9));
    const Recipe deep = *needed_recipe(small_slab(4, 0.6));
    thin.transmission = true;
    const auto both = common_recipe(thin, deep);
    ASSERT_TRUE(both);
    expect_range(both->optical_depth, 0.5, 4);
    expect_range(both->albedo, 0.6, 0.9);
    EXPECT_TRUE(both->transmission);
    EXPECT_FALSE(common_recipe(thin, *needed_recipe(small_planet(0, infinity, 0.9))));
    Scene other = small_slab(0.5, 0.9);
    other.layer.components = {PhaseFunction::isotropic()};
    EXPECT_FALSE(common_recipe(thin, *needed_recipe(other)));
}

TEST(CommonRecipe, CoversBothDirectionsOfView) {
    const Scene one = small_rings(1);
    Scene other = one;
    other.camera.position = 10.0 * direction_at(radians(25), radians(60));
    other.to_sun = direction_at(radians(50), 0);
    const Recipe first = *needed_recipe(one), second = *needed_recipe(other),
                 both = *common_recipe(first, second);
    for (Range Recipe::*const range : {&Recipe::mu_in, &Recipe::mu_out, &Recipe::azimuth}) {
        EXPECT_LE((both.*range).min, std::min((first.*range).min, (second.*range).min));
        EXPECT_GE((both.*range).max, std::max((first.*range).max, (second.*range).max));
        EXPECT_LT((both.*range).max, range == &Recipe::azimuth ? 180 : 1);
    }
    // With a globe, which sees all.
    Recipe globe = second;
    globe.mu_in = globe.mu_out = {0, 1};
    const Recipe symmetric = *common_recipe(first, globe);
    EXPECT_EQ(symmetric.mu_in.min, 0);
    EXPECT_EQ(symmetric.mu_out.max, 1);
}

TEST(NeededRecipe, HasAMixtureAxisForRings) {
    const Recipe recipe = *needed_recipe(small_rings(1));
    ASSERT_TRUE(is_mixture_alone(recipe));
    EXPECT_NEAR(mixture_range(recipe)->min, 0.5, 1e-15);
    EXPECT_NEAR(mixture_range(recipe)->max, 0.5 / 0.6, 1e-15);
    EXPECT_EQ(recipe.phase_function.text(), "lambert_sphere");
    EXPECT_EQ(recipe.second_phase_function.text(), "henyey_greenstein:g=0.5");
    Scene even = small_rings(1);
    the_rings(even).profile.w2 = {0.5, 0.3};
    EXPECT_EQ(mixture_range(*needed_recipe(even)), nullptr);  // one mixture everywhere: their sum
    EXPECT_FALSE(common_recipe(recipe, *needed_recipe(even)));
}

TEST(BakeFor, SharesTheTablesOfChannels) {
    Scene one = small_slab(1, 0.8);
    one.tolerance = 0.05;
    one.layer.channels = {PhaseFunction::isotropic(), PhaseFunction::rayleigh(),
                          PhaseFunction::isotropic()};
    one.layer.albedo = {0.8, 0.8, 0};
    Scene green = one;
    green.layer.channels.clear();
    const auto tables = bake_for({one, once(one), green});
    ASSERT_TRUE(tables[0]);
    EXPECT_FALSE(tables[0]->at(LightPath::sunlight));
    EXPECT_EQ(tables[0]->channels[0]->paths[0]->headers[0].phase_function.text(), "isotropic");
    EXPECT_EQ(tables[0]->channels[1]->paths, tables[2]->paths) << "the same phase function";
    EXPECT_FALSE(tables[0]->channels[2]) << "black";
    EXPECT_FALSE(tables[1]) << "scattered once";
}

auto adopt(const std::vector<Scene>& scenes, const std::vector<Table>& tables) {
    std::vector<PackedTable> packed;
    for (const Table& each : tables) packed.emplace_back(pack(each));
    return adopt_tables(scenes, std::move(packed));
}

TEST(AdoptTables, RefusesATableThatDoesNotCoverTheScene) {
    const Scene scene = small_slab(1, 0.8);
    Recipe recipe = of_all_directions(*needed_recipe(scene));
    recipe.tolerance = 0.05;
    recipe.optical_depth = {0.5, 2};
    recipe.albedo = {0.5, 0.9};
    const Table table = bake(recipe);
    EXPECT_TRUE(adopt({scene}, {table})[0]->at(LightPath::sunlight));
    auto refuse = [&](const Scene& other, const Fragments& fragments) {
        expect_refusal([&] { adopt({scene, other}, {table}); }, fragments);
    };
    refuse(small_slab(4, 0.8), {"table.optical_depth.max", "got 2"});
    refuse(small_slab(1, 0.95), {"table.albedo.max", "got 0.9"});
    refuse(small_slab(infinity, 0.8), {"table.optical_depth.max", "inf", "got 2"});
    refuse(small_rings(1), {"table.phase_function", "lambert_sphere", "got rayleigh"});
    Scene rings = small_rings(1);
    rings.layer.components[0] = scene.layer.components[0];
    refuse(rings, {"table", "with a mixture axis"});
    Scene other = scene;
    other.layer.components = {PhaseFunction::isotropic()};
    refuse(other, {"table.phase_function", "isotropic", "got rayleigh"});
    other.layer.channels = {3, PhaseFunction::rayleigh()};
    EXPECT_TRUE(adopt({other}, {table})[0]->channels[2]);
    EXPECT_TRUE(adopt({other}, {table, table, table})[0]->channels[2]);
    Recipe of_others = recipe;
    of_others.phase_function = PhaseFunction::isotropic();
    const Table foreign = bake(of_others);
    expect_refusal(
        [&] {
            adopt({scene}, {table, foreign});
        },
        {"--table", "that the scene needs", "got number 2"});
    const auto refuse_table = [&](const Table& changed, const Fragments& fragments) {
        expect_refusal([&] { adopt({scene}, {changed}); }, fragments);
    };
    Table without_reflection = table;
    without_reflection.reflection_multiple.clear();
    refuse_table(without_reflection, {"one with reflection", "got none"});
    Table of_two_orders = table;
    of_two_orders.highest_order = 2;
    refuse_table(of_two_orders, {"table.orders", "all", "got 2"});
    const auto narrowed = [&](Range Recipe::*member, const Range& range) {
        Recipe narrow = recipe;
        narrow.*member = range;
        return bake(narrow);
    };
    refuse_table(narrowed(&Recipe::mu_in, {0.5, 0.5}), {"table.mu_in.max", "got 0.5"});
    refuse_table(narrowed(&Recipe::mu_out, {0.1, 0.45}),
                 {"table.mu_out.max", "at least the scene's, 0.49", "got 0.45"});
    refuse_table(narrowed(&Recipe::azimuth, {60, 170}), {"table.azimuth.min", "got 1.04"});
}

TEST(AdoptTables, TakesATableForEachLightPathOrOneForAll) {
    Scene scene = small_planet(40, 1, 0.8);
    the_planet(scene).surface.colour = {0.5f, 0.5f, 0.5f};
    scene.tolerance = 0.05;
    const Recipe recipe = *needed_recipe(scene);
    const Table sunlight = bake(recipe), fluxes = bake(*needed_recipe(scene, LightPath::fluxes));
    for (const auto& each :
         {adopt({scene}, {sunlight, fluxes})[0], adopt({scene}, {fluxes, sunlight})[0]}) {
        EXPECT_GT(each->at(LightPath::sunlight)->headers[0].mu_out.values.size(), 1u);
        EXPECT_EQ(each->at(LightPath::fluxes)->headers[0].mu_out.values.size(), 1u);
    }
    const auto all = adopt({scene}, {bake(of_all_directions(recipe))})[0];
    EXPECT_EQ(all->paths[0], all->paths[1]);
    expect_refusal([&] { adopt({scene}, {sunlight}); },
                   {"one with transmission", "got none", "for fluxes"});
    expect_refusal([&] { adopt({scene}, {fluxes}); }, {"table.mu_out.min", "got 1"});
}

/// A slab in three lobes.
Scene lobes(const std::array<double, 3>& g) {
    Scene scene = small_slab(1, 0.8);
    for (const double each : g)
        scene.layer.channels.push_back(PhaseFunction::henyey_greenstein(each));
    scene.layer.components = {scene.layer.channels[1]};
    scene.tolerance = 0.01;
    return scene;
}

TEST(AdoptTables, FindsMembersOfAFamily) {
    const Scene scene = lobes({0.2, 0.3, 0.4}), other = lobes({0.3, 0.35, 0.2});
    Scene grey = lobes({0.3, 0.3, 0.3});
    grey.layer.channels.clear();
    Recipe recipe = of_all_directions(*needed_recipe(channel_scenes(scene)[0]));
    recipe.albedo = {0.5, 0.9};
    recipe.family = {{PhaseParameter::g, {0.1, 0.5}, {}}};
    const Table family = bake(recipe);
    const auto given = adopt({scene, other, once(other), grey}, {family});
    EXPECT_EQ(given[0]->channels[0]->paths[0]->headers[0].phase_function.text(),
              "henyey_greenstein:g=0.2");
    EXPECT_EQ(given[0]->channels[1]->paths, given[1]->channels[0]->paths) << "one member";
    EXPECT_FALSE(given[2]) << "scattered once";
    EXPECT_EQ(given[3]->paths, given[1]->channels[0]->paths);
    const auto baked = bake_for({scene});  // of each phase function alone
    const Image found = render(scene, LayerLight(scene, given[0].get())),
                expected = render(scene, LayerLight(scene, baked[0].get()));
    expect_all_near(found.rgb, expected.rgb, 0.02);
    EXPECT_NE(expected.rgb[0], expected.rgb[1]);
    const auto refuse = [&](const Scene& refused, const Fragments& fragments) {
        expect_refusal([&] { adopt({refused}, {family}); }, fragments);
    };
    refuse(lobes({0.2, 0.3, 0.6}), {"scene", "g of the phase function", "[0.1, 0.5]", "got 0.6"});
    refuse(small_slab(1, 0.8), {"table.family", "rayleigh", "got g"});
    refuse(small_rings(1), {"table", "one with a mixture axis alone", "another family"});
    grey.layer.optical_depth.max = 4;
    refuse(grey, {"table.optical_depth.max", "at least the scene's, 4"});
}

// The squares of what errors in so faint a light count are beyond the range of float.
TEST(LayerTable, OfAStackUnderABlackOneIsDark) {
    const PhaseFunction phase_function = PhaseFunction::isotropic();
    Recipe recipe = recipe_of_stack({{phase_function, 0, 8}, {phase_function, 1, 2}}, {});
    recipe.mu_in = {0.2, 0.2};
    recipe.mu_out = {0.25, 0.3};
    recipe.transmission = false;
    const auto table = bake_layer_table(recipe);
    double value[3];
    table->packed.multiple(Side::reflection, {{1, 1, 1}, {2, 2, 2}}, {0.2, 0.27, 0}, 0, value);
    for (const double each : value) EXPECT_NEAR(each, 0, 1e-24);
}

}  // namespace
}  // namespace stratus
