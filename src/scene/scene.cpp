
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "sections.h"

#include <cmath>

namespace stratus {
namespace scene_file {
namespace {

const std::vector<std::string> subjects{"rings", "planet", "slab", "lobes", "lambert"};

/// The one subject of a file.
std::string subject_name(const Section& root) {
    constexpr const char* allowed = "of one kind: [rings], [planet], [slab], [lobes] or [lambert]";
    std::string subject;
    for (const std::string& name : subjects) {
        if (!root.has(name.c_str()) || (subject == "rings" && name == "planet")) continue;
        root.require(subject.empty(), name.c_str(), allowed,
                     "[" + subject + "] and [" + name + "]");
        subject = name;
    }
    require(!subject.empty(), caller, root.here(), allowed, "none");
    return subject;
}

bool is_figure(const std::string& subject) { return subject == "lobes" || subject == "lambert"; }

void read_effects(const Section& root, Scene& scene) {
    constexpr const char* key = "effects";
    const std::vector<std::string> names =
        root.is_list(key) ? root.texts(key, 0, 100) : std::vector<std::string>{root.text(key)};
    scene.effects = root.placed(key, [&] { return parse_scene_effects(names); });
    for (const std::string& name : names)
        if (!name.starts_with('-') && name != "all") scene.named.push_back(scene_effect(name));
}

/// Tables of stacks know light from above alone: one that is lit from beneath is turned upside down.
void turn_to_sun(const Section& root, Scene& scene) {
    const Slab* const slab = scene.subject_as<Slab>();
    if (!slab) return;
    const double middle = std::asin(std::clamp(scene.to_sun.z, -1.0, 1.0)),
                 above = std::abs(middle) - scene.sun_diameter / 2;
    root.require(above > 0, "sun", "wholly above or wholly beneath a slab that is a stack",
                 std::to_string(degrees(middle)) + " degrees above it");
    const bool from_below = middle < 0;
    if (from_below)
        for (StackLayers& stack : scene.layer.stacks) {
            std::ranges::reverse(stack);
            if (std::isinf(stack[0].optical_depth)) stack.resize(1);  // the others are never lit
        }
    const Camera& camera = scene.camera;
    const double height = camera.orthographic ? -camera.forward().z : camera.position.z;
    if (from_below ? height < 0 : height > 0) return;
    const bool lit_ground = slab->surface && !slab->surface->is_black();
    root.section("slab").require(!lit_ground, "surface",
                                 "black or absent under a stack that is seen from its unlit side",
                                 "another");
    root.require(!scene.background.is_one_colour(), "background",
                 "black or an image behind a stack that is seen from its unlit side", "a colour");
}

/// The effects that a layer's keys make.
void name_effects(const SceneLayer& layer, Scene& scene) {
    if (layer.density > 0) scene.named.push_back(&SceneEffects::density);
    if (layer.opposition.is_present()) scene.named.push_back(&SceneEffects::opposition);
}

/// Refuses layers that are no spherical shells, and shells of which the orders n >= 2 are farther from
/// photons than docs/scenes.md states.
void check_shell(const Section& root, const Scene& scene) {
    const Planet* const planet = scene.subject_as<Planet>();
    const double height = planet ? planet->shell : 0;
    if (height == 0) return;
    constexpr double most = 0.05;  // of height times optical depth
    const SceneLayer& layer = scene.layer;
    const Section section = root.section("planet");
    section.require(layer.stacks.empty() && !layer.opposition.is_present(), "shell",
                    "0 where the layer is a stack or has an opposition", height);
    const double depth =
        seen_depth(scene, layer.optical_depth.max) * std::ranges::max(layer.extinction);
    section.require(height * depth <= most, "shell",
                    short_number(most) + " over the layer's largest optical depth at most, " +
                        short_number(most / depth, 2),
                    height);
}

Scene read_panel(const Section& root, const Source& source) {
    const std::string subject = subject_name(root);
    root.require(!is_figure(subject), subject.c_str(), "absent from pictures", "given");
    Scene scene;
    scene.title = root.text("title");
    scene.tolerance = root.number("tolerance");
    read_effects(root, scene);
    read_picture(root, scene);
    scene.camera = read_camera(root);
    read_sun(root, scene);
    if (root.has("background")) scene.background = read_background(root, source);
    scene.layer = read_layer(root.section("layer"), source, subject == "rings");
    if (subject == "rings") scene.subject = read_rings(root, source, scene.camera);
    if (subject == "planet") scene.subject = read_planet(root, source, scene.camera);
    if (subject == "slab") scene.subject = read_slab(root, source, scene.camera);
    if (!scene.layer.stacks.empty()) turn_to_sun(root, scene);
    check_shell(root, scene);
    if (scene.sun_diameter > 0) scene.named.push_back(&SceneEffects::sun_size);
    name_effects(scene.layer, scene);
    if (const std::optional<Scene> planet = planet_scene(scene)) name_effects(planet->layer, scene);
    return scene;
}

/// Overrides keys of `table` by those of `change`, in nested tables one by one. Nodes are moved: a
/// copy has no line number.
void merge(toml::table& table, toml::table&& change) {
    for (auto&& [key, node] : change) {
        toml::table* const inner = node.as_table();
        toml::table* const outer = table.get_as<toml::table>(key);
        if (inner && outer)
            merge(*outer, std::move(*inner));
        else
            table.insert_or_assign(key, std::move(node));
    }
}

/// One of a file's panels at a frame: the file without its panels and title, with the panel's keys.
toml::table panel_table(const std::string& text, const TomlFile& origin, int frame,
                        std::size_t panel) {
    toml::table table = parse_toml(text, origin);
    animate(table, origin, frame);
    toml::array panels = std::move(*table.get_as<toml::array>("panels"));
    table.erase("panels");
    table.erase("title");
    merge(table, std::move(*panels[panel].as_table()));
    return table;
}

/// The pictures of a file at a frame: itself, or its panels.
void read_panels(const Section& root, const TomlFile& origin, const Source& source, int frame,
                 SceneFile& file) {
    if (!root.has("panels")) {
        require_absent(root, "columns", "where there are no [[panels]]");
        file.panels.push_back(read_panel(root, source));
        return;
    }
    const toml::array& panels = root.tables("panels");
    root.require(panels.size() <= 64, "panels", "64 tables at most", panels.size());
    for (std::size_t k = 0; k < panels.size(); ++k) {
        const Section own(*panels[k].as_table(), origin, scene_keys());
        for (const char* key : {"animation", "columns", "panels"})
            require_absent(own, key, "from a panel");
        const toml::table table = panel_table(file.text, origin, frame, k);
        file.panels.push_back(read_panel({table, origin, scene_keys()}, source));
    }
    for (const Scene& scene : file.panels)
        root.require(scene.width == file.panels[0].width && scene.height == file.panels[0].height,
                     "panels", "pictures of one size", "several sizes");
    file.columns = root.has("columns") ? root.count("columns") : int_size(file.panels);
}

Figure read_figure(const Section& root, const std::string& subject, const Source& source) {
    for (const Key& key : scene_keys())
        if (key.own_name() == key.name && key.name != subject && key.own_name() != "title")
            require_absent(root, key.name, "from a figure");
    if (subject == "lobes") return read_lobes(root, source);
    return read_lambert(root, source);
}

SceneFile read_frame(const std::string& text, const TomlFile& origin, const Source& source,
                     int frame) {
    toml::table parsed = parse_toml(text, origin);
    SceneFile file;
    file.text = text;
    file.frames = animate(parsed, origin, frame).frames;
    const Section root(parsed, origin, scene_keys());
    file.title = root.text("title");
    const std::string subject = subject_name(root);
    if (is_figure(subject))
        file.figure = read_figure(root, subject, source);
    else
        read_panels(root, origin, source, frame, file);
    return file;
}

}  // namespace
}  // namespace scene_file

Film parse_film(const std::string& text, const std::string& directory,
                std::vector<std::string>* notes, const std::string& name) {
    using namespace scene_file;
    std::vector<std::string> all_notes;  // panels and frames repeat one another's
    std::map<std::string, std::shared_ptr<const Image>> images;
    std::map<std::string, Texture> oceans;
    const Source source{{directory, &all_notes}, &images, &oceans};
    const TomlFile origin{caller, name};
    toml::table parsed = parse_toml(text, origin);
    const Animation animation = animate(parsed, origin, 0);
    // Frames with keys come first: refusals of what these say name its line.
    std::vector<int> order = animation.keyed;
    for (int frame = 0; frame < animation.frames; ++frame)
        if (!std::ranges::binary_search(animation.keyed, frame)) order.push_back(frame);
    Film film(order.size());
    for (const int frame : order) {
        TomlFile own = origin;
        if (film.size() > 1)
            own.name += (own.name.empty() ? "frame " : ", frame ") + std::to_string(frame);
        film[size(frame)] = read_frame(text, own, source, frame);
    }
    for (const SceneFile& each : film)
        require(each.figure || (each.panels[0].width == film[0].panels[0].width &&
                                each.panels[0].height == film[0].panels[0].height),
                caller, "picture", "of one size in all frames", "several sizes");
    for (const std::string& note : all_notes)
        if (notes && !is_listed(note, *notes)) notes->push_back(note);
    return film;
}

Film read_film(const fs::path& path, std::vector<std::string>* notes) {
    return parse_film(read_text(path), path.parent_path().string(), notes, path.string());
}

void change(const SceneChanges& changes, Film& film) {
    for (SceneFile& frame : film)
        for (Scene& scene : frame.panels) {
            if (!changes.effects.empty()) scene.effects = parse_scene_effects(changes.effects);
            for (const std::string& name : changes.drop) scene.effects.*scene_effect(name) = false;
            if (changes.tolerance > 0) scene.tolerance = changes.tolerance;
            if (changes.width == 0) continue;
            const double height = static_cast<double>(scene.height) * changes.width / scene.width;
            scene.height = std::max(1, static_cast<int>(std::lround(height)));
            scene.width = changes.width;
        }
}

Scenes all_panels(const Film& film) {
    Scenes scenes;
    for (const SceneFile& frame : film)
        scenes.insert(scenes.end(), frame.panels.begin(), frame.panels.end());
    return scenes;
}

const std::vector<std::pair<const char*, EffectFlag>>& scene_effects() {
    static const std::vector<std::pair<const char*, EffectFlag>> effects{
        {"single", &SceneEffects::single},
        {"multiple", &SceneEffects::multiple},
        {"azimuth", &SceneEffects::azimuth},
        {"reflection", &SceneEffects::reflection},
        {"transmission", &SceneEffects::transmission},
        {"background", &SceneEffects::background},
        {"opposition", &SceneEffects::opposition},
        {"density", &SceneEffects::density},
        {"shadows", &SceneEffects::shadows},
        {"sun_size", &SceneEffects::sun_size},
        {"ringshine", &SceneEffects::ringshine},
        {"planetshine", &SceneEffects::planetshine},
        {"shell", &SceneEffects::shell}};
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
        if (name == "all")
            set_all(on);
        else
            effects.*scene_effect(name) = on;
    }
    return effects;
}

