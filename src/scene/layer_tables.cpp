#include <stratus/scene/layer_tables.h>

#include <stratus/base/angle.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/table/family_member.h>

#include "axes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>

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

/// Directions at which a scene looks its layer up. Fluxes are over mu_in and asked for at cosines of
/// view, too.
SeenDirections asked_directions(const Scene& scene, const SeenLight& light) {
    SeenDirections asked = seen_directions(scene);
    if (light.fluxes || light.underside) asked.mu_in = all_cosines;
    for (Range* const range : {&asked.mu_in, &asked.mu_out}) {
        range->max = std::max(range->max, min_mu);
        if (range->min <= min_mu) range->min = range->max == min_mu ? min_mu : all_cosines.min;
    }
    return asked;
}

// Tabulated ranges of view end at these, so that a camera that moves a little asks for the same
// table.
constexpr double mu_marks[] = {0,    0.001, 0.003, 0.01, 0.02, 0.05, 0.1,  0.15, 0.2,
                               0.25, 0.3,   0.35,  0.4,  0.45, 0.5,  0.55, 0.6,  0.65,
                               0.7,  0.75,  0.8,   0.85, 0.9,  0.95, 0.98, 1};
constexpr double azimuth_step = 5;  // degrees

constexpr double rounding = 1e-6;  // of ranges against lookups

/// Pairs of cosines that a table solves: where both axes are the same, of two ways round one.
std::size_t pairs_of(const Range& mu_in, const Range& mu_out) {
    constexpr int samples = 32;  // of all cosines, about as many as are chosen
    const std::size_t in = mu_axis(mu_in, samples).values.size(),
                      out = mu_axis(mu_out, samples).values.size();
    return mu_in.min == mu_out.min && mu_in.max == mu_out.max ? in * (in + 1) / 2 : in * out;
}

/// Cosines of view to tabulate: all unless some take half of the pairs. What saves less is not worth
/// a table that serves fewer pictures.
Range tabulated_cosines(const Range& mu_in, const Range& asked) {
    const Range some{*(std::ranges::upper_bound(mu_marks, std::max(0.0, asked.min - rounding)) - 1),
                     *std::ranges::lower_bound(mu_marks, std::min(1.0, asked.max + rounding))};
    const std::size_t all =
        std::min(pairs_of(mu_in, all_cosines), pairs_of(all_cosines, all_cosines));
    return 2 * pairs_of(mu_in, some) <= all ? some : all_cosines;
}

/// The same of azimuths.
Range tabulated_azimuths(const Range& asked) {
    const auto step = [](double steps) { return std::clamp(azimuth_step * steps, 0.0, 180.0); };
    const Range some{step(std::floor((asked.min - rounding) / azimuth_step)),
                     step(std::ceil((asked.max + rounding) / azimuth_step))};
    return 2 * (some.max - some.min) <= all_azimuths.max ? some : all_azimuths;
}

/// Makes mu_in and mu_out the same where that takes no more pairs than both as they are.
void take_fewer_pairs(Recipe& recipe) {
    const Range both{std::min(recipe.mu_in.min, recipe.mu_out.min),
                     std::max(recipe.mu_in.max, recipe.mu_out.max)};
    if (pairs_of(both, both) <= pairs_of(recipe.mu_in, recipe.mu_out))
        recipe.mu_in = recipe.mu_out = both;
}

bool have_same_layers(const Recipe& one, const Recipe& other) {
    return std::ranges::equal(
        one.layers, other.layers, [](const StackLayer& a, const StackLayer& b) {
            return a.albedo == b.albedo && a.optical_depth == b.optical_depth &&
                   a.phase_function.text() == b.phase_function.text();
        });
}

