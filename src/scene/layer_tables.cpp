#include <stratus/scene/layer_tables.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include "axes.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

constexpr const char* caller = "scene";

/// For maps that go down to 0: below it, lookups follow the law of thin layers (lookup.h).
constexpr double min_mapped_depth = 0.02;

/// Limits of recipes.
constexpr double min_table_depth = 1e-6, max_table_depth = 1e9;

/// A single value where two differ by rounding alone.
Range merged(const Range& range) {
    return range.max - range.min < 1e-9 ? Range{range.max, range.max} : range;
}

constexpr double min_mixture_range = 1e-6;  // below, one mixture is enough

/// Ranges of the layer's matter, with the effect of density.
struct MatterRange {
    Range optical_depth{infinity, 0}, albedo{1, 0}, mixture{1, 0};
};

MatterRange matter_range(const Scene& scene) {
    MatterRange range;
    auto add = [&](const Matter& matter) {
        if (matter.optical_depth == 0) return;
        for (const double extinction : scene.layer.extinction)
            if (extinction > 0)
                widen(range.optical_depth, extinction * seen_depth(scene, matter.optical_depth));
        for (const double albedo : matter.albedo) widen(range.albedo, albedo);
        widen(range.mixture, matter.mixture);
    };
    if (const Rings* const rings = std::get_if<Rings>(&scene.subject)) {
        for (const double radius : rings->profile.radius)
            add(rings->profile.at(radius, scene.layer.albedo));
        return range;
    }
    add({scene.layer.optical_depth.max, scene.layer.albedo, 1});
    if (!scene.layer.optical_depth.is_plain() && range.optical_depth.max > 0)
        widen(range.optical_depth, std::min(min_mapped_depth, range.optical_depth.max));
    return range;
}

/// Cosines at which a scene looks its layer up as lit: that of a point sun over a plane. Planetshine
/// comes from everywhere, and fluxes are asked for at the cosine of view.
Range incidence(const Scene& scene, const SeenLight& light) {
    const bool globe = std::holds_alternative<Planet>(scene.subject);
    if (globe || light.fluxes || light.underside || light.shine) return all_cosines;
    const Range seen = seen_directions(scene).mu_in;
    if (seen.max <= min_mu) return {min_mu, min_mu};
    return {seen.min <= min_mu ? all_cosines.min : seen.min, seen.max};
}

bool have_same_layers(const Recipe& one, const Recipe& other) {
    return std::ranges::equal(one.layers, other.layers,
                              [](const StackLayer& a, const StackLayer& b) {
                                  return a.albedo == b.albedo &&
                                         a.optical_depth == b.optical_depth &&
                                         a.phase_function.text() == b.phase_function.text();
                              });
}

/// Refuses a table that does not serve a scene.
void check_table(const Scene& scene, const Table& table) {
    require(!table.lower_boundary.is_present(), caller, "table.below", "absent", "one");
    const std::optional<Recipe> needed = needed_recipe(scene);
    if (!needed) return;
    const auto same = [](const char* name, const PhaseFunction& own, const PhaseFunction& met) {
        require(met.text() == own.text(), caller, name, own.text(), met.text());
    };
    same("table.phase_function", needed->phase_function, table.phase_function);
    Recipe of_table;
    of_table.layers = table.layers;
    require(have_same_layers(*needed, of_table), caller, "table.layers",
            needed->layers.empty() ? "absent" : "those of the scene's stack",
            table.is_stack() ? "another stack" : "none");
    require(table.has_mixture() == needed->mixture.has_value(), caller, "table",
            needed->mixture ? "one with a mixture axis" : "one without a mixture axis", "another");
    if (needed->mixture)
        same("table.second_phase_function", needed->second_phase_function,
             table.second_phase_function);
    auto covers = [&](const std::string& name, const AxisView& axis, const Range& range) {
        require(axis.lowest <= range.min, caller, name + ".min",
                "at most the scene's, " + shortest_text(range.min), axis.lowest);
        require(axis.highest >= range.max || axis.ends_at_infinity, caller, name + ".max",
                "at least the scene's, " + shortest_text(range.max), axis.highest);
    };
    covers("table.albedo", table.albedo.view(), needed->albedo);
    if (needed->mixture) covers("table.mixture", table.mixture.view(), *needed->mixture);
    const AxisView depths = table.optical_depth.view();
    if (std::isinf(needed->optical_depth.max))
        require(depths.ends_at_infinity, caller, "table.optical_depth.max", "inf", depths.highest);
    if (!std::isinf(needed->optical_depth.min))
        covers("table.optical_depth", depths, needed->optical_depth);
    constexpr double rounding = 1e-6;
    covers(
        "table.mu_in", table.mu_in.view(),
        {std::max(min_mu, needed->mu_in.min) * (1 + rounding), needed->mu_in.max * (1 - rounding)});
    require(!needed->reflection || !table.reflection_multiple.empty(), caller, "table",
            "one with reflection", "none");
    require(!needed->transmission || !table.transmission_multiple.empty(), caller, "table",
            "one with transmission", "none");
}

}  // namespace

