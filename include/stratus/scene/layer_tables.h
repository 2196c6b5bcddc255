// What a scene's layer is looked up in: the recipe that the scene calls for, and the tables baked
// from it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <stratus/bake/bake.h>
#include <stratus/runtime/table.h>
#include <stratus/runtime/textured_table.h>
#include <stratus/scene/scene.h>

namespace stratus {

/// Lets a range include a value.
void widen(Range& range, double value) noexcept;

/// The table that a scene calls for: its ranges, its sides; nothing where its effects need no
/// table. In rings it is to be baked for several mixtures (mixture_fractions).
std::optional<Recipe> needed_recipe(const Scene& scene);

/// One recipe for two scenes of the same phase function and ground: the wider ranges, the smaller
/// tolerance. Nothing where one table cannot serve both.
std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other);

/// Where the orders n >= 2 of a mixture are tabulated, as shares of the first component, ascending:
/// one number where all are the same. Order n is a polynomial of degree n in that share.
std::vector<double> mixture_fractions(const Scene& scene);

/// Shares of each of the fractions' tables in a mixture: the polynomial through them, which meets
/// mixtures of a Lambert sphere and Henyey-Greenstein's 0.5 to 6e-4 of the light.
constexpr std::size_t most_mixtures = 5;
std::array<double, most_mixtures> mixture_weights(const std::vector<double>& fractions,
                                                  double mixture) noexcept;

/// Tables of one layer, for all that may be asked of it. They are not to be moved while lights look
/// up in them.
struct LayerTables {
    std::vector<double> fractions;        // of the first component; of one mixture, one
    std::vector<Table> tables;            // as many
    std::vector<TexturedTable> textured;  // as many, where depth or albedo vary from place to place
};

/// Bakes what `recipe` asks for, for the mixtures of a scene.
std::unique_ptr<LayerTables> bake_layer_tables(const Scene& scene, const Recipe& recipe,
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