/// Refuses a table that does not serve a scene.
void check_table(const Scene& scene, const PackedTable& packed) {
    const Table& table = packed.header();
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
    const Range* const mixture = mixture_of(*needed);
    require(table.has_family() == (mixture != nullptr), caller, "table",
            mixture ? "one with a mixture axis" : "one without a mixture axis", "another");
    if (mixture)
        same("table.second_phase_function", needed->second_phase_function,
             table.second_phase_function);
    const auto covers = [&](const std::string& name, const AxisView& axis, const Range& range,
                            double slack = 0) {
        require(axis.lowest <= range.min + slack, caller, name + ".min",
                "at most the scene's, " + shortest_text(range.min), axis.lowest);
        require(axis.highest >= range.max - slack || axis.ends_at_infinity, caller, name + ".max",
                "at least the scene's, " + shortest_text(range.max), axis.highest);
    };
    covers("table.albedo", table.albedo.view(), needed->albedo);
    if (mixture) covers("table.mixture", table.family[0].axis.view(), *mixture);
    const AxisView depths = table.optical_depth.view();
    if (std::isinf(needed->optical_depth.max))
        require(depths.ends_at_infinity, caller, "table.optical_depth.max", "inf", depths.highest);
    if (!std::isinf(needed->optical_depth.min))
        covers("table.optical_depth", depths, needed->optical_depth);
    const SeenDirections asked = asked_directions(scene, seen_light(scene));
    covers("table.mu_in", table.mu_in.view(), {std::max(min_mu, asked.mu_in.min), asked.mu_in.max},
           rounding);
    covers("table.mu_out", table.mu_out.view(),
           {std::max(min_mu, asked.mu_out.min), asked.mu_out.max}, rounding);
    const AxisView azimuth = table.azimuth.view();
    if (azimuth.count > 1 || azimuth.highest > 0)  // else nothing depends on it
        covers("table.azimuth", azimuth, {radians(asked.azimuth.min), radians(asked.azimuth.max)},
               rounding);
    require(!needed->reflection || packed.has_reflection(), caller, "table", "one with reflection",
            "none");
    require(!needed->transmission || packed.has_transmission(), caller, "table",
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
            set_mixture(recipe, scene.layer.components[1], range.mixture);
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
    const SeenDirections asked = asked_directions(scene, seen);
    recipe.mu_in = asked.mu_in;
    recipe.mu_out = tabulated_cosines(asked.mu_in, asked.mu_out);
    if (scene.effects.azimuth) recipe.azimuth = tabulated_azimuths(asked.azimuth);
    take_fewer_pairs(recipe);
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
    if (one.phase_text != other.phase_text || !have_same_layers(one, other) ||
        one_is_infinite != other_is_infinite ||
        one.discretisation.modes != other.discretisation.modes ||
        one.family.size() != other.family.size() ||
        one.second_phase_function.text() != other.second_phase_function.text())
        return std::nullopt;
    Recipe both = one;
    both.tolerance = std::min(one.tolerance, other.tolerance);
    for (Range Recipe::*const range : {&Recipe::optical_depth, &Recipe::albedo, &Recipe::mu_in,
                                       &Recipe::mu_out, &Recipe::azimuth}) {
        widen(both.*range, (other.*range).min);
        widen(both.*range, (other.*range).max);
    }
    take_fewer_pairs(both);
    if (Range* const mixture = mixture_of(both)) {
        widen(*mixture, mixture_of(other)->min);
        widen(*mixture, mixture_of(other)->max);
    }
    both.reflection = one.reflection || other.reflection;
    both.transmission = one.transmission || other.transmission;
    return both;
}

std::unique_ptr<LayerTables> make_layer_tables(PackedTable table) {
    auto made = std::make_unique<LayerTables>();
    const Table& header = table.header();
    if (header.has_family()) made->mixture = header.family[0].axis;
    for (std::size_t m = 0; m < header.member_count(); ++m) {
        Table& one = made->headers.emplace_back(header);
        for_each_of_members(
            [&](auto& numbers) {
                const auto size =
                    static_cast<std::ptrdiff_t>(numbers.size() / header.member_count());
                const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(m) * size;
                numbers = {first, first + size};
            },
            one);
    }
    made->packed = std::move(table);
    return made;
}

std::unique_ptr<LayerTables> bake_layer_tables(Recipe recipe, const BakeOptions& options,
                                               TableCache* cache) {
    recipe.text = resolved_text(recipe);
    if (cache)
        if (std::optional<PackedTable> table = cache->find(recipe))
            return make_layer_tables(std::move(*table));
    std::vector<char> packed;
    BakeOptions straight = options;
    straight.packed = &packed;
    const std::unique_ptr<Checkpoint> choices = cache ? cache->open_choices(recipe) : nullptr;
    if (choices) straight.log.find = [&](const std::string& piece) { return choices->find(piece); };
    Table header = bake(recipe, straight);
    if (cache) packed = cache->keep(recipe, std::move(header), std::move(packed));
    return make_layer_tables(PackedTable(packed));
}

namespace {

/// The tables of a scene, from those of its channel_scenes.
std::shared_ptr<const LayerTables> of_channels(
    const Scene& scene, std::span<const std::shared_ptr<const LayerTables>> own) {
    if (scene.layer.channels.empty()) return own[0];
    const auto all = std::make_shared<LayerTables>();
    bool needed = false;
    for (std::size_t c = 0; c < all->channels.size(); ++c) {
        all->channels[c] = own[c];
        needed = needed || own[c];
    }
    return needed ? all : nullptr;
}

/// The point of a table's family where it has a scene's phase function.
FamilyPoint point_of(const Table& table, const PhaseFunction& phase_function) {
    std::vector<double> values;
    for (const FamilyAxis& axis : table.family) {
        const std::optional<double> value = parameter_of(phase_function, axis.parameter);
        require(value.has_value(), caller, "table.family",
                "one of parameters of the scene's phase function, " +
                    phase_function.text().substr(0, 80),
                axis.name());
        require(holds(axis, *value), caller, axis.name() + std::string(" of the phase function"),
                allowed_text(axis), *value);
        values.push_back(*value);
    }
    return FamilyPoint(values);
}

/// A table given for scenes, prepared once; of a family once for each member that is asked for.
class GivenTable {
  public:
    explicit GivenTable(PackedTable table) {
        if (table.header().varies_parameters())
            family_ = table.unpacked();
        else
            made_[""] = make_layer_tables(std::move(table));
    }

    /// For a scene of one phase function, or of two that mix; none where it needs none of a family.
    std::shared_ptr<const LayerTables> serve(const Scene& scene) {
        const std::optional<Recipe> needed = needed_recipe(scene);
        if (family_ && !needed) return nullptr;
        std::shared_ptr<const LayerTables>& made = made_[family_ ? needed->phase_text : ""];
        if (!made) {
            require(mixture_of(*needed) == nullptr, caller, "table",
                    "one with a mixture axis alone where there are rings of two components",
                    "another family");
            made = make_layer_tables(
                PackedTable(pack(table_at(*family_, point_of(*family_, needed->phase_function)))));
        }
        check_table(scene, *made->packed);
        return made;
    }

  private:
    std::optional<Table> family_;
    std::map<std::string, std::shared_ptr<const LayerTables>> made_;  // by phase function, or ""
};

}  // namespace

std::vector<std::shared_ptr<const LayerTables>> adopt_tables(const std::vector<Scene>& scenes,
                                                             std::vector<PackedTable> tables) {
    const auto has_channels = [](const Scene& scene) { return !scene.layer.channels.empty(); };
    const bool coloured = std::ranges::any_of(scenes, has_channels);
    const bool one_family = tables.size() == 1 && tables[0].header().varies_parameters();
    require(one_family || !coloured || std::ranges::all_of(scenes, has_channels), caller, "panels",
            "alike in the number of their phase functions where tables are given", "one and three");
    require(one_family || tables.size() == (coloured ? 3 : 1), caller, "--table",
            coloured ? "given three times, for red, green and blue, or once, of a family"
                     : "given once",
            std::to_string(tables.size()));
    std::vector<GivenTable> given;
    for (PackedTable& table : tables) given.emplace_back(std::move(table));
    std::vector<std::shared_ptr<const LayerTables>> adopted;
    for (const Scene& scene : scenes) {
        std::vector<std::shared_ptr<const LayerTables>> own;
        for (const Scene& channel : channel_scenes(scene))
            own.push_back(given[one_family ? 0 : own.size()].serve(channel));
        adopted.push_back(of_channels(scene, own));
    }
    return adopted;
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
std::vector<std::shared_ptr<const LayerTables>> make_shared_tables(const std::vector<Scene>& scenes,
                                                                   const TableMaker& make) {
    std::vector<std::shared_ptr<const LayerTables>> tables(scenes.size());
    for (const SharedRecipe& shared : shared_recipes(scenes)) {
        const std::shared_ptr<const LayerTables> made = make(shared.recipe);
        for (const std::size_t s : shared.scenes) tables[s] = made;
    }
    return tables;
}

}  // namespace

std::vector<std::shared_ptr<const LayerTables>> bake_for(const std::vector<Scene>& scenes,
                                                         const BakeOptions& options,
                                                         TableCache* cache) {
    return make_tables(
        scenes, [&](const Recipe& recipe) { return bake_layer_tables(recipe, options, cache); });
}

std::vector<std::shared_ptr<const LayerTables>> make_tables(const std::vector<Scene>& scenes,
                                                            const TableMaker& make) {
    std::vector<Scene> channels;
    for (const Scene& scene : scenes)
        for (Scene& channel : channel_scenes(scene)) channels.push_back(std::move(channel));
    const auto baked = make_shared_tables(channels, make);
    std::vector<std::shared_ptr<const LayerTables>> tables;
    std::span<const std::shared_ptr<const LayerTables>> next = baked;
    for (const Scene& scene : scenes) {
        tables.push_back(of_channels(scene, next));
        next = next.subspan(scene.layer.channels.empty() ? 1 : 3);
    }
    return tables;
}

}  // namespace stratus
