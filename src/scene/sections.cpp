// Values of several sections, then [picture], [camera] and [sun], [animation].
#include "sections.h"

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/picture/png.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace stratus::scene_file {

std::shared_ptr<const Image> Source::image(const Section& section, double most) const {
    constexpr const char* key = "image";
    const fs::path path = directory / section.text(key);
    const std::string ending = path.extension().string();
    section.require(ending == ".png" || ending == ".exr", key, "a .png or .exr file",
                    path.string());
    const bool is_png = ending == ".png";
    section.require(is_png || !section.has("encoding"), "encoding",
                    "absent beside an .exr file, whose numbers are linear", "given");
    const std::string encoding = section.choice("encoding", {"srgb", "data"});
    std::shared_ptr<const Image>& image = (*images)[path.string() + encoding];
    if (!image)
        image = section.placed(key, [&] {
            return std::make_shared<const Image>(
                is_png
                    ? read_png(path, 0, encoding == "srgb" ? PngEncoding::srgb : PngEncoding::data)
                    : read_exr_image(path));
        });
    const auto outside = std::ranges::find_if_not(
        image->rgb, [&](float value) { return value >= 0 && double{value} <= most; });
    if (outside != image->rgb.end())
        section.require(false, key, "of numbers in [0, " + shortest_text(most) + "]", *outside);
    return image;
}

void require_exactly_one(const Section& section, const char* one, const char* other) {
    require(section.has(one) != section.has(other), caller,
            section.here() + ": exactly one of " + one + " and " + other, "given",
            section.has(one) ? "both" : "neither");
}

bool has_image(const Section& section, const char* instead) {
    require_exactly_one(section, "image", instead);
    if (!section.has("image")) require_absent(section, "encoding", "without an image");
    return section.has("image");
}

void require_absent(const Section& section, const char* key, const char* where) {
    section.require(!section.has(key), key, std::string("absent ") + where, "one");
}

Vector3 read_vector(const Section& section, const char* key) {
    const std::vector<double> v = section.numbers(key, 3, 3);
    return {v[0], v[1], v[2]};
}

double read_angle(const Section& section, const char* key) { return radians(section.number(key)); }

Rgb read_colour(const Section& section, const char* key) {
    const Rgb3 c = section.three(key);
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

unsigned read_seed(const Section& section) { return static_cast<unsigned>(section.count("seed")); }

Texture read_image(const Section& section, const Source& source, double most) {
    Texture texture;
    texture.pattern = Texture::Pattern::image;
    texture.image = source.image(section, most);
    return texture;
}

// [picture], [camera] and [sun].

namespace {

Vector3 read_position(const Section& section, const Vector3& look_at) {
    require_exactly_one(section, "position", "distance");
    if (section.has("position")) {
        for (const char* angle : {"elevation_deg", "azimuth_deg"})
            require_absent(section, angle, "where position is given");
        return read_vector(section, "position");
    }
    const double elevation = read_angle(section, "elevation_deg"),
                 azimuth = read_angle(section, "azimuth_deg");
    return look_at + section.number("distance") * direction_at(elevation, azimuth);
}

}  // namespace

void read_picture(const Section& root, Scene& scene) {
    const Section section = root.section("picture");
    scene.width = section.count("width");
    scene.height = section.count("height");
    scene.samples = section.count("samples");
    scene.white = section.number("white");
}

Camera read_camera(const Section& root) {
    const Section section = root.section("camera");
    Camera camera;
    camera.look_at = read_vector(section, "look_at");
    camera.position = read_position(section, camera.look_at);
    section.require(length(camera.look_at - camera.position) > 0, "position",
                    "another point than look_at", "the same");
    require_exactly_one(section, "field_of_view_deg", "orthographic_width");
    camera.orthographic = section.has("orthographic_width");
    camera.width = camera.orthographic ? section.number("orthographic_width")
                                       : read_angle(section, "field_of_view_deg");
    return camera;
}

void read_sun(const Section& root, Scene& scene) {
    const Section section = root.section("sun");
    const bool by_angles = section.has("elevation_deg") || section.has("azimuth_deg");
    require(section.has("direction") + by_angles + section.has("phase_angle_deg") == 1, caller,
            section.here(),
            "given by direction, by elevation_deg and azimuth_deg, or by phase_angle_deg",
            "none or several of them");
    if (section.has("direction")) {
        const Vector3 direction = read_vector(section, "direction");
        const double largest =
            std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
        section.require(largest > 0, "direction", "longer than 0", "0");
        // By a power of two, so that no square underflows: 2^1000 takes the least number to 1e-23.
        scene.to_sun = normalised(std::exp2(-std::max(std::ilogb(largest), -1000)) * direction);
    } else if (by_angles) {
        scene.to_sun =
            direction_at(read_angle(section, "elevation_deg"), read_angle(section, "azimuth_deg"));
    } else {
        const double phase_angle = read_angle(section, "phase_angle_deg");
        scene.to_sun = -std::cos(phase_angle) * scene.camera.forward() +
                       std::sin(phase_angle) * scene.camera.right();
    }
    scene.sun_diameter = read_angle(section, "angular_diameter_deg");
    scene.sun_colour = section.three("colour");
    scene.sun_visible = section.flag("visible");
    section.require(!scene.sun_visible || scene.sun_diameter > 0, "visible",
                    "false where angular_diameter_deg is 0", "true");
}

// [animation]: keys of the scene over time.

namespace {

using Path = std::vector<std::string>;  // of a key, table after table

/// The values of one key, by ascending frame.
using Track = std::vector<std::pair<int, toml::node*>>;

void collect(toml::table& changes, int frame, Path path, std::map<Path, Track>& tracks) {
    path.emplace_back();
    for (auto&& [key, node] : changes) {
        path.back() = std::string(key.str());
        if (toml::table* const inner = node.as_table())
            collect(*inner, frame, path, tracks);
        else
            tracks[path].emplace_back(frame, &node);
    }
}

/// Takes the frame out of a table of [[animation.keys]]; the keys of the scene remain.
int take_frame(toml::table& table, const TomlFile& origin, int frames) {
    toml::table place;  // nodes are moved: a copy has no line number
    if (toml::node* const frame = table.get("frame")) {
        place.insert("frame", std::move(*frame));
        table.erase("frame");
    }
    const char* const name = "animation.keys";
    const Section section(place, origin, scene_keys(), name, name);
    const int frame = section.count("frame");
    section.require(frame < frames, "frame", "below animation.frames, " + std::to_string(frames),
                    frame);
    const Section keys(table, origin, scene_keys());
    for (const char* key : {"animation", "columns", "panels"})
        require_absent(keys, key, "from animation.keys");
    return frame;
}

/// One number, or those of a list; none where there is anything else.
std::optional<std::vector<double>> numbers_in(const toml::node& node) {
    std::vector<double> numbers;
    const auto add = [&](const toml::node& each) {
        if (each.is_number()) numbers.push_back(*each.value<double>());
        return each.is_number();
    };
    const toml::array* const list = node.as_array();
    const bool all = list ? std::ranges::all_of(*list, add) : add(node);
    return all ? std::optional(numbers) : std::nullopt;
}

/// By the last two names, as "surface.seed" is a key of whatever has a surface.
bool is_whole(const Path& path) {
    const std::string name = path.size() > 1 ? path[path.size() - 2] + '.' + path.back() : path[0];
    return std::ranges::any_of(scene_keys(), [&](const Key& key) {
        return ('.' + std::string(key.name)).ends_with('.' + name) &&
               key.form == std::string("whole number");
    });
}

/// Sets a key to numbers between those of two nodes, or else moves the earlier one there.
void set_between(toml::table& table, const Path& path, toml::node& before, const toml::node& after,
                 double share) {
    const std::string& key = path.back();
    std::optional<std::vector<double>> from = numbers_in(before), to = numbers_in(after);
    bool blends = share > 0 && from && to && from->size() == to->size() && !is_whole(path) &&
                  before.is_array() == after.is_array();
    for (std::size_t k = 0; blends && k < from->size(); ++k) {
        double& value = (*from)[k];
        value += share * ((*to)[k] - value);
        blends = std::isfinite(value);
    }
    if (!blends) {
        table.insert_or_assign(key, std::move(before));
    } else if (before.is_array()) {
        toml::array list;
        for (const double value : *from) list.push_back(value);
        table.insert_or_assign(key, std::move(list));
    } else {
        table.insert_or_assign(key, from->front());
    }
}

/// Sets one key to its value at a frame.
void set_at_frame(toml::table& root, const Path& path, const Track& track, int frame) {
    toml::table* table = &root;
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
        if (!table->get_as<toml::table>(path[k])) table->insert_or_assign(path[k], toml::table{});
        table = table->get_as<toml::table>(path[k]);
    }
    const auto next = std::ranges::upper_bound(track, frame, {}, &Track::value_type::first);
    const auto& after = next == track.end() ? track.back() : *next;
    const auto& before = next == track.begin() ? track.front() : *std::prev(next);
    const double share =
        before.first == after.first
            ? 0
            : (frame - before.first) / static_cast<double>(after.first - before.first);
    set_between(*table, path, *before.second, *after.second, share);
}

}  // namespace

Animation animate(toml::table& root, const TomlFile& origin, int frame) {
    Animation animation;
    const Section file(root, origin, scene_keys());
    if (!file.has("animation")) return animation;
    const Section section = file.section("animation");
    animation.frames = section.count("frames");
    std::map<Path, Track> tracks;
    section.tables("keys");  // refuses all else
    for (toml::node& each : *root["animation"]["keys"].as_array()) {
        toml::table& table = *each.as_table();
        const int own = take_frame(table, origin, animation.frames);
        const int before = animation.keyed.empty() ? -1 : animation.keyed.back();
        section.require(own > before, "keys", "tables of ascending frames",
                        std::to_string(own) + " after " + std::to_string(before));
        animation.keyed.push_back(own);
        collect(table, own, {}, tracks);
    }
    const Path* last = nullptr;
    for (const auto& [path, track] : tracks) {
        const bool within = last && last->size() < path.size() &&
                            std::equal(last->begin(), last->end(), path.begin());
        section.require(!within, "keys",
                        "tables that give a key a value everywhere or a table everywhere",
                        within ? last->back() + " as both" : "");
        set_at_frame(root, path, track, frame);
        last = &path;
    }
    return animation;
}

}  // namespace stratus::scene_file
