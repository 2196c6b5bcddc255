#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/scene/scene.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

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
        if (name == "all") {
            set_all(on);
            continue;
        }
        effects.*scene_effect(name) = on;
    }
    return effects;
}

EffectFlag scene_effect(const std::string& name) {
    const auto found = std::find_if(scene_effects().begin(), scene_effects().end(),
                                    [&](const auto& effect) { return effect.first == name; });
    if (found != scene_effects().end()) return found->second;
    std::vector<std::string> known{"all"};
    for (const auto& effect : scene_effects()) known.emplace_back(effect.first);
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
    const Rings* const rings = std::get_if<Rings>(&scene.subject);
    if (!rings || !rings->planet_layer) return std::nullopt;
    Scene planet = scene;
    planet.layer = *rings->planet_layer;
    planet.subject =
        Planet{rings->surface, 0, scene.effects.ringshine || scene.effects.planetshine};
    return planet;
}

std::vector<Scene> channel_scenes(const Scene& scene) {
    std::vector<Scene> scenes(std::max<std::size_t>(1, scene.layer.channels.size()), scene);
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

std::vector<Scene> channel_scenes(const std::vector<Scene>& scenes) {
    std::vector<Scene> channels;
    for (const Scene& scene : scenes)
        for (Scene& channel : channel_scenes(scene)) channels.push_back(std::move(channel));
    return channels;
}

bool are_alike(const SceneLayer& one, const SceneLayer& other) {
    const auto text = [](const SceneLayer& layer) {
        std::string all;
        const auto add = [&](const PhaseFunction& function, std::initializer_list<double> numbers) {
            all += function.text() + ";";
            for (const double number : numbers) all += shortest_text(number) + ";";
        };
        for (const auto* const functions : {&layer.components, &layer.channels})
            for (const PhaseFunction& each : *functions) add(each, {});
        for (const std::vector<StackLayer>& stack : layer.stacks)
            for (const StackLayer& each : stack)
                add(each.phase_function, {each.albedo, each.optical_depth});
        return all;
    };
    const Opposition &a = one.opposition, &b = other.opposition;
    return one.albedo == other.albedo && one.extinction == other.extinction &&
           one.optical_depth.max == other.optical_depth.max && one.density == other.density &&
           a.law == b.law && a.amplitude == b.amplitude && a.width == b.width &&
           text(one) == text(other);
}

double seen_shell(const Scene& scene) noexcept {
    const Planet* const planet = std::get_if<Planet>(&scene.subject);
    return planet && scene.effects.shell && scene.layer.optical_depth.max > 0 ? planet->shell : 0;
}

double seen_depth(const Scene& scene, double optical_depth) noexcept {
    return scene.effects.density ? effective_optical_depth(optical_depth, scene.layer.density)
                                 : optical_depth;
}

}  // namespace stratus