std::optional<Matter> uniform_matter(const Scene& scene) {
    if (std::holds_alternative<Rings>(scene.subject) || !scene.layer.optical_depth.is_plain())
        return std::nullopt;
    return Matter{scene.layer.optical_depth.max, scene.layer.albedo, 1};
}

std::optional<Recipe> needed_recipe(const Scene& scene) {
    const MatterRange range = matter_range(scene);
    const SeenLight seen = seen_light(scene);
    if (!scene.effects.multiple || !seen.any() || range.optical_depth.max == 0 ||
        range.albedo.max == 0)
        return std::nullopt;
    Recipe recipe;
    if (!scene.layer.stack.empty()) recipe = recipe_of_stack(scene.layer.stack, {});
    recipe.title = scene.title;
    recipe.phase_function = scene.layer.components[0];
    if (scene.layer.components.size() > 1) {
        if (range.mixture.max - range.mixture.min < min_mixture_range) {
            const double share = (range.mixture.min + range.mixture.max) / 2;
            recipe.phase_function =
                PhaseFunction::mixture(share, scene.layer.components[0], scene.layer.components[1]);
        } else {
            recipe.second_phase_function = scene.layer.components[1];
            recipe.mixture = range.mixture;
        }
    }
    recipe.phase_text = recipe.phase_function.text();
    recipe.tolerance = scene.tolerance;
    // Beyond the limits of tables, lookups follow the laws of thin and deep layers (lookup.h).
    auto tabulated = [](double depth) {
        return std::isinf(depth) ? depth : std::clamp(depth, min_table_depth, max_table_depth);
    };
    recipe.optical_depth =
        merged({std::max(tabulated(range.optical_depth.min),
                         std::min(min_mapped_depth, tabulated(range.optical_depth.max))),
                tabulated(range.optical_depth.max)});
    recipe.albedo = merged(range.albedo);
    recipe.mu_in = incidence(scene, seen);
    recipe.transmission = scene.effects.transmission && (seen.transmission || seen.fluxes) &&
                          range.optical_depth.min < infinity;
    recipe.reflection = seen.reflection || !recipe.transmission;
    if (!scene.effects.azimuth) {
        recipe.discretisation.modes = recipe.discretisation.azimuth_samples = 1;
        recipe.discretisation.azimuth_scale = AxisScale::linear;
    }
    return recipe;
}

std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other) {
    const bool one_is_infinite = std::isinf(one.optical_depth.min),
               other_is_infinite = std::isinf(other.optical_depth.min);
    if (one.phase_text != other.phase_text || !have_same_layers(one, other) || one_is_infinite != other_is_infinite ||
        one.discretisation.modes != other.discretisation.modes ||
        one.mixture.has_value() != other.mixture.has_value() ||
        (one.mixture && one.second_phase_function.text() != other.second_phase_function.text()))
        return std::nullopt;
    Recipe both = one;
    both.tolerance = std::min(one.tolerance, other.tolerance);
    widen(both.optical_depth, other.optical_depth.min);
    widen(both.optical_depth, other.optical_depth.max);
    widen(both.albedo, other.albedo.min);
    widen(both.albedo, other.albedo.max);
    widen(both.mu_in, other.mu_in.min);
    widen(both.mu_in, other.mu_in.max);
    if (both.mixture) {
        widen(*both.mixture, other.mixture->min);
        widen(*both.mixture, other.mixture->max);
    }
    both.reflection = one.reflection || other.reflection;
    both.transmission = one.transmission || other.transmission;
    return both;
}

