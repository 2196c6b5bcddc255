#include <stratus/scene/layer_tables.h>

#include <stratus/base/argument.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/metadata.h>

#include <map>
#include <span>
#include <utility>

namespace stratus {

SharedLayerTable make_layer_table(PackedTable table) {
    Axis mixture{AxisScale::linear, {}};
    std::vector<Table> headers;
    const Table& header = table.header();
    if (header.has_family()) mixture = header.family[0].axis;
    for (std::size_t m = 0; m < header.member_count(); ++m) {
        Table& one = headers.emplace_back(header);
        const auto keep_member = [&](auto& numbers) {
            const auto size = static_cast<std::ptrdiff_t>(numbers.size() / header.member_count());
            const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(m) * size;
            numbers = {first, first + size};
        };
        for (const SampleField& field : sample_fields) keep_member(one.*field.samples);
        keep_member(one.diffusion_exponent);
    }
    return std::make_shared<const LayerTable>(
        LayerTable{std::move(mixture), std::move(headers), std::move(table)});
}

BakeOptions table_options(BakeOptions options) {
    options.checked_points = 1000;
    return options;
}

SharedLayerTable bake_layer_table(Recipe recipe, const BakeOptions& options, TableCache* cache) {
    recipe.text = resolved_text(recipe);
    if (cache)
        if (std::optional<PackedTable> table = cache->find(recipe))
            return make_layer_table(std::move(*table));
    std::vector<char> packed;
    BakeOptions straight = table_options(options);
    straight.packed = &packed;
    const std::unique_ptr<Checkpoint> choices = cache ? cache->open_choices(recipe) : nullptr;
    if (choices) straight.log.find = std::bind_front(&Checkpoint::find, choices.get());
    Table header = bake(recipe, straight);
    if (cache) packed = cache->keep(recipe, std::move(header), std::move(packed));
    return make_layer_table(PackedTable(packed));
}

namespace {

/// The tables of a scene, from the first of those of channel_scenes, which are taken away; none where
/// none is needed.
SharedLayerTables take_tables(const Scene& scene, std::span<const LayerTables>& own) {
    const auto all = std::make_shared<LayerTables>();
    const auto take = [&]() -> const LayerTables& {
        const LayerTables& first = own[0];
        own = own.subspan(1);
        return first;
    };
    const auto needed = [](const LayerTables& some) {
        const auto any = [](const auto& tables) {
            return std::ranges::any_of(tables, [](const auto& each) { return !!each; });
        };
        return any(some.paths) || any(some.channels) || some.planet;
    };
    if (scene.layer.channels.empty())
        all->paths = take().paths;
    else
        for (auto& channel : all->channels)
            if (const LayerTables& tables = take(); needed(tables))
                channel = std::make_shared<const LayerTables>(tables);
    if (const std::optional<Scene> planet = planet_scene(scene))
        all->planet = take_tables(*planet, own);
    return needed(*all) ? all : nullptr;
}

/// The tables of each of several scenes, from those of all their channel_scenes.
SceneTables scene_tables(const Scenes& scenes, std::span<const LayerTables> own) {
    SceneTables tables;
    for (const Scene& scene : scenes) tables.push_back(take_tables(scene, own));
    return tables;
}

/// The point of a table's family where it has a scene's phase function.
FamilyPoint family_point(const Table& table, const PhaseFunction& phase_function) {
    std::vector<double> values;
    for (const FamilyAxis& axis : table.family) {
        const std::optional<double> value = find_parameter(phase_function, axis.parameter);
        require(value.has_value(), "scene", "table.family",
                "one of parameters of the scene's phase function, " +
                    phase_function.text().substr(0, 80),
                axis.name());
        require(holds(axis, *value), "scene", axis.name() + std::string(" of the phase function"),
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
            made_[""] = make_layer_table(std::move(table));
    }

    /// For a light path of a scene of one phase function, or of two that mix.
    SharedLayerTable serve(const Scene& scene, const NeededRecipe& needed) {
        const Recipe& recipe = needed.recipe;
        SharedLayerTable& made = made_[family_ ? recipe.phase_text : ""];
        if (!made) {
            require(mixture_range(recipe) == nullptr, "scene", "table",
                    "one with a mixture axis alone where there are rings of two components",
                    "another family");
            made = make_layer_table(PackedTable(
                pack(table_at(*family_, family_point(*family_, recipe.phase_function)))));
        }
        check_table(scene, needed, made->packed);
        served_ = true;
        return made;
    }

    bool has_served() const { return served_; }

  private:
    std::optional<Table> family_;
    std::map<std::string, SharedLayerTable> made_;  // by phase function, or ""
    bool served_ = false;
};

/// The first of several tables that serves a light path of a scene. All are tried, so that those that
/// serve nothing are known.
SharedLayerTable served(std::vector<GivenTable>& given, const Scene& scene,
                        const NeededRecipe& needed) {
    SharedLayerTable first;
    std::string refusal;
    for (GivenTable& table : given) {
        try {
            const SharedLayerTable serving = table.serve(scene, needed);
            if (!first) first = serving;
        } catch (const std::invalid_argument& refused) {
            refusal = refused.what();
        }
    }
    if (first) return first;
    if (needed.path != LightPath::sunlight)
        refusal += std::string(" (a table for ") + light_path_name(needed.path) +
                   ", or one for all light paths, is missing)";
    throw std::invalid_argument(refusal);
}

}  // namespace

SceneTables adopt_tables(const Scenes& scenes, std::vector<PackedTable> tables) {
    std::vector<GivenTable> given;
    for (PackedTable& table : tables) given.emplace_back(std::move(table));
    std::vector<LayerTables> adopted;
    bool needs_any = false;
    for (const Scene& scene : channel_scenes(scenes)) {
        LayerTables& own = adopted.emplace_back();
        for (const NeededRecipe& needed : needed_recipes(scene)) {
            own.paths[static_cast<std::size_t>(needed.path)] = served(given, scene, needed);
            needs_any = true;
        }
    }
    for (std::size_t k = 0; k < given.size(); ++k)
        require(given[k].has_served() || !needs_any, "scene", "--table",
                "a table of something that the scene needs", "number " + std::to_string(k + 1));
    return scene_tables(scenes, adopted);
}

SceneTables bake_for(const Scenes& scenes, const BakeOptions& options, TableCache* cache) {
    return make_tables(
        scenes, [&](const Recipe& recipe) { return bake_layer_table(recipe, options, cache); });
}

SceneTables make_tables(const Scenes& scenes, const TableMaker& make) {
    const Scenes channels = channel_scenes(scenes);
    std::vector<LayerTables> made(channels.size());
    for (const SharedRecipe& shared : shared_recipes(channels)) {
        const SharedLayerTable table = make(shared.recipe);
        for (const std::size_t s : shared.scenes)
            made[s].paths[static_cast<std::size_t>(shared.path)] = table;
    }
    return scene_tables(scenes, made);
}

}  // namespace stratus
