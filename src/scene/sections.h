// The sections of a scene file: each TOML table is read into a part of the scene.
#pragma once

#include <stratus/scene/scene.h>

#include <filesystem>
#include <map>
#include <memory>

namespace stratus::scene_file {

constexpr const char* caller = "scene";

/// Where the files that a scene names are found.
struct Source : PhaseSource {
    // Panels and frames share these, which are read once: images, and oceans by their text.
    std::map<std::string, std::shared_ptr<const Image>>* images;
    std::map<std::string, Texture>* oceans;

    /// Returns the image that a section names; refuses numbers that are not in [0, most].
    std::shared_ptr<const Image> image(const Section& section, double most) const;
};

// ---- Values

void require_exactly_one(const Section& section, const char* one, const char* other);

/// Whether an image is given rather than what the key `instead` gives; refuses both and neither.
bool has_image(const Section& section, const char* instead);

/// Refuses keys that belong to other subjects: "absent `where`".
void require_absent(const Section& section, const char* key, const char* where);

Vector3 read_vector(const Section& section, const char* key);
/// In degrees; returns radians.
double read_angle(const Section& section, const char* key);
Rgb read_colour(const Section& section, const char* key);
unsigned read_seed(const Section& section);
Texture read_image(const Section& section, const Source& source, double most);

// ---- Sections

/// The frames of an [animation].
struct Animation {
    int frames = 1;
    std::vector<int> keyed{};  // those of its keys, ascending
};

/// Gives a file's keys the values that they have at a frame of its [animation]: of numbers, and of lists of
/// as many numbers, linear between two keys' frames, of all else those of the key before.
Animation animate(toml::table& root, const TomlFile& origin, int frame);

void read_picture(const Section& root, Scene& scene);
Camera read_camera(const Section& root);
/// After the camera, which a phase angle refers to.
void read_sun(const Section& root, Scene& scene);
Texture read_background(const Section& root, const Source& source);
/// `of_rings`: depth and albedo come from the rings' profile.
SceneLayer read_layer(const Section& section, const Source& source, bool of_rings);
/// `parent`'s surface, of a planet or of the ground, as a Lambert albedo, with the mirror of an ocean;
/// black without the key.
Texture read_surface(const Section& parent, const Source& source);
Rings read_rings(const Section& root, const Source& source, const Camera& camera);
Planet read_planet(const Section& root, const Source& source, const Camera& camera);
Slab read_slab(const Section& root, const Source& source, const Camera& camera);
LobeFigure read_lobes(const Section& root, const Source& source);
LambertFigure read_lambert(const Section& root, const Source& source);

}  // namespace stratus::scene_file