EffectFlag scene_effect(const std::string& name) {
    std::vector<std::string> known;
    for (const auto& [own_name, effect] : scene_effects()) {
        if (name == own_name) return effect;
        known.emplace_back(own_name);
    }
    throw std::invalid_argument("unknown effect '" + name + "'; did you mean '" +
                                nearest_name(name, known) + "'?");
}

std::vector<std::string> scene_effect_names(const SceneEffects& effects) {
    std::vector<std::string> names{"all"};
    for (const auto& [name, member] : scene_effects())
        if (!(effects.*member)) names.push_back(std::string("-") + name);
    return names;
}

std::optional<Scene> planet_scene(const Scene& scene) {
    const Rings* const rings = scene.subject_as<Rings>();
    if (!rings || !rings->planet_layer) return std::nullopt;
    Scene planet = scene;
    planet.layer = *rings->planet_layer;
    planet.subject =
        Planet{rings->surface, 0, scene.effects.ringshine || scene.effects.planetshine};
    return planet;
}

Scenes channel_scenes(const Scene& scene) {
    Scenes scenes(std::max<std::size_t>(1, scene.layer.channels.size()), scene);
    for (std::size_t c = 0; c < scene.layer.channels.size(); ++c) {
        SceneLayer& layer = scenes[c].layer;
        layer.components = {scene.layer.channels[c]};
        layer.channels.clear();
        if (!layer.stacks.empty()) layer.stacks = {scene.layer.stacks[c]};
        layer.albedo.fill(scene.layer.albedo[c]);
        layer.optical_depth.max *= scene.layer.extinction[c];
        layer.extinction.fill(1);
    }
    if (const std::optional<Scene> planet = planet_scene(scene))
        for (Scene& channel : channel_scenes(*planet)) scenes.push_back(std::move(channel));
    return scenes;
}

