// Scenes: the TOML file that says what is seen, from where, and in what light.
//
//     [camera]
//     distance = 10.0
//     orthographic_width = 2.2
//
//     [sun]
//     phase_angle_deg = 30.0
//
//     [layer]
//     phase_function = "isotropic"
//     albedo = 0.99
//     optical_depth = 8.0
//
//     [planet]
//     surface = 0.3
//
// docs/scenes.md and `stratus render --keys` have every key.
//
// Radiance is relative to that of a white Lambert surface which faces the sun: I = mu0 R.
// Lengths are in equatorial radii of the planet, or in any unit over a slab; angles in degrees.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/bake/toml_section.h>
#include <stratus/base/size.h>
#include <stratus/layer/effects.h>
#include <stratus/scene/figure.h>
#include <stratus/scene/texture.h>

namespace stratus {

/// The effects that a picture takes into account; each can be switched off.
struct SceneEffects {
    bool single = true;
    bool multiple = true;      // orders n >= 2, and light between layer and ground
    bool azimuth = true;       // of orders n >= 2; without it their mean over azimuth
    bool reflection = true;    // of the layer's lit side
    bool transmission = true;  // diffuse, through the layer
    bool background = true;    // what is seen through the layer, ground included
    bool opposition = true;
    bool density = true;
    bool shadows = true;      // of a planet on its rings, of the rings on it
    bool sun_size = true;     // a disk, not a point
    bool ringshine = true;    // light that rings scatter onto their planet
    bool planetshine = true;  // light that a planet reflects onto its rings
    bool shell = true;        // a planet's layer as a spherical shell

    bool operator==(const SceneEffects&) const = default;
};

/// One of them.
using EffectFlag = bool SceneEffects::*;

/// Effects by name, in the order above.
const std::vector<std::pair<const char*, EffectFlag>>& scene_effects();

/// From names: "all", "NAME", and "-NAME", which switches one off. A list that starts with "-NAME"
/// starts from all.
///
/// Errors   std::invalid_argument with the nearest known name.
SceneEffects parse_scene_effects(const std::vector<std::string>& names);

/// The effect of a name.
///
/// Errors   as above.
EffectFlag scene_effect(const std::string& name);

/// The inverse: "all", and "-NAME" for each that is off.
std::vector<std::string> scene_effect_names(const SceneEffects& effects);

/// The matter of the layer at one point.
struct Matter {
    double optical_depth = 0;
    Rgb3 albedo{1, 1, 1};  // red, green, blue
    double mixture = 1;    // share of the first component in the albedo
};

/// The layer that scatters, wherever it lies.
struct SceneLayer {
    std::vector<PhaseFunction> components;  // two in rings, which mix them; else one
    std::vector<PhaseFunction> channels;    // red's, green's and blue's own; empty: all alike
    Rgb3 extinction{1, 1, 1};               // of red, green and blue; multiplies the depth
    Rgb3 albedo{1, 1, 1};
    DepthMap optical_depth;  // of planets and slabs
    // The layers of a stack, that which the sun meets first; of red, green and blue where channels
    // differ; empty: one layer. Components, channels, albedo and depth are of mean_layer.
    std::vector<StackLayers> stacks;
    double density = 0;
    Opposition opposition;
};

/// Rings by radius, linear between rows, empty outside. [Blinn82] 4.3
struct RingProfile {
    std::vector<double> radius;  // ascending, in equatorial radii of the planet
    std::vector<double> optical_depth;
    std::vector<double> w1, w2;  // albedos of the two components; their sum is the rings'

    double inner() const { return radius.front(); }
    double outer() const { return radius.back(); }
    /// Albedos are multiplied by `tint`.
    Matter at(double radius, const Rgb3& tint) const;
    /// The matter at a radius known to lie between two rows, `row` and the next.
    Matter after(std::size_t row, double radius, const Rgb3& tint) const;
};

/// A planet, flattened at its poles, and its rings in its equatorial plane.
struct Rings {
    RingProfile profile;
    Texture surface;
    std::optional<SceneLayer> planet_layer;  // on the surface; none: it is bare
    double flattening = 0;

