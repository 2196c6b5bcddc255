#include <stratus/scene/scene.h>

#include <stratus/runtime/argument.h>

#include "sections.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace scene_file {
namespace {

const std::vector<std::string> subjects{"rings", "planet", "slab", "lobes", "lambert"};

/// The one subject of a file.
std::string subject_of(const Section& root) {
    constexpr const char* allowed = "of one kind: [rings], [planet], [slab], [lobes] or [lambert]";
    std::string subject;
    for (const std::string& name : subjects) {
        if (!root.has(name.c_str())) continue;
        require(subject.empty(), caller, "scene", allowed, "[" + subject + "] and [" + name + "]");
        subject = name;
    }
    require(!subject.empty(), caller, "scene", allowed, "none");
    return subject;
}

void read_effects(const Section& root, Scene& scene) {
    const std::vector<std::string> names = root.is_list("effects")
                                               ? root.texts("effects", "\"all\" or a list of names")
                                               : std::vector<std::string>{root.text("effects")};
    scene.effects = parse_scene_effects(names);
    for (const std::string& name : names)
        if (!name.starts_with('-') && name != "all") scene.named.push_back(scene_effect(name));
}

Scene read_panel(const toml::table& table, const Source& source) {
    const Section root(table, caller, "",
                       {"title", "tolerance", "effects", "columns", "picture", "camera", "sun",
                        "background", "layer", "rings", "planet", "slab", "panels"});
    Scene scene;
    if (root.has("title")) scene.title = root.text("title");
    read_optional(scene.tolerance, root, "tolerance", 1e-6, 0.1, "in [1e-6, 0.1]");
    if (root.has("effects")) read_effects(root, scene);
    if (root.has("picture")) read_picture(root, scene);
    scene.camera = read_camera(root);
    read_sun(root, scene);
    if (root.has("background")) scene.background = read_background(root, source);
    const std::string subject = subject_of(root);
    scene.layer = read_layer(root, source, subject == "rings");
    if (subject == "rings") scene.subject = read_rings(root, source);
    if (subject == "planet") scene.subject = read_planet(root, source);
    if (subject == "slab") scene.subject = read_slab(root, source, scene.camera);
    if (scene.sun_diameter > 0) scene.named.push_back(&SceneEffects::sun_size);
    if (scene.layer.density > 0) scene.named.push_back(&SceneEffects::density);
    if (scene.layer.opposition.law != Opposition::Law::none)
        scene.named.push_back(&SceneEffects::opposition);
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

/// One of a file's panels: the file without its panels and title, with the panel's keys.
toml::table panel_table(const std::string& text, std::size_t panel) {
    toml::table table = parse_toml(text, caller);
    toml::array panels = std::move(*table.get_as<toml::array>("panels"));
    table.erase("panels");
    table.erase("title");
    merge(table, std::move(*panels[panel].as_table()));
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
            "panels", "1 to 64 tables: [[panels]]", "another value");
    for (std::size_t k = 0; k < panels->size(); ++k)
        file.panels.push_back(read_panel(panel_table(file.text, k), source));
    for (const Scene& scene : file.panels)
        require(scene.width == file.panels[0].width && scene.height == file.panels[0].height,
                caller, "panels", "pictures of one size", "several sizes");
    file.columns = static_cast<int>(file.panels.size());
    if (root.has("columns")) file.columns = root.count("columns", 1, 64);
}

Figure read_figure(const toml::table& table, const std::string& subject, const Source& source) {
    const Section root(table, caller, "", {"title", subject});
    if (subject == "lobes") return read_lobes(root, source);
    return read_lambert(root, source);
}

}  // namespace
}  // namespace scene_file

SceneFile parse_scene(const std::string& text, const std::string& directory,
                      std::vector<std::string>* notes) {
    using namespace scene_file;
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

}  // namespace stratus
