// [animation]: keys of the scene over time.
#include <stratus/base/argument.h>

#include "sections.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stratus::scene_file {
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
    require(frame < frames, caller, section.at("frame"),
            "below animation.frames, " + std::to_string(frames), frame);
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

bool is_whole(const Path& path) {
    return std::ranges::any_of(scene_keys(), [&](const Key& key) {
        return key.name == path.back() && key.form == std::string("whole number");
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
        require(own > before, caller, section.at("keys"), "tables of ascending frames",
                std::to_string(own) + " after " + std::to_string(before));
        animation.keyed.push_back(own);
        collect(table, own, {}, tracks);
    }
    const Path* last = nullptr;
    for (const auto& [path, track] : tracks) {
        const bool within = last && last->size() < path.size() &&
                            std::equal(last->begin(), last->end(), path.begin());
        require(!within, caller, section.at("keys"),
                "tables that give a key a value everywhere or a table everywhere",
                within ? last->back() + " as both" : "");
        set_at_frame(root, path, track, frame);
        last = &path;
    }
    return animation;
}

}  // namespace stratus::scene_file