    bool has_black_planet() const { return surface.is_black() && !planet_layer; }
};

/// A planet with a Lambert surface, and the layer directly on it.
struct Planet {
    Texture surface;
    double shell = 0;        // height of the layer in radii; 0: the layer is plane everywhere
    bool has_rings = false;  // which light it and see it from all around
};

/// A plane layer in z = 0, over ground or free.
struct Slab {
    std::optional<Texture> surface;
    double height = 0;     // of the layer over the ground
    double half_size = 0;  // of a side
    double image_size = 1;
};

/// One picture.
struct Scene {
    std::string title;
    double tolerance = 2e-3;
    SceneEffects effects;
    std::vector<EffectFlag> named;                // asked for by name, or by a key that makes them
    int width = 1024, height = 768, samples = 2;  // pixels; samples squared a pixel
    double white = 1;                             // radiance
    Camera camera;
    Vector3 to_sun{0, 0, 1};
    double sun_diameter = 0;  // radians
    Rgb3 sun_colour{1, 1, 1};
    bool sun_visible = false;
    Texture background;
    SceneLayer layer;
    std::variant<Planet, Rings, Slab> subject;

    /// The subject if it is of this kind, else null.
    template <class Kind>
    const Kind* subject_as() const {
        return std::get_if<Kind>(&subject);
    }
};

using Scenes = std::vector<Scene>;

/// A file: a picture, several side by side, or a figure.
struct SceneFile {
    std::string title;
    std::string text;  // of the file
    int frames = 1;    // of its [animation]
    int columns = 1;   // of panels
    Scenes panels;     // all of one size; one where there are no [[panels]]
    std::optional<Figure> figure;
};

/// A file's frames.
using Film = std::vector<SceneFile>;

/// Keys of scene files, with units, ranges and defaults; docs/scenes.md shows them. Tables that may stand
/// under several keys have rows of their own: "surface" is that of planet.surface, rings.surface and
/// slab.surface.
Keys scene_keys();

/// Reads every frame of a scene's [animation], or the scene alone where there is none, from TOML text; paths in it are
/// relative to `directory`. Frames share their images. Notes for the user are appended to `notes`. `name`: of its
/// file, in refusals.
///
/// Errors   std::invalid_argument naming file, line, key, the allowed range and the value met, and the frame where
///          there are several; unknown keys with the nearest known; frames of several sizes;
///          std::runtime_error for files that cannot be read.
Film parse_film(const std::string& text, const std::string& directory = "",
                std::vector<std::string>* notes = nullptr, const std::string& name = "");

/// Reads them from a file. Errors: std::runtime_error when it cannot be read.
Film read_film(const fs::path& path, std::vector<std::string>* notes = nullptr);

/// The panels of all frames, frame after frame: the scenes that a film's tables serve.
Scenes all_panels(const Film& film);

/// Changes that a user makes to all pictures of a film. A member that is empty or 0 changes nothing.
struct SceneChanges {
    std::vector<std::string> effects;  // in place of the scenes' own
    std::vector<std::string> drop;     // switched off, whether or not a scene names them
    int width = 0;                     // pixels, in the same shape
    double tolerance = 0;
};

/// Makes the changes.
///
/// Errors   std::invalid_argument for an unknown effect.
void change(const SceneChanges& changes, Film& film);

inline Scene with_effects(Scene scene, const SceneEffects& effects) {
    scene.effects = effects;
    return scene;
}

inline SceneEffects without(SceneEffects effects, EffectFlag effect) {
    effects.*effect = false;
    return effects;
}

/// The planet of rings as a scene of its own, where it has a layer: for the layer's light and tables.
std::optional<Scene> planet_scene(const Scene& scene);

/// A scene for each of red, green and blue where these have their own phase functions, with that
/// one's, its depth, and grey in its albedo; else the scene itself. Then those of its planet_scene.
Scenes channel_scenes(const Scene& scene);

/// The channel scenes of several scenes, one after the other.
Scenes channel_scenes(const Scenes& scenes);

/// The layer that a stack makes, or one each for red, green and blue.
///
/// Errors   std::invalid_argument for layers that are no stack (recipe_of_stack).
SceneLayer layer_of_stacks(std::vector<StackLayers> stacks);

/// Whether two layers are of the same matter, depths and albedos: they scatter alike.
bool are_alike(const SceneLayer& one, const SceneLayer& other);

/// The height of the layer as a spherical shell, with its effect; 0: plane, or nothing scatters.
double seen_shell(const Scene& scene);

/// The optical depth with the effect of density, where that is on.
double seen_depth(const Scene& scene, double optical_depth);

}  // namespace stratus
