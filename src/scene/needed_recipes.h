// The tables that a scene needs, and which of some serve it.
#pragma once

#include <stratus/scene/layer_tables.h>

namespace stratus {

/// The subject of refusals of tables.
inline constexpr const char* table_caller = "scene";

/// Refuses a table that does not serve a light path of a scene, for which it needs a recipe.
void check_table(const Scene& scene, const NeededRecipe& need, const PackedTable& packed);

}  // namespace stratus
