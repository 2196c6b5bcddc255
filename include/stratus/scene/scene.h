// Scenes: the TOML file that says what is seen, from where, and in what light.
//
//     title = "A cloud-covered planet"
//     tolerance = 2e-3                  # relative, of the tables; 2e-3
//     effects = ["-multiple"]           # names of effects; "all"; all but those after a minus
//
//     [picture]                         # 1024 x 768 pixels, 2 x 2 samples each; radiance shown
//     width = 1024                      # white in a PNG
//     height = 768
//     samples = 2
//     white = 1.0
//
//     [camera]
//     look_at = [0.0, 0.0, 0.0]         # the origin
//     position = [5.0, 0.0, 1.0]        # or distance, elevation_deg, azimuth_deg from look_at
//     field_of_view_deg = 30.0          # of the picture's width; or orthographic_width
//
//     [sun]
//     direction = [1.0, 1.0, 0.0]       # towards it; or elevation_deg and azimuth_deg; or
//                                       # phase_angle_deg, from the camera to its right
//     angular_diameter_deg = 0.0
//
//     [background]
//     colour = [0.0, 0.0, 0.0]          # or image, all around: longitude and latitude
//
//     [layer]
//     phase_function = "isotropic"      # or three, of red, green and blue
//     albedo = 0.99                     # or [red, green, blue]; "phase_function": of droplets (mie)
//     extinction = "phase_function"     # of three of the same droplets: the depth is green's
//     optical_depth = 8.0               # or inf, or { clouds = ... }, { image = ... }
//     density = 0.1                     # effects.h; 0
//     opposition = { law = "hapke", amplitude = 1.0, width = 0.05 }   # or blinn's, from density
//
// and one of [rings], [planet], [slab] (below), or one of the figures [lobes], [lambert]
// (figure.h). [[panels]] are pictures side by side in `columns`, each the scene with some of its
// keys changed.
//
// Radiance is relative to that of a white Lambert surface which faces the sun: I = mu0 R.
// Lengths are in equatorial radii of the planet, or in any unit over a slab; angles in degrees.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/runtime/effects.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/scene/camera.h>
#include <stratus/scene/figure.h>
#include <stratus/scene/texture.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stratus {

/// What a picture takes into account; each can be switched off.
struct SceneEffects {
    bool single = true;
    bool multiple = true;      // orders n >= 2, and light between layer and ground
    bool azimuth = true;       // of orders n >= 2; without it their mean over azimuth
    bool reflection = true;    // of the layer's lit side
    bool transmission = true;  // diffuse, through the layer
    bool background = true;    // what is seen through the layer, ground included
    bool opposition = true;
    bool density = true;
    bool shadows = true;   // of a planet on its rings, of the rings on it
    bool sun_size = true;  // a disk, not a point
};

/// Effects by name, in the order above.
const std::vector<std::pair<const char*, bool SceneEffects::*>>& scene_effects();

/// From names: "all", "NAME", and "-NAME", which switches one off. A list that starts with "-NAME"
/// starts from all.
///
/// Errors   std::invalid_argument with the nearest known name.
SceneEffects parse_scene_effects(const std::vector<std::string>& names);

/// The effect of a name.
///
/// Errors   as above.
bool SceneEffects::*scene_effect(const std::string& name);

/// The inverse: "all", and "-NAME" for each that is off.
std::vector<std::string> scene_effect_names(const SceneEffects& effects);

/// What the layer is made of at one point.
struct Matter {
    double optical_depth = 0;
    std::array<double, 3> albedo{1, 1, 1};  // red, green, blue
    double mixture = 1;                     // share of the first component in the albedo
};

/// The layer that scatters, wherever it lies.
struct SceneLayer {
    std::vector<PhaseFunction> components;      // two in rings, which mix them; else one
    std::vector<PhaseFunction> channels;        // red's, green's and blue's own; empty: all alike
    std::array<double, 3> extinction{1, 1, 1};  // of those, the depth multiplied by it
    std::array<double, 3> albedo{1, 1, 1};
    DepthMap optical_depth;  // of planets and slabs
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
    Matter at(double radius, const std::array<double, 3>& tint) const noexcept;
};

/// A planet and its rings in its equatorial plane.
///
///     [rings]
///     profile = "saturn.csv"            # radius, optical_depth, w1, w2
///     planet_radius = 60268.0           # in the profile's unit; 1
///     inner = 1.2                       # cut the profile, in planet radii
///     outer = 2.3
///     surface = [0.8, 0.7, 0.5]         # of the planet, Lambert's law; as of [planet]; black
///     flattening = 0.1                  # of its poles; 0
///
/// Their [layer] has components = ["lambert_sphere", "henyey_greenstein:g=0.5"], the phase
/// functions of w1 and w2, and may have an albedo, which multiplies both.
struct Rings {
    RingProfile profile;
    Texture surface;
    double flattening = 0;
};

/// A planet with a Lambert surface, and the layer directly on it.
///
///     [planet]
///     surface = 0.3                     # or [r, g, b]; or { image = "earth.png" }; or
///                                       # { pattern = "squares", scale = 12, colour, other, seed }
///                                       # with squares, continents, bands; black
struct Planet {
    Texture surface;
};

/// A plane layer in z = 0, over ground or free.
///
///     [slab]
///     surface = 0.3                     # of the ground, as of [planet]; without it: no ground
///     height = 0.5                      # of the layer over the ground; 0
///     size = 10.0                       # length of a side, centred on the origin; inf
///     image_size = 1.0                  # of images
struct Slab {
    std::optional<Texture> surface;
    double height = 0;
    double half_size = 0;  // of a side
    double image_size = 1;
};

/// One picture.
struct Scene {
    std::string title;
    double tolerance = 2e-3;
    SceneEffects effects;
    std::vector<bool SceneEffects::*> named;      // asked for by name, or by a key that makes them
    int width = 1024, height = 768, samples = 2;  // pixels; samples squared a pixel
    double white = 1;                             // radiance
    Camera camera;
    Vector3 to_sun{0, 0, 1};
    double sun_diameter = 0;  // radians
    Texture background;
    SceneLayer layer;
    std::variant<Planet, Rings, Slab> subject;
};

/// A file: a picture, several side by side, or a figure.
struct SceneFile {
    std::string title;
    std::string text;           // of the file
    int columns = 1;            // of panels
    std::vector<Scene> panels;  // all of one size; one where there are no [[panels]]
    std::optional<Figure> figure;
};

/// Reads a scene from TOML text; paths in it are relative to `directory`. Notes for the user are
/// appended to `notes`.
///
/// Errors   std::invalid_argument naming the key, the allowed range and the value met; unknown keys
///          with the nearest known; std::runtime_error for files that cannot be read.
SceneFile parse_scene(const std::string& text, const std::string& directory = "",
                      std::vector<std::string>* notes = nullptr);

/// The same from a file. Errors: std::runtime_error when it cannot be read.
SceneFile read_scene(const std::filesystem::path& path, std::vector<std::string>* notes = nullptr);

/// A scene for each of red, green and blue where these have their own phase functions, with that
/// one's, its depth, and grey in its albedo; else the scene itself.
std::vector<Scene> channel_scenes(const Scene& scene);

/// The optical depth with the effect of density, where that is on.
double seen_depth(const Scene& scene, double optical_depth) noexcept;

}  // namespace stratus