std::unique_ptr<LayerTables> make_layer_tables(Table table, bool is_uniform) {
    auto made = std::make_unique<LayerTables>();
    made->mixture = table.mixture;
    if (table.has_mixture())
        for (int m = 0; m < static_cast<int>(table.mixture_count()); ++m)
            made->tables.push_back(table_of_mixture(table, m));
    else
        made->tables.push_back(std::move(table));
    if (!is_uniform)
        for (const Table& each : made->tables) made->textured.emplace_back(each.view());
    return made;
}

std::unique_ptr<LayerTables> bake_layer_tables(const Scene& scene, Recipe recipe,
                                               const BakeOptions& options, TableCache* cache) {
    recipe.text = resolved_text(recipe);
    std::optional<Table> table;
    if (cache) table = cache->find(recipe);
    if (!table) {
        table = bake(recipe, options);
        if (cache) cache->keep(recipe, *table);
    }
    return make_layer_tables(std::move(*table), uniform_matter(scene).has_value());
}

std::shared_ptr<const LayerTables> adopt_tables(const std::vector<Scene>& scenes,
                                                std::vector<Table> tables) {
    const auto has_channels = [](const Scene& scene) { return !scene.layer.channels.empty(); };
    const bool coloured = std::ranges::any_of(scenes, has_channels);
    require(!coloured || std::ranges::all_of(scenes, has_channels), caller, "panels",
            "alike in the number of their phase functions where tables are given", "one and three");
    require(tables.size() == (coloured ? 3 : 1), caller, "--table",
            coloured ? "given three times, for red, green and blue" : "given once",
            std::to_string(tables.size()));
    const bool uniform = std::ranges::all_of(
        scenes, [](const Scene& scene) { return uniform_matter(scene).has_value(); });
    for (const Scene& scene : scenes) {
        const std::vector<Scene> channels = channel_scenes(scene);
        for (std::size_t c = 0; c < channels.size(); ++c) check_table(channels[c], tables[c]);
    }
    if (!coloured) return make_layer_tables(std::move(tables[0]), uniform);
    auto all = std::make_shared<LayerTables>();
    for (std::size_t c = 0; c < tables.size(); ++c)
        all->channels[c] = make_layer_tables(std::move(tables[c]), uniform);
    return all;
}

std::vector<SharedRecipe> shared_recipes(const std::vector<Scene>& scenes) {
    std::vector<SharedRecipe> all;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const std::optional<Recipe> needed = needed_recipe(scenes[s]);
        if (!needed) continue;
        const bool uniform = uniform_matter(scenes[s]).has_value();
        bool found = false;
        for (SharedRecipe& shared : all) {
            const std::optional<Recipe> both = common_recipe(shared.recipe, *needed);
            if (!both || shared.uniform != uniform) continue;
            shared.recipe = *both;
            shared.scenes.push_back(s);
            found = true;
            break;
        }
        if (!found) all.push_back({*needed, uniform, {s}});
    }
    return all;
}

namespace {

/// Of scenes with one phase function each.
std::vector<std::shared_ptr<const LayerTables>> bake_shared(const std::vector<Scene>& scenes,
                                                            const BakeOptions& options,
                                                            TableCache* cache) {
    std::vector<std::shared_ptr<const LayerTables>> tables(scenes.size());
    for (const SharedRecipe& shared : shared_recipes(scenes)) {
        const std::shared_ptr<const LayerTables> made =
            bake_layer_tables(scenes[shared.scenes[0]], shared.recipe, options, cache);
        for (const std::size_t s : shared.scenes) tables[s] = made;
    }
    return tables;
}

}  // namespace

std::vector<std::shared_ptr<const LayerTables>> bake_for(const std::vector<Scene>& scenes,
                                                         const BakeOptions& options,
                                                         TableCache* cache) {
    std::vector<Scene> channels;
    for (const Scene& scene : scenes)
        for (Scene& channel : channel_scenes(scene)) channels.push_back(std::move(channel));
    const auto baked = bake_shared(channels, options, cache);
    std::vector<std::shared_ptr<const LayerTables>> tables;
    std::size_t next = 0;
    for (const Scene& scene : scenes) {
        if (scene.layer.channels.empty()) {
            tables.push_back(baked[next++]);
            continue;
        }
        const auto all = std::make_shared<LayerTables>();
        bool needed = false;
        for (auto& channel : all->channels) {
            channel = baked[next++];
            needed = needed || channel;
        }
        tables.push_back(needed ? all : nullptr);
    }
    return tables;
}

}  // namespace stratus
