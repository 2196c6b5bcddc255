#include <stratus/scene/scene.h>

#include <stratus/io/csv.h>
#include <stratus/picture/png.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>

#include "toml_section.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stratus {
namespace {

constexpr const char* caller = "scene";
constexpr double largest = 1e12;  // of lengths and radiances

/// What a file is read with, at any of its keys.
struct Source {
    std::filesystem::path directory;
    std::vector<std::string>* notes;

    std::shared_ptr<const Image> image(const Section& section, const char* key) const {
        const std::filesystem::path path = directory / section.text(key);
        const std::string ending = path.extension().string();
        require(ending == ".png" || ending == ".exr", caller, section.full_name(key),
                "a .png or .exr file", path.string());
        return std::make_shared<const Image>(ending == ".png" ? read_png(path)
                                                              : read_exr_image(path));
    }

    PhaseFunction phase_function(const std::string& text) const {
        return read_phase_function(text, directory.string(), notes);
    }
};

// ---- Numbers, vectors, colours

void take(double& into, const Section& section, const char* key, double least, double most,
          const char* allowed) {
    if (section.has(key)) into = section.number(key, least, most, allowed);
}

Vector3 read_vector(const Section& section, const char* key) {
    const std::vector<double> v =
        section.numbers(key, -largest, largest, "in [-1e12, 1e12], three of them");
    require(v.size() == 3, caller, section.full_name(key), "a list of three numbers", v.size());
    return {v[0], v[1], v[2]};
}

double read_angle(const Section& section, const char* key, double least, double most,
                  const char* allowed) {
    return radians(section.number(key, least, most, allowed));
}

/// One number, or one for red, green and blue each.
std::array<double, 3> read_three(const Section& section, const char* key, double most,
                                 const char* allowed) {
    if (!section.is_list(key)) {
        const double grey = section.number(key, 0, most, allowed);
        return {grey, grey, grey};
    }
    const std::vector<double> v = section.numbers(key, 0, most, allowed);
    require(v.size() == 3, caller, section.full_name(key), "a number, or a list of three",
            v.size());
    return {v[0], v[1], v[2]};
}

Rgb read_colour(const Section& section, const char* key, double most, const char* allowed) {
    const std::array<double, 3> c = read_three(section, key, most, allowed);
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

unsigned read_seed(const Section& section) {
    return static_cast<unsigned>(section.count("seed", 0, 1000000000));
}

// ---- Textures

constexpr const char* surface_form = "a number, a list of three, or a table";

Texture read_pattern(const Section& section, const Source& source) {
    Texture texture;
    require(section.has("image") != section.has("pattern"), caller, section.full_name("pattern"),
            "there, or else image", section.has("image") ? "both" : "neither");
    if (section.has("image")) {
        texture.pattern = Texture::Pattern::image;
        texture.image = source.image(section, "image");
        return texture;
    }
    const std::string name = section.text("pattern");
    const std::vector<std::pair<std::string, Texture::Pattern>> patterns{
        {"squares", Texture::Pattern::squares},
        {"continents", Texture::Pattern::continents},
        {"bands", Texture::Pattern::bands}};
    const auto found = std::find_if(patterns.begin(), patterns.end(),
                                    [&](const auto& pattern) { return pattern.first == name; });
    require(found != patterns.end(), caller, section.full_name("pattern"),
            "\"squares\", \"continents\" or \"bands\"", name);
    texture.pattern = found->second;
    texture.colour = {0.02f, 0.05f, 0.12f};
    texture.other = {0.5f, 0.5f, 0.5f};
    if (section.has("colour")) texture.colour = read_colour(section, "colour", 1, "in [0, 1]");
    if (section.has("other")) texture.other = read_colour(section, "other", 1, "in [0, 1]");
    take(texture.scale, section, "scale", 1e-3, 1e3, "in [1e-3, 1e3]");
    if (section.has("seed")) texture.seed = read_seed(section);
    return texture;
}

Texture read_surface(const Section& section, const char* key, const Source& source) {
    Texture texture;
    if (!section.has(key)) return texture;
    if (!section.is_table(key)) {
        texture.colour = read_colour(section, key, 1, "in [0, 1]");
        return texture;
    }
    return read_pattern(Section(section.table(key, surface_form), caller, section.full_name(key),
                                {"image", "pattern", "colour", "other", "scale", "seed"}),
                        source);
}

DepthMap read_depth(const Section& section, const Source& source) {
    constexpr const char* key = "optical_depth";
    DepthMap map;
    if (!section.is_table(key)) {
        map.most = section.number(key, 0, infinity, "in [0, inf], or a table");
        return map;
    }
    const Section table(section.table(key, "a number or a table"), caller, section.full_name(key),
                        {"image", "clouds", "most", "scale", "coverage", "seed"});
    require(table.has("image") != table.has("clouds"), caller, section.full_name(key),
            "{ clouds = true, ... } or { image = ..., ... }",
            table.has("image") ? "both" : "neither");
    map.most = table.number("most", 0, 1e4, "in [0, 1e4]");
    if (table.has("image")) {
        map.pattern = DepthMap::Pattern::image;
        map.image = source.image(table, "image");
        return map;
    }
    map.pattern = DepthMap::Pattern::clouds;
    take(map.scale, table, "scale", 1e-3, 1e3, "in [1e-3, 1e3]");
    take(map.coverage, table, "coverage", 0, 1, "in [0, 1]");
    if (table.has("seed")) map.seed = read_seed(table);
    return map;
}

// ---- The parts of a scene

void read_picture(const Section& root, Scene& scene) {
    const Section section(root.table("picture", "a table: [picture]"), caller, "picture",
                          {"width", "height", "samples", "white"});
    if (section.has("width")) scene.width = section.count("width", 1, 16384);
    if (section.has("height")) scene.height = section.count("height", 1, 16384);
    if (section.has("samples")) scene.samples = section.count("samples", 1, 16);
    take(scene.white, section, "white", 1e-6, 1e6, "in [1e-6, 1e6]");
}

Camera read_camera(const Section& root) {
    const Section section(root.table("camera", "a table: [camera]"), caller, "camera",
                          {"position", "distance", "elevation_deg", "azimuth_deg", "look_at",
                           "field_of_view_deg", "orthographic_width"});
    Camera camera;
    if (section.has("look_at")) camera.look_at = read_vector(section, "look_at");
    require(section.has("position") != section.has("distance"), caller, "camera.position",
            "there, or else distance", section.has("position") ? "both" : "neither");
    if (section.has("position")) {
        require(!section.has("elevation_deg") && !section.has("azimuth_deg"), caller,
                "camera.position", "without elevation_deg and azimuth_deg", "them");
        camera.position = read_vector(section, "position");
    } else {
        const double distance = section.number("distance", 1e-6, largest, "in [1e-6, 1e12]");
        double elevation = 0, azimuth = 0;
        take(elevation, section, "elevation_deg", -90, 90, "in [-90, 90]");
        take(azimuth, section, "azimuth_deg", -360, 360, "in [-360, 360]");
        camera.position =
            camera.look_at + distance * direction_at(radians(elevation), radians(azimuth));
    }
    require(length(camera.look_at - camera.position) > 0, caller, "camera.position",
            "another point than look_at", "the same");
    require(section.has("field_of_view_deg") != section.has("orthographic_width"), caller,
            "camera.field_of_view_deg", "there, or else orthographic_width",
            section.has("field_of_view_deg") ? "both" : "neither");
    camera.orthographic = section.has("orthographic_width");
    camera.width = camera.orthographic
                       ? section.number("orthographic_width", 1e-9, largest, "in [1e-9, 1e12]")
                       : read_angle(section, "field_of_view_deg", 1e-3, 170, "in [1e-3, 170]");
    return camera;
}

void read_sun(const Section& root, Scene& scene) {
    const Section section(
        root.table("sun", "a table: [sun]"), caller, "sun",
        {"direction", "elevation_deg", "azimuth_deg", "phase_angle_deg", "angular_diameter_deg"});
    const bool by_angles = section.has("elevation_deg") || section.has("azimuth_deg");
    require(section.has("direction") + by_angles + section.has("phase_angle_deg") == 1, caller,
            "sun", "given by direction, by elevation_deg and azimuth_deg, or by phase_angle_deg",
            "none or several of them");
    if (section.has("direction")) {
        const Vector3 direction = read_vector(section, "direction");
        require(length(direction) > 0, caller, "sun.direction", "longer than 0", "0");
        scene.to_sun = normalised(direction);
    } else if (by_angles) {
        double azimuth = 0;
        take(azimuth, section, "azimuth_deg", -360, 360, "in [-360, 360]");
        scene.to_sun = direction_at(read_angle(section, "elevation_deg", -90, 90, "in [-90, 90]"),
                                    radians(azimuth));
    } else {
        const double phase_angle =
            read_angle(section, "phase_angle_deg", -180, 180, "in [-180, 180]");
        scene.to_sun = -std::cos(phase_angle) * scene.camera.forward() +
                       std::sin(phase_angle) * scene.camera.right();
    }
    if (section.has("angular_diameter_deg"))
        scene.sun_diameter = read_angle(section, "angular_diameter_deg", 0, 60, "in [0, 60]");
}

Texture read_background(const Section& root, const Source& source) {
    const Section section(root.table("background", "a table: [background]"), caller, "background",
                          {"colour", "image"});
    Texture texture;
    require(section.has("colour") != section.has("image"), caller, "background.colour",
            "there, or else image", section.has("image") ? "both" : "neither");
    if (section.has("image")) {
        texture.pattern = Texture::Pattern::image;
        texture.image = source.image(section, "image");
    } else {
        texture.colour = read_colour(section, "colour", 1e6, "in [0, 1e6]");
    }
    return texture;
}

Opposition read_opposition(const Section& layer) {
    const Section section(layer.table("opposition", "a table"), caller, "layer.opposition",
                          {"law", "density", "amplitude", "width"});
    const std::string law = section.text("law");
    require(law == "blinn" || law == "hapke", caller, "layer.opposition.law",
            "\"blinn\" or \"hapke\"", law);
    if (law == "blinn")
        return Opposition::blinn(section.number("density", 1e-9, 1 - 1e-9, "in (0, 1)"));
    return Opposition::hapke(section.number("amplitude", 0, 1, "in [0, 1]"),
                             section.number("width", 1e-9, 1e9, "in [1e-9, 1e9]"));
}

/// Of planets and slabs; of rings, which know their matter by the radius.
SceneLayer read_layer(const Section& root, const Source& source, bool of_rings) {
    std::vector<std::string> known{"albedo", "density", "opposition"};
    if (of_rings)
        known.push_back("components");
    else
        known.insert(known.end(), {"phase_function", "optical_depth"});
    const Section section(root.table("layer", "a table: [layer]"), caller, "layer", known);
    SceneLayer layer;
    if (of_rings) {
        const std::vector<std::string> texts =
            section.texts("components", "a list of two phase functions, of w1 and of w2");
        require(texts.size() == 2, caller, "layer.components",
                "a list of two phase functions, of w1 and of w2", texts.size());
        for (const std::string& text : texts)
            layer.components.push_back(source.phase_function(text));
    } else {
        layer.components.push_back(source.phase_function(section.text("phase_function")));
        layer.optical_depth = read_depth(section, source);
    }
    if (section.has("albedo"))
        layer.albedo = read_three(section, "albedo", 1, "in [0, 1]");
    else
        require(of_rings, caller, "layer.albedo", "present", "nothing");
    take(layer.density, section, "density", 0, 1 - 1e-9, "in [0, 1)");
    if (section.has("opposition")) layer.opposition = read_opposition(section);
    return layer;
}

// ---- The kinds

RingProfile read_profile(const std::filesystem::path& path, double unit) {
    const CsvTable csv = read_csv(path.string());
    struct Column {
        const char* name;
        std::vector<double> RingProfile::*into;
        double most;
        const char* allowed;
    };
    const Column columns[] = {{"radius", &RingProfile::radius, largest, "in [0, 1e12]"},
                              {"optical_depth", &RingProfile::optical_depth, 1e4, "in [0, 1e4]"},
                              {"w1", &RingProfile::w1, 1, "in [0, 1]"},
                              {"w2", &RingProfile::w2, 1, "in [0, 1]"}};
    RingProfile profile;
    for (std::size_t r = 0; r < csv.rows.size(); ++r) {
        const std::string line = csv.name + ", line " + std::to_string(csv.lines[r]) + ": ";
        for (const Column& column : columns) {
            const double value = csv.rows[r][static_cast<std::size_t>(csv.column(column.name))];
            require(value >= 0 && value <= column.most, caller, line + column.name, column.allowed,
                    value);
            (profile.*column.into).push_back(value);
        }
        require(profile.w1[r] + profile.w2[r] <= 1, caller, line + "w1 + w2", "in [0, 1]",
                profile.w1[r] + profile.w2[r]);
        profile.radius[r] /= unit;
        require(r == 0 || profile.radius[r] > profile.radius[r - 1], caller, line + "radius",
                "above the one before", unit * profile.radius[r]);
    }
    require(csv.rows.size() >= 2, caller, csv.name, "a profile of at least 2 rows",
            csv.rows.size());
    return profile;
}

/// The part of a profile within [inner, outer], with rows at both.
RingProfile cut(const RingProfile& whole, double inner, double outer) {
    RingProfile part;
    auto add = [&](double radius) {
        const Matter matter = whole.at(radius, {1, 1, 1});
        part.radius.push_back(radius);
        part.optical_depth.push_back(matter.optical_depth);
        part.w1.push_back(matter.mixture * matter.albedo[0]);
        part.w2.push_back((1 - matter.mixture) * matter.albedo[0]);
    };
    add(inner);
    for (const double radius : whole.radius)
        if (radius > inner && radius < outer) add(radius);
    add(outer);
    return part;
}

Rings read_rings(const Section& root, const Source& source) {
    const Section section(root.table("rings", "a table: [rings]"), caller, "rings",
                          {"profile", "planet_radius", "inner", "outer", "surface", "flattening"});
    Rings rings;
    double unit = 1;
    take(unit, section, "planet_radius", 1e-9, largest, "in [1e-9, 1e12]");
    rings.profile = read_profile(source.directory / section.text("profile"), unit);
    double inner = rings.profile.inner(), outer = rings.profile.outer();
    take(inner, section, "inner", inner, outer, "within the profile");
    take(outer, section, "outer", inner, outer, "within the profile and from inner on");
    require(inner >= 1, caller, "rings.inner", "at least the planet's radius, 1", inner);
    require(inner < outer, caller, "rings.outer", "above inner", outer);
    rings.profile = cut(rings.profile, inner, outer);
    rings.surface = read_surface(section, "surface", source);
    take(rings.flattening, section, "flattening", 0, 0.9, "in [0, 0.9]");
    return rings;
}

Planet read_planet(const Section& root, const Source& source) {
    const Section section(root.table("planet", "a table: [planet]"), caller, "planet", {"surface"});
    return {read_surface(section, "surface", source)};
}

Slab read_slab(const Section& root, const Source& source, const Camera& camera) {
    const Section section(root.table("slab", "a table: [slab]"), caller, "slab",
                          {"surface", "height", "size", "image_size"});
    Slab slab;
    if (section.has("surface")) slab.surface = read_surface(section, "surface", source);
    take(slab.height, section, "height", 0, 1e6, "in [0, 1e6]");
    double size = infinity;
    take(size, section, "size", 1e-6, infinity, "in [1e-6, inf]");
    slab.size = size / 2;
    take(slab.image_size, section, "image_size", 1e-6, 1e6, "in [1e-6, 1e6]");
    if (slab.surface)
        require(camera.position.z > 0, caller, "camera.position",
                "above a slab that has ground beneath it", camera.position.z);
    return slab;
}

const std::vector<std::string> subjects{"rings", "planet", "slab", "lobes", "lambert"};

/// The one subject of a file.
std::string subject_of(const Section& root) {
    std::string subject;
    for (const std::string& name : subjects) {
        if (!root.has(name.c_str())) continue;
        require(subject.empty(), caller, "scene",
                "of one kind: [rings], [planet], [slab], [lobes] or [lambert]",
                "[" + subject + "] and [" + name + "]");
        subject = name;
    }
    require(!subject.empty(), caller, "scene",
            "of one kind: [rings], [planet], [slab], [lobes] or [lambert]", "none");
    return subject;
}

Scene read_panel(const toml::table& table, const Source& source) {
    const Section root(table, caller, "",
                       {"title", "tolerance", "effects", "columns", "picture", "camera", "sun",
                        "background", "layer", "rings", "planet", "slab", "panels"});
    Scene scene;
    if (root.has("title")) scene.title = root.text("title");
    take(scene.tolerance, root, "tolerance", 1e-6, 0.1, "in [1e-6, 0.1]");
    if (root.has("effects"))
        scene.effects = parse_scene_effects(
            root.is_list("effects") ? root.texts("effects", "\"all\" or a list of names")
                                    : std::vector<std::string>{root.text("effects")});
    if (root.has("picture")) read_picture(root, scene);
    scene.camera = read_camera(root);
    read_sun(root, scene);
    if (root.has("background")) scene.background = read_background(root, source);
    const std::string subject = subject_of(root);
    scene.layer = read_layer(root, source, subject == "rings");
    if (subject == "rings") scene.subject = read_rings(root, source);
    if (subject == "planet") scene.subject = read_planet(root, source);
    if (subject == "slab") scene.subject = read_slab(root, source, scene.camera);
    return scene;
}

/// `table` with the keys of `change` in place of its own, in tables within it one by one.
toml::table changed(toml::table table, const toml::table& change) {
    for (const auto& [key, node] : change) {
        const toml::table* const inner = node.as_table();
        toml::table* const outer = table.get_as<toml::table>(key);
        if (inner && outer)
            *outer = changed(*outer, *inner);
        else
            table.insert_or_assign(key, node);
    }
    return table;
}

/// The pictures of a file: itself, or its panels.
void read_panels(const Section& root, const toml::table& parsed, const Source& source,
                 SceneFile& file) {
    if (!root.has("panels")) {
        file.panels.push_back(read_panel(parsed, source));
        return;
    }
    const toml::array* const panels = parsed.get_as<toml::array>("panels");
    require(panels && panels->is_homogeneous<toml::table>() && panels->size() <= 64, caller,
            "panels", "1 to 64 tables: [[panels]]", "something else");
    toml::table base = parsed;
    base.erase("panels");
    base.erase("title");
    for (const toml::node& panel : *panels)
        file.panels.push_back(read_panel(changed(base, *panel.as_table()), source));
    for (const Scene& scene : file.panels)
        require(scene.width == file.panels[0].width && scene.height == file.panels[0].height,
                caller, "panels", "pictures of one size", "several sizes");
    file.columns = static_cast<int>(file.panels.size());
    if (root.has("columns")) file.columns = root.count("columns", 1, 64);
}

// ---- Figures

Figure read_figure(const toml::table& table, const std::string& subject, const Source& source) {
    const Section root(table, caller, "", {"title", subject});
    if (subject == "lobes") {
        const Section section(root.table("lobes", "a table: [lobes]"), caller, "lobes",
                              {"phase_function", "incident_deg", "optical_depths", "albedos"});
        LobeFigure figure;
        figure.phase_function = source.phase_function(section.text("phase_function"));
        for (const double angle : section.numbers("incident_deg", 0, 180, "in [0, 180]")) {
            require(std::abs(angle - 90) > 0.1, caller, "lobes.incident_deg",
                    "not along the layer, 90", angle);
            figure.incident.push_back(radians(angle));
        }
        figure.optical_depths = section.numbers("optical_depths", 0, infinity, "in [0, inf]");
        figure.albedos = section.numbers("albedos", 0, 1, "in [0, 1]");
        for (const auto& [key, count] : {std::pair("incident_deg", figure.incident.size()),
                                         std::pair("optical_depths", figure.optical_depths.size()),
                                         std::pair("albedos", figure.albedos.size())})
            require(count >= 1 && count <= 8, caller, section.full_name(key),
                    "a list of 1 to 8 numbers", count);
        return figure;
    }
    const Section section(root.table("lambert", "a table: [lambert]"), caller, "lambert",
                          {"phase_function", "albedo", "optical_depth", "mu_in"});
    LambertFigure figure;
    figure.phase_function = source.phase_function(section.text("phase_function"));
    figure.albedo = section.number("albedo", 0, 1, "in [0, 1]");
    figure.optical_depth = section.number("optical_depth", 0, infinity, "in [0, inf]");
    figure.mu_in = section.numbers("mu_in", 1e-3, 1, "in [1e-3, 1]");
    require(!figure.mu_in.empty() && figure.mu_in.size() <= 8, caller, "lambert.mu_in",
            "a list of 1 to 8 numbers", figure.mu_in.size());
    return figure;
}

}  // namespace

const std::vector<std::pair<const char*, bool SceneEffects::*>>& scene_effects() {
    static const std::vector<std::pair<const char*, bool SceneEffects::*>> effects{
        {"single", &SceneEffects::single},
        {"multiple", &SceneEffects::multiple},
        {"azimuth", &SceneEffects::azimuth},
        {"reflection", &SceneEffects::reflection},
        {"transmission", &SceneEffects::transmission},
        {"background", &SceneEffects::background},
        {"opposition", &SceneEffects::opposition},
        {"density", &SceneEffects::density},
        {"shadows", &SceneEffects::shadows},
        {"sun_size", &SceneEffects::sun_size}};
    return effects;
}

SceneEffects parse_scene_effects(const std::vector<std::string>& names) {
    SceneEffects effects;
    auto set_all = [&](bool on) {
        for (const auto& [name, member] : scene_effects()) effects.*member = on;
    };
    set_all(!names.empty() && names.front().starts_with('-'));
    for (const std::string& text : names) {
        const bool on = !text.starts_with('-');
        const std::string name = on ? text : text.substr(1);
        if (name == "all") {
            set_all(on);
            continue;
        }
        const auto found = std::find_if(scene_effects().begin(), scene_effects().end(),
                                        [&](const auto& effect) { return effect.first == name; });
        if (found == scene_effects().end()) {
            std::vector<std::string> known{"all"};
            for (const auto& effect : scene_effects()) known.emplace_back(effect.first);
            throw std::invalid_argument(std::string(caller) + ": unknown effect '" + name +
                                        "'; did you mean '" + nearest_name(name, known) + "'?");
        }
        effects.*found->second = on;
    }
    return effects;
}

std::vector<std::string> scene_effect_names(const SceneEffects& effects) {
    std::vector<std::string> names{"all"};
    for (const auto& [name, member] : scene_effects())
        if (!(effects.*member)) names.push_back(std::string("-") + name);
    return names;
}

Matter RingProfile::at(double at_radius, const std::array<double, 3>& tint) const noexcept {
    if (!(at_radius >= inner() && at_radius <= outer())) return {};
    const auto above = std::lower_bound(radius.begin() + 1, radius.end() - 1, at_radius);
    const auto k = static_cast<std::size_t>(above - radius.begin());
    const double share = (at_radius - radius[k - 1]) / (radius[k] - radius[k - 1]);
    auto linear = [&](const std::vector<double>& of) {
        return of[k - 1] + share * (of[k] - of[k - 1]);
    };
    const double first = linear(w1), both = first + linear(w2);
    return {linear(optical_depth),
            {both * tint[0], both * tint[1], both * tint[2]},
            both > 0 ? first / both : 1};
}

SceneFile parse_scene(const std::string& text, const std::string& directory,
                      std::vector<std::string>* notes) {
    const toml::table parsed = parse_toml(text, caller);
    std::vector<std::string> all_notes;  // panels repeat one another's
    const Source source{directory, &all_notes};
    std::vector<std::string> known{"title",  "tolerance", "effects",    "columns", "picture",
                                   "camera", "sun",       "background", "layer",   "panels"};
    known.insert(known.end(), subjects.begin(), subjects.end());
    const Section root(parsed, caller, "", known);
    SceneFile file;
    file.text = text;
    if (root.has("title")) file.title = root.text("title");
    const std::string subject = subject_of(root);
    if (subject == "lobes" || subject == "lambert")
        file.figure = read_figure(parsed, subject, source);
    else
        read_panels(root, parsed, source, file);
    for (const std::string& note : all_notes)
        if (notes && std::ranges::find(*notes, note) == notes->end()) notes->push_back(note);
    return file;
}

SceneFile read_scene(const std::filesystem::path& path, std::vector<std::string>* notes) {
    return parse_scene(read_text(path), path.parent_path().string(), notes);
}

double seen_depth(const Scene& scene, double optical_depth) noexcept {
    return scene.effects.density ? effective_optical_depth(optical_depth, scene.layer.density)
                                 : optical_depth;
}

}  // namespace stratus
