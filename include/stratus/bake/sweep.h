// Sweeps: many tables from one recipe, a row of a CSV file each.
//
// Each column is a key of the recipe, dotted where it stands in a section ("discretisation.nodes";
// of a stack also "layers.2.albedo", counted from the top): its cells take the place of what the
// recipe has there. A cell holds what the recipe would, texts with or without quotes; an empty one
// leaves the recipe as it is. The column `name` names the tables, or else they are numbered from 1.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/runtime/table.h>

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

struct SweepRow {
    std::string name;  // of its table
    Recipe recipe;     // whose text is the recipe with the row's cells in it
};

/// The rows of a sweep. Notes for the user go to `notes`, each once.
///
/// Errors   as of read_recipe, naming the CSV's line and the column's key; std::invalid_argument for
///          a column that is no key, with the nearest known, for a name twice or one that is no
///          file's, and for no rows; std::runtime_error for files that cannot be read.
std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 const std::filesystem::path& csv,
                                 std::vector<std::string>* notes = nullptr);

/// Whether a table was baked of this recipe, by a program of this version, with the same files of
/// phase functions.
bool is_baked_of(const Table& table, const Recipe& recipe);

/// Whether the errors that a table states meet its tolerance, as Verification::meets.
bool states_tolerance_met(const Table& table);

}  // namespace stratus
