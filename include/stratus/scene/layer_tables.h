// The tables that a scene's layer is looked up in: the recipe that the scene needs, and what is
// baked from it.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/scene/contents.h>
#include <stratus/scene/scene.h>
#include <stratus/scene/table_cache.h>
#include <stratus/table/packed_table.h>
#include <stratus/table/table.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace stratus {

/// The recipe of the table that a scene needs; none where its effects need no table. Channels with
/// their own phase functions need a table each: that of `channel_scenes` (scene.h). Directions are
/// those that the scene sees, in wider ranges, or all where those would not halve the table.
std::optional<Recipe> needed_recipe(const Scene& scene);

/// One recipe in place of two: the wider ranges, the smaller tolerance. None where one table
/// cannot serve both.
std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other);

/// Tables of one layer. Must not be moved while a LayerLight uses them.
struct LayerTables {
    Axis mixture{AxisScale::linear, {}};  // empty where there is one mixture
    std::vector<Table> headers;           // without samples, one for each mixture
    std::optional<PackedTable> packed;    // none where channels have their own
    /// Of red, green and blue where these have their own phase functions, in place of all above.
    std::array<std::shared_ptr<const LayerTables>, 3> channels;
};

/// Prepares a table for lookups.
std::unique_ptr<LayerTables> make_layer_tables(PackedTable table);

/// Bakes `recipe`, or takes its table from the cache, and prepares it for a scene.
std::unique_ptr<LayerTables> bake_layer_tables(Recipe recipe, const BakeOptions& options = {},
                                               TableCache* cache = nullptr);

/// Tables for each of several scenes out of those that are given: one, or three for scenes whose
/// channels have their own phase functions, or one of a family that has the phase functions of all
/// scenes and channels among its members, each of which becomes a table of its own (table_at).
///
/// Errors   std::invalid_argument for a table of another phase function, or that does not cover
///          what a scene needs; for another number of tables.
std::vector<std::shared_ptr<const LayerTables>> adopt_tables(const std::vector<Scene>& scenes,
                                                             std::vector<PackedTable> tables);

/// The layer's matter, if it is uniform.
std::optional<Matter> uniform_matter(const Scene& scene);

/// Recipes that serve several scenes, each of as many as it can.
struct SharedRecipe {
    Recipe recipe;
    bool uniform;                     // the layers of all its scenes
    std::vector<std::size_t> scenes;  // positions
};

/// Range    scenes of one phase function, or of two that mix (channel_scenes of others).
std::vector<SharedRecipe> shared_recipes(const std::vector<Scene>& scenes);

/// Tables for each of several scenes, shared where possible, from the cache where that has them.
std::vector<std::shared_ptr<const LayerTables>> bake_for(const std::vector<Scene>& scenes,
                                                         const BakeOptions& options = {},
                                                         TableCache* cache = nullptr);

/// The same of tables that are made in another way, each from a recipe.
using TableMaker = std::function<std::shared_ptr<const LayerTables>(const Recipe& recipe)>;
std::vector<std::shared_ptr<const LayerTables>> make_tables(const std::vector<Scene>& scenes,
                                                            const TableMaker& make);

}  // namespace stratus
