// The tables that a scene's layer is looked up in: the recipes that the scene needs, one for each way
// of light, and what is baked from them.
//
// Sunlight that the layer sends to the camera is all that most pixels hold: its table has the scene's
// tolerance, and of a point sun over a plane one cosine of incidence. What lies behind the layer needs
// fluxes alone, which have no azimuth and no second cosine; those of slabs come with sunlight's table,
// which costs less than a second one. Light that rings and their planet exchange comes along all
// directions, but is a small part of what is seen.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/scene/contents.h>
#include <stratus/scene/table_cache.h>

#include <array>

namespace stratus {

/// Ways of light that need orders n >= 2 of the layer.
enum class LightPath {
    sunlight,  // off the layer or through it, to the camera
    fluxes,    // of a ground or of a background of one colour, through the layer
    shine,     // between rings and their planet
};
constexpr std::size_t light_paths = 3;

const char* light_path_name(LightPath path);

/// The ways of light for which a scene needs a table; none where its effects need no table.
std::vector<LightPath> needed_paths(const Scene& scene);

/// The recipe of the table for one way of light.
struct NeededRecipe {
    LightPath path;
    Recipe recipe;
};

/// The recipes of the tables that a scene needs, one for each of needed_paths. Channels with their
/// own phase functions need tables each: those of `channel_scenes` (scene.h). Directions are those
/// that the light takes, in wider ranges, or all where those would not halve the table; tolerances
/// are such that the picture keeps the scene's (tests/scene/picture_test.cpp).
std::vector<NeededRecipe> needed_recipes(const Scene& scene);

/// Refuses a table that does not serve a light path of a scene, for which it needs a recipe.
void check_table(const Scene& scene, const NeededRecipe& need, const PackedTable& packed);

/// One recipe in place of two: the wider ranges, the smaller tolerance. None where one table
/// cannot serve both.
std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other);

/// A table prepared for lookups. Must not be moved while a LayerLight uses it.
struct LayerTable {
    Axis mixture{AxisScale::linear, {}};  // empty where there is one mixture
    std::vector<Table> headers;           // without samples, one for each mixture
    PackedTable packed;
};

using SharedLayerTable = std::shared_ptr<const LayerTable>;

/// Prepares a table for lookups.
SharedLayerTable make_layer_table(PackedTable table);

/// The options with which tables of scenes are baked: checked at fewer points, which for small tables
/// took longer than all else.
BakeOptions table_options(BakeOptions options);

/// Bakes `recipe`, or takes its table from the cache, and prepares it for lookups.
SharedLayerTable bake_layer_table(Recipe recipe, const BakeOptions& options = {},
                                  TableCache* cache = nullptr);

struct LayerTables;
using SharedLayerTables = std::shared_ptr<const LayerTables>;

/// Tables of one scene.
struct LayerTables {
    /// By LightPath; null where there is none, and sunlight's, if any, stands in.
    std::array<SharedLayerTable, light_paths> paths;
    /// Tables of red, green and blue where these have their own phase functions, in place of the above.
    std::array<SharedLayerTables, 3> channels;
    /// Tables of the planet_scene (scene.h).
    SharedLayerTables planet;

    const LayerTable* at(LightPath path) const {
        const auto& own = paths[static_cast<std::size_t>(path)];
        return own ? own.get() : paths[0].get();
    }
};

/// Tables of several scenes, in their order; null where none is needed.
using SceneTables = std::vector<SharedLayerTables>;

/// Tables for each of several scenes out of those that are given: each light path of each channel
/// gets the first that serves it. One of a family that has the phase functions of scenes and channels
/// among its members serves all of these, each of which becomes a table of its own (table_at).
///
/// Errors   std::invalid_argument where none of the tables serves what a scene needs, saying why the
///          last does not; for a table that serves nothing.
SceneTables adopt_tables(const Scenes& scenes, std::vector<PackedTable> tables);

/// The layer's matter, if it is uniform.
std::optional<Matter> uniform_matter(const Scene& scene);

/// A recipe that serves one light path of several scenes.
struct SharedRecipe {
    LightPath path;
    Recipe recipe;
    bool uniform;                     // the layers of all its scenes
    std::vector<std::size_t> scenes;  // positions
};

/// Each of as many scenes as it can serve.
///
/// Range    scenes of one phase function, or of two that mix (channel_scenes of others).
std::vector<SharedRecipe> shared_recipes(const Scenes& scenes);

/// Tables for each of several scenes, shared where possible, from the cache where that has them.
SceneTables bake_for(const Scenes& scenes, const BakeOptions& options = {},
                     TableCache* cache = nullptr);

/// Makes the table of a recipe.
using TableMaker = std::function<SharedLayerTable(const Recipe& recipe)>;
SceneTables make_tables(const Scenes& scenes, const TableMaker& make);

}  // namespace stratus
