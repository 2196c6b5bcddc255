// Scenes of a few pixels, for tests to change.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/scene.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace stratus {

/// The first frame of a scene file.
inline SceneFile parse_scene(const std::string& text, const std::string& directory = "",
                             const std::string& name = "") {
    return parse_film(text, directory, nullptr, name)[0];
}

auto& the_planet(auto& scene) { return std::get<Planet>(scene.subject); }
auto& the_rings(auto& scene) { return std::get<Rings>(scene.subject); }
auto& the_slab(auto& scene) { return std::get<Slab>(scene.subject); }

inline void cover_with_clouds(Scene& scene) {
    scene.layer.optical_depth.pattern = DepthMap::Pattern::clouds;
}
inline void shine_on_one_another(Scene& scene, bool shine) {
    scene.effects.ringshine = scene.effects.planetshine = shine;
}

/// A planet of unit radius before an orthographic camera, the picture 2 wide and high.
inline Scene small_planet(double phase_angle_deg, double optical_depth, double albedo) {
    Scene scene;
    scene.width = scene.height = 16;
    scene.samples = 1;
    scene.camera.position = {5, 0, 0};
    scene.camera.orthographic = true;
    scene.camera.width = 2;
    const double angle = radians(phase_angle_deg);
    scene.to_sun = {std::cos(angle), std::sin(angle), 0};
    scene.layer.components = {PhaseFunction::rayleigh()};
    scene.layer.albedo = {albedo, albedo, albedo};
    scene.layer.optical_depth.max = optical_depth;
    scene.subject = Planet{};
    return scene;
}

/// A plane before a camera that looks down on it by 60 degrees from its normal, the sun 30 degrees
/// from the normal opposite to the camera.
inline Scene small_slab(double optical_depth, double albedo) {
    Scene scene = small_planet(0, optical_depth, albedo);
    scene.camera.position = 10.0 * direction_at(radians(30), 0);
    scene.camera.width = 1;
    scene.to_sun = direction_at(radians(60), pi);
    scene.background.colour = {0.25f, 0.5f, 1.0f};
    Slab slab;
    slab.half_size = 1e3;
    scene.subject = slab;
    return scene;
}

/// A planet and rings of one depth from 1.5 to 2.5 of its radii, which do not light one another.
inline Scene small_rings(double optical_depth) {
    Scene scene = small_planet(0, 0, 1);
    scene.camera.width = 6;
    scene.camera.position = 10.0 * direction_at(radians(40), 0);
    scene.to_sun = direction_at(radians(30), radians(20));
    scene.layer.components = {PhaseFunction::lambert_sphere(),
                              PhaseFunction::henyey_greenstein(0.5)};
    Rings rings;
    rings.profile = {{1.5, 2.5}, {optical_depth, optical_depth}, {0.5, 0.3}, {0.1, 0.3}};
    rings.surface.colour = {0.5f, 0.25f, 0.75f};
    scene.subject = rings;
    shine_on_one_another(scene, false);
    return scene;
}

/// The recipe for one light path of a scene; none where it needs none.
inline std::optional<Recipe> needed_recipe(const Scene& scene,
                                           LightPath path = LightPath::sunlight) {
    for (const NeededRecipe& needed : needed_recipes(scene))
        if (needed.path == path) return needed.recipe;
    return std::nullopt;
}

/// For lookups beside what a scene's camera sees, of all light paths.
inline Recipe of_all_directions(Recipe recipe) {
    recipe.mu_in = recipe.mu_out = {0, 1};
    recipe.azimuth = {0, 180};
    recipe.reflection = true;
    recipe.transmission = std::isfinite(recipe.optical_depth.min);
    return recipe;
}

/// One table for all light paths.
inline std::unique_ptr<LayerTables> bake_layer_tables(const Recipe& recipe) {
    auto tables = std::make_unique<LayerTables>();
    tables->paths[0] = bake_layer_table(recipe);
    return tables;
}

struct TablesOfLight {
    std::shared_ptr<const LayerTables> tables;
};

/// The light of a scene and the tables that it needs, baked for what its camera sees or given.
struct BakedLight : TablesOfLight, LayerLight {
    explicit BakedLight(const Scene& scene) : BakedLight(scene, bake_for({scene})[0]) {}
    BakedLight(const Scene& scene, std::shared_ptr<const LayerTables> given)
        : TablesOfLight{std::move(given)}, LayerLight(scene, tables.get()) {}
};

/// For lookups beside what a scene's camera sees.
inline BakedLight light_of_all_directions(const Scene& scene) {
    return BakedLight(scene, bake_layer_tables(of_all_directions(*needed_recipe(scene))));
}

/// All effects but orders n >= 2: nothing is baked.
inline Scene once(Scene scene) {
    scene.effects.multiple = false;
    return scene;
}

}  // namespace stratus
