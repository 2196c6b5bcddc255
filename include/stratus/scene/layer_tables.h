// What a scene's layer is looked up in: the recipe that the scene calls for, and the tables baked
// from it.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/runtime/table.h>
#include <stratus/runtime/textured_table.h>
#include <stratus/scene/scene.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace stratus {

/// Lets a range include a value.
void widen(Range& range, double value) noexcept;

/// The table that a scene calls for: its ranges, its sides; nothing where its effects need no
/// table.
std::optional<Recipe> needed_recipe(const Scene& scene);

/// One recipe for two scenes of the same phase function and ground: the wider ranges, the smaller
/// tolerance. Nothing where one table cannot serve both.
std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other);

/// Tables of one layer, for all that may be asked of it. They are not to be moved while lights look
/// up in them.
struct LayerTables {
    Axis mixture{AxisScale::identity, {}};  // empty where one mixture is all
    std::vector<Table> tables;              // one for each mixture
    std::vector<TexturedTable> textured;  // as many, where depth or albedo vary from place to place
};

/// Makes a table ready for lookups; in a layer that is uniform without textured tables.
std::unique_ptr<LayerTables> make_layer_tables(Table table, bool is_uniform);

/// Bakes what `recipe` asks for and makes it ready for a scene.
std::unique_ptr<LayerTables> bake_layer_tables(const Scene& scene, Recipe recipe,
                                               const BakeOptions& options = {});

/// The same of a table that is there already, for all of several scenes.
///
/// Errors   std::invalid_argument for a table that is not of a scene's phase function, or that does
///          not hold what it calls for.
std::shared_ptr<const LayerTables> adopt_table(const std::vector<Scene>& scenes, Table table);

/// The layer's matter where it is the same everywhere.
std::optional<Matter> uniform_matter(const Scene& scene);

/// Tables for each of several scenes; those that can do with the same share it.
std::vector<std::shared_ptr<const LayerTables>> bake_for(const std::vector<Scene>& scenes,
                                                         const BakeOptions& options = {});

}  // namespace stratus