Scenes channel_scenes(const Scenes& scenes) {
    Scenes channels;
    for (const Scene& scene : scenes)
        for (Scene& channel : channel_scenes(scene)) channels.push_back(std::move(channel));
    return channels;
}

bool are_alike(const SceneLayer& one, const SceneLayer& other) {
    const auto key = [](const SceneLayer& layer) {
        std::string all;
        const auto add = [&](const PhaseFunction& function, std::initializer_list<double> numbers) {
            all += function.text() + ";";
            for (const double number : numbers) all += shortest_text(number) + ";";
        };
        for (const auto* const functions : {&layer.components, &layer.channels})
            for (const PhaseFunction& each : *functions) add(each, {});
        for (const StackLayers& stack : layer.stacks)
            for (const StackLayer& each : stack)
                add(each.phase_function, {each.albedo, each.optical_depth});
        const auto& [law, width, amplitude] = layer.opposition;
        return std::tuple(layer.albedo, layer.extinction, layer.optical_depth.max, layer.density,
                          law, width, amplitude, all);
    };
    return key(one) == key(other);
}

double seen_shell(const Scene& scene) {
    const Planet* const planet = scene.subject_as<Planet>();
    return planet && scene.effects.shell && scene.layer.optical_depth.max > 0 ? planet->shell : 0;
}

double seen_depth(const Scene& scene, double optical_depth) {
    return scene.effects.density ? effective_optical_depth(optical_depth, scene.layer.density)
                                 : optical_depth;
}

}  // namespace stratus
